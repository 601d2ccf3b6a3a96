#include "runtime/access.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <numeric>

#include "core/text.h"
#include "runtime/memory/exchange.h"
#include "runtime/operations.h"
#include "runtime/value_text.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::Problem;

bool is_leaf(const ImageType& type) { return type.kind == TypeKind::kScalar || type.kind == TypeKind::kString; }

/// "a.b[1].c" cut into names and indices.
struct Step {
  std::string_view name;  ///< empty for an index
  std::int64_t index = 0;
};

std::optional<std::vector<Step>> parse_path(std::string_view path) {
  std::vector<Step> steps;
  std::size_t at = 0;
  bool name_next = true;
  while (at < path.size()) {
    if (name_next) {
      std::size_t end = path.find_first_of(".[", at);
      if (end == std::string_view::npos) end = path.size();
      const std::string_view name = core::trimmed(path.substr(at, end - at));
      if (name.empty()) return std::nullopt;
      steps.push_back({name, 0});
      at = end;
      name_next = false;
    } else if (path[at] == '.') {
      ++at;
      name_next = true;
    } else if (path[at] == '[') {
      do {
        ++at;
        std::size_t end = path.find_first_of(",]", at);
        if (end == std::string_view::npos) return std::nullopt;
        const std::string_view text = core::trimmed(path.substr(at, end - at));
        std::int64_t index = 0;
        const auto result = std::from_chars(text.data(), text.data() + text.size(), index);
        if (text.empty() || result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
        steps.push_back({{}, index});
        at = end;
      } while (path[at] == ',');
      ++at;
    } else {
      return std::nullopt;
    }
  }
  if (steps.empty() || name_next) return std::nullopt;
  return steps;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t change = diagonal + (core::fold(a[i]) == core::fold(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, change});
    }
  }
  return row[b.size()];
}

/// Remembers the closest of the names that were on offer where a path ended.
class Nearest {
 public:
  explicit Nearest(std::string_view wanted) : wanted_(wanted), distance_(wanted.size() / 2 + 1) {}
  void offer(const std::string& name) {
    if (name.find('#') != std::string::npos) return;
    const std::size_t distance = edit_distance(wanted_, name);
    if (distance >= distance_) return;
    distance_ = distance;
    name_ = name;
  }
  [[nodiscard]] std::string help() const { return name_.empty() ? std::string{} : "did you mean \"" + name_ + "\"?"; }

 private:
  std::string_view wanted_;
  std::size_t distance_;
  std::string name_;
};

/// Follows `steps` from `place`. On failure `problem` says where; the deepest failure of several attempts counts.
struct Failure {
  std::size_t depth = 0;
  std::string message;
  std::string help;
};

bool descend(const Image& image, std::span<const Step> steps, std::size_t done, Place& place, Failure& failure) {
  const auto fail = [&](std::size_t depth, std::string message, std::string help) {
    if (depth < failure.depth) return;
    failure = {depth, std::move(message), std::move(help)};
  };
  for (std::size_t i = done; i < steps.size(); ++i) {
    const Step& step = steps[i];
    const ImageType& type = image.types[place.type];
    if (step.name.empty()) {
      if (type.kind != TypeKind::kArray) {
        fail(i, "index on what is not an array", {});
        return false;
      }
      const auto element = static_cast<std::uint64_t>(step.index) - static_cast<std::uint64_t>(type.lower);
      if (element >= type.count) {
        const std::int64_t last = type.lower + static_cast<std::int64_t>(type.count) - 1;
        fail(i,
             "index " + std::to_string(step.index) + " is outside " + std::to_string(type.lower) + ".." +
                 std::to_string(last),
             {});
        return false;
      }
      place.offset += static_cast<std::uint32_t>(element) * image.types[type.element].size;
      place.type = type.element;
      continue;
    }
    const auto field = std::find_if(type.fields.begin(), type.fields.end(),
                                    [&step](const ImageField& f) { return core::iequals(f.name, step.name); });
    if (type.kind != TypeKind::kStruct || field == type.fields.end()) {
      Nearest nearest(step.name);
      for (const ImageField& f : type.fields) nearest.offer(f.name);
      fail(i, "no \"" + std::string(step.name) + "\" here", nearest.help());
      return false;
    }
    place.offset += field->offset;
    place.type = field->type;
    place.constant = place.constant || field->constant;
  }
  return true;
}

Place global_place(const Image& image, std::size_t index) {
  const ImageField& field = image.types[image.global_type].fields[index];
  return {Place::kGlobal, field.offset, field.type, field.constant};
}

bool glob_match(std::string_view pattern, std::string_view text) {
  std::size_t p = 0;
  std::size_t t = 0;
  std::size_t star = std::string_view::npos;
  std::size_t resume = 0;
  while (t < text.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = t;
    } else if (p < pattern.size() && (pattern[p] == '?' || core::fold(pattern[p]) == core::fold(text[t]))) {
      ++p;
      ++t;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      t = ++resume;
    } else {
      return false;
    }
  }
  while (p < pattern.size() && pattern[p] == '*') ++p;
  return p == pattern.size();
}

