#include "tests/library/oracle.h"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <regex>

namespace plc::test {
namespace {

using Oracle = Expected (*)(const Overload&, std::span<const Value>);

constexpr Wide kDayNs = Wide{86'400} * 1'000'000'000;

bool is_real(TypeId type) { return core::in_category(type, core::kAnyReal); }
bool is_duration(TypeId type) { return core::in_category(type, core::kAnyDuration); }
bool is_time_of_day(TypeId type) { return type == TypeId::kTod || type == TypeId::kLtod; }

Wide within_day(Wide ns) { return (ns % kDayNs + kDayNs) % kDayNs; }
Expected exactly(Value value, Event event = Event::kNone) {
  return {Expected::As::kExactly, std::move(value), {}, event};
}
Expected truth(bool value) { return exactly({TypeId::kBool, value ? 1u : 0u, {}}); }

// ---- arithmetic -------------------------------------------------------------------------------------------------

/// Sums and differences of numbers, durations, dates; a time of day stays within its day.
Expected sum(const Overload& o, std::span<const Value> a, char symbol) {
  if (is_real(o.result_type())) {
    Value value = a[0];
    for (const Value& next : a.subspan(1)) value = real_arithmetic(symbol, value, next);
    return exactly(value);
  }
  Wide value = wide_of(a[0]);
  for (const Value& next : a.subspan(1)) value += symbol == '+' ? wide_of(next) : -wide_of(next);
  return exactly(wrapped(o.result_type(), is_time_of_day(o.result_type()) ? within_day(value) : value));
}
Expected add(const Overload& o, std::span<const Value> a) { return sum(o, a, '+'); }
Expected subtract(const Overload& o, std::span<const Value> a) { return sum(o, a, '-'); }

/// Of two values without sign the product needs all 128 bits; only the low ones count.
Value product(TypeId type, const Value& a, const Value& b) {
  __extension__ using Bits = unsigned __int128;
  return wrapped(type, static_cast<Wide>(static_cast<Bits>(wide_of(a)) * static_cast<Bits>(wide_of(b))));
}
Expected multiply(const Overload& o, std::span<const Value> a) {
  const TypeId type = o.result_type();
  if (is_duration(type) && is_real(a[1].type)) return scaled(type, '*', wide_of(a[0]), a[1]);
  Value value = a[0];
  for (const Value& next : a.subspan(1)) {
    value = is_real(type) ? real_arithmetic('*', value, next) : product(type, value, next);
  }
  return exactly(value);
}
Expected divide(const Overload& o, std::span<const Value> a) {
  const TypeId type = o.result_type();
  if (is_real(type)) return exactly(real_arithmetic('/', a[0], a[1]));
  const bool by_zero = is_real(a[1].type) ? real_of(a[1]) == 0 : wide_of(a[1]) == 0;
  if (by_zero) return exactly(wrapped(type, 0), Event::kDivideByZero);
  if (is_real(a[1].type)) return scaled(type, '/', wide_of(a[0]), a[1]);
  return exactly(wrapped(type, wide_of(a[0]) / wide_of(a[1])));
}
Expected modulo(const Overload& o, std::span<const Value> a) {
  return exactly(wrapped(o.t, wide_of(a[1]) == 0 ? 0 : wide_of(a[0]) % wide_of(a[1])));
}
/// By multiplying one by one, as far as the bits still change; powers of 2^n repeat.
Expected integer_power(const Overload& o, std::span<const Value> a) {
  const Wide base = wide_of(a[0]);
  const Wide exponent = wide_of(a[1]);
  if (exponent < 0 && base == 0) return exactly(wrapped(o.t, 0), Event::kDivideByZero);
  if (exponent < 0) return exactly(wrapped(o.t, base == 1 ? 1 : base != -1 ? 0 : exponent % 2 == 0 ? 1 : -1));
  // Odd numbers to the power 2^62 are 1 in 64 bits, and even ones are 0 from the 64th power on.
  const Wide rounds = exponent < 64 ? exponent : base % 2 == 0 ? 64 : -1;
  Value result = wrapped(o.t, 1);
  if (rounds >= 0) {
    for (Wide i = 0; i < rounds; ++i) result = product(o.t, result, a[0]);
    return exactly(result);
  }
  for (int bit = 63; bit >= 0; --bit) {
    result = product(o.t, result, result);
    if ((exponent >> bit & 1) != 0) result = product(o.t, result, a[0]);
  }
  return exactly(result);
}
Value sign_changed(const Value& value) {
  if (!is_real(value.type)) return wrapped(value.type, -wide_of(value));
  return real_value(value.type, -real_of(value));
}
Expected negate(const Overload&, std::span<const Value> a) { return exactly(sign_changed(a[0])); }
Expected magnitude(const Overload&, std::span<const Value> a) {
  const bool negative = is_real(a[0].type) ? (a[0].bits >> (width_of(a[0].type) - 1)) != 0 : wide_of(a[0]) < 0;
  return exactly(negative ? sign_changed(a[0]) : a[0]);
}

// ---- bit strings ------------------------------------------------------------------------------------------------

template <class Combine>
Expected bit_by_bit(std::span<const Value> a, Combine combine) {
  std::uint64_t bits = a[0].bits;
  for (const Value& next : a.subspan(1)) bits = combine(bits, next.bits);
  return exactly(wrapped(a[0].type, static_cast<Wide>(bits)));
}
Expected bits_and(const Overload&, std::span<const Value> a) {
  return bit_by_bit(a, [](std::uint64_t x, std::uint64_t y) { return x & y; });
}
Expected bits_or(const Overload&, std::span<const Value> a) {
  return bit_by_bit(a, [](std::uint64_t x, std::uint64_t y) { return x | y; });
}
Expected bits_xor(const Overload&, std::span<const Value> a) {
  return bit_by_bit(a, [](std::uint64_t x, std::uint64_t y) { return x ^ y; });
}
Expected bits_not(const Overload&, std::span<const Value> a) {
  return exactly(wrapped(a[0].type, greatest_of(a[0].type) - wide_of(a[0])));
}

/// Bit i of the result is bit `from(i)` of IN, or 0 where that is none.
template <class From>
Expected moved(std::span<const Value> a, From from) {
  const auto width = static_cast<Wide>(width_of(a[0].type));
  const Wide places = std::max<Wide>(wide_of(a[1]), 0);
  Wide out = 0;
  for (Wide i = 0; i < width; ++i) {
    const Wide source = from(i, places, width);
    if (source >= 0 && source < width) out |= (wide_of(a[0]) >> static_cast<int>(source) & 1) << static_cast<int>(i);
  }
  return exactly(wrapped(a[0].type, out), wide_of(a[1]) < 0 ? Event::kOutOfRange : Event::kNone);
}
Expected shift_left(const Overload&, std::span<const Value> a) {
  return moved(a, [](Wide i, Wide n, Wide) { return i - n; });
}
Expected shift_right(const Overload&, std::span<const Value> a) {
  return moved(a, [](Wide i, Wide n, Wide) { return i + n; });
}
Expected rotate_left(const Overload&, std::span<const Value> a) {
  return moved(a, [](Wide i, Wide n, Wide width) { return (i - n % width + width) % width; });
}
Expected rotate_right(const Overload&, std::span<const Value> a) {
  return moved(a, [](Wide i, Wide n, Wide width) { return (i + n) % width; });
}

Expected pack(const Overload& o, std::span<const Value> a) {
  Wide byte = 0;
  for (std::size_t i = 0; i < a.size(); ++i) byte += wide_of(a[i]) << i;
  return exactly(wrapped(o.result_type(), byte));
}

/// Hexadecimal digits as they are read.
std::string hexadecimal(const Value& in) {
  char text[32];
  std::snprintf(text, sizeof text, "%0*llX", static_cast<int>(width_of(in.type) / 4),
                static_cast<unsigned long long>(in.bits));
  return text;
}
bool is_decimal(const std::string& digits) { return digits.find_first_not_of("0123456789") == std::string::npos; }
Expected valid_bcd(const Overload&, std::span<const Value> a) { return truth(is_decimal(hexadecimal(a[0]))); }
Expected from_bcd(const Overload& o, std::span<const Value> a) {
  const std::string digits = hexadecimal(a[0]);
  if (!is_decimal(digits)) return exactly(wrapped(o.result_type(), 0), Event::kInvalid);
  return saturated(o.result_type(), static_cast<Wide>(std::strtoull(digits.c_str(), nullptr, 10)));
}
Expected to_bcd(const Overload& o, std::span<const Value> a) {
  const TypeId type = o.result_type();
  const std::size_t room = width_of(type) / 4;
  const std::string digits = std::to_string(a[0].bits);
  const bool fits = digits.size() <= room;
  const std::string held = fits ? digits : std::string(room, '9');
  return exactly(wrapped(type, static_cast<Wide>(std::strtoull(held.c_str(), nullptr, 16))),
                 fits ? Event::kNone : Event::kOutOfRange);
}

Expected same_bytes(const Overload&, std::span<const Value> a) { return exactly(a[0]); }
Expected reversed_bytes(const Overload&, std::span<const Value> a) {
  Value out = a[0];
  if (out.type == TypeId::kWstring) {
    for (char16_t& unit : out.text) unit = static_cast<char16_t>(unit % 256 * 256 + unit / 256);
  } else if (!is_string(out.type) && width_of(out.type) > 8) {
    out.bits = 0;
    for (unsigned i = 0; i < width_of(out.type); i += 8) out.bits = out.bits << 8 | (a[0].bits >> i & 0xff);
  }
  return exactly(out);
}

// ---- comparison and selection -----------------------------------------------------------------------------------

std::partial_ordering order_of(const Value& a, const Value& b) {
  if (is_string(a.type)) return a.text.compare(b.text) <=> 0;
  if (is_real(a.type)) return real_of(a) <=> real_of(b);
  return wide_of(a) == wide_of(b)  ? std::partial_ordering::equivalent
         : wide_of(a) < wide_of(b) ? std::partial_ordering::less
                                   : std::partial_ordering::greater;
}
template <class Holds>
Expected each_pair(std::span<const Value> a, Holds holds) {
  bool all = true;
  for (std::size_t i = 1; i < a.size(); ++i) all = all && holds(order_of(a[i - 1], a[i]));
  return truth(all);
}
Expected greater(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order > 0; });
}
Expected not_less(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order >= 0; });
}
Expected equal(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order == 0; });
}
Expected not_greater(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order <= 0; });
}
Expected less(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order < 0; });
}
Expected different(const Overload&, std::span<const Value> a) {
  return each_pair(a, [](auto order) { return order != 0; });
}

