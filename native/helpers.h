// What native code calls: the parts of instructions that are C++.
//
// In: machine, position in the resolved code. Out: the effect the interpreter's handler has there. Everything here is
// RT. Does not belong here: making code.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/interpreter/interpreter.h"

namespace plc::native {

/// The instruction at `position` raised `event` (stdlib::Event).
void raise_event(runtime::Machine& machine, std::uint32_t position, std::uint32_t event) noexcept;
/// The loop jump at `position` found no budget left.
void fail_loop(runtime::Machine& machine, std::uint32_t position) noexcept;
/// One execution of a taskblock. False: machine.fault is set.
bool run_taskblock(runtime::Machine& machine, std::uint32_t position, std::byte* ports) noexcept;
/// Copies a text (runtime::copy_string). False when it was cut.
bool copy_text(std::byte* to, const std::byte* from, std::uint32_t capacities, std::uint32_t width) noexcept;

}  // namespace plc::native
