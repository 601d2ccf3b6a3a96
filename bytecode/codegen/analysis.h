// What must be known about the values of one body before code is made for it: aliases, uses, hazards, loops.
//
// In: a body. Out: flat tables by instruction and place. A load needs no code when its consumers can read the variable
// themselves; `hazard` says until which instruction they can. Does not belong here: addresses, code.
#pragma once

#include <cstdint>
#include <vector>

#include "ir/ir.h"

namespace plc::bytecode {

inline constexpr std::uint32_t kUnset = 0xffffffffu;

/// A BOOL value or its negation: 2 * index of the instruction + 1 if negated; or a constant.
using Literal = std::uint32_t;
inline constexpr Literal kFalseLiteral = 0xfffffffeu;
inline constexpr Literal kTrueLiteral = 0xffffffffu;
constexpr bool is_constant(Literal literal) { return literal >= kFalseLiteral; }
constexpr std::uint32_t value_of(Literal literal) { return literal >> 1; }
constexpr bool is_inverted(Literal literal) { return (literal & 1u) != 0; }

/// One per instruction.
struct ValueInfo {
  Literal literal = 0;     ///< the value without negations, double operands and constants (BOOL)
  std::uint32_t uses = 0;  ///< by living instructions; code generation counts down
  std::uint32_t first_use = kUnset;
  std::uint32_t last_use = 0;
  /// Last instruction at whose place the value may still be read: uses by logic are read where that logic is evaluated.
  std::uint32_t evaluated = 0;
  /// Loads: first later instruction that may change what was loaded; a use there still reads the old value. Stores: the
  /// same for what was stored. Other values: kUnset; code generation narrows it for logic.
  std::uint32_t hazard = kUnset;
  std::uint32_t word = kUnset;   ///< operand word, once the value has a place of its own
  std::uint32_t link = kUnset;   ///< logic: its cone; other values: the store that took it over
  std::uint8_t leaves = 1;       ///< leaves of the logic tree below, at most 255
  std::uint8_t root_leaves = 0;  ///< the most leaves of a tree it is part of
  bool live = false;
  bool pinned = false;         ///< a loop starts between value and last use: its intermediate is never reused
  bool crosses_label = false;  ///< a label is between value and last use: not every way there passes every use before
  bool store_first = false;    ///< evaluated by the store that uses it first; read from there afterwards
};

struct PlaceInfo {
  std::uint32_t root = 0;            ///< place id
  std::uint32_t reference = kUnset;  ///< value id of the reference the root dereferences, or kUnset
  std::uint32_t array = kUnset;      ///< place id of the outermost array that is indexed by a value, or kUnset
  /// Its address is known: a leaf of a table.
  [[nodiscard]] bool is_static() const { return reference == kUnset && array == kUnset; }
};

struct Analysis {
  std::vector<ValueInfo> values;
  std::vector<PlaceInfo> places;
  std::vector<std::uint32_t> label_at;  ///< instruction that binds the label, kUnset when none does
};

/// Fills `out` (vectors are reused from body to body).
/// `body`: that of the POU, or what was made of it.
void analyse(const ir::Module& module, const ir::Pou& pou, const ir::Body& body, Analysis& out);

inline bool is_logic(ir::Op op) { return op == ir::Op::kAnd || op == ir::Op::kOr || op == ir::Op::kXor; }

}  // namespace plc::bytecode