const Value& least(const Value& a, const Value& b) { return order_of(b, a) < 0 ? b : a; }
const Value& most(const Value& a, const Value& b) { return order_of(b, a) > 0 ? b : a; }
Expected minimum(const Overload&, std::span<const Value> a) {
  Value value = a[0];
  for (const Value& next : a.subspan(1)) value = least(value, next);
  return exactly(value);
}
Expected maximum(const Overload&, std::span<const Value> a) {
  Value value = a[0];
  for (const Value& next : a.subspan(1)) value = most(value, next);
  return exactly(value);
}
Expected limit(const Overload&, std::span<const Value> a) { return exactly(least(most(a[1], a[0]), a[2])); }
Expected move(const Overload&, std::span<const Value> a) { return exactly(a[0]); }
Expected assertion(const Overload&, std::span<const Value> a) {
  return exactly(a[0], a[0].bits == 0 ? Event::kAssertion : Event::kNone);
}
Expected select(const Overload&, std::span<const Value> a) { return exactly(a[0].bits == 0 ? a[1] : a[2]); }
Expected multiplex(const Overload&, std::span<const Value> a) {
  const Wide last = static_cast<Wide>(a.size()) - 2;
  const Wide index = std::clamp<Wide>(wide_of(a[0]), 0, last);
  return exactly(a[1 + static_cast<std::size_t>(index)], index == wide_of(a[0]) ? Event::kNone : Event::kBadIndex);
}

