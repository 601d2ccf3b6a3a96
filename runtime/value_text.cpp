#include "runtime/value_text.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/integer_at.h"
#include "core/text.h"
#include "core/utf8.h"
#include "core/windows_1252.h"
#include "runtime/interpreter/operations.h"
#include "stdlib/arithmetic.h"
#include "stdlib/text_values.h"

namespace plc::runtime {
namespace {

using bytecode::ImageType;
using bytecode::TypeKind;
using core::Code;
using core::Problem;
using core::Rep;

constexpr char kHex[] = "0123456789ABCDEF";

template <class T>
void append_number(T value, std::string& out) {
  char buffer[40];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  out.append(buffer, result.ptr);
}

void append_character(unsigned character, unsigned width, char quote, std::string& out) {
  switch (character) {
    case '$':
      out += "$$";
      return;
    case '\n':
      out += "$N";
      return;
    case '\r':
      out += "$R";
      return;
    case '\t':
      out += "$T";
      return;
    case '\f':
      out += "$P";
      return;
    default:
      break;
  }
  if (character == static_cast<unsigned char>(quote)) {
    out += '$';
    out += quote;
  } else if (character >= 0x20 && character < 0x7f) {
    out += static_cast<char>(character);
  } else {
    out += '$';
    for (unsigned digit = width * 2; digit-- > 0;) out += kHex[(character >> (digit * 4)) & 0xfu];
  }
}

void append_string(const std::byte* characters, std::size_t length, unsigned width, std::string& out) {
  const char quote = width == 1 ? '\'' : '"';
  out += quote;
  for (std::size_t i = 0; i < length; ++i) {
    const unsigned character =
        width == 1 ? load<std::uint8_t>(characters + i) : load<std::uint16_t>(characters + 2 * i);
    append_character(character, width, quote, out);
  }
  out += quote;
}

std::string type_name(const ImageType& type) {
  // A range that is declared with its variable has a name that no source can spell.
  if (type.name.find(' ') != std::string::npos) {
    return std::string(core::name_of(type.elementary)) +
           (type.limited ? " (" + std::to_string(type.lower) + ".." + std::to_string(type.upper) + ")" : "");
  }
  return type.name.empty() ? std::string(core::name_of(type.elementary)) : type.name;
}
Problem no_value(const ImageType& type, std::string_view text) {
  return {Code::P7103, "\"" + std::string(text) + "\" is not a value of type " + type_name(type), {}};
}
Problem out_of_range(const ImageType& type, std::string_view text) {
  return {Code::P7104, std::string(text) + " is outside the range of type " + type_name(type), {}};
}

/// An integer literal: magnitude and sign. `too_large`: it has the form of one but exceeds 64 bits.
struct Integer {
  std::uint64_t magnitude = 0;
  bool negative = false;
  bool too_large = false;
};

std::optional<Integer> parse_integer(std::string_view text) {
  Integer value;
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) {
    value.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  unsigned base = 10;
  for (const auto& [prefix, prefix_base] : {std::pair{"16#", 16u}, std::pair{"8#", 8u}, std::pair{"2#", 2u}}) {
    if (text.starts_with(prefix)) {
      base = prefix_base;
      text.remove_prefix(std::strlen(prefix));
      break;
    }
  }
  bool digit_before = false;
  for (const char c : text) {
    if (c == '_' && digit_before) {
      digit_before = false;
      continue;
    }
    const char f = core::fold(c);
    unsigned digit = 99;
    if (f >= '0' && f <= '9') digit = static_cast<unsigned>(f - '0');
    if (f >= 'a' && f <= 'f') digit = static_cast<unsigned>(f - 'a') + 10;
    if (digit >= base) return std::nullopt;
    if (value.magnitude > (std::numeric_limits<std::uint64_t>::max() - digit) / base) value.too_large = true;
    value.magnitude = value.magnitude * base + digit;
    digit_before = true;
  }
  if (!digit_before) return std::nullopt;
  return value;
}

/// "T#1d2h3m4.5s", "LTIME#-5us": units in descending order, a fraction in the last part only. In ns.
std::optional<Integer> parse_duration(std::string_view text) {
  const std::size_t hash = text.find('#');
  if (hash == std::string_view::npos) return std::nullopt;
  const std::string_view prefix = text.substr(0, hash);
  if (!core::iequals(prefix, "T") && !core::iequals(prefix, "TIME") && !core::iequals(prefix, "LT") &&
      !core::iequals(prefix, "LTIME")) {
    return std::nullopt;
  }
  text.remove_prefix(hash + 1);
  Integer value;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    value.negative = text.front() == '-';
    text.remove_prefix(1);
  }
  struct Unit {
    std::string_view name;
    std::uint64_t ns;
  };
  // Longer names first: "ms" is no "m".
  constexpr Unit kUnits[] = {
      {"ms", 1'000'000},        {"us", 1'000},         {"ns", 1},           {"d", 86'400'000'000'000},
      {"h", 3'600'000'000'000}, {"m", 60'000'000'000}, {"s", 1'000'000'000}};
  std::uint64_t previous = std::numeric_limits<std::uint64_t>::max();
  bool any = false;
  while (!text.empty()) {
    std::uint64_t whole = 0;
    std::uint64_t fraction = 0;
    std::uint64_t scale = 1;
    bool digits = false;
    bool in_fraction = false;
    std::size_t at = 0;
    for (; at < text.size(); ++at) {
      const char c = text[at];
      if (c == '_') continue;
      if (c == '.' && !in_fraction) {
        in_fraction = true;
      } else if (c >= '0' && c <= '9') {
        const auto digit = static_cast<std::uint64_t>(c - '0');
        digits = true;
        if (!in_fraction) {
          if (whole > 1'000'000'000'000'000'000ull) value.too_large = true;
          whole = whole * 10 + digit;
        } else if (scale < 1'000'000'000'000'000ull) {
          fraction = fraction * 10 + digit;
          scale *= 10;
        }
      } else {
        break;
      }
    }
    text.remove_prefix(at);
    const Unit* unit = nullptr;
    for (const Unit& u : kUnits) {
      if (core::iequals(text.substr(0, u.name.size()), u.name)) {
        unit = &u;
        break;
      }
    }
    if (!digits || unit == nullptr || unit->ns >= previous) return std::nullopt;
    text.remove_prefix(unit->name.size());
    while (!text.empty() && text.front() == '_') text.remove_prefix(1);
    if (in_fraction && !text.empty()) return std::nullopt;
    previous = unit->ns;
    any = true;
    __extension__ using Wide = unsigned __int128;
    const Wide sum = Wide{value.magnitude} + Wide{whole} * unit->ns + Wide{fraction} * unit->ns / scale;
    if (sum > std::numeric_limits<std::uint64_t>::max()) value.too_large = true;
    value.magnitude = static_cast<std::uint64_t>(sum);
  }
  if (!any) return std::nullopt;
  return value;
}

/// "D#2024-02-29", with or without what precedes '#'. In ns.
std::optional<Integer> parse_date(std::string_view text, core::TypeId type) {
  stdlib::Event event = stdlib::Event::kNone;
  const std::int64_t ns = stdlib::parse_date(text, type, event);
  if (event != stdlib::Event::kNone) return std::nullopt;
  const auto bits = static_cast<std::uint64_t>(ns);
  return Integer{ns < 0 ? 0 - bits : bits, ns < 0, false};
}

template <class T>
std::optional<Problem> put_integer(const ImageType& type, std::string_view text, const Integer& value, std::byte* to) {
  constexpr auto kMax = static_cast<std::uint64_t>(std::numeric_limits<T>::max());
  const std::uint64_t most = value.negative ? (std::is_signed_v<T> ? kMax + 1 : 0) : kMax;
  if (value.too_large || value.magnitude > most) return out_of_range(type, text);
  const std::uint64_t bits = value.negative ? 0 - value.magnitude : value.magnitude;
  const auto result = static_cast<T>(bits);
  // Limits are 64-bit signed: a ULINT above them is above any declared upper limit.
  const bool above =
      !value.negative && value.magnitude > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  if (type.limited &&
      (above || static_cast<std::int64_t>(result) < type.lower || static_cast<std::int64_t>(result) > type.upper)) {
    return out_of_range(type, text);
  }
  store(to, result);
  return std::nullopt;
}

template <class T>
std::optional<Problem> put_real(const ImageType& type, std::string_view text, std::byte* to) {
  std::string digits;
  for (const char c : text) {
    if (c != '_') digits += c;
  }
  const char* const begin = digits.data() + (digits.starts_with('+') ? 1 : 0);
  const char* const end = digits.data() + digits.size();
  T value{};
  const auto result = std::from_chars(begin, end, value);
  if (result.ec == std::errc::result_out_of_range && result.ptr == end) {
    // Too small for the type is zero or a denormal, not an error; only a magnitude that is too large is one.
    double wide = 0;
    const auto again = std::from_chars(begin, end, wide);
    if (again.ec == std::errc{} && std::fabs(wide) < 1.0) {
      store(to, static_cast<T>(wide));
      return std::nullopt;
    }
    return out_of_range(type, text);
  }
  if (result.ec != std::errc{} || result.ptr != end || begin == end) return no_value(type, text);
  store(to, stdlib::canonical(value));
  return std::nullopt;
}

std::optional<unsigned> hex_digits(std::string_view text) {
  unsigned value = 0;
  for (const char c : text) {
    const char f = core::fold(c);
    if (f >= '0' && f <= '9') {
      value = value * 16 + static_cast<unsigned>(f - '0');
    } else if (f >= 'a' && f <= 'f') {
      value = value * 16 + static_cast<unsigned>(f - 'a') + 10;
    } else {
      return std::nullopt;
    }
  }
  return value;
}

/// Characters of a string literal, quoted or bare; nothing when an escape is wrong.
std::optional<std::u16string> parse_characters(std::string_view text, unsigned width) {
  const char quote = width == 1 ? '\'' : '"';
  const bool quoted = text.size() >= 2 && text.front() == quote && text.back() == quote;
  std::u16string characters;
  const auto add = [&characters](unsigned c) { characters += static_cast<char16_t>(c); };
  // A STRING has the characters of Windows-1252, a WSTRING units of UTF-16.
  const auto add_plain = [&](std::size_t& i) {
    const char32_t point = core::decode_utf8(text, i);
    if (point > 0x10ffff) return false;
    if (width == 1) {
      const auto byte = core::to_windows_1252(point);
      if (byte) add(*byte);
      return byte.has_value();
    }
    if (point > 0xffff) {
      add(0xd800u + ((static_cast<unsigned>(point) - 0x10000u) >> 10));
      add(0xdc00u + ((static_cast<unsigned>(point) - 0x10000u) & 0x3ffu));
    } else {
      add(static_cast<unsigned>(point));
    }
    return true;
  };
  if (!quoted) {
    for (std::size_t i = 0; i < text.size();) {
      if (!add_plain(i)) return std::nullopt;
    }
    return characters;
  }
  text = text.substr(1, text.size() - 2);
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == quote) return std::nullopt;
    if (text[i] != '$') {
      if (!add_plain(i)) return std::nullopt;
      --i;
      continue;
    }
    if (++i == text.size()) return std::nullopt;
    switch (core::fold(text[i])) {
      case '$':
      case '\'':
      case '"':
        add(static_cast<unsigned char>(text[i]));
        continue;
      case 'l':
      case 'n':
        add('\n');
        continue;
      case 'p':
        add('\f');
        continue;
      case 'r':
        add('\r');
        continue;
      case 't':
        add('\t');
        continue;
      default:
        break;
    }
    const auto code = hex_digits(text.substr(i, width * 2));
    if (!code || i + width * 2 > text.size()) return std::nullopt;
    add(*code);
    i += width * 2 - 1;
  }
  return characters;
}

