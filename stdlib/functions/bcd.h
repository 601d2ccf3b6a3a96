// Rows: binary coded decimals (IEC 61131-3:2013, table 22; 2003, table 24): WORD_BCD_TO_UINT, UINT_TO_BCD_WORD and
// their like, overloaded BCD_TO_UINT and TO_BCD_WORD, and IS_VALID_BCD of table 39.
//
// A bit string holds one decimal digit in each four bits, the last digit in the lowest: 16#1234 is 1234. A digit above
// 9 makes a value invalid; a number that the result has no room for gives the greatest one. Both with an event.
#pragma once

#include <algorithm>
#include <limits>

#include "stdlib/functions/conversion.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

template <class Bits>
inline constexpr unsigned kBcdDigits = 2 * sizeof(Bits);

template <class Bits>
constexpr bool is_bcd(Bits bits) noexcept {
  for (unsigned i = 0; i < kBcdDigits<Bits>; ++i) {
    if ((static_cast<std::uint64_t>(bits) >> 4 * i & 0xf) > 9) return false;
  }
  return true;
}
/// For bits of which is_bcd() holds.
template <class Bits>
constexpr std::uint64_t value_of_bcd(Bits bits) noexcept {
  std::uint64_t value = 0;
  for (unsigned i = kBcdDigits<Bits>; i-- > 0;) value = value * 10 + (static_cast<std::uint64_t>(bits) >> 4 * i & 0xf);
  return value;
}
/// The greatest number of as many digits as Bits holds: 99 for a BYTE.
template <class Bits>
inline constexpr std::uint64_t kMostBcd = [] {
  std::uint64_t most = 0;
  for (unsigned i = 0; i < kBcdDigits<Bits>; ++i) most = most * 10 + 9;
  return most;
}();
/// For values of at most kMostBcd.
template <class Bits>
constexpr Bits bcd_of(std::uint64_t value) noexcept {
  std::uint64_t bits = 0;
  for (unsigned i = 0; i < kBcdDigits<Bits>; ++i, value /= 10) bits |= value % 10 << 4 * i;
  return static_cast<Bits>(bits);
}

template <class Bits, class Number>
Event bcd_to_number(void* result, const void* const* args, std::uint32_t) noexcept {
  const auto bits = load<Bits>(args[0]);
  if (!is_bcd(bits)) return either(Event::kInvalid, store(result, Number{0}));
  const std::uint64_t value = value_of_bcd(bits);
  constexpr std::uint64_t kMost = std::numeric_limits<Number>::max();
  return either(value > kMost ? Event::kOutOfRange : Event::kNone,
                store(result, static_cast<Number>(std::min(value, kMost))));
}
template <class Number, class Bits>
Event number_to_bcd(void* result, const void* const* args, std::uint32_t) noexcept {
  const std::uint64_t value = load<Number>(args[0]);
  return either(value > kMostBcd<Bits> ? Event::kOutOfRange : Event::kNone,
                store(result, bcd_of<Bits>(std::min(value, kMostBcd<Bits>))));
}

inline constexpr std::string_view kBcdClause = "IEC 61131-3:2013, table 22";

#define PLC_FROM_BCD(Row, pattern, style, ...)                                                             \
  struct Row {                                                                                             \
    static constexpr Example examples[] = {__VA_ARGS__};                                                   \
    static constexpr FunctionSpec spec{                                                                    \
        .name = pattern,                                                                                   \
        .t_categories = core::kAnyBit,                                                                     \
        .u_categories = core::kAnyUnsigned,                                                                \
        .params = {{"IN", kT}},                                                                            \
        .param_count = 1,                                                                                  \
        .result = kU,                                                                                      \
        .events = events(Event::kInvalid, Event::kOutOfRange),                                             \
        .clause = kBcdClause,                                                                              \
        .summary =                                                                                         \
            "The number that the decimal digits of IN say, one in each four bits; 0 with an event if one " \
            "of them is above 9, the greatest number with an event if there is no room.",                  \
        .examples = examples};                                                                             \
    static constexpr bool accepts(TypeId t, TypeId) { return t != TypeId::kBool; }                         \
    static constexpr std::string_view name_of(TypeId t, TypeId u) {                                        \
      return PairTables::name<PairTables::style>(t, u);                                                    \
    }                                                                                                      \
    template <TypeId T, TypeId U>                                                                          \
    static constexpr Kernel kernel = &bcd_to_number<ValueOf<T>, ValueOf<U>>;                               \
  }
