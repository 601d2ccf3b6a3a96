// Loop runs: counted loops whose body computes and moves elements of arrays, instruction by instruction: all rounds of
// the first one, all rounds of the second one, and so on, a few rounds at a time (kLoopChunk).
//
// What an instruction reads and writes is a stream: a variable, which stays where it is; an element, which steps
// through its array; a value between two instructions, in scratch memory. In: the words below, which loop_plan.h
// makes. Out: what the loop leaves behind its last round and the comparison that ends it; where the loop budget ends
// first, before the round it ends in; when an index leaves its array, before the first one. RT: takes no more rounds
// than the loop budget has.
#pragma once

#include <cstddef>
#include <cstdint>

#include "runtime/interpreter.h"

namespace plc::runtime {

/// Rounds at a time: values between instructions stay in the first cache.
inline constexpr std::uint32_t kLoopChunk = 64;
/// Of one loop. What needs more is no loop run.
inline constexpr std::uint32_t kMostStreams = 32;

/// First words of a LOOP_RUN; position 0 is its handler word. Behind them: of each value its bytes; the operands and
/// steps of variables and of the arrays whose elements are used (2); indices; records; what the last round leaves:
/// values, computed ones.
struct LoopWords {
  enum : std::uint32_t {
    kHead = 1,  ///< where the loop begins
    kExit,      ///< where its comparison leads when it ends
    kLoopJump,  ///< position of its jump
    kControl,   ///< operands: the control variable,
    kLimit,     ///< which counts while it is less (or greater) than this,
    kStep,      ///< by this
    kResult,    ///< operand of the comparison's BOOL
    kForm,      ///< kWide | kDown | kKnown
    kStart,     ///< of a loop that is kKnown: what the control variable begins with, what is added to it each round,
    kAdded,
    kJumps,      ///< and the rounds but one
    kValues,     ///< how many of each
    kVariables,  ///< and arrays: one for each element
    kElements,
    kByControl,  ///< indices, by what makes them
    kByVariable,
    kByBoth,
    kBySum,
    kRecords,
    kLastWords,   ///< of 4 bytes
    kLastValues,  ///< of other sizes
    kLastComputed,
    kScratch,  ///< table offset of the values
    kCount
  };
};
inline constexpr std::uint32_t kWide = 1;  ///< the control variable has 32 bits, not 16; both are signed
inline constexpr std::uint32_t kDown = 2;
inline constexpr std::uint32_t kKnown = 4;  ///< start, limit and step are constants

/// An index of an element: its stream, count, stride in bytes, and what makes its number, from 0: a start, to which the
/// control variable, a variable or both are added. Where the control variable is known, it is in the array's operand
/// and step already. Of the variable: operand, bytes.
struct IndexWords {
  enum : std::uint32_t { kStream, kElements, kStride, kStart, kOperand, kBytes, kCount };
};
/// Any other index: stream, count, stride, factor of the control variable, number of terms, start (2); the terms:
/// operand, factor, bytes.
struct SumWords {
  enum : std::uint32_t { kStream, kElements, kStride, kFactor, kTerms, kStart, kCount = kStart + 2 };
};
inline constexpr std::uint32_t kTermWords = 3;

/// A record: StreamRun or stdlib::Kernel (2), streams: out, three inputs; arguments of the kernel (0 = a StreamRun),
/// position of the instruction. Streams stand in a row: values, variables, elements; they are named by their distance
/// from the first one in bytes.
struct RecordWords {
  enum : std::uint32_t { kRun, kOut = 2, kIn, kArguments = kIn + 3, kPosition, kCount };
};

/// What the last round leaves in variables that the others do not set. First values are copied: operand, stream that
/// has it, bytes; then what no stream has is computed from variables: ValueRun (2), number of operands, operands.
inline constexpr std::uint32_t kLastValueWords = 3, kLastComputedWords = 3;

/// The jumps of a loop that counts as FOR does: from `start` by `step` up to `limit`, or `down` to it, in T. 0 when it
/// has none, or when its code has to find out. Fits 32 bits.
template <class T>
constexpr std::int64_t jumps_of_loop(std::int64_t start, std::int64_t step, std::int64_t limit, bool down) noexcept {
  const std::int64_t way = down ? start - limit : limit - start;
  if (way <= 0 || step <= 0) return 0;
  if (step == 1) [[likely]]
    return way;
  const std::int64_t jumps = (static_cast<std::uint32_t>(way) - 1) / static_cast<std::uint32_t>(step) + 1;
  const std::int64_t last = start + (down ? -jumps : jumps) * step;
  return last == static_cast<T>(last) ? jumps : 0;
}

/// Runs the LOOP_RUN at `words`. Returns where to go on.
template <Addressing kAddressing>
const std::uint32_t* run_loop(Machine& m, std::uint32_t instance, const std::uint32_t* words) noexcept;

extern template const std::uint32_t* run_loop<Addressing::kFixed>(Machine&, std::uint32_t,
                                                                  const std::uint32_t*) noexcept;
extern template const std::uint32_t* run_loop<Addressing::kRelative>(Machine&, std::uint32_t,
                                                                     const std::uint32_t*) noexcept;

}  // namespace plc::runtime