std::optional<Problem> put_string(const ImageType& type, std::string_view text, std::span<std::byte> to) {
  const unsigned width = bytecode::rep_of(type) == Rep::kWstr ? 2 : 1;
  const auto characters = parse_characters(text, width);
  if (!characters) return no_value(type, text);
  if (characters->size() > type.capacity) {
    return Problem{Code::P7105,
                   "text of " + std::to_string(characters->size()) + " characters for a string of at most " +
                       std::to_string(type.capacity),
                   {}};
  }
  std::memset(to.data(), 0, to.size());
  store(to.data(), core::StringHeader{type.capacity, static_cast<std::uint16_t>(characters->size())});
  for (std::size_t i = 0; i < characters->size(); ++i) {
    std::byte* const at = to.data() + sizeof(core::StringHeader) + i * width;
    if (width == 1) {
      store(at, static_cast<std::uint8_t>((*characters)[i]));
    } else {
      store(at, static_cast<std::uint16_t>((*characters)[i]));
    }
  }
  return std::nullopt;
}

std::optional<Problem> put_number(const ImageType& type, std::string_view text, std::byte* to) {
  std::optional<Integer> value = parse_integer(text);
  if (!value && core::in_category(type.elementary, core::kAnyDuration)) value = parse_duration(text);
  if (!value && core::in_category(type.elementary, core::kAnyDate)) value = parse_date(text, type.elementary);
  // "Filling", "Step#Filling" and, as CODESYS has it, "Step.Filling".
  const std::size_t prefix = text.find_first_of("#.");
  const bool qualified = prefix != std::string_view::npos && core::iequals(text.substr(0, prefix), type.name);
  const std::string_view name = qualified ? text.substr(prefix + 1) : text;
  for (std::size_t i = 0; !value && i < type.members.size(); ++i) {
    if (!core::iequals(name, type.members[i])) continue;
    const std::int64_t member = type.member_values[i];
    const auto bits = static_cast<std::uint64_t>(member);
    value = Integer{member < 0 ? 0 - bits : bits, member < 0, false};
  }
  if (!value) return no_value(type, text);
  switch (core::rep_of(type.elementary)) {
    case Rep::kI8:
      return put_integer<std::int8_t>(type, text, *value, to);
    case Rep::kU8:
      return put_integer<std::uint8_t>(type, text, *value, to);
    case Rep::kI16:
      return put_integer<std::int16_t>(type, text, *value, to);
    case Rep::kU16:
      return put_integer<std::uint16_t>(type, text, *value, to);
    case Rep::kI32:
      return put_integer<std::int32_t>(type, text, *value, to);
    case Rep::kU32:
      return put_integer<std::uint32_t>(type, text, *value, to);
    case Rep::kI64:
      return put_integer<std::int64_t>(type, text, *value, to);
    case Rep::kU64:
      return put_integer<std::uint64_t>(type, text, *value, to);
    default:
      return no_value(type, text);
  }
}