PLC_FROM_BCD(BcdToTyped, "*_BCD_TO_*", kFromBcd, {"WORD,UINT", "WORD_BCD_TO_UINT(16#1234)", "1234"},
             {"BYTE,USINT", "BYTE_BCD_TO_USINT(16#0A)", "event:invalid 0"},
             {"WORD,USINT", "WORD_BCD_TO_USINT(16#0256)", "event:out_of_range 255"});
PLC_FROM_BCD(BcdTo, "BCD_TO_*", kBcdTo, {"DWORD,UDINT", "BCD_TO_UDINT(16#12345678)", "12345678"});
#undef PLC_FROM_BCD

#define PLC_TO_BCD(Row, pattern, style, ...)                                                           \
  struct Row {                                                                                         \
    static constexpr Example examples[] = {__VA_ARGS__};                                               \
    static constexpr FunctionSpec spec{                                                                \
        .name = pattern,                                                                               \
        .t_categories = core::kAnyUnsigned,                                                            \
        .u_categories = core::kAnyBit,                                                                 \
        .params = {{"IN", kT}},                                                                        \
        .param_count = 1,                                                                              \
        .result = kU,                                                                                  \
        .events = events(Event::kOutOfRange),                                                          \
        .clause = kBcdClause,                                                                          \
        .summary =                                                                                     \
            "The decimal digits of IN, one in each four bits; all nines with an event if there is no " \
            "room for them.",                                                                          \
        .examples = examples};                                                                         \
    static constexpr bool accepts(TypeId, TypeId u) { return u != TypeId::kBool; }                     \
    static constexpr std::string_view name_of(TypeId t, TypeId u) {                                    \
      return PairTables::name<PairTables::style>(t, u);                                                \
    }                                                                                                  \
    template <TypeId T, TypeId U>                                                                      \
    static constexpr Kernel kernel = &number_to_bcd<ValueOf<T>, ValueOf<U>>;                           \
  }
PLC_TO_BCD(TypedToBcd, "*_TO_BCD_*", kToBcd, {"UINT,WORD", "UINT_TO_BCD_WORD(1234)", "16#1234"},
           {"USINT,BYTE", "USINT_TO_BCD_BYTE(100)", "event:out_of_range 16#99"});
PLC_TO_BCD(ToBcd, "TO_BCD_*", kToBcdOverloaded, {"UDINT,DWORD", "TO_BCD_DWORD(12345678)", "16#12345678"});
#undef PLC_TO_BCD

struct IsValidBcd {
  static constexpr Example examples[] = {{"WORD", "IS_VALID_BCD(16#1234)", "TRUE"},
                                         {"BYTE", "IS_VALID_BCD(16#A0)", "FALSE"}};
  static constexpr FunctionSpec spec{.name = "IS_VALID_BCD",
                                     .t_categories = core::kAnyBit,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = fixed(TypeId::kBool),
                                     .clause = "IEC 61131-3:2013, table 39",
                                     .summary = "TRUE if no four bits of IN say more than 9.",
                                     .examples = examples};
  static constexpr bool accepts(TypeId t, TypeId) { return t != TypeId::kBool; }
  template <class V>
  static std::uint8_t eval(V in, Event&) noexcept {
    return is_bcd(in) ? 1 : 0;
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &unary<IsValidBcd, ValueOf<T>>;
};

using BcdRows = Rows<BcdToTyped, BcdTo, TypedToBcd, ToBcd, IsValidBcd>;

}  // namespace plc::stdlib::rows
