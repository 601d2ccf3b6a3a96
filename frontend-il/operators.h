// Operators of instruction lists and their modifiers.
//
// In: a word. Out: its row and modifiers. Does not belong here: operands, brackets.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "frontend-st/ast.h"

namespace plc::il {

/// What an operator does. kFunction and kClose have no row: a function's name is the operator, and ")" closes.
enum class Kind : std::uint8_t {
  kLoad,
  kStore,
  kSet,
  kReset,
  kNot,
  kBinary,  ///< accumulator := accumulator op operand; with a bracket, op the value of the bracket
  kJump,
  kCall,
  kReturn,
  kInput,     ///< S1, CLK, ..: the input of an instance
  kFunction,  ///< accumulator := function(accumulator, operands), or function(arguments) with parentheses
  kClose,     ///< )
  kBroken,    ///< what could not be read, and was reported
};

enum Modifier : std::uint8_t { kN = 1, kBracket = 2, kC = 4, kList = 8 };

struct OperatorRow {
  std::string_view name;
  Kind kind = Kind::kLoad;
  st::Operator op = st::Operator::kNone;
  std::uint8_t modifiers = 0;
  std::string_view summary;
  [[nodiscard]] constexpr bool takes(Modifier modifier) const { return (modifiers & modifier) != 0; }
};

/// All rows, in the order of operators.def.
std::span<const OperatorRow> operator_rows();

enum class Condition : std::uint8_t { kAlways, kIfTrue, kIfFalse };

/// A word taken apart: "JMPCN" is JMP under the condition that the accumulator is FALSE, "ANDN" is AND, negated.
struct Spelled {
  const OperatorRow* row = nullptr;
  bool negated = false;
  Condition condition = Condition::kAlways;
};

/// What `word` spells in any letter case; nothing when it is no operator.
std::optional<Spelled> operator_named(std::string_view word);

/// "did you mean \"LD\"?", or empty when no operator is near.
std::string operator_meant(std::string_view word);

}  // namespace plc::il