/// The value as people write it, when it has a name or is a time. False: it is a plain number.
bool append_name(const ImageType& type, const std::byte* bytes, std::string& out) {
  if (type.kind != TypeKind::kScalar) return false;
  const bool duration = core::in_category(type.elementary, core::kAnyDuration);
  const bool date = core::in_category(type.elementary, core::kAnyDate);
  if (type.members.empty() && !duration && !date) return false;
  const auto value = core::integer_at(bytecode::rep_of(type), bytes);
  if (!value) return false;
  for (std::size_t i = 0; i < type.members.size(); ++i) {
    if (type.member_values[i] != *value) continue;
    out += type.members[i];
    return true;
  }
  if (!duration && !date) return false;
  stdlib::ValueText text;
  const std::size_t length =
      duration ? stdlib::format_duration(*value, type.elementary == core::TypeId::kLtime ? "LT#" : "T#", text)
               : stdlib::format_date(*value, type.elementary, text);
  out.append(text, length);
  return true;
}

}  // namespace

void append_value(const ImageType& type, const std::byte* bytes, std::string& out, ValueStyle style) {
  if (style == ValueStyle::kNames && append_name(type, bytes, out)) return;
  const Rep rep = bytecode::rep_of(type);
  if (type.kind == TypeKind::kScalar && core::in_category(type.elementary, core::kAnyChar))
    return append_string(bytes, 1, core::rep_bytes(rep), out);
  switch (rep) {
    case Rep::kBool:
    case Rep::kI8:
    case Rep::kU8:
    case Rep::kI16:
    case Rep::kU16:
    case Rep::kI32:
    case Rep::kU32:
    case Rep::kI64:
      append_number(*core::integer_at(rep, bytes), out);
      return;
    case Rep::kU64:
      append_number(load<std::uint64_t>(bytes), out);
      return;
    case Rep::kF32:
      append_number(stdlib::canonical(load<float>(bytes)), out);
      return;
    case Rep::kF64:
      append_number(stdlib::canonical(load<double>(bytes)), out);
      return;
    case Rep::kStr:
    case Rep::kWstr: {
      const auto length = std::min(load<core::StringHeader>(bytes).length, type.capacity);
      append_string(bytes + sizeof(core::StringHeader), length, rep == Rep::kStr ? 1 : 2, out);
      return;
    }
    case Rep::kRef:
      out += load<std::uint64_t>(bytes) == 0 ? "null" : "ref";
      return;
  }
}

