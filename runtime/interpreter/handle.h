// Handle: the value of a REF leaf. A checked name of a typed place in a task's table, never a pointer, so that tables
// can be copied, moved and saved.
//
// Bits 0..30 byte offset in the table, 31..52 type index, 53..63 tag: 0 = null, 1 = in the copy of the global table
// (the same place in every task), 2 + n = in the rest of the table of task n. Only REF_AT and REF_VIA make
// handles, from verified places, so tag and type together prove the offset; a handle that travelled to another
// task is null there.
#pragma once

#include <cstdint>

namespace plc::runtime {

struct Handle {
  std::uint64_t bits = 0;

  static constexpr std::uint32_t kMaxTypes = 1u << 22;
  static constexpr std::uint32_t kMaxTasks = (1u << 11) - 2;
  static constexpr std::uint64_t kGlobalTag = 1;
  static constexpr std::uint64_t task_tag(std::uint32_t task) { return std::uint64_t{task} + 2; }

  static constexpr Handle make(std::uint64_t tag, std::uint32_t type, std::uint32_t offset) {
    return {tag << 53 | std::uint64_t{type} << 31 | offset};
  }
  [[nodiscard]] constexpr std::uint64_t tag() const { return bits >> 53; }
  [[nodiscard]] constexpr std::uint32_t type() const { return static_cast<std::uint32_t>(bits >> 31) & 0x3fffffu; }
  [[nodiscard]] constexpr std::uint32_t offset() const { return static_cast<std::uint32_t>(bits) & 0x7fffffffu; }
};

}  // namespace plc::runtime
