// What the interpreter's handlers share: typed loads and stores, strings, handles, events and faults.
//
// In: addresses inside one task's table. Out: the effect an instruction has beyond plain arithmetic. Everything here is
// RT. Does not belong here: dispatch (interpreter.cpp).
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "core/types.h"
#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/taskblocks.h"

namespace plc::runtime {

template <class T>
inline T load(const void* from) noexcept {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}
template <class T>
inline void store(std::byte* to, T value) noexcept {
  std::memcpy(to, &value, sizeof value);
}
/// Shifts by a constant from 0 to 63, by the width or more to 0: in 64 bits there is nothing to look at.
template <class T>
inline T shift_left(T value, std::uint8_t n) noexcept {
  return static_cast<T>(std::uint64_t{value} << (n & 63u));
}
template <class T>
inline T shift_right(T value, std::uint8_t n) noexcept {
  return static_cast<T>(std::uint64_t{value} >> (n & 63u));
}

/// A pointer that takes two words of resolved code.
template <class T>
inline T load_pointer(const std::uint32_t* words) noexcept {
  static_assert(sizeof(T) == 8);
  return load<T>(words);
}

/// The address of a resolved operand (link.h).
template <Addressing kAddressing>
inline std::byte* place(std::byte* table, std::uint32_t instance, std::uint32_t operand) noexcept {
  if constexpr (kAddressing == Addressing::kFixed) {
    return table + operand;
  } else {
    return table + (operand & ~kRelativeBit) + ((0u - (operand >> 31)) & instance);
  }
}

/// Code word of the instruction at `position`, for events and faults.
inline const CodeMark& mark_at(std::span<const CodeMark> marks, std::uint32_t position) noexcept {
  const auto after = std::upper_bound(marks.begin(), marks.end(), position,
                                      [](std::uint32_t p, const CodeMark& mark) { return p < mark.position; });
  return *(after - 1);
}
inline const CodeMark& mark_at(const Machine& m, const std::uint32_t* pc) noexcept {
  return mark_at(m.marks, static_cast<std::uint32_t>(pc - m.code));
}

[[gnu::noinline, gnu::cold]] inline void raise(Machine& m, const std::uint32_t* pc, stdlib::Event event) noexcept {
  ++m.event_count;
  const CodeMark& mark = mark_at(m, pc);
  m.events->record(mark.pou, mark.word, event);
}

[[gnu::noinline, gnu::cold]] inline void fail(Machine& m, const std::uint32_t* pc, FaultKind kind) noexcept {
  const CodeMark& mark = mark_at(m, pc);
  m.fault = {kind, mark.pou, mark.word};
}
/// After a taskblock ran: false when the scan is over.
[[gnu::noinline, gnu::cold]] inline bool settle_taskblock(Machine& m, const std::uint32_t* pc,
                                                          Taskblocks::Status status) noexcept {
  if (status == Taskblocks::Status::kOutOfRange) {
    raise(m, pc, stdlib::Event::kOutOfRange);
    return true;
  }
  fail(m, pc, status == Taskblocks::Status::kLate ? FaultKind::kBudget : FaultKind::kTaskblock);
  m.fault.taskblock = m.taskblocks->failed();
  return false;
}

/// After the step of a block that may be a taskblock: false when the scan is over.
inline bool settle_step(Machine& m, const std::uint32_t* pc) noexcept {
  if (m.taskblocks == nullptr) return true;
  const Taskblocks::Status status = m.taskblocks->take_status();
  return status == Taskblocks::Status::kFine || settle_taskblock(m, pc, status);
}

/// Copies a string of `width`-byte characters; `capacities` = that of the destination | that of the source << 16, from
/// the type map: headers are clamped to them. False when it was cut.
inline bool copy_string(std::byte* to, const std::byte* from, std::uint32_t capacities, std::uint32_t width) noexcept {
  const auto capacity = static_cast<std::uint16_t>(capacities);
  const auto available = static_cast<std::uint16_t>(capacities >> 16);
  const std::uint16_t length = std::min(load<core::StringHeader>(from).length, available);
  const std::uint16_t kept = std::min(length, capacity);
  std::memmove(to + sizeof(core::StringHeader), from + sizeof(core::StringHeader), std::size_t{kept} * width);
  store(to, core::StringHeader{capacity, kept});
  return kept == length;
}

/// The third word of an argument of CALL_FN when it is not a number of bytes.
inline constexpr std::uint32_t kPassStr = 0xffffffffu;
inline constexpr std::uint32_t kPassWstr = 0xfffffffeu;

/// Moves one argument of CALL_FN. False when a string was cut.
inline bool pass(std::byte* to, const std::byte* from, std::uint32_t bytes, std::uint32_t capacities) noexcept {
  switch (bytes) {
    case 1:
      store(to, load<std::uint8_t>(from));
      return true;
    case 2:
      store(to, load<std::uint16_t>(from));
      return true;
    case 4:
      store(to, load<std::uint32_t>(from));
      return true;
    case 8:
      store(to, load<std::uint64_t>(from));
      return true;
    case kPassStr:
      return copy_string(to, from, capacities, 1);
    case kPassWstr:
      return copy_string(to, from, capacities, 2);
    default:
      std::memmove(to, from, bytes);
      return true;
  }
}

inline Handle handle_of(const Machine& m, const std::byte* place, std::uint32_t type) noexcept {
  const auto offset = static_cast<std::uint32_t>(place - m.table);
  return Handle::make(offset < m.global_bytes ? Handle::kGlobalTag : m.task_tag, type, offset);
}

/// Words of one index in resolved code: operand, count, stride, lower bound (2), Rep.
inline constexpr std::uint32_t kIndexWords = 6;
/// Words of a path in resolved code: distance in bytes, number of indices, indices.
inline std::uint32_t path_words(const std::uint32_t* path) noexcept { return 2 + path[1] * kIndexWords; }

/// Number of the element, from 0, whose index is the leaf at `leaf`; one beyond every array when it is below the lower
/// bound. Wraps: the upper bound is a 64-bit number (rule V104), so no index of a wrong sign comes out inside the
/// array.
inline std::uint64_t element_of(const std::uint32_t* index, const std::byte* leaf) noexcept {
  const auto lower = load<std::uint64_t>(index + 3);
  const auto rep = static_cast<core::Rep>(index[5]);
  // Most indices: without a jump through a table.
  if (rep == core::Rep::kI32) return static_cast<std::uint64_t>(load<std::int32_t>(leaf)) - lower;
  if (rep == core::Rep::kI16) return static_cast<std::uint64_t>(load<std::int16_t>(leaf)) - lower;
  switch (rep) {
    case core::Rep::kI8:
      return static_cast<std::uint64_t>(load<std::int8_t>(leaf)) - lower;
    case core::Rep::kU8:
      return std::uint64_t{load<std::uint8_t>(leaf)} - lower;
    case core::Rep::kU16:
      return std::uint64_t{load<std::uint16_t>(leaf)} - lower;
    case core::Rep::kU32:
      return std::uint64_t{load<std::uint32_t>(leaf)} - lower;
    case core::Rep::kU64: {
      const auto value = load<std::uint64_t>(leaf);
      return value >> 63 != 0 ? ~std::uint64_t{0} : value - lower;
    }
    default:
      return load<std::uint64_t>(leaf) - lower;
  }
}

enum class Use : std::uint8_t { kRead, kWrite };

/// The place of type `type` that `handle` names in this task, or null.
inline std::byte* target(const Machine& m, Handle handle, std::uint32_t type, Use use) noexcept {
  const bool here = handle.tag() == Handle::kGlobalTag || handle.tag() == m.task_tag;
  if (!here || handle.type() != type) return nullptr;
  const std::uint32_t offset = handle.offset();
  if (use == Use::kWrite && offset >= m.constants_begin && offset < m.constants_end) return nullptr;
  return m.table + offset;
}

}  // namespace plc::runtime
