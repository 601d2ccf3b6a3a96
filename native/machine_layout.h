// Where members of runtime::Machine lie, for code that reaches them through its address.
//
// Does not belong here: how such code reads them (x86_64/, aarch64/).
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/interpreter/interpreter.h"

namespace plc::native::machine {

// Machine holds atomics and a span, so the standard leaves its layout to the compiler; both compilers know it.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winvalid-offsetof"
using runtime::Machine;
static_assert(sizeof(Machine::loops_left) == 4 && sizeof(Machine::place) == 4 && sizeof(Machine::event_count) == 8);
inline constexpr std::int32_t kLoopsLeft = offsetof(Machine, loops_left);    ///< 4 bytes
inline constexpr std::int32_t kPlace = offsetof(Machine, place);             ///< 4 bytes
inline constexpr std::int32_t kEventCount = offsetof(Machine, event_count);  ///< 8 bytes
inline constexpr std::int32_t kStep = offsetof(Machine, step);               ///< the context that blocks are given
inline constexpr std::int32_t kNow = kStep + std::int32_t{offsetof(stdlib::StepContext, now_ns)};  ///< the time in it
#pragma GCC diagnostic pop

}  // namespace plc::native::machine
