// Strings of the oracle: on std::u16string; what numbers and dates look like as text, and a table of what texts mean.
#include <fmt/format.h>

#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>

#include "tests/library/oracle.h"

namespace plc::test {
namespace {

using Text = std::u16string;

Expected exactly(Value value, Event event = Event::kNone) {
  return {Expected::As::kExactly, std::move(value), {}, event};
}
Text widened(const std::string& text) { return {text.begin(), text.end()}; }
std::string narrowed(const Text& text) {
  std::string out;
  for (const char16_t unit : text) out += unit < 0x80 ? static_cast<char>(unit) : '?';
  return out;
}

// ---- functions of strings ---------------------------------------------------------------------------------------

/// A length or position as std::u16string takes it: negative ones are 0, huge ones beyond every string.
std::size_t size_of(const Value& number) {
  constexpr Wide kBeyond = 1'000'000;
  const Wide n = wide_of(number);
  return static_cast<std::size_t>(n < 0 ? 0 : n > kBeyond ? kBeyond : n);
}
bool negative(const Value& number) { return wide_of(number) < 0; }
/// Position `p` is that of a character of `text`.
bool inside(const Value& p, const Text& text) { return wide_of(p) >= 1 && size_of(p) <= text.size(); }

// ---- values as text ---------------------------------------------------------------------------------------------

std::string decimal(Wide number) {
  if (number < 0) return "-" + decimal(-number);
  std::string out;
  do {
    out.insert(out.begin(), static_cast<char>('0' + static_cast<int>(number % 10)));
    number /= 10;
  } while (number != 0);
  return out;
}

std::string duration(Wide ns) {
  if (ns == 0) return "0s";
  std::string out = ns < 0 ? "-" : "";
  if (ns < 0) ns = -ns;
  constexpr std::pair<std::int64_t, const char*> kUnits[] = {{86'400'000'000'000, "d"},
                                                             {3'600'000'000'000, "h"},
                                                             {60'000'000'000, "m"},
                                                             {1'000'000'000, "s"},
                                                             {1'000'000, "ms"},
                                                             {1'000, "us"},
                                                             {1, "ns"}};
  for (const auto& [unit, name] : kUnits) {
    if (ns / unit != 0) out += decimal(ns / unit) + name;
    ns %= unit;
  }
  return out;
}

// ---- texts as values --------------------------------------------------------------------------------------------

/// Nanoseconds that a text says; nothing when default made.
struct Count {
  constexpr Count() = default;
  constexpr Count(std::int64_t ns_, bool beyond_ = false) : given(true), beyond(beyond_), ns(ns_) {}  // NOLINT
  bool given = false;
  bool beyond = false;  ///< it says more than 64 bits hold, and this is the nearest
  std::int64_t ns = 0;
};
struct Reading {
  std::u16string_view text;
  std::optional<Wide> whole{};
  const char* real = nullptr;
  std::optional<bool> truth{};
  Count duration{}, day{}, time{}, stamp{};
};
// NOLINTNEXTLINE(cppcoreguidelines-macro-usage)
#define PLC_READING(characters, ...) {.text = characters __VA_OPT__(, ) __VA_ARGS__},
const Reading kReadings[] = {
#include "tests/library/readings.def"
};

Expected real_reading(TypeId type, const char* text) {
  errno = 0;
  const double number =
      type == TypeId::kReal ? static_cast<double>(std::strtof(text, nullptr)) : std::strtod(text, nullptr);
  const bool outside = errno == ERANGE && (number == 0 || std::isinf(number));
  if (!outside) return exactly(real_value(type, number));
  const double greatest = type == TypeId::kReal ? static_cast<double>(std::numeric_limits<float>::max())
                                                : std::numeric_limits<double>::max();
  // What is too small for the type is 0 without a sign.
  return exactly(real_value(type, number == 0 ? 0.0 : std::copysign(greatest, number)), Event::kOutOfRange);
}

}  // namespace

std::optional<Expected> text_function(const Overload& overload, std::span<const Value> a) {
  const std::string_view name = overload.spec->name;
  const TypeId type = overload.result_type();
  const Text& in = a[0].text;
  const auto text = [&](Text out, bool out_of_range = false) {
    return exactly({type, 0, std::move(out)}, out_of_range ? Event::kOutOfRange : Event::kNone);
  };
  if (name == "LEN") return exactly(wrapped(type, static_cast<Wide>(in.size())));
  if (name == "LEFT") return text(in.substr(0, size_of(a[1])), negative(a[1]));
  if (name == "RIGHT") return text(in.substr(in.size() - std::min(in.size(), size_of(a[1]))), negative(a[1]));
  if (name == "MID") {
    if (!inside(a[2], in)) return text({}, true);
    return text(in.substr(size_of(a[2]) - 1, size_of(a[1])), negative(a[1]));
  }
  if (name == "CONCAT") {
    Text out;
    for (const Value& piece : a) out += piece.text;
    return text(out);
  }
  if (name == "INSERT") {
    if (negative(a[2]) || size_of(a[2]) > in.size()) return text(in, true);
    return text(Text(in).insert(size_of(a[2]), a[1].text));
  }
  if (name == "DELETE") {
    if (!inside(a[2], in)) return text(in, true);
    return text(Text(in).erase(size_of(a[2]) - 1, size_of(a[1])), negative(a[1]));
  }
  if (name == "REPLACE") {
    if (!inside(a[3], in)) return text(in, true);
    return text(Text(in).replace(size_of(a[3]) - 1, size_of(a[2]), a[1].text), negative(a[2]));
  }
  if (name != "FIND") return std::nullopt;
  const std::size_t at = a[1].text.empty() ? Text::npos : in.find(a[1].text);
  return exactly(wrapped(type, at == Text::npos ? 0 : static_cast<Wide>(at) + 1));
}

// Windows-1252 from 16#80 on; a dot where it has no character and the code stays.
static constexpr std::u16string_view kFrom80 = u"€.‚ƒ„…†‡ˆ‰Š‹Œ.Ž..‘’“”•–—˜™š›œ.žŸ";
static_assert(kFrom80.size() == 32);

char16_t character_of_byte(char16_t byte) {
  const bool moved = byte >= 0x80 && byte < 0xa0 && kFrom80[byte - 0x80u] != u'.';
  return moved ? kFrom80[byte - 0x80u] : byte;
}
std::optional<char16_t> byte_of_character(char16_t character) {
  if (character <= 0xff) return character;
  const std::size_t at = kFrom80.find(character);
  if (at == std::u16string_view::npos) return std::nullopt;
  return static_cast<char16_t>(0x80 + at);
}

Expected written(TypeId type, const Value& in) {
  const auto text = [&](const std::string& out) { return exactly({type, 0, widened(out)}); };
  if (core::in_category(in.type, core::kAnyChar)) return exactly({type, 0, Text(1, static_cast<char16_t>(in.bits))});
  if (is_string(in.type)) {
    Expected out = exactly({type, 0, in.text});
    for (char16_t& unit : out.value.text) {
      if (in.type == type) continue;
      if (type == TypeId::kWstring) {
        unit = character_of_byte(unit);
      } else if (const auto byte = byte_of_character(unit)) {
        unit = *byte;
      } else {
        unit = u'?';
        out.event = Event::kInvalid;
      }
    }
    return out;
  }
  if (in.type == TypeId::kBool) return text(in.bits != 0 ? "TRUE" : "FALSE");
  if (core::in_category(in.type, core::kAnyReal)) return {Expected::As::kShortestText, in};
  if (core::in_category(in.type, core::kAnyBit)) return text(fmt::format("16#{:0{}X}", in.bits, width_of(in.type) / 4));
  if (core::in_category(in.type, core::kAnyInt)) return text(decimal(wide_of(in)));
  if (core::in_category(in.type, core::kAnyDate)) return text(date_text(in));
  return text((in.type == TypeId::kTime ? "T#" : "LTIME#") + duration(wide_of(in)));
}

Expected read(TypeId type, const Value& in) {
  using enum TypeId;
  if (core::in_category(type, core::kAnyChar)) {
    const bool none = in.text.empty();
    return exactly(wrapped(type, none ? 0 : in.text[0]), none ? Event::kOutOfRange : Event::kNone);
  }
  const Expected none = exactly(wrapped(type, 0), Event::kInvalid);
  const auto count = [&](const Count& found) {
    if (!found.given) return none;
    return exactly(wrapped(type, found.ns), found.beyond ? Event::kOutOfRange : Event::kNone);
  };
  // A full string of nines is the one sample outside of the table that is a number.
  const bool nines = !in.text.empty() && in.text.find_first_not_of(u'9') == Text::npos;
  const std::string digits = narrowed(in.text);
  const Reading large{.text = in.text, .whole = Wide{1} << 66, .real = digits.c_str()};
  const Reading* reading = nines ? &large : nullptr;
  for (const Reading& row : kReadings) {
    if (reading == nullptr && row.text == in.text) reading = &row;
  }
  if (reading == nullptr) return none;
  switch (type) {
    case kBool:
      return reading->truth ? exactly(wrapped(type, *reading->truth ? 1 : 0)) : none;
    case kReal:
    case kLreal:
      return reading->real != nullptr ? real_reading(type, reading->real) : none;
    case kTime:
    case kLtime:
      return count(reading->duration);
    case kDate:
    case kLdate:
      return count(reading->day);
    case kTod:
    case kLtod:
      return count(reading->time);
    case kDt:
    case kLdt:
      return count(reading->stamp);
    default:
      return reading->whole ? saturated(type, *reading->whole) : none;
  }
}

}  // namespace plc::test
