// Generic functions: those with parameters ARRAY [*] (IEC 61131-3:2013, 6.4.4.5.3, table 15).
//
// In: a function as declared and the arrays of one call. Out: a function of its own for these arrays, in which the
// bounds are constants; calls with the same arrays share it. So nothing behind the front ends knows of variable length.
// Does not belong here: where ARRAY [*] may stand (frontend-st).
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
/// The function made from the generic `pou` for these arguments, in the order of its variables: an index into
/// Module::pous, at whose end it is added when it is new. Its body is lowered as that of `pou` is.
std::uint32_t specialize(Module& module, std::uint32_t pou, std::span<const OpenArgument> arguments);
/// The same for arrays that nobody passes, so that the body of a function that is never called is checked too.
std::uint32_t specialize_for_check(Module& module, std::uint32_t pou);

/// LOWER_BOUND and UPPER_BOUND: functions of an array and the number of a dimension, which no row of the library can
/// be.
enum class Bound : std::uint8_t { kLower, kUpper };
/// Which of them `name` is, in any letter case.
std::optional<Bound> array_bound_named(std::string_view name);
/// The bound of `array` in dimension `dimension` (1 is the first), a DINT, or LINT where it needs one. A dimension that
/// is computed and does not exist is an event. Nothing and reported when it is a constant and does not exist.
std::optional<ValueId> array_bound(Builder& builder, Bound bound, TypeRef array, const Operand& dimension,
                                   const SourceRef& at);

}  // namespace plc::ir
