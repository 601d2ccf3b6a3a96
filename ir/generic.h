// Generic functions: those with parameters ARRAY [*] (IEC 61131-3:2013, 6.4.4.5.3, table 15).
//
// In: a function as declared and the arrays of one call. Out: a function of its own for these arrays, in which the
// bounds are constants; calls with the same arrays share it. So nothing after the front ends knows of variable length.
// Does not belong here: where ARRAY [*] may be used (frontend-st).
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "ir/builder.h"

namespace plc::ir {

/// Whether an array of type `given` may be passed to a parameter of type `open`: same element, same dimensions.
bool fits_open(const TypeTable& types, TypeRef open, TypeRef given);

/// What one argument gives to an open parameter.
struct OpenArgument {
  std::uint32_t variable = 0;  ///< of the function
  TypeRef type{};              ///< of the array; fits_open holds
};
/// Functions made in one project: generic ones that call each other with more arrays each would not come to an end.
inline constexpr std::size_t kMostMade = 4096;
/// The function made from the generic `pou` for these arguments, in the order of its variables: an index into
/// Module::pous, at whose end it is added when it is new. Its body is lowered as that of `pou` is. Nothing beyond
/// kMostMade, which is the caller's to report (P5001, kTooManyMade).
std::optional<std::uint32_t> specialize(Module& module, std::uint32_t pou, std::span<const OpenArgument> arguments);
inline constexpr std::string_view kTooManyMade =
    "is called with more sets of array bounds than a project may have, 4096";
/// Whether a function made from a generic one got arrays of this type, or with parts of it, for its ARRAY [*].
bool is_given_array(const Module& module, const Pou& pou, TypeRef array);
/// The same for arrays that are never passed, so that the body of a function that is never called is checked too.
std::optional<std::uint32_t> specialize_for_check(Module& module, std::uint32_t pou);

/// LOWER_BOUND and UPPER_BOUND: functions of an array and the number of a dimension, which no row of the library can
/// be.
enum class ArrayBound : std::uint8_t { kLower, kUpper };
/// Which of them `name` is, in any letter case.
std::optional<ArrayBound> array_bound_named(std::string_view name);
/// The bound of `array` in dimension `dimension` (1 is the first): a literal, which takes any integer type that it
/// fits; where the dimension is computed a DINT, or LINT where it needs one, and an event if there is no such
/// dimension. Nothing and reported when it is a constant and does not exist.
std::optional<Operand> array_bound(Builder& builder, ArrayBound bound, TypeRef array, const Operand& dimension,
                                   const SourceRef& at);

}  // namespace plc::ir
