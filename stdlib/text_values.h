// Values as text and back: what A_TO_STRING and STRING_TO_A write and read. The text is a literal of the standard,
// without type prefix for numbers ("-12", "1.5", "TRUE", "16#00FF", "T#1m2s3ms", "D#2024-02-29").
//
// In: values or characters. Out: characters in the caller's buffer, or values and an Event. RT: no allocation, no
// locale. Does not belong here: STRING variables (strings.h), ST literals in programs (frontend-st).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/types.h"
#include "stdlib/library.h"

namespace plc::stdlib {

/// Holds every text below.
inline constexpr std::size_t kMaxValueText = 64;
using ValueText = char[kMaxValueText];

/// Characters written to `out`.
std::size_t format_bool(bool value, ValueText& out) noexcept;
std::size_t format_signed(std::int64_t value, ValueText& out) noexcept;
std::size_t format_unsigned(std::uint64_t value, ValueText& out) noexcept;
/// "16#" and `digits` hexadecimal digits.
std::size_t format_bits(std::uint64_t value, unsigned digits, ValueText& out) noexcept;
/// The shortest text that reads back as the same value: "0.1", "1.0E+20", "NaN", "-Inf".
std::size_t format_real(float value, ValueText& out) noexcept;
std::size_t format_real(double value, ValueText& out) noexcept;
/// `prefix` and "1d2h3m4s5ms6us7ns", parts that are 0 left out; "0s" for none.
std::size_t format_duration(std::int64_t ns, std::string_view prefix, ValueText& out) noexcept;
/// "D#2024-02-29", "TOD#12:34:56.789", "DT#2024-02-29-12:34:56": DATE, TOD, DT and their long forms.
std::size_t format_date(std::int64_t ns, TypeId type, ValueText& out) noexcept;

/// Each reads the whole text, blanks at both ends aside, with or without a prefix such as "INT#", "T#". Text that is
/// not such a literal gives 0 and kInvalid; a value out of range gives the nearest one and kOutOfRange.
bool parse_bool(std::string_view text, Event& event) noexcept;
std::int64_t parse_signed(std::string_view text, std::int64_t least, std::int64_t greatest, Event& event) noexcept;
std::uint64_t parse_unsigned(std::string_view text, std::uint64_t greatest, Event& event) noexcept;
float parse_real(std::string_view text, Event& event) noexcept;
double parse_lreal(std::string_view text, Event& event) noexcept;
std::int64_t parse_duration(std::string_view text, Event& event) noexcept;
std::int64_t parse_date(std::string_view text, TypeId type, Event& event) noexcept;

}  // namespace plc::stdlib
