// Loop runs: counted loops whose body computes and moves elements of arrays, instruction by instruction: all rounds of
// the first one, all rounds of the second one, and so on, a few rounds at a time (kLoopChunk).
//
// What an instruction reads and writes is a stream: a variable, which stays where it is; an element, which steps
// through its array; a value between two instructions, in scratch memory. In: the words below, which link_loops.h
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

/// First words of a LOOP_RUN; position 0 is its handler word. Behind them: the operands of variables; of each value its
/// bytes; indices of the elements; records; what the last round leaves: values, computed ones.
struct LoopWords {
  enum : std::uint32_t {
    kHead = 1,   ///< where the loop begins
    kExit,       ///< where its comparison leads when it ends
    kLoopJump,   ///< position of its jump
    kControl,    ///< operands: the control variable,
    kLimit,      ///< which counts while it is less (or greater) than this,
    kStep,       ///< by this
    kResult,     ///< operand of the comparison's BOOL
    kForm,       ///< kWide | kDown
    kVariables,  ///< how many of each
    kValues,
    kElements,
    kIndices,  ///< of all elements
    kRecords,
    kLastValues,
    kLastComputed,
    kScratch,  ///< table offset of the values
    kCount
  };
};
inline constexpr std::uint32_t kWide = 1;  ///< the control variable has 32 bits, not 16; both are signed
inline constexpr std::uint32_t kDown = 2;

/// An index of an element: kind, count, stride in bytes, operand of the array, and what makes its number, from 0. Sums:
/// factor of the control variable, number of terms, start (2); the terms: operand, factor, bytes. Others: start,
/// operand; what is added to the start is what the kind says.
inline constexpr std::uint32_t kByControl = 1;  ///< the control variable
inline constexpr std::uint32_t kByInt = 2;      ///< the variable that is the operand, of 16 bits
inline constexpr std::uint32_t kByDint = 4;     ///< ..of 32
inline constexpr std::uint32_t kBySum = 8;
inline constexpr std::uint32_t kFurther = 16;  ///< one more index of the element before; the array does not count
inline constexpr std::uint32_t kSumIndexWords = 8, kTermWords = 3, kPlainIndexWords = 6;

/// A record: StreamRun or stdlib::Kernel (2), streams (2; out, inputs: 16 bits each), arguments of the kernel (0 = a
/// StreamRun), position of the instruction. Streams stand in a row: variables, values, elements; they are named by
/// their distance from the first one in bytes.
inline constexpr std::uint32_t kLoopRecordWords = 6;

/// What the last round leaves in variables that the others do not set. First values are copied: operand, stream that
/// has it, bytes; then what no stream has is computed from variables: ValueRun (2), number of operands, operands.
inline constexpr std::uint32_t kLastValueWords = 3, kLastComputedWords = 3;

/// Runs the LOOP_RUN at `words`. Returns where to go on.
template <Addressing kAddressing>
const std::uint32_t* run_loop(Machine& m, std::uint32_t instance, const std::uint32_t* words) noexcept;

extern template const std::uint32_t* run_loop<Addressing::kFixed>(Machine&, std::uint32_t,
                                                                  const std::uint32_t*) noexcept;
extern template const std::uint32_t* run_loop<Addressing::kRelative>(Machine&, std::uint32_t,
                                                                     const std::uint32_t*) noexcept;

}  // namespace plc::runtime
