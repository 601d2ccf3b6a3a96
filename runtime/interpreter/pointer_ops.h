// What the instructions of pointers do beyond finding their operands: accesses through pointers/objects.h, and the
// event of one that leads nowhere.
//
// In: a pointer, or nothing after an index that was an event; words of resolved code. Out: changed memory, at most one
// event. All of it is RT, bounded as Objects is. Internal to the interpreter. Does not belong here: paths (paths.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "runtime/interpreter/handle.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/pointers/pointer.h"

namespace plc::runtime {

/// The pointer to the value of `type` at `part`, which is null after an event. RT.
Pointer address_of(Machine& m, const std::uint32_t* pc, const std::byte* part, std::uint32_t type) noexcept;
/// ADR_PTR: `part` of what `whole` leads to; null is no whole. RT.
inline Pointer part_of(Pointer whole, std::optional<Pointer> part) noexcept {
  return whole.bits == 0 ? whole : part.value_or(Pointer{});
}
/// LOAD_PTR and STORE_PTR: words from the type on are type of the part, capacity of the string outside, and of a load
/// the zeros of the type (2). RT.
void load_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> from, const std::uint32_t* type,
                  std::byte* to) noexcept;
void store_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> to, const std::uint32_t* type,
                   const std::byte* from) noexcept;
/// The handle of the value of exactly `type` that the pointer leads to. RT.
Handle handle_through(Machine& m, const std::uint32_t* pc, std::optional<Pointer> to, std::uint32_t type) noexcept;
/// PTR_TO_32 and PTR_FROM_32. RT.
std::uint32_t pointer_to_32(Machine& m, const std::uint32_t* pc, Pointer pointer) noexcept;
Pointer pointer_from_32(Machine& m, const std::uint32_t* pc, std::uint32_t address) noexcept;

}  // namespace plc::runtime