std::string shown_value(const ImageType& type, const std::byte* bytes) {
  if (type.kind == TypeKind::kScalar && type.elementary == core::TypeId::kBool)
    return load<std::uint8_t>(bytes) != 0 ? "TRUE" : "FALSE";
  std::string text;
  append_value(type, bytes, text, ValueStyle::kNames);
  return text;
}

std::optional<Problem> parse_value(const ImageType& type, std::string_view text, std::span<std::byte> to) {
  if (type.kind == TypeKind::kString) return put_string(type, text, to);
  text = core::trimmed(text);
  if (core::in_category(type.elementary, core::kAnyChar)) {
    const unsigned width = core::rep_of(type.elementary) == Rep::kU8 ? 1 : 2;
    const auto characters = parse_characters(text, width);
    if (!characters || characters->size() != 1) return no_value(type, text);
    if (width == 1) {
      store(to.data(), static_cast<std::uint8_t>(characters->front()));
    } else {
      store(to.data(), static_cast<std::uint16_t>(characters->front()));
    }
    return std::nullopt;
  }
  switch (core::rep_of(type.elementary)) {
    case Rep::kBool: {
      const bool yes = text == "1" || core::iequals(text, "TRUE");
      if (!yes && text != "0" && !core::iequals(text, "FALSE")) return no_value(type, text);
      store(to.data(), static_cast<std::uint8_t>(yes ? 1 : 0));
      return std::nullopt;
    }
    case Rep::kF32:
      return put_real<float>(type, text, to.data());
    case Rep::kF64:
      return put_real<double>(type, text, to.data());
    default:
      return put_number(type, text, to.data());
  }
}

}  // namespace plc::runtime
