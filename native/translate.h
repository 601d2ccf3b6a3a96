// The translators: resolved instructions as machine code, for each processor in its folder.
//
// In: the words of an instruction (link.h), its place in the resolved code. Out: code at the end of an Assembly that
// leaves the task's table, events and faults as the interpreter's handler does. Does not belong here: control between
// instructions and bodies (compile.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "native/assembly.h"
#include "native/boolean_function.h"
#include "stdlib/library.h"

namespace plc::native {

/// What code of an instruction need not do (range_analysis.h).
struct Known {
  std::uint32_t inside = 0;  ///< bit n: index number n lies within its array
  bool any_nan = false;      ///< a NaN as the processor makes it will do
  bool unread = false;       ///< the BOOL that a comparison with a jump makes is not read
  /// Until it is loaded anew nothing reads the element but the real arithmetic after, as its second operand.
  bool passes_on = false;
};

/// One instruction, and what a translator needs to know of its body.
struct Instruction {
  const std::uint32_t* words = nullptr;  ///< from the handler word on
  std::uint32_t position = 0;
  Operation operation;
  std::uint32_t ports = 0, port_bytes = 0;  ///< of a block that runs soon after it
  std::uint32_t deferred_bytes = 0;         ///< of its ports: the first ones, which the block may store by itself
  Known known{};
  [[nodiscard]] bool is_port(std::uint32_t out) const { return out - ports < port_bytes; }
  [[nodiscard]] bool may_defer(std::uint32_t out) const { return out - ports < deferred_bytes; }
};

/// Moves, arithmetic, comparisons, parts of integers, elements of arrays.
void translate_data(Assembly& assembly, const Instruction& instruction);

/// A comparison without the jump that is the other half of the instruction.
void translate_compare(Assembly& assembly, const Instruction& instruction);

/// A comparison with a conditional jump to `target`.
void translate_compare_jump(Assembly& assembly, const Instruction& instruction, const asmjit::Label& target);

/// One execution of the library's block with this step on the ports at an operand. False, and nothing was written, when
/// there is no code for it.
bool translate_block(Assembly& assembly, stdlib::Step step, std::uint32_t ports);

/// A call of a function of the library as code; `call` writes the call itself, for what the code leaves to it. False,
/// and nothing was written, when there is no code for the function.
bool translate_library(Assembly& assembly, const Instruction& instruction, const std::function<void()>& call);

/// Gives the frame of a function its initial values; what they are stays where it is.
void reset_frame(Emitter& emitter, std::uint32_t frame, const std::byte* initial, std::uint32_t bytes);
/// One argument of a function, in or out: words to, from, bytes or kind, capacities (runtime::pass). `position`: of the
/// call.
void pass_argument(Emitter& emitter, std::uint32_t position, const std::uint32_t* argument);

/// The look-up records of a boolean run. `code`: all resolved code.
void translate_records(Assembly& assembly, const Instruction& instruction, const std::uint32_t* code,
                       BooleanExpressions& expressions);

}  // namespace plc::native
