// Inputs of type ANY and its kin (CODESYS): what they take, and the structure that the POU sees of what it gets.
//
// In: a name of a generic type, a module. Out: the structure (TypeClass, pValue, diSize), numbers of TYPE_CLASS. Does
// not belong here: which variable is given (lower_any.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "ir/ir.h"

namespace plc::st {

/// The structure of inputs of the generic type `name` (ANY, ANY_BIT, ANY_DATE, ANY_INT, ANY_NUM, ANY_REAL, ANY_STRING),
/// declared at first use, as is the enumeration TYPE_CLASS. Nothing for other names.
std::optional<ir::TypeRef> any_type(ir::TypeTable& types, std::string_view name);
/// Whether `type` is such a structure; of ANY itself, of a structure that takes some types alone.
struct AnyInput {
  std::string_view name;         ///< "ANY_NUM"
  std::uint16_t categories = 0;  ///< core::Category bits; 0 = everything
};
std::optional<AnyInput> any_input(const ir::TypeTable& types, ir::TypeRef type);
/// The number of the value of TYPE_CLASS that stands for `type`.
std::int64_t type_class_of(const ir::TypeTable& types, ir::TypeRef type);

}  // namespace plc::st
