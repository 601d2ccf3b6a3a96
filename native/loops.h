// Loops of a body: where they are, and which variables are worth a register in them.
//
// In: the resolved instructions of one body. Out: loops that no jump enters but at their head, with everything
// inside them, and the variables that only instructions with known operands touch there. Compile time, for all
// processors. Does not belong here: registers and code (assembly.h), what instructions mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "native/operation.h"
#include "runtime/link/link.h"

namespace plc::native {

struct Instruction;

/// What an instruction takes an operand for.
enum class Use : std::uint8_t {
  kInteger,
  kReal,
  kBits,    ///< it is moved, whatever it is
  kMemory,  ///< only where it is
};

/// One operand of an instruction.
struct Access {
  std::uint32_t operand = 0;
  std::uint64_t bytes = 0;
  Use use = Use::kMemory;
  bool write = false;
};

/// The operands of an instruction, in any order; what it reads and writes is there twice. Nothing when it is none for
/// loops whose variables lie in registers. `code`: all resolved code.
std::optional<std::vector<Access>> accesses_of(const std::uint32_t* code, const Instruction& instruction);

struct LoopVariable {
  std::uint32_t operand = 0;
  unsigned bytes = 0;
  bool real = false;     ///< a register for reals suits it
  bool written = false;  ///< in the loop
  /// How often it is touched, if every loop in the loop takes eight iterations.
  std::uint64_t weight = 0;
};

struct Loop {
  std::size_t first = 0, last = 0;  ///< instructions of the body, the last one a jump to the first
  /// The most used ones first. No other variable and no element of an array that the loop touches overlaps with one.
  std::vector<LoopVariable> variables;
  /// A loop in it, or all of it, that has none inside.
  struct Inner {
    std::size_t first = 0, last = 0;
    /// It ends as FOR does, with a comparison that leaves it, counting, and its jump. There is no other jump, and
    /// nothing else changes what it counts with.
    bool counts = false;
  };
  std::vector<Inner> inner;  ///< in the order of the code
};

/// The outermost loops that call nothing but functions of the library; in loops that do, those inside. In the order of
/// the code, none within another. `code`: all resolved code.
std::vector<Loop> find_loops(const std::uint32_t* code, std::span<const runtime::LinkedInstruction> instructions);

/// Where an instruction jumps to, as a position; kNoTarget when it does not.
inline constexpr std::uint32_t kNoTarget = 0xffffffffu;
std::uint32_t target_of(Form form, const std::uint32_t* words);

}  // namespace plc::native
