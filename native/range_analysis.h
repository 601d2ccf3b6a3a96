// Range analysis of loops: what code of a loop need not do, because the difference cannot be seen.
//
// In: a loop (loops.h) and the body around it. Out: for each of its instructions, which indices are inside their
// arrays, whether a non-canonical NaN may stay, and whether the BOOL of its comparison is read; and what has to
// be made canonical before an instruction and at each exit. Two abstract interpretations over the control flow of the
// loop, one with the range of each integer, one with the state of each real. What they cannot prove is computed.
// Compile time, for all processors. Does not belong here: registers and code.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "native/emitter.h"
#include "native/loops.h"
#include "native/translate.h"
#include "runtime/link/link.h"

namespace plc::native {

/// A real whose NaN may be any; it has to become the one that the interpreter makes.
struct NonCanonicalReal {
  std::uint32_t operand = 0;
  Type type = Type::kF32;
};

/// What is put right where the loop is left, or the scan ends in it.
struct LoopEnd {
  std::vector<NonCanonicalReal> reals;
  std::vector<std::pair<std::uint32_t, bool>> results;  ///< BOOLs of comparisons, which have not been stored
};

struct InstructionRanges {
  Known known;
  std::vector<NonCanonicalReal> before;  ///< put right before the instruction, which looks at bits
  LoopEnd end;                           ///< if the scan ends here: RETURN, a loop jump without budget
};

struct LoopRanges {
  std::vector<InstructionRanges> instructions;  ///< from the first one of the loop on
  std::map<std::uint32_t, LoopEnd> exits;       ///< by the position outside that a jump leads to
  std::vector<std::uint32_t> unread;            ///< BOOLs that are written only where the loop is left
};

/// `body`: all instructions that may jump to each other, with the loop in it. `code`: all resolved code.
LoopRanges analyse_ranges(const Emitter& emitter, const std::uint32_t* code,
                          std::span<const runtime::LinkedInstruction> body, const Loop& loop);

}  // namespace plc::native
