// The native engine: machine code for the resolved code of one task (docs/guides/engines.md).
//
// In: a program, whose linked code holds all addresses already. Out: a CompiledTask for Program::install(), which does
// what the interpreter does, bit for bit. Instructions without code of their own run in the interpreter, a few at a
// time. Time and memory grow with the program and with nothing else. Any thread; the task may run meanwhile.
// Does not belong here: when to compile (tools), resolving (runtime/link.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/result.h"
#include "native/change_tracker.h"
#include "native/code_memory.h"
#include "native/operation.h"
#include "runtime/compiled_task.h"
#include "runtime/program.h"
#include "runtime/sched/task_plan.h"

namespace plc::native {

struct CompileReport {
  struct Body {
    std::uint32_t pou = 0;  ///< index into Image::pous
    std::size_t bytes = 0;  ///< of machine code
  };
  std::vector<Body> bodies;  ///< in the order of the code
  std::size_t code_bytes = 0;
  /// How many instructions of which kind run in the interpreter.
  std::map<runtime::ResolvedOp, std::uint32_t> interpreted;
};

class NativeTask final : public runtime::CompiledTask {
 public:
  /// The code begins with what a scan calls.
  NativeTask(CodeMemory memory, std::vector<std::uint32_t> words, std::vector<runtime::CodeMark> code_marks,
             std::unique_ptr<ChangeTracker> tracker, CompileReport report)
      : memory_(std::move(memory)),
        tracker_(std::move(tracker)),
        words_(std::move(words)),
        marks_(std::move(code_marks)),
        report_(std::move(report)) {
    run = reinterpret_cast<bool (*)(runtime::Machine&) noexcept>(reinterpret_cast<std::uintptr_t>(memory_.data()));
    code = words_;
    marks = marks_;
  }
  [[nodiscard]] const CompileReport& report() const { return report_; }
  [[nodiscard]] const runtime::SkipCounts* skipped() const noexcept override {
    return tracker_ ? &tracker_->counts() : nullptr;
  }

 private:
  CodeMemory memory_;
  std::unique_ptr<ChangeTracker> tracker_;  ///< null when each scan executes everything
  std::vector<std::uint32_t> words_;
  std::vector<runtime::CodeMark> marks_;
  CompileReport report_;
};

inline constexpr auto kPatience = static_cast<std::uint32_t>(100 * runtime::kChangedShare);

struct CompileOptions {
  /// Boolean logic of more look-up records than this is not made code; nothing = as many as this processor's second
  /// cache holds as code.
  std::optional<std::size_t> most_records_as_code = std::nullopt;
  /// No instructions but those that every processor of this kind has.
  bool baseline = false;
  /// Scans leave out what would change nothing, because none of its inputs changed (docs/adr/0022).
  bool changed = false;
  /// Most that finding and running changed parts one by one may take before the rest of a scan runs as a whole; in
  /// percent of a whole scan.
  std::uint32_t patience = kPatience;
};

/// Compiles a task. P9001 when the system gives no executable memory, or there is no code generator for this processor.
core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program& program, const CompileOptions& options = {});

}  // namespace plc::native