// ---- others -----------------------------------------------------------------------------------------------------

Expected of_one_real(const Overload& o, std::span<const Value> a) { return *real_function(o.spec->name, a[0]); }
Expected arc_tangent_2(const Overload&, std::span<const Value> a) { return arc_tangent(a[0], a[1]); }
Expected raise(const Overload&, std::span<const Value> a) { return power(a[0], a[1]); }
Expected valid_real(const Overload&, std::span<const Value> a) { return truth(std::isfinite(real_of(a[0]))); }
Expected dead_band(const Overload& o, std::span<const Value> a) {
  const double x = real_of(a[0]), width = std::max(0.0, real_of(a[1]));
  if (std::isnan(x) || std::isnan(real_of(a[1]))) return exactly(real_value(o.t, std::nan("")));
  if (std::fabs(x) <= width) return exactly(real_value(o.t, 0));
  return exactly(real_arithmetic(x > 0 ? '-' : '+', a[0], real_value(o.t, width)));
}
Expected date_and_time(const Overload& o, std::span<const Value> a) {
  return saturated(o.result_type(), wide_of(a[0]) + wide_of(a[1]));
}
Expected of_parts(const Overload& o, std::span<const Value> a) { return date_of_parts(o.result_type(), a); }
Expected part(const Overload& o, std::span<const Value> a) {
  return part_of_date(o.result_type(), stdlib::output_name(*o.spec), a[0]);
}
/// S0 .. S7 of SWITCH.
Expected chosen(const Overload& o, std::span<const Value> a) {
  return truth(wide_of(a[0]) == stdlib::output_name(*o.spec)[1] - '0');
}
Expected weekday(const Overload& o, std::span<const Value> a) { return day_of_week(o.result_type(), a[0]); }
Expected on_text(const Overload& o, std::span<const Value> a) { return *text_function(o, a); }
Expected convert(const Overload& o, std::span<const Value> a) { return converted(o.result_type(), a[0]); }
Expected integer_part(const Overload& o, std::span<const Value> a) { return truncated(o.result_type(), a[0]); }

