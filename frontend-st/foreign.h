// Foreign: what other tools know and PICARD does not, by name: statements, operators, types, and who brings libraries
// that projects use without having them. So that a message names the feature and not the first token that did not fit.
//
// In: a word of a text. Out: words for messages. Does not belong here: reporting, grammar.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace plc::st {

struct Foreign {
  std::string_view what;  ///< "exception handling of CODESYS": said to be not supported
  std::string_view help;  ///< what to write instead
};

/// A word that begins a statement or is an operator elsewhere, as __TRY, __NEW, JMP, THIS.
std::optional<Foreign> foreign_word(std::string_view word);
/// A type that is built into other tools, as ANY_NUM, USTRING, __XWORD.
std::optional<Foreign> foreign_type(std::string_view name);
/// True for a pragma that holds C, as matiec and OpenPLC compile it, also between double braces.
bool is_c_code(std::string_view pragma);
inline constexpr const char* kCodeInC = "code in C between braces is not compiled: what it does is missing";
inline constexpr const char* kCodeInCHelp = "write it in ST, or as a taskblock in C++ (docs/guides/taskblocks.md)";

/// Who is known to bring a type, block, function or variable of this name: "the SVGHMI extension of Beremiz"; empty
/// when nobody is.
std::string_view supplier_of(std::string_view name);
/// How to come by what a library brings: for help lines.
std::string supply_help(std::string_view name, std::string_view declaration);

}  // namespace plc::st