/// Walks all leaves below a place.
class Lister {
 public:
  Lister(const Image& image, std::string_view pattern, std::size_t limit)
      : image_(image), pattern_(pattern), limit_(limit), hidden_(pattern.find('#') != std::string_view::npos) {}

  void walk(std::string& path, std::uint32_t type_index) {
    if (found_.size() >= limit_) return;
    const ImageType& type = image_.types[type_index];
    const std::size_t length = path.size();
    switch (type.kind) {
      case TypeKind::kScalar:
      case TypeKind::kString:
        if (glob_match(pattern_, path)) found_.push_back(path);
        return;
      case TypeKind::kRef:
        return;
      case TypeKind::kArray:
        for (std::uint32_t i = 0; i < type.count && found_.size() < limit_; ++i) {
          path += '[';
          path += std::to_string(type.lower + static_cast<std::int64_t>(i));
          path += ']';
          walk(path, type.element);
          path.resize(length);
        }
        return;
      case TypeKind::kStruct:
        for (const ImageField& field : type.fields) {
          if (!hidden_ && field.name.find('#') != std::string::npos) continue;
          if (!path.empty()) path += '.';
          path += field.name;
          walk(path, field.type);
          path.resize(length);
        }
        return;
    }
  }
  std::vector<std::string> take() { return std::move(found_); }

 private:
  const Image& image_;
  std::string_view pattern_;
  std::size_t limit_;
  bool hidden_;
  std::vector<std::string> found_;
};

/// True when a program instance of this name is in more than one task.
bool in_several_tasks(const Image& image, std::string_view name) {
  std::size_t tasks = 0;
  for (const bytecode::ImageTask& task : image.tasks) {
    const auto& fields = image.types[image.pous[task.body].instance_type].fields;
    tasks +=
        std::any_of(fields.begin(), fields.end(), [name](const ImageField& f) { return core::iequals(f.name, name); })
            ? 1
            : 0;
  }
  return tasks > 1;
}

}  // namespace

core::Result<Place> Access::find(std::string_view path) const {
  const Image& image = resource_.image();
  path = core::trimmed(path);
  const auto& globals = image.types[image.global_type].fields;
  if (path.starts_with('%')) {
    for (std::size_t i = 0; i < globals.size(); ++i) {
      if (core::iequals(image.globals[i].address, path)) return global_place(image, i);
    }
    return Problem{Code::P7101, "no variable at address \"" + std::string(path) + "\"", {}};
  }
  const auto steps = parse_path(path);
  if (!steps || steps->front().name.empty()) {
    return Problem{Code::P7101, "\"" + std::string(path) + "\" is not a path",
                   "write it as Instance.Variable, Global or Array[3]"};
  }
  const std::string_view first = steps->front().name;
  Failure failure;
  Place place;
  if (in_several_tasks(image, first)) {
    failure = {1, "instances of this name are in several tasks", "put the task's name in front"};
  } else {
    for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
      const std::uint32_t body = image.tasks[task].body;
      const std::uint32_t base = resource_.program(task).table().layout().instance;
      place = {task, base, image.pous[body].instance_type, false};
      if (descend(image, *steps, 0, place, failure)) return place;
    }
  }
  // "List.Name" before "Name", so that a variable called as a list does not hide the list.
  for (std::size_t i = 0; i < globals.size(); ++i) {
    if (steps->size() < 2 || image.globals[i].list.empty() || !core::iequals(image.globals[i].list, first) ||
        !core::iequals(globals[i].name, (*steps)[1].name)) {
      continue;
    }
    place = global_place(image, i);
    if (descend(image, *steps, 2, place, failure)) return place;
  }
  std::size_t named = 0;
  for (std::size_t i = 0; i < globals.size(); ++i) named += core::iequals(globals[i].name, first) ? 1 : 0;
  for (std::size_t i = 0; i < globals.size(); ++i) {
    if (!core::iequals(globals[i].name, first)) continue;
    if (named > 1 && !image.globals[i].list.empty()) {
      failure = {1, "variables of this name are in several lists",
                 "write \"" + image.globals[i].list + "." + globals[i].name + "\""};
      continue;
    }
    place = global_place(image, i);
    if (descend(image, *steps, 1, place, failure)) return place;
  }
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    if (!core::iequals(image.tasks[task].name, first)) continue;
    place = {task, resource_.program(task).table().layout().instance, image.pous[image.tasks[task].body].instance_type,
             false};
    if (descend(image, *steps, 1, place, failure)) return place;
  }
  if (failure.depth == 0) {
    Nearest nearest(first);
    for (const ImageField& field : globals) nearest.offer(field.name);
    for (const bytecode::ImageGlobal& global : image.globals) nearest.offer(global.list);
    for (const bytecode::ImageTask& task : image.tasks) {
      for (const ImageField& field : image.types[image.pous[task.body].instance_type].fields) nearest.offer(field.name);
    }
    failure.message = "no instance or global of this name";
    failure.help = nearest.help();
  }
  return Problem{Code::P7101, "\"" + std::string(path) + "\": " + failure.message, failure.help};
}

