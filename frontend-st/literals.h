// Literals of IEC 61131-3 (third edition, 6.3): text -> value.
//
// In: the text of one literal token. Out: a Literal, or what is wrong with it. Times and dates are nanoseconds: dates
// since 1970-01-01, times of day since midnight. Does not belong here: enumeration values (they need the type table).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/types.h"

namespace plc::st {

struct Literal {
  enum class Kind : std::uint8_t {
    kInt,     ///< untyped integer
    kReal,    ///< untyped real
    kScalar,  ///< `type` and `bits`
    kText,    ///< STRING, WSTRING, CHAR or WCHAR in `type`; characters in `text`
  } kind = Kind::kInt;
  std::int64_t int_value = 0;  ///< kInt; the bits of a value above 2^63-1 when int_is_unsigned
  bool int_is_unsigned = false;
  double real_value = 0;  ///< kReal
  core::TypeId type = core::TypeId::kBool;
  std::uint64_t bits = 0;  ///< kScalar: zero-extended; REAL in the low 32
  std::string text;        ///< kText: bytes; WSTRING and WCHAR: UTF-16LE code units as bytes
  /// The first character of a STRING that ISO 8859-1 does not have and Windows-1252 has, or empty.
  std::string beyond_latin_1;
};

/// The value of a literal, sign included ("-5", "INT#-5", "T#1h2m", "'a$N'", "TRUE"). Nothing, and why in `problem`, if
/// it is malformed or out of the range of its type.
std::optional<Literal> parse_literal(std::string_view text, std::string& problem);

/// What a note says of a text with a character that not every tool has in a STRING.
std::string beyond_latin_1_text(const Literal& literal);
inline constexpr const char* kBeyondLatin1Help = "other tools may store it in several bytes; WSTRING has it everywhere";

/// Nanoseconds of a duration without prefix ("1h2m3.5s", "-10ms").
std::optional<std::int64_t> parse_duration(std::string_view text, std::string& problem);

/// The elementary type that a literal prefix names: type names and aliases, and T and LT.
std::optional<core::TypeId> literal_prefix(std::string_view prefix);

/// True when `value` (unsigned above 2^63-1) lies in the range of the integer or bit type `type`; BOOL takes 0 and 1.
bool int_fits(std::int64_t value, bool is_unsigned, core::TypeId type);
/// Keeps the bits that a value of `rep` has.
std::uint64_t truncate_bits(std::uint64_t bits, core::Rep rep);
/// The value of zero-extended `bits` of a type, signed types sign-extended.
std::int64_t signed_value(std::uint64_t bits, core::Rep rep);

}  // namespace plc::st
