// Linker: the code of one task, handles resolved to addresses (paper, 3.2.4), before the first run.
//
// In: a verified image, a task, the layout of its table. Out: one stream of 32-bit words for all POUs the task reaches,
// for the interpreter and for compilers (native/):
//   handler word (distance of the handler's address, interpreter.h), then operands
//   operand: byte offset from the start of the task's table; in relative bodies, with kRelativeBit, from the instance
//   targets and entries: positions in the stream; pointers (kernels, steps) in two words
// A POU that the task has one instance of is fixed: its operands are final. Others are relative: one body for all
// instances. Does not belong here: running (interpreter.h), checking images (bytecode::verify).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "core/result.h"
#include "runtime/interpreter/interpreter.h"
#include "runtime/memory/exchange.h"
#include "runtime/memory/table.h"
#include "runtime/program.h"

namespace plc::runtime {

class Probes;

/// The POUs that a task reaches, callers before callees.
std::vector<std::uint32_t> reached_pous(const bytecode::Image& image, std::uint32_t body);

/// Fields of the global table from `first` on.
struct FieldRange {
  std::uint32_t first = 0;
  std::uint32_t count = 0;
  bool exported = false;
};
/// What the task body `body` imports and exports, in the order of its instructions.
std::vector<FieldRange> exchanged_ranges(const bytecode::Image& image, std::uint32_t body);

/// One instruction of resolved code; its words follow its handler word. The records of short boolean runs lie further
/// on, where the instruction says.
struct LinkedInstruction {
  std::uint32_t position = 0;
  ResolvedOp op = ResolvedOp::kReturn;
};
/// The code of one POU: the instructions from `first` to the first one of the next body.
struct LinkedBody {
  std::uint32_t pou = 0;
  Addressing addressing = Addressing::kFixed;
  std::uint32_t entry = 0;  ///< position
  std::uint32_t first = 0;  ///< into LinkedCode::instructions
};

/// Code that no jump leads into, from a BLOCK_START on (arrange.h).
struct LinkedBlock {
  Addressing addressing = Addressing::kFixed;
  std::uint32_t position = 0;  ///< of the BLOCK_START
  std::uint32_t end = 0;       ///< past its last instruction
  std::size_t first = 0;       ///< the instruction after the BLOCK_START, into LinkedCode::instructions
};

struct LinkedCode {
  TableMemory words;  ///< 64-byte aligned, so that records lie as the linker placed them
  std::vector<CodeMark> marks;
  std::vector<LinkedInstruction> instructions;          ///< ascending positions
  std::vector<LinkedBody> bodies;                       ///< in the order of the code
  std::vector<LinkedBlock> blocks;                      ///< ascending positions
  std::vector<LinkedInstruction> arranged;              ///< of the interpreter alone: what BLOCK_START leads to
  std::uint32_t entry = 0;                              ///< of the task's body
  std::vector<std::unique_ptr<std::byte[]>> constants;  ///< zeros of types, pointed into by the code
  Program::LinkReport report;
  [[nodiscard]] const std::uint32_t* data() const { return reinterpret_cast<const std::uint32_t*>(words.data()); }
  /// All instructions of body number `body`.
  [[nodiscard]] std::span<const LinkedInstruction> instructions_of(std::size_t body) const {
    const std::size_t first = bodies[body].first;
    const std::size_t end = body + 1 < bodies.size() ? bodies[body + 1].first : instructions.size();
    return std::span(instructions).subspan(first, end - first);
  }
};

/// Resolves everything the task reaches, and arranges straight code for the interpreter. Registers its exchange ranges.
/// P9001 when a function or block is not in this build's library.
/// `probes`: POUs that somebody looks at take values on their way, which only the interpreter of a replica does.
core::Result<LinkedCode> link_task(const bytecode::Image& image, std::uint32_t body,
                                   const std::vector<std::uint32_t>& pous, const TaskLayout& layout, Exchange& exchange,
                                   bool arranged = true, const Probes* probes = nullptr);

}  // namespace plc::runtime
