// LoopPlan: a loop run (loop_run.h) before it is words.
//
// In: what link_loops.cpp has found out of a loop. Out: the words that run_loop() reads. Streams have numbers by kind
// until they are written, then places in one row. Compile time. Does not belong here: which loops become runs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "runtime/link_operand.h"
#include "runtime/operations.h"

namespace plc::runtime {

struct LoopPlan {
  /// constant + factor * control variable + the sum of factor * variable, modulo its size.
  struct Affine {
    struct Term {
      std::uint32_t operand = 0;
      std::int64_t factor = 0;
      friend auto operator<=>(const Term&, const Term&) = default;
    };
    std::int64_t constant = 0;
    std::int64_t factor = 0;
    std::vector<Term> terms;  ///< ascending, no operand twice
    std::uint32_t bytes = 0;
  };
  struct Index {
    std::uint32_t count = 0, stride = 0;
    std::int64_t lower = 0;
    Affine number;
  };
  /// One access to an element.
  struct Element {
    OperandRange array;       ///< every element that the indices can name
    std::uint32_t bytes = 0;  ///< of the element
    std::vector<Index> indices;
    bool write = false;
  };
  struct Record {
    std::uintptr_t run = 0;  ///< StreamRun, or Kernel
    std::uint32_t out = 0;
    std::vector<std::uint32_t> in;
    std::uint32_t arguments = 0;
    std::uint32_t position = 0;
  };
  /// What a variable has behind the last round.
  struct LastValue {
    std::uint32_t operand = 0;
    std::uint32_t stream = 0;
    std::uint32_t bytes = 0;
  };
  /// The same, where it is computed from variables.
  struct LastComputed {
    std::uint32_t position = 0;  ///< of its instruction
    std::uintptr_t run = 0;      ///< ValueRun
    std::vector<std::uint32_t> operands;
  };
  /// The rounds of a loop from a constant to a constant, as most are.
  struct KnownRounds {
    std::int64_t start = 0, added = 0, jumps = 0;
  };

  enum class StreamKind : std::uint8_t { kVariable, kValue, kElement };
  static std::uint32_t stream(StreamKind kind, std::size_t i) {
    return static_cast<std::uint32_t>(kind) << 16 | static_cast<std::uint32_t>(i);
  }

  bool wide = false, down = false;                 ///< how the control variable counts
  std::uint32_t control = 0, step = 0, limit = 0;  ///< operands
  std::uint32_t head = 0, exit = 0, jump = 0;      ///< positions
  OperandRange result;                             ///< of the comparison
  std::optional<KnownRounds> rounds;
  std::vector<std::uint32_t> variables;  ///< streams: operands
  std::vector<std::uint32_t> values;     ///< streams: bytes
  std::vector<const Element*> elements;  ///< streams
  std::vector<Record> records;
  std::vector<LastValue> last_values;  ///< those of 4 bytes first
  std::vector<LastComputed> last_computed;
};

/// Appends the LOOP_RUN to `words`; its position. `scratch`: table offset of the values between instructions.
std::uint32_t write_loop_run(std::vector<std::uint32_t>& words, const LoopPlan& plan, Addressing addressing,
                             std::uint32_t scratch);

}  // namespace plc::runtime