/// By the name of the row. Rows of one name (ADD of numbers, of dates) share an oracle, which looks at the types.
const std::map<std::string_view, Oracle> kOracles = {
    {"ADD", add},
    {"ADD_TIME", add},
    {"ADD_LTIME", add},
    {"ADD_TOD_TIME", add},
    {"ADD_LTOD_LTIME", add},
    {"ADD_DT_TIME", add},
    {"ADD_LDT_LTIME", add},
    {"SUB", subtract},
    {"SUB_TIME", subtract},
    {"SUB_LTIME", subtract},
    {"SUB_TOD_TIME", subtract},
    {"SUB_LTOD_LTIME", subtract},
    {"SUB_DT_TIME", subtract},
    {"SUB_LDT_LTIME", subtract},
    {"SUB_DATE_DATE", subtract},
    {"SUB_LDATE_LDATE", subtract},
    {"SUB_TOD_TOD", subtract},
    {"SUB_LTOD_LTOD", subtract},
    {"SUB_DT_DT", subtract},
    {"SUB_LDT_LDT", subtract},
    {"MUL", multiply},
    {"MUL_TIME", multiply},
    {"MULTIME", multiply},
    {"MUL_LTIME", multiply},
    {"DIV", divide},
    {"DIV_TIME", divide},
    {"DIVTIME", divide},
    {"DIV_LTIME", divide},
    {"MOD", modulo},
    {"NEG", negate},
    {"INTEGER_POWER", integer_power},
    {"ABS", magnitude},
    {"AND", bits_and},
    {"OR", bits_or},
    {"XOR", bits_xor},
    {"NOT", bits_not},
    {"SHL", shift_left},
    {"SHR", shift_right},
    {"ROL", rotate_left},
    {"ROR", rotate_right},
    {"PACK", pack},
    {"IS_VALID_BCD", valid_bcd},
    {"*_BCD_TO_*", from_bcd},
    {"BCD_TO_*", from_bcd},
    {"*_TO_BCD_*", to_bcd},
    {"TO_BCD_*", to_bcd},
    {"TO_BIG_ENDIAN", reversed_bytes},
    {"FROM_BIG_ENDIAN", reversed_bytes},
    {"TO_LITTLE_ENDIAN", same_bytes},
    {"FROM_LITTLE_ENDIAN", same_bytes},
    {"GT", greater},
    {"GE", not_less},
    {"EQ", equal},
    {"LE", not_greater},
    {"LT", less},
    {"NE", different},
    {"ASSERT", assertion},
    {"MOVE", move},
    {"SEL", select},
    {"MAX", maximum},
    {"MIN", minimum},
    {"LIMIT", limit},
    {"MUX", multiplex},
    {"SQRT", of_one_real},
    {"LN", of_one_real},
    {"LOG", of_one_real},
    {"EXP", of_one_real},
    {"SIN", of_one_real},
    {"COS", of_one_real},
    {"TAN", of_one_real},
    {"ASIN", of_one_real},
    {"ACOS", of_one_real},
    {"ATAN", of_one_real},
    {"ATAN2", arc_tangent_2},
    {"EXPT", raise},
    {"IS_VALID", valid_real},
    {"DEADBAND", dead_band},
    {"DEAD_BAND", dead_band},
    {"CONCAT_DATE_TOD", date_and_time},
    {"CONCAT_DATE_LTOD", date_and_time},
    {"CONCAT_LDATE_LTOD", date_and_time},
    {"CONCAT_DATE", of_parts},
    {"CONCAT_TOD", of_parts},
    {"CONCAT_LTOD", of_parts},
    {"CONCAT_DT", of_parts},
    {"CONCAT_LDT", of_parts},
    {"DAY_OF_WEEK", weekday},
    {"SPLIT_DATE", part},
    {"SPLIT_TOD", part},
    {"SPLIT_LTOD", part},
    {"SPLIT_DT", part},
    {"SPLIT_LDT", part},
    {"SWITCH", chosen},
    {"LEN", on_text},
    {"LEFT", on_text},
    {"RIGHT", on_text},
    {"MID", on_text},
    {"CONCAT", on_text},
    {"INSERT", on_text},
    {"DELETE", on_text},
    {"REPLACE", on_text},
    {"FIND", on_text},
    {"*_TO_*", convert},
    {"*_TO_* (long names)", convert},
    {"TO_*", convert},
    {"TRUNC", integer_part},
    {"TRUNC_*", integer_part},
    {"*_TRUNC_*", integer_part},
};

