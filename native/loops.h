// Loops: which stretches of a body run again and again, and which variables are worth a register meanwhile.
//
// In: the resolved instructions of one body. Out: loops that nobody jumps into but at their head, with everything
// inside them, and the variables that only instructions with known operands touch there. Compile time, for all
// processors. Does not belong here: registers and code (assembly.h), what instructions mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "native/operation.h"
#include "runtime/link.h"

namespace plc::native {

struct LoopVariable {
  std::uint32_t operand = 0;
  unsigned bytes = 0;
  bool real = false;     ///< a register for reals suits it
  bool written = false;  ///< in the loop
  /// How often it is touched, if every loop in the loop takes eight rounds.
  std::uint64_t weight = 0;
};

struct Loop {
  std::size_t first = 0, last = 0;  ///< instructions of the body, the last one a jump to the first
  /// The most used ones first. No other variable and no element of an array that the loop touches overlaps with one.
  std::vector<LoopVariable> variables;
  bool has_parts = false;  ///< elements of arrays that are not the instance's
};

/// The outermost loops that call nothing but functions of the library; in loops that do, those inside. In the order of
/// the code, none within another. `code`: all resolved code.
std::vector<Loop> find_loops(const std::uint32_t* code, std::span<const runtime::LinkedInstruction> instructions);

/// Where an instruction jumps to, as a position; kNoTarget when it does not.
inline constexpr std::uint32_t kNoTarget = 0xffffffffu;
std::uint32_t target_of(Form form, const std::uint32_t* words);

}  // namespace plc::native
