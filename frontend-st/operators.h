// Operators of expressions, and the library functions that compute them.
#pragma once

#include <string_view>

#include "frontend-st/ast.h"

namespace plc::st {

constexpr bool is_comparison(Operator op) { return op >= Operator::kEqual && op <= Operator::kGreaterEqual; }
/// "ADD" for +; empty for operators that are no function of their operands.
std::string_view function_of(Operator op);

/// Message of P4359: "3 * T#1s".
inline constexpr std::string_view kFactorFirst = "the factor is written before the duration that it multiplies";

}  // namespace plc::st
