// Where a number comes from that alarms and the historian look at: a variable of a task or a global, never in a table
// that a task works on.
//
// In: a resource, a path. Out: a place that can be read again and again. Threads: any. Does not belong here: when it is
// read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/result.h"
#include "runtime/access.h"

namespace plc::alarms {

struct Watched {
  runtime::Place place;
  core::TypeId type = core::TypeId::kBool;
  /// After whose scans it is looked at in replicas; none: a global that no task has, or nothing is recorded.
  std::optional<std::uint32_t> task;
  [[nodiscard]] bool is_global() const { return place.task == runtime::Place::kGlobal; }
};

/// A BOOL, number, bit string, enumeration or duration. P7101, P7102; P7720 for a variable of a task when nothing is
/// recorded.
core::Result<Watched> watch(runtime::Resource& resource, std::string_view path, bool recorded);
/// BOOL as 0 or 1, durations in seconds.
double number_at(const std::byte* from, core::TypeId type);
/// Bytes of a value that watch() takes.
std::uint32_t bytes_of(core::TypeId type);
/// A STRING, as UTF-8.
std::string text_at(const std::byte* from, std::uint16_t capacity);

}  // namespace plc::alarms
