// Rows: conversions A_TO_B, overloaded TO_B, and TRUNC (IEC 61131-3:2013, tables 22 to 27). docs/guides/conversions.md
//
// Numbers keep their value or, between integers and bit strings, their low bits; reals round half to even and saturate;
// TIME counts milliseconds, LTIME nanoseconds, also as reals; anything but 0 is TRUE; strings hold literals.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/windows_1252.h"
#include "stdlib/arithmetic.h"
#include "stdlib/functions/durations.h"
#include "stdlib/row.h"
#include "stdlib/text_values.h"

namespace plc::stdlib::rows {

inline constexpr std::uint16_t kNumeric = core::kAnyNum | core::kAnyBit;
inline constexpr std::int64_t kMsNs = 1'000'000;

constexpr bool is_real(TypeId id) { return core::in_category(id, core::kAnyReal); }
constexpr bool is_text(TypeId id) { return core::in_category(id, core::kAnyString); }
constexpr bool is_numeric(TypeId id) { return core::in_category(id, kNumeric); }

/// Conversions between different types that there are; TO_B also takes B itself.
constexpr bool converts(TypeId t, TypeId u) {
  using enum TypeId;
  if (t == u || t == kPointer || u == kPointer) return false;
  const auto either_is = [&](TypeId a, TypeId b) { return (t == a && u == b) || (t == b && u == a); };
  if (core::in_category(t, core::kAnyChar) || core::in_category(u, core::kAnyChar)) {
    if (either_is(kChar, kWchar) || either_is(kChar, kString) || either_is(kWchar, kWstring)) return true;
    const TypeId other = core::in_category(t, core::kAnyChar) ? u : t;
    return core::in_category(other, core::kAnyInt | core::kAnyBit) && other != kBool;
  }
  if (is_text(t) || is_text(u)) return true;
  const auto is_count = [](TypeId id) { return core::in_category(id, core::kAnyInt | core::kAnyBit) && id != kBool; };
  const auto is_date = [](TypeId id) { return core::in_category(id, core::kAnyDate); };
  if ((is_date(t) && is_count(u)) || (is_date(u) && is_count(t))) return true;
  const auto is_time_of_day = [](TypeId id) { return id == kTod || id == kLtod; };
  const auto is_duration = [](TypeId id) { return core::in_category(id, core::kAnyDuration); };
  if ((is_time_of_day(t) && is_duration(u)) || (is_time_of_day(u) && is_duration(t))) return true;
  constexpr std::uint16_t kCounts = kNumeric | core::kAnyDuration;
  if (core::in_category(t, kCounts) && core::in_category(u, kCounts)) return true;
  const auto kind = [](TypeId id) { return id == kDate || id == kLdate ? 1 : id == kTod || id == kLtod ? 2 : 3; };
  return core::in_category(t, core::kAnyDate) && core::in_category(u, core::kAnyDate) &&
         (kind(t) == kind(u) || kind(t) == 3 || (kind(t) == 1 && kind(u) == 3));
}

/// Types of one machine value and meaning share their kernels: BYTE is USINT, LTIME a LINT of nanoseconds.
constexpr TypeId meaning_of(TypeId id) {
  using enum TypeId;
  switch (id) {
    case kByte:
    case kChar:
      return kUsint;
    case kWord:
    case kWchar:
      return kUint;
    case kDword:
      return kUdint;
    case kLword:
      return kUlint;
    case kLtime:
    case kLdt:
      return kLint;
    default:
      return id;
  }
}
/// Nanoseconds in one unit of the numbers that a type counts as: TIME and TOD in milliseconds, DATE and DT in seconds,
/// as CODESYS and TwinCAT have them.
constexpr std::int64_t unit_of(TypeId id) {
  using enum TypeId;
  if (id == kTime || id == kTod) return kMsNs;
  return id == kDate || id == kDt ? 1'000'000'000 : 1;
}

/// The midnight before `ns`. The first day of 64 bits begins before they do: the day after it, with an event.
inline std::int64_t midnight(std::int64_t ns, Event& event) noexcept {
  constexpr std::int64_t kFirstDay = -kMostDays * kDayNs;
  if (ns >= kFirstDay) return ns - within_day(ns);
  event = Event::kOutOfRange;
  return kFirstDay;
}

/// A number, BOOL or duration to another. `T` and `U` are meanings.
template <TypeId T, TypeId U>
Event convert_number(void* result, const void* const* args, std::uint32_t) noexcept {
  using enum TypeId;
  using To = ValueOf<U>;
  const auto in = load<ValueOf<T>>(args[0]);
  Event event = Event::kNone;
  To out{};
  if constexpr (U == kBool) {
    const bool is_nan = in != in;
    if (is_nan) event = Event::kOutOfRange;
    out = static_cast<To>(!is_nan && in != ValueOf<T>{0});
  } else if constexpr (T == kTime && is_real(U)) {
    out = nearest_ratio<To>(in, kMsNs);
  } else if constexpr (core::in_category(T, core::kAnyDuration | core::kAnyDate)) {
    out = static_cast<To>(in / unit_of(T));
  } else if constexpr (core::in_category(U, core::kAnyDate)) {
    out = wrap_mul(static_cast<std::int64_t>(in), unit_of(U));
    if constexpr (U == kDate || U == kLdate) out = midnight(out, event);
    if constexpr (U == kTod || U == kLtod) out = within_day(out);
  } else if constexpr (U == kTime && is_real(T)) {
    out = multiply_rounded(kMsNs, static_cast<double>(in), event);
  } else if constexpr (U == kTime) {
    out = wrap_mul(static_cast<std::int64_t>(in), kMsNs);
  } else if constexpr (is_real(U)) {
    out = canonical(static_cast<To>(in));
  } else if constexpr (is_real(T)) {
    out = real_to_int<To>(static_cast<double>(in), event);
  } else {
    out = static_cast<To>(in);
  }
  return either(event, store(result, out));
}

/// Same machine value, same meaning of it: LTIME to TIME, DATE to LDATE.
template <TypeId T>
Event copy_value(void* result, const void* const* args, std::uint32_t) noexcept {
  return store(result, load<ValueOf<T>>(args[0]));
}

/// Part of a date and time.
inline Event date_part(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const std::int64_t day = midnight(load<std::int64_t>(args[0]), event);
  return either(event, store(result, day));
}
inline Event time_part(void* result, const void* const* args, std::uint32_t) noexcept {
  return store(result, within_day(load<std::int64_t>(args[0])));
}

template <TypeId T>
std::size_t format_value(const void* place, ValueText& out) noexcept {
  using enum TypeId;
  const auto in = load<ValueOf<T>>(place);
  if constexpr (T == kBool) {
    return format_bool(in != 0, out);
  } else if constexpr (is_real(T)) {
    return format_real(in, out);
  } else if constexpr (core::in_category(T, core::kAnyBit)) {
    return format_bits(in, 2 * sizeof in, out);
  } else if constexpr (core::in_category(T, core::kAnySigned)) {
    return format_signed(in, out);
  } else if constexpr (core::in_category(T, core::kAnyUnsigned)) {
    return format_unsigned(in, out);
  } else if constexpr (core::in_category(T, core::kAnyDuration)) {
    return format_duration(in, T == kTime ? "T#" : "LTIME#", out);
  } else {
    return format_date(in, T, out);
  }
}
template <TypeId T, TypeId U>
Event to_text(void* result, const void* const* args, std::uint32_t) noexcept {
  ValueText text;
  const std::size_t n = format_value<T>(args[0], text);
  if constexpr (U == TypeId::kString) {
    return write_text(result, std::string_view(text, n));
  } else {
    char16_t wide[kMaxValueText];
    for (std::size_t i = 0; i < n; ++i) wide[i] = static_cast<unsigned char>(text[i]);
    return write_text(result, std::u16string_view(wide, n));
  }
}

template <TypeId U>
Event parse_value(std::string_view text, void* result) noexcept {
  using enum TypeId;
  using To = ValueOf<U>;
  Event event = Event::kNone;
  To out{};
  if constexpr (U == kBool) {
    out = parse_bool(text, event);
  } else if constexpr (U == kReal) {
    out = parse_real(text, event);
  } else if constexpr (U == kLreal) {
    out = parse_lreal(text, event);
  } else if constexpr (core::in_category(U, core::kAnySigned)) {
    out = static_cast<To>(parse_signed(text, std::numeric_limits<To>::min(), std::numeric_limits<To>::max(), event));
  } else if constexpr (is_numeric(U)) {
    out = static_cast<To>(parse_unsigned(text, std::numeric_limits<To>::max(), event));
  } else if constexpr (core::in_category(U, core::kAnyDuration)) {
    out = parse_duration(text, event);
  } else {
    out = parse_date(text, U, event);
  }
  return either(event, store(result, out));
}
/// Longer texts are no literal of any type.
inline constexpr std::size_t kLongestLiteral = 254;
template <TypeId T, TypeId U>
Event from_text(void* result, const void* const* args, std::uint32_t) noexcept {
  const auto text = load<ValueOf<T>>(args[0]);
  if constexpr (T == TypeId::kString) {
    return parse_value<U>(text.substr(0, kLongestLiteral + 1), result);
  } else {
    char narrow[kLongestLiteral + 1];
    const std::size_t n = std::min(text.size(), sizeof narrow);
    for (std::size_t i = 0; i < n; ++i) narrow[i] = text[i] < 0x80 ? static_cast<char>(text[i]) : '?';
    return parse_value<U>(std::string_view(narrow, n), result);
  }
}

/// A character of STRING as a code unit of WSTRING, and back: what Windows-1252 does not have is '?' with an event.
inline char16_t widened(std::uint8_t c) noexcept { return core::from_windows_1252(c); }
inline std::uint8_t narrowed(char16_t unit, Event& event) noexcept {
  const auto byte = core::to_windows_1252(unit);
  if (!byte) event = Event::kInvalid;
  return byte.value_or('?');
}
/// Strings of one width as those of the other.
template <TypeId T, TypeId U>
Event transcode(void* result, const void* const* args, std::uint32_t) noexcept {
  using To = typename ValueOf<U>::value_type;
  const auto in = load<ValueOf<T>>(args[0]);
  core::StringHeader header;
  std::memcpy(&header, result, sizeof header);
  const std::size_t n = std::min<std::size_t>(in.size(), std::min(header.capacity, core::kMaxStringCapacity));
  To* const out = detail::chars_of<To>(result);
  Event event = n < in.size() ? Event::kTruncated : Event::kNone;
  for (std::size_t i = 0; i < n; ++i) {
    if constexpr (U == TypeId::kWstring) {
      out[i] = widened(static_cast<std::uint8_t>(in[i]));
    } else {
      out[i] = static_cast<char>(narrowed(in[i], event));
    }
  }
  detail::set_text<To>(result, header, n);
  return event;
}
/// As transcode does with each of a string.
inline Event narrow_character(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const std::uint8_t out = narrowed(static_cast<char16_t>(load<ValueOf<TypeId::kWchar>>(args[0])), event);
  return either(event, store(result, out));
}
inline Event widen_character(void* result, const void* const* args, std::uint32_t) noexcept {
  return store(result, static_cast<ValueOf<TypeId::kWchar>>(widened(load<ValueOf<TypeId::kChar>>(args[0]))));
}
/// A character as a string of one, and the first character of a string (0 of an empty one, with an event).
template <TypeId T, TypeId U>
Event char_and_text(void* result, const void* const* args, std::uint32_t) noexcept {
  if constexpr (is_text(U)) {
    using Char = typename ValueOf<U>::value_type;
    const auto in = static_cast<Char>(load<ValueOf<T>>(args[0]));
    return write_text(result, std::basic_string_view<Char>(&in, 1));
  } else {
    const auto in = load<ValueOf<T>>(args[0]);
    const auto out = in.empty() ? ValueOf<U>{0} : static_cast<ValueOf<U>>(in.front());
    return either(in.empty() ? Event::kOutOfRange : Event::kNone, store(result, out));
  }
}

template <TypeId T, TypeId U>
constexpr Kernel conversion() {
  constexpr std::uint16_t kDurationOrDate = core::kAnyDuration | core::kAnyDate;
  constexpr bool kSameMeaning = meaning_of(T) == meaning_of(U);
  if constexpr (T == U || (core::in_category(T, kDurationOrDate) && core::in_category(U, core::kAnyDuration) &&
                           core::in_category(T, core::kAnyDuration))) {
    return &copy_value<T>;
  } else if constexpr (is_text(T) && is_text(U)) {
    return &transcode<T, U>;
  } else if constexpr ((is_text(T) && core::in_category(U, core::kAnyChar)) ||
                       (is_text(U) && core::in_category(T, core::kAnyChar))) {
    return &char_and_text<T, U>;
  } else if constexpr (is_text(U)) {
    return &to_text<T, U>;
  } else if constexpr (is_text(T)) {
    return &from_text<T, U>;
  } else if constexpr (core::in_category(T, core::kAnyDate) && core::in_category(U, core::kAnyDate)) {
    if constexpr (U == TypeId::kDate || U == TypeId::kLdate) return &date_part;
    if constexpr (U == TypeId::kTod || U == TypeId::kLtod) return &time_part;
    return &copy_value<T>;
  } else if constexpr (core::in_category(T, kDurationOrDate) && core::in_category(U, core::kAnyDuration)) {
    return &copy_value<T>;
  } else if constexpr (core::in_category(T, core::kAnyDuration) && core::in_category(U, core::kAnyDate)) {
    return &time_part;
  } else if constexpr (T == TypeId::kWchar && U == TypeId::kChar) {
    return &narrow_character;
  } else if constexpr (T == TypeId::kChar && U == TypeId::kWchar) {
    return &widen_character;
  } else if constexpr (kSameMeaning) {
    return &copy_value<meaning_of(T)>;
  } else {
    return &convert_number<meaning_of(T), meaning_of(U)>;
  }
}

/// Kernels and names of all pairs as plain tables: thousands of template instances for them take the compiler too long.
struct PairTables {
  enum Style : std::uint8_t { kShort, kLong, kTo, kTruncTo, kTruncFromTo, kFromBcd, kBcdTo, kToBcd, kToBcdOverloaded };
  static constexpr std::size_t kPairs = core::kTypeCount * core::kTypeCount;
  static constexpr std::size_t kLongestName = 40;
  struct Name {
    char text[kLongestName] = {};
    std::size_t size = 0;
    constexpr void append(std::string_view part) {
      for (const char c : part) text[size++] = c;
    }
  };
  static constexpr std::size_t pair(TypeId t, TypeId u) {
    return static_cast<std::size_t>(t) * core::kTypeCount + static_cast<std::size_t>(u);
  }
  /// How conversions spell a type: by the short name of dates and times of day, "TOD" but "DATE".
  static constexpr std::string_view spelled(TypeId id, Style style) {
    const auto& type = core::info(id);
    return style == kLong || type.alias.size() < 2 || type.alias == "LD" ? type.iec : type.alias;
  }
  static constexpr std::array<Name, kPairs> make_names(Style style) {
    std::array<Name, kPairs> names{};
    for (std::size_t i = 0; i < kPairs; ++i) {
      const auto t = static_cast<TypeId>(i / core::kTypeCount);
      const auto u = static_cast<TypeId>(i % core::kTypeCount);
      constexpr std::string_view kBetween[] = {"_TO_",     "_TO_",    "TO_",      "TRUNC_", "_TRUNC_",
                                               "_BCD_TO_", "BCD_TO_", "_TO_BCD_", "TO_BCD_"};
      if (kBetween[style].front() == '_') names[i].append(spelled(t, style));
      names[i].append(kBetween[style]);
      names[i].append(spelled(u, style));
    }
    return names;
  }
  template <Style S>
  static constexpr std::array<Name, kPairs> kNames = make_names(S);
  template <Style S>
  static constexpr std::string_view name(TypeId t, TypeId u) {
    const Name& entry = kNames<S>[pair(t, u)];
    return {entry.text, entry.size};
  }

