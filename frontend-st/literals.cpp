#include "frontend-st/literals.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>

#include "core/text.h"
#include "core/utf8.h"
#include "core/windows_1252.h"
#include "frontend-st/lexer.h"
#include "stdlib/calendar.h"

namespace plc::st {
namespace {

using core::Rep;
using core::TypeId;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kDay = 86'400 * kSecond;

std::optional<Literal> fail(std::string& problem, std::string why) {
  problem = std::move(why);
  return std::nullopt;
}

/// `text` without underscores; nothing when one is at an end or beside another.
std::optional<std::string> without_underscores(std::string_view text) {
  std::string out;
  char last = '_';
  for (char c : text) {
    if (c == '_' && last == '_') return std::nullopt;
    if (c != '_') out += c;
    last = c;
  }
  if (last == '_') return std::nullopt;
  return out;
}

struct Magnitude {
  std::uint64_t value = 0;
};

// Digits, optionally based: "12", "16#FF". No sign.
std::optional<Magnitude> parse_magnitude(std::string_view text, std::string& problem) {
  int base = 10;
  const std::size_t hash = text.find('#');
  std::string_view digits = text;
  if (hash != std::string_view::npos) {
    const std::string_view prefix = text.substr(0, hash);
    if (prefix == "2") {
      base = 2;
    } else if (prefix == "8") {
      base = 8;
    } else if (prefix == "16") {
      base = 16;
    } else if (prefix != "10") {
      problem = "base " + std::string(prefix) + " is not 2, 8, 10 or 16";
      return std::nullopt;
    }
    digits = text.substr(hash + 1);
  }
  const std::optional<std::string> plain = without_underscores(digits);
  if (!plain || plain->empty()) {
    problem = "\"" + std::string(text) + "\" is not an integer";
    return std::nullopt;
  }
  Magnitude out;
  const char* end = plain->data() + plain->size();
  const auto [stop, error] = std::from_chars(plain->data(), end, out.value, base);
  if (error == std::errc::result_out_of_range) {
    problem = "integer " + std::string(text) + " needs more than 64 bits";
    return std::nullopt;
  }
  if (error != std::errc{} || stop != end) {
    problem = "\"" + std::string(text) + "\" has digits that base " + std::to_string(base) + " does not have";
    return std::nullopt;
  }
  return out;
}

bool take_sign(std::string_view& text) {
  if (text.empty() || (text[0] != '-' && text[0] != '+')) return false;
  const bool negative = text[0] == '-';
  text.remove_prefix(1);
  return negative;
}

bool looks_real(std::string_view text) {
  if (text.find('#') != std::string_view::npos) return false;
  return text.find_first_of(".eE") != std::string_view::npos;
}

template <class Float>
std::optional<Float> parse_real(std::string_view text, std::string& problem) {
  const bool negative = take_sign(text);
  const std::optional<std::string> plain = without_underscores(text);
  Float value = 0;
  if (!plain || plain->empty() || !is_digit((*plain)[0])) {
    problem = "\"" + std::string(text) + "\" is not a real number";
    return std::nullopt;
  }
  const char* end = plain->data() + plain->size();
  const auto [stop, error] = std::from_chars(plain->data(), end, value);
  if (error == std::errc::result_out_of_range) {
    // from_chars says the same for too large and too small; the exponent's sign tells them apart.
    if (plain->find("e-") != std::string::npos || plain->find("E-") != std::string::npos) return Float{0};
    problem = "real number " + std::string(text) + " is out of range";
    return std::nullopt;
  }
  if (error != std::errc{} || stop != end) {
    problem = "\"" + std::string(text) + "\" is not a real number";
    return std::nullopt;
  }
  return negative ? -value : value;
}

std::optional<Literal> parse_number_of(TypeId type, std::string_view text, std::string& problem) {
  Literal out;
  out.kind = Literal::Kind::kScalar;
  out.type = type;
  if (type == TypeId::kReal) {
    const auto value = parse_real<float>(text, problem);
    if (!value) return std::nullopt;
    out.bits = std::bit_cast<std::uint32_t>(*value);
    return out;
  }
  if (type == TypeId::kLreal) {
    const auto value = parse_real<double>(text, problem);
    if (!value) return std::nullopt;
    out.bits = std::bit_cast<std::uint64_t>(*value);
    return out;
  }
  std::string_view digits = text;
  const bool negative = take_sign(digits);
  const auto magnitude = parse_magnitude(digits, problem);
  if (!magnitude) return std::nullopt;
  const std::uint64_t limit = std::uint64_t{1} << 63;
  const bool fits =
      negative ? magnitude->value <= limit && int_fits(static_cast<std::int64_t>(0 - magnitude->value), false, type)
               : int_fits(static_cast<std::int64_t>(magnitude->value), magnitude->value >= limit, type);
  if (!fits) return fail(problem, std::string(text) + " does not fit into " + std::string(core::name_of(type)));
  out.bits = truncate_bits(negative ? 0 - magnitude->value : magnitude->value, core::rep_of(type));
  return out;
}

std::optional<std::uint32_t> hex(std::string_view digits) {
  std::uint32_t value = 0;
  const auto [stop, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
  if (error != std::errc{} || stop != digits.data() + digits.size()) return std::nullopt;
  return value;
}

void append_unit(std::string& out, std::uint32_t unit) {
  out += static_cast<char>(unit & 0xffu);
  out += static_cast<char>(unit >> 8);
}

// 'text' or "text" with the quotes.
std::optional<Literal> parse_quoted(std::string_view text, std::string& problem) {
  const char quote = text[0];
  const bool wide = quote == '"';
  if (text.size() < 2 || text.back() != quote) return fail(problem, "string without closing " + std::string(1, quote));
  const std::string_view inner = text.substr(1, text.size() - 2);
  Literal out;
  out.kind = Literal::Kind::kText;
  out.type = wide ? TypeId::kWstring : TypeId::kString;
  const auto put = [&](std::uint32_t unit) {
    if (wide) {
      append_unit(out.text, unit);
    } else {
      out.text += static_cast<char>(unit);
    }
  };
  for (std::size_t i = 0; i < inner.size();) {
    if (inner[i] != '$') {
      const std::size_t begin = i;
      const std::uint32_t point = core::decode_utf8(inner, i);
      if (!wide) {
        const auto byte = core::to_windows_1252(point);
        if (!byte) {
          return fail(problem, "STRING has no character \"" + std::string(inner.substr(begin, i - begin)) +
                                   "\", only those of Windows-1252; WSTRING has it");
        }
        if (point > 0xff && out.beyond_latin_1.empty()) out.beyond_latin_1 = inner.substr(begin, i - begin);
        out.text += static_cast<char>(*byte);
        continue;
      }
      if (point < 0x10000) {
        append_unit(out.text, point);
      } else {
        append_unit(out.text, 0xd800u + ((point - 0x10000u) >> 10));
        append_unit(out.text, 0xdc00u + ((point - 0x10000u) & 0x3ffu));
      }
      continue;
    }
    const std::size_t width = wide ? 4 : 2;
    if (i + 1 + width <= inner.size()) {
      if (const auto code = hex(inner.substr(i + 1, width))) {
        put(*code);
        i += 1 + width;
        continue;
      }
    }
    const char c = i + 1 < inner.size() ? core::upper(inner[i + 1]) : '\0';
    switch (c) {
      case '$':
        put('$');
        break;
      case '\'':
        put('\'');
        break;
      case '"':
        put('"');
        break;
      case 'L':
        put('\n');
        break;
      case 'N':
        put('\n');
        break;
      case 'P':
        put('\f');
        break;
      case 'R':
        put('\r');
        break;
      case 'T':
        put('\t');
        break;
      default:
        return fail(problem, "unknown escape $" + std::string(c == '\0' ? "" : std::string(1, inner[i + 1])));
    }
    i += 2;
  }
  if (out.text.size() / (wide ? 2u : 1u) > core::kMaxStringCapacity) return fail(problem, "string is too long");
  return out;
}

std::optional<Literal> parse_quoted_of(TypeId type, std::string_view text, std::string& problem) {
  if (!core::in_category(type, core::kAnyChars)) {
    return fail(problem, std::string(core::name_of(type)) + "# takes no quoted text");
  }
  // CHAR#"a" and STRING#"a" are written by tools that quote everything the same way: the prefix decides.
  const bool wide = type == TypeId::kWstring || type == TypeId::kWchar;
  std::string requoted(text);
  requoted.front() = requoted.back() = wide ? '"' : '\'';
  auto out = parse_quoted(requoted, problem);
  if (!out) return out;
  if (core::in_category(type, core::kAnyChar) && out->text.size() != (wide ? 2u : 1u)) {
    return fail(problem, std::string(core::name_of(type)) + " holds exactly one character");
  }
  out->type = type;
  return out;
}

std::optional<std::int64_t> digits_of(std::string_view& text, std::size_t min, std::size_t max) {
  std::size_t count = 0;
  std::int64_t value = 0;
  while (count < text.size() && is_digit(text[count]) && count < max) value = value * 10 + (text[count++] - '0');
  if (count < min) return std::nullopt;
  text.remove_prefix(count);
  return value;
}

bool take(std::string_view& text, char c) {
  if (text.empty() || text[0] != c) return false;
  text.remove_prefix(1);
  return true;
}

// "2024-01-31"; nanoseconds since 1970.
std::optional<std::int64_t> take_date(std::string_view& text, std::string& problem) {
  const auto year = digits_of(text, 4, 4);
  const auto month = year && take(text, '-') ? digits_of(text, 1, 2) : std::nullopt;
  const auto day = month && take(text, '-') ? digits_of(text, 1, 2) : std::nullopt;
  if (!day) {
    problem = "a date is written year-month-day, as in 2024-01-31";
    return std::nullopt;
  }
  if (*month < 1 || *month > 12 || *day < 1 || *day > stdlib::days_in_month(*year, static_cast<unsigned>(*month))) {
    problem = "there is no such day in the calendar";
    return std::nullopt;
  }
  const std::int64_t days = stdlib::days_of({*year, static_cast<unsigned>(*month), static_cast<unsigned>(*day)});
  if (days < -stdlib::kMostDays || days > stdlib::kMostDays) {
    problem = "dates before 1677-09-22 and after 2262-04-11 have no 64-bit nanosecond value";
    return std::nullopt;
  }
  return days * kDay;
}

// "12:30:05.25"; nanoseconds since midnight. Seconds may be left out.
std::optional<std::int64_t> take_time_of_day(std::string_view& text, std::string& problem) {
  const auto hour = digits_of(text, 1, 2);
  const auto minute = hour && take(text, ':') ? digits_of(text, 1, 2) : std::nullopt;
  std::optional<std::int64_t> second = 0;
  std::int64_t fraction = 0;
  if (minute && take(text, ':')) {
    second = digits_of(text, 1, 2);
    if (second && take(text, '.')) {
      std::int64_t unit = kSecond;
      const auto is_part = [&text] {
        const bool between = text.size() > 1 && text[0] == '_' && is_digit(text[1]);
        return !text.empty() && (is_digit(text[0]) || between);
      };
      for (bool first = true; is_part() && !(first && text[0] == '_'); first = false, text.remove_prefix(1)) {
        if (text[0] == '_') continue;
        unit /= 10;
        fraction += (text[0] - '0') * unit;
      }
    }
  }
  if (!minute || !second || *hour > 23 || *minute > 59 || *second > 59) {
    problem = "a time of day is written hours:minutes:seconds, 00:00:00 to 23:59:59.999";
    return std::nullopt;
  }
  return (*hour * 3600 + *minute * 60 + *second) * kSecond + fraction;
}

std::optional<Literal> parse_date_of(TypeId type, std::string_view text, std::string& problem) {
  const bool has_date = type != TypeId::kTod && type != TypeId::kLtod;
  const bool has_time = type != TypeId::kDate && type != TypeId::kLdate;
  std::int64_t value = 0;
  if (has_date) {
    const auto date = take_date(text, problem);
    if (!date) return std::nullopt;
    value += *date;
    if (has_time && !take(text, '-')) return fail(problem, "the time of day is missing after the date");
  }
  if (has_time) {
    const auto time = take_time_of_day(text, problem);
    if (!time) return std::nullopt;
    if (__builtin_add_overflow(value, *time, &value)) {
      return fail(problem, "times after 2262-04-11-23:47:16.854775807 have no 64-bit nanosecond value");
    }
  }
  if (!text.empty()) return fail(problem, "\"" + std::string(text) + "\" is left over");
  Literal out;
  out.kind = Literal::Kind::kScalar;
  out.type = type;
  out.bits = static_cast<std::uint64_t>(value);
  return out;
}

std::optional<Literal> parse_typed(TypeId type, std::string_view body, std::string& problem) {
  // "T# 30ms": the lexer takes blanks after the prefix and between the parts of a duration.
  body = core::trimmed(body);
  if (body.empty()) return fail(problem, "nothing follows " + std::string(core::name_of(type)) + "#");
  if (body[0] == '\'' || body[0] == '"') return parse_quoted_of(type, body, problem);
  if (core::in_category(type, core::kAnyDuration)) {
    const auto ns = parse_duration(body, problem);
    if (!ns) return std::nullopt;
    Literal out;
    out.kind = Literal::Kind::kScalar;
    out.type = type;
    out.bits = static_cast<std::uint64_t>(*ns);
    return out;
  }
  if (core::in_category(type, core::kAnyDate)) return parse_date_of(type, body, problem);
  if (type == TypeId::kBool && (core::iequals(body, "TRUE") || core::iequals(body, "FALSE"))) {
    Literal out;
    out.kind = Literal::Kind::kScalar;
    out.bits = core::iequals(body, "TRUE") ? 1 : 0;
    return out;
  }
  if (core::in_category(type, core::kAnyString)) {
    return fail(problem, std::string(core::name_of(type)) + "# needs a quoted text");
  }
  return parse_number_of(type, body, problem);
}

}  // namespace

std::string beyond_latin_1_text(const Literal& literal) {
  return "character \"" + literal.beyond_latin_1 + "\" of a STRING is one of Windows-1252, not of ISO 8859-1";
}

std::optional<TypeId> literal_prefix(std::string_view prefix) {
  if (core::iequals(prefix, "T")) return TypeId::kTime;
  if (core::iequals(prefix, "LT")) return TypeId::kLtime;
  return core::type_named(prefix);
}

bool int_fits(std::int64_t value, bool is_unsigned, TypeId type) {
  const Rep rep = core::rep_of(type);
  if (rep == Rep::kU64) return is_unsigned || value >= 0;
  if (is_unsigned) return false;
  switch (rep) {
    case Rep::kBool:
      return value == 0 || value == 1;
    case Rep::kI8:
      return value >= INT8_MIN && value <= INT8_MAX;
    case Rep::kU8:
      return value >= 0 && value <= UINT8_MAX;
    case Rep::kI16:
      return value >= INT16_MIN && value <= INT16_MAX;
    case Rep::kU16:
      return value >= 0 && value <= UINT16_MAX;
    case Rep::kI32:
      return value >= INT32_MIN && value <= INT32_MAX;
    case Rep::kU32:
      return value >= 0 && value <= UINT32_MAX;
    case Rep::kI64:
      return true;
    default:
      return false;
  }
}

std::uint64_t truncate_bits(std::uint64_t bits, Rep rep) {
  const std::uint32_t bytes = core::rep_bytes(rep);
  return bytes == 0 || bytes >= 8 ? bits : bits & ((std::uint64_t{1} << (bytes * 8)) - 1);
}

std::int64_t signed_value(std::uint64_t bits, Rep rep) {
  switch (rep) {
    case Rep::kI8:
      return static_cast<std::int8_t>(bits);
    case Rep::kI16:
      return static_cast<std::int16_t>(bits);
    case Rep::kI32:
      return static_cast<std::int32_t>(bits);
    default:
      return static_cast<std::int64_t>(bits);
  }
}

std::optional<std::int64_t> parse_duration(std::string_view text, std::string& problem) {
  const std::string whole(text);
  const bool negative = take_sign(text);
  struct Unit {
    std::string_view name;
    std::int64_t ns;
  };
  // Longer names first: "ms" is not minutes.
  static constexpr Unit kUnits[] = {{"ms", 1'000'000},     {"us", 1'000},       {"ns", 1},     {"d", kDay},
                                    {"h", 3600 * kSecond}, {"m", 60 * kSecond}, {"s", kSecond}};
  std::int64_t total = 0;
  std::int64_t last_unit = INT64_MAX;
  bool fraction_seen = false;
  bool any = false;
  const auto bad = [&](const std::string& why) {
    problem = "\"" + whole + "\" is not a duration: " + why;
    return std::nullopt;
  };
  const auto skip_blanks = [&text] { text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size())); };
  while (skip_blanks(), !text.empty()) {
    if (any) take(text, '_');
    std::int64_t value = 0;
    std::size_t count = 0;
    std::size_t i = 0;
    while (i < text.size() && (is_digit(text[i]) || (text[i] == '_' && count > 0))) {
      if (is_digit(text[i])) {
        if (__builtin_mul_overflow(value, 10, &value) || __builtin_add_overflow(value, text[i] - '0', &value)) {
          return bad("too long");
        }
        ++count;
      }
      ++i;
    }
    constexpr const char* kUnitNames = "units are d, h, m, s, ms, us and ns";
    if (count == 0) return bad(any && text[0] != '.' ? kUnitNames : "a number is missing");
    if (fraction_seen) return bad("only the last part may have a fraction");
    std::string_view fraction;
    if (i < text.size() && text[i] == '.') {
      const std::size_t first = ++i;
      while (i < text.size() && (is_digit(text[i]) || text[i] == '_')) ++i;
      fraction = text.substr(first, i - first);
      fraction_seen = true;
    }
    text.remove_prefix(i);
    skip_blanks();
    std::int64_t unit = 0;
    for (const Unit& u : kUnits) {
      if (text.size() >= u.name.size() && core::iequals(text.substr(0, u.name.size()), u.name)) {
        unit = u.ns;
        text.remove_prefix(u.name.size());
        break;
      }
    }
    if (unit == 0) return bad(kUnitNames);
    if (unit >= last_unit) return bad("units go from large to small");
    last_unit = unit;
    any = true;
    if (__builtin_mul_overflow(value, unit, &value) || __builtin_add_overflow(total, value, &total)) {
      return bad("too long");
    }
    // A fraction finer than a nanosecond is cut off.
    for (char c : fraction) {
      if (c == '_') continue;
      unit /= 10;
      if (__builtin_add_overflow(total, (c - '0') * unit, &total)) return bad("too long");
    }
  }
  if (!any) return bad("it is empty");
  return negative ? -total : total;
}

std::optional<Literal> parse_literal(std::string_view text, std::string& problem) {
  if (text.empty()) return fail(problem, "nothing is written");
  if (text[0] == '\'' || text[0] == '"') return parse_quoted(text, problem);
  Literal out;
  if (core::iequals(text, "TRUE") || core::iequals(text, "FALSE")) {
    out.kind = Literal::Kind::kScalar;
    out.bits = core::fold(text[0]) == 't' ? 1 : 0;
    return out;
  }
  const std::size_t hash = text.find('#');
  if (hash != std::string_view::npos && is_identifier_start(text[0])) {
    const auto type = literal_prefix(text.substr(0, hash));
    if (!type) return fail(problem, "\"" + std::string(text.substr(0, hash)) + "\" is not an elementary type");
    return parse_typed(*type, text.substr(hash + 1), problem);
  }
  std::string_view digits = text;
  const bool negative = take_sign(digits);
  if (looks_real(digits)) {
    const auto value = parse_real<double>(text, problem);
    if (!value) return std::nullopt;
    out.kind = Literal::Kind::kReal;
    out.real_value = *value;
    return out;
  }
  const auto magnitude = parse_magnitude(digits, problem);
  if (!magnitude) return std::nullopt;
  const std::uint64_t limit = std::uint64_t{1} << 63;
  if (negative && magnitude->value > limit)
    return fail(problem, "integer " + std::string(text) + " needs more than 64 bits");
  out.int_value = static_cast<std::int64_t>(negative ? 0 - magnitude->value : magnitude->value);
  out.int_is_unsigned = !negative && magnitude->value >= limit;
  return out;
}

}  // namespace plc::st
