// What other tools take and the standard does not know, of types: implicit conversions, and calls that no overload fits
// exactly. One table of conversions, one choice of overloads; texts, drawings and initial values ask here.
//
// The rules, with examples: docs/guides/conversions.md; why they are these: docs/adr/0030-arithmetic-on-bit-strings.md.
// Does not belong here: what the third edition widens (library.h), messages.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "stdlib/library.h"

namespace plc::stdlib {

/// Ways of writing that other tools take, with one meaning. Each is a note with a code of its own.
enum class Idiom : std::uint8_t {
  kNone,
  kBitArithmetic,  ///< arithmetic on BYTE .. LWORD
  kIntegerBits,    ///< AND, SHL and the like on integers
  kMixedSigns,     ///< signed for unsigned, or the other way round
  kMixedBits,      ///< bit string for integer or real, or the other way round
  kBoolNumber,     ///< BOOL as 0 and 1
  kLiteralBits,    ///< literal that fits by its bits: UINT := -1, INT := 16#FFFF
  kIntegerPower,   ///< power of integers as an integer
  kIntoReal,       ///< integer for a real that may not hold all its digits
  kShiftCount,     ///< bit string as count of a shift or rotation
};

/// The idiom by which a value of `from` may be used where `to` is needed, though the third edition does not widen it;
/// kNone when tools refuse it. Integers and bit strings keep their low bits, signed ones are extended by their sign.
Idiom implicit_conversion(TypeId from, TypeId to);

/// True when the literal, which is no value of `to`, has as many bits, and these are meant: one below 0 (UINT := -1),
/// or one written with its base (INT := 16#FFFF). INT := 40000 is a mistake.
bool literal_fits_by_bits(const Arg& literal, TypeId to);

/// Type of an argument, and what it stands for: BYTE + BYTE is computed in LINT and goes where a BYTE may go.
struct LooseArg {
  Arg arg;                        ///< as it was computed
  TypeId narrow = TypeId::kBool;  ///< typed: what it stands for
  bool noted = false;             ///< an idiom was found before it
};

struct LooseCall {
  const Overload* overload = nullptr;
  TypeId narrow = TypeId::kBool;  ///< what the result stands for
  /// The result is made this type first: the bits of an INT are an INT.
  TypeId result = TypeId::kBool;
  bool keeps_sign = false;  ///< a shift to the right fills with the sign
  Idiom idiom = Idiom::kNone;
  std::size_t because = 0;  ///< the argument that the idiom is of
};
/// The overload that other tools would call where resolve() finds none. Nothing when they refuse it, too.
std::optional<LooseCall> resolve_loosely(std::string_view name, std::span<const LooseArg> args,
                                         std::optional<TypeId> expected);

/// What the result of an ordinary call stands for, where that is narrower than the type it is computed in: INT + UINT
/// is a DINT, and goes where an INT may go.
TypeId narrow_result(const Overload& overload, std::span<const LooseArg> args);

/// The integer without sign of the bits of `id`, an integer or bit string.
TypeId unsigned_of(TypeId id);

}  // namespace plc::stdlib
