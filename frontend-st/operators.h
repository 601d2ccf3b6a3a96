// Operators of expressions, and the library functions that compute them.
#pragma once

#include <string_view>

#include "frontend-st/ast.h"

namespace plc::st {

constexpr bool is_comparison(Operator op) { return op >= Operator::kEqual && op <= Operator::kGreaterEqual; }
/// "ADD" for +; empty for operators that are no function of their operands.
std::string_view function_of(Operator op);

}  // namespace plc::st
