// Parts of values: where the path of an instruction leads, from a place, through a reference or through a pointer.
//
// In: words of resolved code (link.h). Out: addresses inside the task's table, or an event. All of it is RT: bounded by
// the indices of the path, and by how deep types nest. Internal to the interpreter. Does not belong here: dispatch.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "runtime/interpreter/operations.h"
#include "runtime/pointers/pointer.h"
#include "stdlib/library.h"

namespace plc::runtime {

/// The part of the value at `base` that a path leads to; null where an index leaves its array.
template <Addressing kAddressing>
[[gnu::always_inline]] inline std::byte* follow(const Machine& m, std::uint32_t instance, std::byte* base,
                                                const std::uint32_t* path) noexcept {
  // A number, since an index outside of its array leads anywhere.
  std::uint64_t offset = path[0];
  const std::uint32_t* index = path + 2;
  const auto next = [&m, instance, &offset, &index ]() __attribute__((always_inline)) {
    const std::uint64_t element = element_of(index, place<kAddressing>(m.table, instance, index[0]));
    offset += element * index[2];
    const bool inside = element < index[1];
    index += kIndexWords;
    return inside;
  };
  // Most paths that come here have two.
  if (path[1] == 2) {
    if (!next()) return nullptr;
    return next() ? base + offset : nullptr;
  }
  for (std::uint32_t i = path[1]; i != 0; --i) {
    if (!next()) return nullptr;
  }
  return base + offset;
}
/// Null after an event, for the instruction at `pc`. RT.
template <Addressing kAddressing>
std::byte* part_at(Machine& m, std::uint32_t instance, const std::uint32_t* pc, std::uint32_t whole,
                   const std::uint32_t* path) noexcept {
  std::byte* const part = follow<kAddressing>(m, instance, place<kAddressing>(m.table, instance, whole), path);
  if (part == nullptr) [[unlikely]]
    raise(m, pc, stdlib::Event::kBadIndex);
  return part;
}
/// The same through a reference. RT.
template <Addressing kAddressing>
std::byte* part_via(Machine& m, std::uint32_t instance, const std::uint32_t* pc, std::uint32_t ref, std::uint32_t type,
                    Use use, const std::uint32_t* path) noexcept {
  std::byte* const whole = target(m, load<Handle>(place<kAddressing>(m.table, instance, ref)), type, use);
  std::byte* const part = whole == nullptr ? nullptr : follow<kAddressing>(m, instance, whole, path);
  if (part == nullptr) [[unlikely]]
    raise(m, pc, whole == nullptr ? stdlib::Event::kNullReference : stdlib::Event::kBadIndex);
  return part;
}

/// The pointer at `operand`, moved along a path; nothing after an index outside of its array, which is an event. RT.
template <Addressing kAddressing>
std::optional<Pointer> moved(Machine& m, std::uint32_t instance, const std::uint32_t* pc, std::uint32_t operand,
                             const std::uint32_t* path) noexcept {
  auto pointer = load<Pointer>(place<kAddressing>(m.table, instance, operand));
  pointer.bits += path[0];
  const std::uint32_t* index = path + 2;
  for (std::uint32_t i = path[1]; i != 0; --i, index += kIndexWords) {
    const std::uint64_t element = element_of(index, place<kAddressing>(m.table, instance, index[0]));
    if (element >= index[1]) [[unlikely]] {
      raise(m, pc, stdlib::Event::kBadIndex);
      return std::nullopt;
    }
    pointer.bits += element * index[2];
  }
  return pointer;
}

}  // namespace plc::runtime
