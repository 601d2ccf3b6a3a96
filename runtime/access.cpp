#include "runtime/access.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <numeric>

#include "core/guess.h"
#include "core/integer_at.h"
#include "core/text.h"
#include "runtime/interpreter/operations.h"
#include "runtime/path_lister.h"
#include "runtime/value_text.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using bytecode::ImageAlias;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::Problem;

bool is_leaf(const ImageType& type) { return type.kind == TypeKind::kScalar || type.kind == TypeKind::kString; }

/// A part of "a.b[1].c": a name or an index.
struct Step {
  std::string_view name;  ///< empty for an index
  std::int64_t index = 0;
};

/// The parts of "a.b[1].c", or of the ".b[1].c" after a name.
std::optional<std::vector<Step>> parse_path(std::string_view path, bool after_name = false) {
  std::vector<Step> steps;
  std::size_t at = 0;
  bool name_next = !after_name;
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
  if ((steps.empty() && !after_name) || name_next) return std::nullopt;
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

/// Why a path leads nowhere; the deepest failure of several attempts counts.
struct Failure {
  std::size_t depth = 0;
  std::string message;
  std::string help;
};

/// Where the value at `place` comes from, when that is a wired input of a taskblock in the instance of type `instance`
/// at `begin`: nothing is ever copied into such an input.
void follow_wire(const Image& image, std::uint32_t instance, std::uint32_t begin, Place& place) {
  for (const bytecode::ImagePou& pou : image.pous) {
    if (pou.wires.empty() || pou.instance_type != instance) continue;
    for (const bytecode::ImageWire& wire : pou.wires) {
      for (const bytecode::ImageBlock& block : image.blocks) {
        if (!place_at(image, instance, wire.block, block.type)) continue;
        const ImageField& input = image.types[block.type].fields[wire.input];
        if (place.offset == begin + wire.block + input.offset && place.type == input.type) {
          place.offset = begin + wire.source;
          return;
        }
      }
    }
  }
}

/// Follows `steps` from `place`; an alias leads over to the global table, a wire to its other end.
bool descend(const Image& image, std::span<const Step> steps, std::size_t done, Place& place, Failure& failure) {
  const auto fail = [&](std::size_t depth, std::string message, std::string help) {
    if (depth < failure.depth) return;
    failure = {depth, std::move(message), std::move(help)};
  };
  std::vector<Place> passed;
  for (std::size_t i = done; i < steps.size(); ++i) {
    const Step& step = steps[i];
    const ImageType& type = image.types[place.type];
    passed.push_back(place);
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
    if (type.kind == TypeKind::kStruct && field == type.fields.end()) {
      const auto alias = std::find_if(type.aliases.begin(), type.aliases.end(),
                                      [&step](const ImageAlias& a) { return core::iequals(a.name, step.name); });
      if (alias != type.aliases.end()) {
        place = place_of_global(image, alias->global);
        continue;
      }
    }
    if (type.kind != TypeKind::kStruct || field == type.fields.end()) {
      Nearest nearest(step.name);
      for (const ImageField& f : type.fields) nearest.offer(f.name);
      for (const ImageAlias& a : type.aliases) nearest.offer(a.name);
      fail(i, "no \"" + std::string(step.name) + "\" here", nearest.help());
      return false;
    }
    place.offset += field->offset;
    place.type = field->type;
    place.constant = place.constant || field->constant;
    if (!bytecode::is_taskblock_type(image, passed.back().type)) continue;
    for (const Place& instance : passed) follow_wire(image, instance.type, instance.offset, place);
  }
  return true;
}

/// Looks for a path in the tables. One text may name several places (an instance and a global of one name): the first
/// that exists counts, and a single value before the others when one is wanted.
class Finder {
 public:
  Finder(const Resource& resource, std::string_view path, bool wants_leaf)
      : resource_(resource), image_(resource.image()), path_(path), wants_leaf_(wants_leaf) {}

  core::Result<Place> run() {
    if (path_.starts_with('%')) {
      if (among_full_names(true)) return *found_;
      if (failure_.depth == 0) failure_.message = "no variable at this address";
      return result();
    }
    const auto steps = parse_path(path_);
    if (!steps || steps->front().name.empty()) {
      return Problem{Code::P7101, "\"" + std::string(path_) + "\" is not a path",
                     "write it as Instance.Variable, Global or Array[3]"};
    }
    steps_ = *steps;
    if (among_instances() || among_lists() || among_globals() || among_full_names(false) || among_tasks()) {
      return *found_;
    }
    if (failure_.depth == 0) {
      failure_.message = "no instance or global of this name";
      failure_.help = nearest();
    }
    return result();
  }

 private:
  [[nodiscard]] const std::vector<ImageField>& globals() const { return image_.types[image_.global_type].fields; }
  [[nodiscard]] const bytecode::ImagePou& body(std::size_t task) const { return image_.pous[image_.tasks[task].body]; }
  [[nodiscard]] Place task_place(std::uint32_t task) const {
    return {task, resource_.program(task).table().layout().instance, body(task).instance_type, false};
  }

  /// Follows the steps from the `done`th on; true ends the search.
  bool accept(Place place, std::span<const Step> steps, std::size_t done) {
    if (!descend(image_, steps, done, place, failure_)) return false;
    const bool last = !wants_leaf_ || is_leaf(image_.types[place.type]);
    if (last || !found_) found_ = place;
    return last;
  }
  core::Result<Place> result() const {
    if (found_) return *found_;
    return Problem{Code::P7101, "\"" + std::string(path_) + "\": " + failure_.message, failure_.help};
  }

  bool among_instances() {
    if (in_several_tasks(image_, steps_[0].name)) {
      failure_ = {1, "instances of this name are in several tasks", "put the task's name before it"};
      return false;
    }
    for (std::uint32_t task = 0; task < image_.tasks.size(); ++task) {
      if (accept(task_place(task), steps_, 0)) return true;
      for (const ImageAlias& alias : image_.types[body(task).instance_type].aliases) {
        if (accept_prefixed(alias.name, alias.global)) return true;
      }
    }
    return false;
  }
  // "List.Name" before "Name", so that a variable called as a list does not hide the list.
  bool among_lists() {
    for (std::size_t i = 0; i < globals().size() && steps_.size() > 1; ++i) {
      const std::string& list = image_.globals[i].list;
      if (list.empty() || !core::iequals(list, steps_[0].name) || !core::iequals(globals()[i].name, steps_[1].name)) {
        continue;
      }
      if (accept(place_of_global(image_, i), steps_, 2)) return true;
    }
    return false;
  }
  bool among_globals() {
    std::vector<std::size_t> named;
    for (std::size_t i = 0; i < globals().size(); ++i) {
      if (core::iequals(globals()[i].name, steps_[0].name)) named.push_back(i);
    }
    for (const std::size_t i : named) {
      if (named.size() > 1 && !image_.globals[i].list.empty()) {
        failure_ = {1, "variables of this name are in several lists",
                    "write \"" + image_.globals[i].list + "." + globals()[i].name + "\""};
        continue;
      }
      if (accept(place_of_global(image_, i), steps_, 1)) return true;
    }
    return false;
  }
  /// Names and addresses that hold dots themselves: "Pou.Variable" of a located variable, "%IX0.0".
  bool among_full_names(bool addresses) {
    for (std::size_t i = 0; i < globals().size(); ++i) {
      if (!is_declared_global(globals()[i]) && accept_prefixed(globals()[i].name, i)) return true;
    }
    for (const ImageAlias& alias : image_.types[image_.global_type].aliases) {
      if (addresses) break;
      if (accept_prefixed(alias.name, alias.global)) return true;
      // As a variable of a list, it is also called without the list.
      const std::size_t dot = alias.name.find('.');
      if (dot != std::string::npos && accept_prefixed(alias.name.substr(dot + 1), alias.global)) return true;
    }
    for (std::size_t i = 0; i < globals().size() && addresses; ++i) {
      const std::string& address = image_.globals[i].address;
      // "%I*" is no address: many variables have it.
      if (!address.empty() && !address.ends_with('*') && accept_prefixed(address, i)) return true;
    }
    return false;
  }
  bool accept_prefixed(std::string_view name, std::size_t global) {
    if (path_.size() < name.size() || !core::iequals(path_.substr(0, name.size()), name)) return false;
    const auto steps = parse_path(path_.substr(name.size()), true);
    return steps && accept(place_of_global(image_, global), *steps, 0);
  }
  bool among_tasks() {
    for (std::uint32_t task = 0; task < image_.tasks.size(); ++task) {
      if (core::iequals(image_.tasks[task].name, steps_[0].name) && accept(task_place(task), steps_, 1)) return true;
    }
    return false;
  }

  /// The paths that end as the one that was written; else the nearest of the names that a path may begin with.
  [[nodiscard]] std::string nearest() const {
    constexpr std::size_t kNamed = 3;
    const auto listed = [this](const std::string& pattern) {
      PathLister lister(resource_, pattern, kNamed + 1, Paths::kNames);
      lister.leave_out_states();
      lister.run();
      return lister.take();
    };
    // An asterisk or a question mark would match anything.
    if (path_.find_first_of("*?#") == std::string_view::npos) {
      std::vector<Listed> ends = listed("*." + std::string(path_));
      if (ends.empty() && steps_.size() > 1) ends = listed("*." + std::string(path_.substr(path_.find('.') + 1)));
      std::string help;
      for (std::size_t i = 0; i < std::min(ends.size(), kNamed); ++i) {
        help += (i == 0 ? "\"" : i + 1 == ends.size() ? " or \"" : ", \"") + ends[i].path + '"';
      }
      if (!help.empty()) return "did you mean " + help + (ends.size() > kNamed ? ", .." : "") + "?";
    }
    Nearest nearest(steps_[0].name);
    for (const ImageField& field : globals()) nearest.offer(field.name);
    for (const bytecode::ImageGlobal& global : image_.globals) nearest.offer(global.list);
    for (std::size_t task = 0; task < image_.tasks.size(); ++task) {
      for (const ImageField& field : image_.types[body(task).instance_type].fields) nearest.offer(field.name);
    }
    std::string help = nearest.help();
    if (!help.empty() || steps_.size() > 1) return help;
    return nearest_variable();
  }

  /// A variable of an instance whose own name is nearly the one that was written.
  [[nodiscard]] std::string nearest_variable() const {
    constexpr std::size_t kLookedAt = 20'000;
    PathLister lister(resource_, "*", kLookedAt, Paths::kNames);
    lister.leave_out_states();
    lister.run();
    core::Guess guess(steps_[0].name);
    std::string best, path;
    for (Listed& listed : lister.take()) {
      guess.offer(std::string_view(listed.path).substr(listed.path.rfind('.') + 1));
      if (guess.best() == best) continue;
      best = guess.best();
      path = std::move(listed.path);
    }
    return path.empty() ? std::string{} : "did you mean \"" + path + "\"?";
  }

  const Resource& resource_;
  const Image& image_;
  std::string_view path_;
  bool wants_leaf_;
  std::vector<Step> steps_;
  Failure failure_;
  std::optional<Place> found_;
};

}  // namespace