/// Whether `text` reads back as `value`, by the C library.
bool reads_back(const std::string& text, const Value& value) {
  const double number = value.type == TypeId::kReal ? static_cast<double>(std::strtof(text.c_str(), nullptr))
                                                    : std::strtod(text.c_str(), nullptr);
  return real_value(value.type, number) == value;
}

/// "1.0", "-0.1", "1.0E+20", "NaN", "-Inf": reads back as the number, and no text with fewer digits does. Whole numbers
/// may be written out when that is no longer than with an exponent.
bool is_shortest_text(const std::u16string& wide, const Value& value) {
  std::string text;
  for (const char16_t unit : wide) text += unit < 0x80 ? static_cast<char>(unit) : '?';
  const double number = real_of(value);
  if (std::isnan(number)) return text == "NaN";
  if (std::isinf(number)) return text == (number < 0 ? "-Inf" : "Inf");
  static const std::regex kForm("-?([0-9]+)\\.([0-9]+)(E[-+][0-9]{2,3})?");
  std::smatch parts;
  if (!std::regex_match(text, parts, kForm) || !reads_back(text, value)) return false;
  std::string digits = parts[1].str() + parts[2].str();
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size()));
  digits.erase(digits.find_last_not_of('0') + 1);
  char shortest[64];
  int needed = 0;
  do {
    std::snprintf(shortest, sizeof shortest, "%.*e", needed++, number);
  } while (!reads_back(shortest, value));
  if (digits.size() <= static_cast<std::size_t>(needed)) return true;
  const bool written_out = parts[2] == "0" && !parts[3].matched;
  return written_out && text.size() - 2 <= std::string_view(shortest).size();
}

}  // namespace

Wide wide_of(const Value& value) {
  const bool is_signed = core::in_category(value.type, core::kAnySigned | core::kAnyDuration | core::kAnyDate);
  const unsigned unused = 64 - std::max(8u, width_of(value.type));
  if (is_signed) return static_cast<std::int64_t>(value.bits << unused) >> unused;
  return static_cast<Wide>(value.bits);
}
Value wrapped(TypeId type, Wide number) {
  return {type, static_cast<std::uint64_t>(number) & (~std::uint64_t{0} >> (64 - width_of(type))), {}};
}
Wide least_of(TypeId type) {
  const bool is_signed = core::in_category(type, core::kAnySigned | core::kAnyDuration | core::kAnyDate);
  return is_signed ? -(Wide{1} << (width_of(type) - 1)) : 0;
}
Wide greatest_of(TypeId type) { return least_of(type) + (Wide{1} << width_of(type)) - 1; }
Expected saturated(TypeId type, Wide number) {
  const Wide held = std::clamp(number, least_of(type), greatest_of(type));
  return exactly(wrapped(type, held), held == number ? Event::kNone : Event::kOutOfRange);
}

bool agrees(const Expected& expected, const Value& result) {
  switch (expected.as) {
    case Expected::As::kExactly:
      return result == expected.value;
    case Expected::As::kNeighbour:
      return result == expected.value || result == expected.other;
    case Expected::As::kShortestText:
      return is_shortest_text(result.text, expected.value);
  }
  return false;
}

std::optional<Expected> expect(const Overload& overload, std::span<const Value> arguments, std::size_t room) {
  // The outputs of a bundle share its oracle.
  const std::string_view name = overload.spec->name;
  const auto found = kOracles.find(name.substr(0, name.find('.')));
  const Oracle oracle = found != kOracles.end() ? found->second : nullptr;
  if (oracle == nullptr) return std::nullopt;
  Expected expected = oracle(overload, arguments);
  if (expected.as == Expected::As::kExactly && is_string(expected.value.type) && expected.value.text.size() > room) {
    expected.value.text.resize(room);
    if (expected.event == Event::kNone) expected.event = Event::kTruncated;
  }
  return expected;
}

}  // namespace plc::test
