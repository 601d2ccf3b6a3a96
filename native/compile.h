// The native engine: machine code for the resolved code of one task (docs/guides/engines.md).
//
// In: a program, whose linked code holds all addresses already. Out: a CompiledTask for Program::install(), which does
// what the interpreter does, bit for bit. Instructions without code of their own run in the interpreter, a few at a
// time. Time and memory grow with the program and with nothing else. Any thread; the task may run meanwhile.
// Does not belong here: when to compile (tools), resolving (runtime/link/link.h).
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/result.h"
#include "native/code_memory.h"
#include "native/operation.h"
#include "runtime/compiled_task.h"
#include "runtime/program.h"

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
             CompileReport report)
      : memory_(std::move(memory)),
        words_(std::move(words)),
        marks_(std::move(code_marks)),
        report_(std::move(report)) {
    run = std::bit_cast<bool (*)(runtime::Machine&) noexcept>(memory_.data());
    code = words_;
    marks = marks_;
  }
  [[nodiscard]] const CompileReport& report() const { return report_; }

 private:
  CodeMemory memory_;
  std::vector<std::uint32_t> words_;
  std::vector<runtime::CodeMark> marks_;
  CompileReport report_;
};

/// How variables of the table are named.
enum class Naming : std::uint8_t { kFromRegister, kFromCode };

struct CompileOptions {
  /// No instructions but those that every processor of this kind has.
  bool baseline = false;
  /// Nothing = what this processor runs faster (naming.h). kFromCode is a wish: the table may be out of reach.
  std::optional<Naming> naming = std::nullopt;
};

/// Compiles a task. P9001 when the system gives no executable memory, or there is no code generator for this processor.
core::Result<std::unique_ptr<NativeTask>> compile(runtime::Program& program, const CompileOptions& options = {});

}  // namespace plc::native
