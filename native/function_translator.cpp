#include "native/function_translator.h"

namespace plc::native {

FunctionTranslator::FunctionTranslator(const Instruction& instruction, const FunctionRow& row,
                                       const std::function<void()>& call)
    : words_(instruction.words), overload_(*row.overload), call_(call), type_(row.type), bytes_(bytes_of(row.type)) {}

bool FunctionTranslator::translate(Function function) {
  switch (function) {
    case Function::kSelect:
      select();
      break;
    case Function::kLeast:
    case Function::kGreatest:
      extreme(function == Function::kLeast);
      break;
    case Function::kLimit:
      limit();
      break;
    case Function::kAbsolute:
      absolute();
      break;
    case Function::kSquareRoot:
      square_root();
      break;
    case Function::kNot:
      invert();
      break;
    case Function::kShiftLeft:
    case Function::kShiftRight:
      shift(function == Function::kShiftLeft);
      break;
    case Function::kRotateLeft:
    case Function::kRotateRight:
      rotate(function == Function::kRotateLeft);
      break;
    case Function::kConvert:
      return convert();
  }
  return true;
}

}  // namespace plc::native
