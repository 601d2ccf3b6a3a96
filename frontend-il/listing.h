// Listing: an instruction list taken apart: instructions in order, labels between them.
//
// In: made by the parser. Out: read by the flow and the lowering. Does not belong here: names, types, basic blocks.
#pragma once

#include <cstdint>
#include <vector>

#include "frontend-il/operators.h"
#include "frontend-st/ast.h"

namespace plc::il {

struct Instruction {
  Kind kind = Kind::kBroken;
  st::Operator op = st::Operator::kNone;  ///< kBinary
  Condition condition = Condition::kAlways;
  bool negated = false;     ///< N: the operand, or the value of the bracket
  bool opens = false;       ///< kBinary: a bracket; its first operand, if any, is `operand`
  bool formal = false;      ///< kFunction: `operand` is a kCall with its arguments in parentheses
  std::uint32_t begin = 0;  ///< byte range of the operator in the text
  std::uint32_t end = 0;
  /// The operands, linked by next. kJump: the kName of the label. kCall: the kCall. Else kNoNode where there is none.
  st::NodeId operand = st::kNoNode;
};

struct Label {
  std::uint32_t begin = 0;  ///< byte range of its name in the text
  std::uint32_t end = 0;
  std::uint32_t instruction = 0;  ///< the one after it; the number of instructions at the end of the list
};

struct Listing {
  st::Ast ast;
  std::vector<Instruction> instructions;
  std::vector<Label> labels;
  bool failed = false;  ///< there was an error, which was reported
};

}  // namespace plc::il
