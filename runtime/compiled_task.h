// CompiledTask: what another engine made of the resolved code of one task, for Program::install().
//
// In: LinkedCode (link.h). Out: a function that does what interpreting it does: the same table, events and faults after
// every scan. Does not belong here: making it (native/).
#pragma once

#include <cstdint>
#include <span>

#include "runtime/interpreter/interpreter.h"

namespace plc::runtime {

struct CompiledTask {
  CompiledTask() = default;
  CompiledTask(const CompiledTask&) = delete;
  CompiledTask& operator=(const CompiledTask&) = delete;
  virtual ~CompiledTask() = default;

  /// Executes the body of the task. False: machine.fault is set. RT.
  bool (*run)(Machine& machine) noexcept = nullptr;
  /// Machine::code and Machine::marks while it runs: those of the linked code, with more after them at most.
  std::span<const std::uint32_t> code;
  std::span<const CodeMark> marks;
};

}  // namespace plc::runtime
