// What calls by name and assignments share: operands as values of a type, kernels run on constants, idioms named.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "ir/builder.h"
#include "stdlib/idioms.h"

namespace plc::ir {

/// The receiver's name, made only when a message needs it: every pin of every block passes here.
using What = std::function<std::string()>;

/// Builder::convert() with a name that is made late.
std::optional<ValueId> convert_with(Builder& builder, const Operand& operand, TypeRef to, const What& what);

/// A literal as written, or its value.
std::string text_of(const Operand& operand);
/// True for a text literal, quotes and all.
bool is_literal_text(const Operand& operand);
/// For a text literal where the other kind of text is wanted: the quotes tell them apart, other than in most languages.
std::string quotes_help(const Operand& operand);
/// An operand that is an integer literal, for the library.
stdlib::Arg literal_arg(const Operand& operand);
/// The function A_TO_B; null where there is none.
const stdlib::Overload* conversion(TypeId from, TypeId to);
/// The call, or its value where it is constant.
ValueId call_or_fold(Builder& builder, const stdlib::Overload& overload, std::span<const ValueId> args,
                     TypeRef result_type);

/// The code under which an idiom is noted.
core::Code code_of(stdlib::Idiom idiom);

}  // namespace plc::ir