core::Result<Place> Access::find(std::string_view path) const {
  return Finder(resource_, core::trimmed(path), false).run();
}

core::Result<Place> Access::find_leaf(std::string_view path) const {
  auto place = Finder(resource_, core::trimmed(path), true).run();
  if (place && !is_leaf(resource_.image().types[place->type])) {
    return Problem{Code::P7102, "\"" + std::string(path) + "\" is not a single value",
                   "name one element or field of it"};
  }
  return place;
}

std::vector<Listed> Access::list_places(std::string_view pattern, std::size_t limit) const {
  PathLister lister(resource_, pattern, limit, Paths::kAll);
  lister.run();
  return lister.take();
}

std::vector<std::string> Access::list_names(std::string_view pattern, std::size_t limit) const {
  if (pattern.starts_with('%')) return list(pattern, limit);  // addresses have no other names
  PathLister lister(resource_, pattern, limit, Paths::kNames);
  lister.run();
  PathLister others(resource_, pattern, limit, Paths::kAll);
  // What "*" leaves out is named already.
  if (pattern.find_first_not_of('*') != std::string_view::npos) others.run();
  lister.add_missing(std::move(others));
  std::vector<std::string> paths;
  for (Listed& listed : lister.take()) paths.push_back(std::move(listed.path));
  return paths;
}