  template <std::size_t I>
  static constexpr Kernel conversion_at() {
    constexpr auto kFrom = static_cast<TypeId>(I / core::kTypeCount);
    constexpr auto kInto = static_cast<TypeId>(I % core::kTypeCount);
    if constexpr ((kFrom == kInto && kFrom != TypeId::kPointer) || converts(kFrom, kInto)) {
      return conversion<kFrom, kInto>();
    } else {
      return nullptr;
    }
  }
  template <std::size_t... I>
  static constexpr std::array<Kernel, kPairs> make_conversions(std::index_sequence<I...>) {
    return {conversion_at<I>()...};
  }
};
inline constexpr auto kConversions = PairTables::make_conversions(std::make_index_sequence<PairTables::kPairs>{});

inline constexpr std::string_view kConversionClause = "IEC 61131-3:2013, tables 22 to 27";

struct Convert {
  static constexpr Example examples[] = {
      {"DINT,SINT", "DINT_TO_SINT(200)", "-56"},
      {"REAL,INT", "REAL_TO_INT(2.5)", "2"},
      {"REAL,INT", "REAL_TO_INT(-1.5)", "-2"},
      {"REAL,USINT", "REAL_TO_USINT(300.0)", "event:out_of_range 255"},
      {"SINT,WORD", "SINT_TO_WORD(-1)", "16#FFFF"},
      {"INT,BOOL", "INT_TO_BOOL(-3)", "TRUE"},
      {"TIME,DINT", "TIME_TO_DINT(T#2500ms)", "2500"},
      {"DINT,TIME", "DINT_TO_TIME(1500)", "T#1500ms"},
      {"LTIME,LINT", "LTIME_TO_LINT(LTIME#3us)", "3000"},
      {"DATE_AND_TIME,UDINT", "DT_TO_UDINT(DT#1970-01-02-00:00:01)", "86401"},
      {"UDINT,DATE", "UDINT_TO_DATE(172799)", "D#1970-01-02"},
      {"TIME_OF_DAY,DINT", "TOD_TO_DINT(TOD#00:00:02)", "2000"},
      {"TIME,TIME_OF_DAY", "TIME_TO_TOD(T#1d1h)", "TOD#01:00:00"},
      {"TIME,REAL", "TIME_TO_REAL(T#1500us)", "1.5"},
      {"REAL,TIME", "REAL_TO_TIME(1.5)", "T#1500us"},
      {"DATE_AND_TIME,DATE", "DT_TO_DATE(DT#2024-02-29-12:00:00)", "D#2024-02-29"},
      {"DATE_AND_TIME,TIME_OF_DAY", "DT_TO_TOD(DT#1969-12-31-23:00:00)", "TOD#23:00:00"},
      {"INT,STRING", "INT_TO_STRING(-12)", "'-12'"},
      {"WORD,STRING", "WORD_TO_STRING(16#FF)", "'16#00FF'"},
      {"REAL,STRING", "REAL_TO_STRING(0.1)", "'0.1'"},
      {"TIME,STRING", "TIME_TO_STRING(T#90s)", "'T#1m30s'"},
      {"STRING,INT", "STRING_TO_INT(' 12 ')", "12"},
      {"STRING,INT", "STRING_TO_INT('12 apples')", "event:invalid 0"},
      {"STRING,BYTE", "STRING_TO_BYTE('16#FF')", "16#FF"},
      {"STRING,WSTRING", "STRING_TO_WSTRING('abc')", "\"abc\""}};
  static constexpr FunctionSpec spec{.name = "*_TO_*",
                                     .t_categories = core::kAnyElementary,
                                     .u_categories = core::kAnyElementary,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kU,
                                     .events = events(Event::kOutOfRange, Event::kTruncated, Event::kInvalid),
                                     .clause = kConversionClause,
                                     .summary = "IN as a value of the other type (docs/guides/conversions.md).",
                                     .examples = examples};
  static constexpr bool accepts(TypeId t, TypeId u) { return converts(t, u); }
  static constexpr std::string_view name_of(TypeId t, TypeId u) { return PairTables::name<PairTables::kShort>(t, u); }
  static constexpr Kernel kernel_of(TypeId t, TypeId u) { return kConversions[PairTables::pair(t, u)]; }
};

/// The long names the second edition also gives dates and times of day: "DATE_AND_TIME_TO_TIME_OF_DAY".
struct ConvertLongName {
  static constexpr Example examples[] = {
      {"DATE_AND_TIME,TIME_OF_DAY", "DATE_AND_TIME_TO_TIME_OF_DAY(DT#2024-01-01-01:02:03)", "TOD#01:02:03"}};
  static constexpr FunctionSpec spec{.name = "*_TO_* (long names)",
                                     .t_categories = core::kAnyElementary,
                                     .u_categories = core::kAnyElementary,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kU,
                                     .events = events(Event::kOutOfRange, Event::kTruncated, Event::kInvalid),
                                     .clause = "IEC 61131-3:2003, table 30",
                                     .summary = "As DT_TO_TOD and its like, names written out.",
                                     .examples = examples};
  static constexpr bool accepts(TypeId t, TypeId u) {
    const auto has_two = [](TypeId id) {
      return core::in_category(id, core::kAnyDate) && id != TypeId::kDate && id != TypeId::kLdate;
    };
    return converts(t, u) && (has_two(t) || has_two(u));
  }
  static constexpr std::string_view name_of(TypeId t, TypeId u) { return PairTables::name<PairTables::kLong>(t, u); }
  static constexpr Kernel kernel_of(TypeId t, TypeId u) { return kConversions[PairTables::pair(t, u)]; }
};

struct ConvertOverloaded {
  static constexpr Example examples[] = {{"REAL,INT", "TO_INT(3.5)", "4"}, {"INT,INT", "TO_INT(3)", "3"}};
  static constexpr FunctionSpec spec{.name = "TO_*",
                                     .t_categories = core::kAnyElementary,
                                     .u_categories = core::kAnyElementary,
                                     .params = {{"IN", kT}},
                                     .param_count = 1,
                                     .result = kU,
                                     .events = events(Event::kOutOfRange, Event::kTruncated, Event::kInvalid),
                                     .clause = kConversionClause,
                                     .summary = "IN as a value of the named type, as A_TO_B does.",
                                     .examples = examples};
  static constexpr bool accepts(TypeId t, TypeId u) { return t == u || converts(t, u); }
  static constexpr std::string_view name_of(TypeId t, TypeId u) { return PairTables::name<PairTables::kTo>(t, u); }
  static constexpr Kernel kernel_of(TypeId t, TypeId u) { return kConversions[PairTables::pair(t, u)]; }
};

struct Truncate {
  template <class V, class To>
  static Event call(void* result, const void* const* args, std::uint32_t) noexcept {
    Event event = Event::kNone;
    const To out = saturate_cast<To>(static_cast<double>(load<V>(args[0])), event);
    return either(event, store(result, out));
  }
};
#define PLC_TRUNC_ROW(Row, iec, ...)                                                                      \
  struct Row : Truncate {                                                                                 \
    static constexpr Example examples[] = {__VA_ARGS__};                                                  \
    static constexpr FunctionSpec spec{.name = iec,                                                       \
                                       .t_categories = core::kAnyReal,                                    \
                                       .u_categories = core::kAnyInt,                                     \
                                       .params = {{"IN", kT}},                                            \
                                       .param_count = 1,                                                  \
                                       .result = kU,                                                      \
                                       .events = events(Event::kOutOfRange),                              \
                                       .clause = "IEC 61131-3:2013, table 22",                            \
                                       .summary =                                                         \
                                           "The integer part of IN, toward zero; out of range saturates " \
                                           "and NaN gives 0, with an event.",                             \
                                       .examples = examples};
PLC_TRUNC_ROW(Trunc, "TRUNC", {"REAL,DINT", "TRUNC(-1.6)", "-1"})
template <TypeId T, TypeId U>
static constexpr Kernel kernel = &call<ValueOf<T>, ValueOf<U>>;
};
PLC_TRUNC_ROW(TruncTo, "TRUNC_*", {"LREAL,SINT", "TRUNC_SINT(-128.9)", "-128"})
static constexpr std::string_view name_of(TypeId t, TypeId u) { return PairTables::name<PairTables::kTruncTo>(t, u); }
template <TypeId T, TypeId U>
static constexpr Kernel kernel = &call<ValueOf<T>, ValueOf<U>>;
}
;
PLC_TRUNC_ROW(TruncFromTo, "*_TRUNC_*", {"REAL,INT", "REAL_TRUNC_INT(1.9)", "1"})
static constexpr std::string_view name_of(TypeId t, TypeId u) {
  return PairTables::name<PairTables::kTruncFromTo>(t, u);
}
template <TypeId T, TypeId U>
static constexpr Kernel kernel = &call<ValueOf<T>, ValueOf<U>>;
}
;
#undef PLC_TRUNC_ROW

using ConversionRows = Rows<Convert, ConvertLongName, ConvertOverloaded, Trunc, TruncTo, TruncFromTo>;

}  // namespace plc::stdlib::rows
