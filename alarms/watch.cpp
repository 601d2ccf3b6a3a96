#include "alarms/watch.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/integer_at.h"
#include "core/utf8.h"
#include "core/windows_1252.h"
#include "runtime/link/link.h"
#include "stdlib/strings.h"

namespace plc::alarms {
namespace {

using core::Rep;
using core::TypeId;

template <class T>
double load(const std::byte* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

/// The fastest of those that publish the global, else of those that take it in.
// WHY one: replicas execute the scans of one task after those of another, so that the values of several would come in
// another order than in the plant.
std::optional<std::uint32_t> task_of(const runtime::Resource& resource, std::uint32_t offset) {
  const bytecode::Image& image = resource.image();
  const std::uint32_t field = resource.globals().field_of(offset);
  std::vector<std::uint32_t> tasks = resource.globals().exporters(field);
  const bool published = !tasks.empty();
  for (std::uint32_t t = 0; !published && t < image.tasks.size(); ++t) {
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[t].body)) {
      if (field < range.first || field >= range.first + range.count) continue;
      tasks.push_back(t);
      break;
    }
  }
  const auto pace = [&image](std::uint32_t task) {
    return image.tasks[task].single.empty() ? image.tasks[task].period_ns : INT64_MAX;
  };
  const auto fastest =
      std::min_element(tasks.begin(), tasks.end(), [&](std::uint32_t a, std::uint32_t b) { return pace(a) < pace(b); });
  if (fastest == tasks.end()) return std::nullopt;
  return *fastest;
}

}  // namespace

core::Result<Watched> watch(runtime::Resource& resource, std::string_view path, bool recorded) {
  const auto place = runtime::Access(resource).find_leaf(path);
  if (!place) return place.error();
  const bytecode::ImageType& type = resource.image().types[place->type];
  const bool text = type.kind == bytecode::TypeKind::kString || core::in_category(type.elementary, core::kAnyChars);
  if (text || core::in_category(type.elementary, core::kAnyDate)) {
    return core::Problem{core::Code::P7102, "\"" + std::string(path) + "\" is a text or a date",
                         "take a BOOL, a number, a duration or an enumeration"};
  }
  Watched watched{*place, type.elementary, std::nullopt};
  if (!watched.is_global()) {
    if (!recorded) {
      return core::Problem{core::Code::P7720,
                           "\"" + std::string(path) + "\" is a variable of a task, and scans are not recorded",
                           "make it a global, or leave [record] mode on"};
    }
    watched.task = place->task;
  } else if (recorded) {
    watched.task = task_of(resource, place->offset);
  }
  return watched;
}

std::uint32_t bytes_of(TypeId type) { return core::rep_bytes(core::rep_of(type)); }

double number_at(const std::byte* from, TypeId type) {
  const Rep rep = core::rep_of(type);
  if (rep == Rep::kF32) return load<float>(from);
  if (rep == Rep::kF64) return load<double>(from);
  if (rep == Rep::kU64) return load<std::uint64_t>(from);
  const auto number = static_cast<double>(core::integer_at(rep, from).value_or(0));
  return core::in_category(type, core::kAnyDuration) ? number / 1e9 : number;
}

std::string text_at(const std::byte* from, std::uint16_t capacity) {
  std::string text;
  for (const char c : stdlib::text_of<char>(from, capacity))
    core::append_utf8(core::from_windows_1252(static_cast<std::uint8_t>(c)), text);
  return text;
}

}  // namespace plc::alarms
