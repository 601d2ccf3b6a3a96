#include "frontend-st/operators.h"

namespace plc::st {

std::string_view function_of(Operator op) {
  switch (op) {
    case Operator::kOr:
      return "OR";
    case Operator::kXor:
      return "XOR";
    case Operator::kAnd:
      return "AND";
    case Operator::kEqual:
      return "EQ";
    case Operator::kNotEqual:
      return "NE";
    case Operator::kLess:
      return "LT";
    case Operator::kLessEqual:
      return "LE";
    case Operator::kGreater:
      return "GT";
    case Operator::kGreaterEqual:
      return "GE";
    case Operator::kAdd:
      return "ADD";
    case Operator::kSubtract:
      return "SUB";
    case Operator::kMultiply:
      return "MUL";
    case Operator::kDivide:
      return "DIV";
    case Operator::kModulo:
      return "MOD";
    case Operator::kPower:
      return "EXPT";
    case Operator::kNegate:
      return "NEG";
    case Operator::kNot:
      return "NOT";
    case Operator::kAndThen:
    case Operator::kOrElse:
    case Operator::kPlus:
    case Operator::kSet:
    case Operator::kReset:
    case Operator::kBind:
    case Operator::kNone:
      break;
  }
  return "";
}

}  // namespace plc::st
