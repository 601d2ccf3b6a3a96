// CompiledTask: what another engine made of the resolved code of one task, for Program::install().
//
// In: LinkedCode (link.h). Out: a function that does what interpreting it does: the same table, events and faults after
// every scan. Does not belong here: making it (native/).
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "runtime/interpreter.h"

namespace plc::runtime {

/// What evaluate = "changed" left out (docs/guides/engines.md). Written by the task, read by anyone.
struct SkipCounts {
  std::uint32_t groups = 0;                   ///< that the task has
  std::atomic<std::uint64_t> scans{0};        ///< since it was installed
  std::atomic<std::uint64_t> whole_scans{0};  ///< of these, those that ran the plain code, to the end at least
  std::atomic<std::uint64_t> runs{0};         ///< of groups, in the others
};

struct CompiledTask {
  CompiledTask() = default;
  CompiledTask(const CompiledTask&) = delete;
  CompiledTask& operator=(const CompiledTask&) = delete;
  virtual ~CompiledTask() = default;

  /// Executes the body of the task. False: machine.fault is set. RT.
  bool (*run)(Machine& machine) noexcept = nullptr;
  /// Machine::code and Machine::marks while it runs: those of the linked code, with more behind them at most.
  std::span<const std::uint32_t> code;
  std::span<const CodeMark> marks;
  /// Null when each scan executes everything.
  [[nodiscard]] virtual const SkipCounts* skipped() const noexcept { return nullptr; }
};

}  // namespace plc::runtime
