#include "testing/mirror.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "bytecode/paths.h"
#include "core/text.h"

namespace plc::tests {

using bytecode::Image;
using bytecode::ImageField;
using bytecode::ImageType;
using bytecode::TypeKind;
using runtime::Place;

core::Result<std::unique_ptr<Mirror>> Mirror::make(runtime::Resource& project, runtime::Resource& tests,
                                                   const std::vector<std::string>& programs) {
  std::unique_ptr<Mirror> made(new Mirror(project, tests));
  const Image& from = project.image();
  const Image& to = tests.image();
  const std::vector<ImageField>& fields = from.types[from.global_type].fields;
  const std::vector<ImageField>& copies = to.types[to.global_type].fields;
  const auto differs = [](const std::string& name) {
    return core::Problem{core::Code::P9001, fmt::format("\"{}\" is laid out differently for the tests", name), {}};
  };
  // Queues and what a build adds for itself (#coverage) have no copies.
  for (std::size_t f = 0; f < fields.size(); ++f) {
    if (fields[f].name.starts_with('#') || fields[f].constant) continue;
    for (std::size_t c = 0; c < copies.size(); ++c) {
      if (copies[c].name != fields[f].name || to.globals[c].list != from.globals[f].list) continue;
      const std::string& list = from.globals[f].list;
      if (!made->add(list.empty() ? fields[f].name : list + "." + fields[f].name,
                     {Place::kGlobal, fields[f].offset, fields[f].type, false},
                     {0, copies[c].offset, copies[c].type, false})) {
        return differs(fields[f].name);
      }
    }
  }
  for (const std::string& program : programs) {
    const auto place = made->access_.find(program);
    if (!place) return place.error();
    const auto copy = std::find_if(copies.begin(), copies.end(), [&](const ImageField& field) {
      return field.name == program && to.globals[static_cast<std::size_t>(&field - copies.data())].list.empty();
    });
    if (copy == copies.end() || !made->add(program, *place, {0, copy->offset, copy->type, false}))
      return differs(program);
  }
  made->globals_.resize(project.globals().size());
  made->seen_.resize(tests.program(0).table().layout().global_bytes);
  return made;
}

bool Mirror::add(const std::string& path, const Place& place, const Place& copy) {
  Part part;
  part.path = path;
  part.place = place;
  part.to = copy.offset;
  if (!add_runs(part, place.type, copy.type, 0, 0)) return false;
  for (Run& run : part.runs) {
    run.from += place.offset;
    run.to += copy.offset;
  }
  parts_.push_back(std::move(part));
  return true;
}

bool Mirror::add_runs(Part& part, std::uint32_t type, std::uint32_t copy_type, std::uint32_t from,
                      std::uint32_t to) const {
  const ImageType& t = project_.image().types[type];
  const ImageType& u = tests_.image().types[copy_type];
  if (t.kind != u.kind || t.size != u.size || t.fields.size() != u.fields.size() || t.count != u.count) return false;
  switch (t.kind) {
    case TypeKind::kRef:
      return true;
    case TypeKind::kStruct:
      for (std::size_t f = 0; f < t.fields.size(); ++f) {
        const ImageField& a = t.fields[f];
        const ImageField& b = u.fields[f];
        if (a.name != b.name || a.offset != b.offset) return false;
        if (!add_runs(part, a.type, b.type, from + a.offset, to + b.offset)) return false;
      }
      return true;
    case TypeKind::kArray: {
      const std::uint32_t size = project_.image().types[t.element].size;
      for (std::uint32_t i = 0; i < t.count; ++i) {
        if (!add_runs(part, t.element, u.element, from + i * size, to + i * size)) return false;
      }
      return true;
    }
    default:
      if (!part.runs.empty() && part.runs.back().from + part.runs.back().bytes == from) {
        part.runs.back().bytes += t.size;
      } else {
        part.runs.push_back({from, to, t.size});
      }
      return true;
  }
}

std::byte* Mirror::project_bytes(const Part& part) {
  return part.place.task == Place::kGlobal ? globals_.data() : project_.program(part.place.task).table().data();
}

void Mirror::pull() {
  project_.globals().copy(globals_.data());
  std::byte* const table = tests_.program(0).table().data();
  for (const Part& part : parts_) {
    const std::byte* const from = project_bytes(part);
    for (const Run& run : part.runs) {
      std::memcpy(table + run.to, from + run.from, run.bytes);
      std::memcpy(seen_.data() + run.to, from + run.from, run.bytes);
    }
  }
}

void Mirror::find_changes(const Part& part, std::uint32_t type, std::uint32_t offset, const std::string& path,
                          std::vector<Leaf>& changes) const {
  const Image& image = project_.image();
  const ImageType& t = image.types[type];
  const std::byte* const table = tests_.program(0).table().data();
  const std::uint32_t to = part.to + offset;
  if (std::memcmp(table + to, seen_.data() + to, t.size) == 0) return;
  switch (t.kind) {
    case TypeKind::kRef:
      return;
    case TypeKind::kStruct:
      for (const ImageField& field : t.fields)
        find_changes(part, field.type, offset + field.offset, path + "." + field.name, changes);
      return;
    case TypeKind::kArray:
      for (std::uint32_t i = 0; i < t.count; ++i) {
        find_changes(part, t.element, offset + i * image.types[t.element].size,
                     fmt::format("{}[{}]", path, t.lower + i), changes);
      }
      return;
    default:
      changes.push_back({part.place.offset + offset, to, type, path});
  }
}

std::optional<core::Problem> Mirror::push() {
  std::byte* const table = tests_.program(0).table().data();
  std::vector<runtime::GlobalWrite> writes;
  std::string first;
  std::vector<Leaf> changes;
  for (const Part& part : parts_) {
    changes.clear();
    find_changes(part, part.place.type, 0, part.path, changes);
    for (const Leaf& leaf : changes) {
      Place place{part.place.task, leaf.from, leaf.type, false};
      // A located variable of a program is a global, which has a path below the instance too; the field has a '#' after
      // its name. What begins with one is hidden.
      if (place.task != Place::kGlobal && leaf.path.find(".#") == std::string::npos) {
        std::string path = leaf.path;
        std::erase(path, '#');
        if (const auto found = access_.find(path)) place = *found;
      }
      if (place.task == Place::kGlobal) {
        if (writes.empty()) first = leaf.path;
        writes.push_back({place.offset, place.type, table + leaf.to, nullptr});
      } else {
        std::memcpy(project_.program(place.task).table().data() + place.offset, table + leaf.to,
                    project_.image().types[place.type].size);
      }
      std::memcpy(seen_.data() + leaf.to, table + leaf.to, project_.image().types[leaf.type].size);
    }
  }
  if (writes.empty()) return std::nullopt;
  switch (project_.globals().write(writes)) {
    case runtime::WriteResult::kDone:
      return std::nullopt;
    case runtime::WriteResult::kBusy:
      return core::Problem{core::Code::P7107, fmt::format("\"{}\" is not written: its task has stopped", first), {}};
    case runtime::WriteResult::kRefused:
      break;
  }
  return core::Problem{core::Code::P7106, fmt::format("\"{}\" cannot be written", first), {}};
}

}  // namespace plc::tests
