// Coverage: which instructions generated programs had, and which engine ran them.
//
// In: programs as they are compiled. Out: a table. Does not belong here: making programs.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>

#include "tests/support/engines.h"

namespace plc::test {

class Coverage {
 public:
  /// Native code whose compilations are counted. The coverage must outlive it.
  Engine native_code();
  /// What is compiled from now on belongs to another program.
  void next_program() { ++program_; }

  /// Kinds of instruction, and those that no program had.
  void print_summary(std::ostream& out) const;
  /// A line for each kind: in how many programs it was, as machine code and left to the interpreter.
  void print(std::ostream& out) const;

 private:
  static constexpr std::size_t kOps = static_cast<std::size_t>(runtime::ResolvedOp::kCount);
  /// Counts each program once.
  struct Count {
    std::uint64_t programs = 0;
    std::uint64_t last = 0;
    void add(std::uint64_t program) {
      programs += last == program ? 0 : 1;
      last = program;
    }
  };
  struct Row {
    Count compiled, interpreted;
  };

  std::uint64_t program_ = 0;
  std::array<Row, kOps> rows_{};
};

}  // namespace plc::test