std::vector<std::string> Access::list(std::string_view pattern, std::size_t limit) const {
  std::vector<std::string> paths;
  for (Listed& listed : list_places(pattern, limit)) paths.push_back(std::move(listed.path));
  return paths;
}

void Access::read_to(const Place& place, std::string& out, ValueStyle style) const {
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
      read_to(part, out, style);
    }
    out += array ? ']' : ')';
    return;
  }
  if (place.task != Place::kGlobal) {
    append_value(type, resource_.program(place.task).table().data() + place.offset, out, style);
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
  resource_.globals().read(place.offset, type.size, to);
  append_value(type, to, out, style);
}

std::string Access::read(const Place& place, ValueStyle style) const {
  std::string out;
  read_to(place, out, style);
  return out;
}

std::optional<std::int64_t> Access::read_integer(const Place& place) const {
  const ImageType& type = resource_.image().types[place.type];
  if (type.kind != TypeKind::kScalar || type.size > sizeof(std::int64_t)) return std::nullopt;
  alignas(8) std::byte value[8];
  if (place.task == Place::kGlobal) {
    resource_.globals().read(place.offset, type.size, value);
  } else {
    std::memcpy(value, resource_.program(place.task).table().data() + place.offset, type.size);
  }
  return core::integer_at(bytecode::rep_of(type), value);
}

std::optional<Problem> Access::write(const Place& place, std::string_view text) {
  const ImageType& type = resource_.image().types[place.type];
  if (!is_leaf(type)) return Problem{Code::P7102, "not a single value", "name one element or field of it"};
  if (place.constant) return Problem{Code::P7106, "the variable is declared CONSTANT", {}};
  std::vector<std::byte> value(type.size);
  if (auto problem = parse_value(type, text, value)) return problem;
  if (place.task == Place::kGlobal) {
    const GlobalWrite write{place.offset, place.type, value.data(), nullptr};
    switch (resource_.globals().write({&write, 1})) {
      case WriteResult::kDone:
        break;
      case WriteResult::kBusy:
        return Problem{Code::P7107, "its task has not started for long and too many writes are waiting for it",
                       "is the task stopped by a fault, or its period very long?"};
      case WriteResult::kRefused:
        if (resource_.globals().is_forced(place.offset))
          return Problem{Code::P7106, "the variable is forced", "release it first, or force another value"};
        return Problem{Code::P7106, "the variable is an input of a driver", "take it out of [inputs] in plc.toml"};
    }
  } else {
    resource_.program(place.task).write_local(place.offset, std::span(value).first(type.size));
  }
  return std::nullopt;
}

}  // namespace plc::runtime
