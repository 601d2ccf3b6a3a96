// Oracle: what each function of the library should give, computed without the library's code: integers, bits and times
// in 128 bits, reals by MPFR, texts on std::u16string, dates by the C library.
//
// In: an overload and its arguments. Out: the expected result and event. A function without an oracle is a failure of
// the sweep. Does not belong here: which arguments are tried (values.h).
#pragma once

#include <optional>
#include <span>

#include "stdlib/library.h"
#include "tests/library/values.h"

namespace plc::test {

__extension__ using Wide = __int128;

/// What is expected of a result.
struct Expected {
  enum class As : std::uint8_t {
    kExactly,       ///< `value`
    kNeighbour,     ///< `value` or `other`, the two nearest reals around the true one: less than 1 ulp away
    kShortestText,  ///< the shortest text that reads back as the real `value`
  } as = As::kExactly;
  Value value;
  Value other{};
  Event event = Event::kNone;
};
/// Whether a result is what was expected, the event aside.
bool agrees(const Expected& expected, const Value& result);

/// Nothing for a function that the oracle does not know. A string result is cut to `room` characters.
std::optional<Expected> expect(const Overload& overload, std::span<const Value> arguments, std::size_t room);

// ---- parts of the oracle, one file each -------------------------------------------------------------------------

/// A scalar that is no real, as the number that it is.
Wide wide_of(const Value& value);
/// The value of `type` with the low bits of `number`.
Value wrapped(TypeId type, Wide number);
Wide least_of(TypeId type);
Wide greatest_of(TypeId type);
/// `number` held within `type`; out of range is an event.
Expected saturated(TypeId type, Wide number);
/// A character of STRING as one of WSTRING, and back; nothing when it has none.
char16_t character_of_byte(char16_t byte);
std::optional<char16_t> byte_of_character(char16_t character);

// oracle_reals.cpp: MPFR, 24 or 53 bits, subnormals included.
/// `a` + - * / `b`, to nearest.
Value real_arithmetic(char symbol, const Value& a, const Value& b);
/// SQRT exactly, the others as neighbours. Nothing for a name that is no function of one real.
std::optional<Expected> real_function(std::string_view name, const Value& in);
Expected arc_tangent(const Value& y, const Value& x);
Expected power(const Value& base, const Value& exponent);
/// A number over `divisor` as the nearest real of `type`.
Value real_quotient(TypeId type, Wide number, std::int64_t divisor);
/// A real as another type of real.
Value real_as(TypeId type, const Value& in);
/// `count` * or / the real, rounded half to even; NaN gives 0 with an event, out of range the nearest with an event.
Expected scaled(TypeId type, char symbol, Wide count, const Value& real);
/// The integer part of a real.
Expected truncated(TypeId type, const Value& real);

// oracle_texts.cpp
/// LEN, LEFT .. FIND; nothing for other names.
std::optional<Expected> text_function(const Overload& overload, std::span<const Value> arguments);
/// Any value as text of type STRING or WSTRING.
Expected written(TypeId type, const Value& in);
/// A text as value of another type.
Expected read(TypeId type, const Value& text);

// oracle_dates.cpp: calendar and clock of the C library.
/// CONCAT_DATE .. CONCAT_LDT.
Expected date_of_parts(TypeId type, std::span<const Value> parts);
/// YEAR .. MILLISECOND of SPLIT_..
Expected part_of_date(TypeId type, std::string_view part, const Value& in);
Expected day_of_week(TypeId type, const Value& in);
/// A date or time as text: "D#2024-02-29".
std::string date_text(const Value& in);

// oracle_conversions.cpp
/// A_TO_B and TO_B.
Expected converted(TypeId type, const Value& in);

}  // namespace plc::test