core::Result<Place> Access::find_leaf(std::string_view path) const {
  auto place = find(path);
  if (place && !is_leaf(resource_.image().types[place->type])) {
    return Problem{Code::P7102, "\"" + std::string(path) + "\" is not a single value",
                   "name one element or field of it"};
  }
  return place;
}

std::vector<std::string> Access::list(std::string_view pattern, std::size_t limit) const {
  const Image& image = resource_.image();
  Lister lister(image, pattern, limit);
  const bool hidden = pattern.find('#') != std::string_view::npos;
  for (const bytecode::ImageTask& task : image.tasks) {
    for (const ImageField& field : image.types[image.pous[task.body].instance_type].fields) {
      if (!hidden && field.name.find('#') != std::string::npos) continue;
      std::string path = in_several_tasks(image, field.name) ? task.name + "." + field.name : field.name;
      lister.walk(path, field.type);
    }
  }
  const auto& globals = image.types[image.global_type].fields;
  for (std::size_t i = 0; i < globals.size(); ++i) {
    if (!hidden && globals[i].name.find('#') != std::string::npos) continue;
    std::string path = image.globals[i].list.empty() ? globals[i].name : image.globals[i].list + "." + globals[i].name;
    lister.walk(path, globals[i].type);
  }
  return lister.take();
}

void Access::read_to(const Place& place, std::string& out) const {
  const Image& image = resource_.image();
  const ImageType& type = image.types[place.type];
  if (type.kind == TypeKind::kArray || type.kind == TypeKind::kStruct) {
    const bool array = type.kind == TypeKind::kArray;
    out += array ? '[' : '(';
    const std::size_t parts = array ? type.count : type.fields.size();
    for (std::size_t i = 0; i < parts; ++i) {
      if (i != 0) out += ", ";
      Place part = place;
      if (array) {
        part.type = type.element;
        part.offset += static_cast<std::uint32_t>(i) * image.types[type.element].size;
      } else {
        part.type = type.fields[i].type;
        part.offset += type.fields[i].offset;
        out += type.fields[i].name + " := ";
      }
      read_to(part, out);
    }
    out += array ? ']' : ')';
    return;
  }
  if (place.task != Place::kGlobal) {
    append_value(type, resource_.program(place.task).table().data() + place.offset, out);
    return;
  }
  // Shared memory is read once into private memory.
  alignas(8) std::byte small[64];
  std::vector<std::byte> large;
  std::byte* to = small;
  if (type.size > sizeof small) {
    large.resize(type.size);
    to = large.data();
  }
  copy_from_shared(to, resource_.globals().data() + place.offset, type.size);
  append_value(type, to, out);
}

std::string Access::read(const Place& place) const {
  std::string out;
  read_to(place, out);
  return out;
}

std::optional<std::int64_t> Access::read_integer(const Place& place) const {
  const ImageType& type = resource_.image().types[place.type];
  if (type.kind != TypeKind::kScalar || type.size > sizeof(std::int64_t)) return std::nullopt;
  alignas(8) std::byte value[8];
  if (place.task == Place::kGlobal) {
    copy_from_shared(value, resource_.globals().data() + place.offset, type.size);
  } else {
    std::memcpy(value, resource_.program(place.task).table().data() + place.offset, type.size);
  }
  switch (bytecode::rep_of(type)) {
    case core::Rep::kBool:
      return load<std::uint8_t>(value) != 0 ? 1 : 0;
    case core::Rep::kI8:
      return load<std::int8_t>(value);
    case core::Rep::kU8:
      return load<std::uint8_t>(value);
    case core::Rep::kI16:
      return load<std::int16_t>(value);
    case core::Rep::kU16:
      return load<std::uint16_t>(value);
    case core::Rep::kI32:
      return load<std::int32_t>(value);
    case core::Rep::kU32:
      return load<std::uint32_t>(value);
    case core::Rep::kI64:
    case core::Rep::kU64:
      return load<std::int64_t>(value);
    default:
      return std::nullopt;
  }
}

std::optional<Problem> Access::write(const Place& place, std::string_view text) {
  const ImageType& type = resource_.image().types[place.type];
  if (!is_leaf(type)) return Problem{Code::P7102, "not a single value", "name one element or field of it"};
  if (place.constant) return Problem{Code::P7106, "the variable is declared CONSTANT", {}};
  std::vector<std::byte> value(type.size);
  if (auto problem = parse_value(type, text, value)) return problem;
  if (place.task == Place::kGlobal) {
    copy_to_shared(resource_.globals().data() + place.offset, value.data(), type.size);
  } else {
    std::memcpy(resource_.program(place.task).table().data() + place.offset, value.data(), type.size);
  }
  return std::nullopt;
}

}  // namespace plc::runtime
