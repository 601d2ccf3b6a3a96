#include "tests/library/values.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace plc::test {
namespace {

constexpr std::uint64_t mask_of(TypeId type) {
  const std::uint32_t bytes = core::rep_bytes(core::rep_of(type));
  return bytes >= 8 ? ~std::uint64_t{0} : (std::uint64_t{1} << (8 * bytes)) - 1;
}

// ---- samples ----------------------------------------------------------------------------------------------------

/// Every edge of every narrower or equally wide type, counts and positions of strings, shifts by a width, parts of
/// dates.
std::vector<Sample> integers(TypeId type) {
  std::vector<Sample> out;
  const bool is_signed = core::in_category(type, core::kAnySigned);
  const unsigned width = width_of(type);
  const auto add = [&](std::uint64_t magnitude, bool negative) {
    const std::uint64_t top =
        is_signed ? (std::uint64_t{1} << (width - 1)) - (negative ? 0 : 1) : ~std::uint64_t{0} >> (64 - width);
    if (magnitude > top || (negative && (!is_signed || magnitude == 0))) return;
    const Value value{type, (negative ? 0 - magnitude : magnitude) & mask_of(type), {}};
    for (const Sample& known : out) {
      if (known.value == value) return;
    }
    out.push_back({value, fmt::format("{}#{}{}", core::name_of(type), negative ? "-" : "", magnitude)});
  };
  for (const std::uint64_t small :
       {0u, 1u, 2u, 3u, 8u, 10u, 12u, 16u, 23u, 29u, 31u, 59u, 64u, 80u, 81u, 99u, 100u, 999u, 1970u, 2024u}) {
    add(small, false);
  }
  add(1, true);
  for (const unsigned bits : {7u, 8u, 15u, 16u, 31u, 32u, 53u, 63u}) {
    const std::uint64_t power = std::uint64_t{1} << bits;
    for (const std::uint64_t magnitude : {power - 1, power, power + 1}) {
      add(magnitude, false);
      add(magnitude, true);
    }
  }
  add(~std::uint64_t{0}, false);
  return out;
}

std::vector<Sample> bit_strings(TypeId type) {
  if (type == TypeId::kBool) return {{{type, 0, {}}, "FALSE"}, {{type, 1, {}}, "TRUE"}};
  std::vector<Sample> out;
  // 16#1234... shows swapped bytes, 16#9999... are digits, 16#A... are none.
  for (const std::uint64_t bits :
       {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{1} << (width_of(type) - 1), ~std::uint64_t{0},
        ~std::uint64_t{1}, std::uint64_t{0x5555'5555'5555'5555}, std::uint64_t{0x0123'4567'89ab'cdef},
        std::uint64_t{0x1234'5678'9876'5432}, std::uint64_t{0x9999'9999'9999'9999},
        std::uint64_t{0x7fff'ffff'ffff'ffff}, std::uint64_t{0x10a}, std::uint64_t{0xff00'ff00'ff00'ff00}}) {
    const Value value{type, bits & mask_of(type), {}};
    bool known = false;
    for (const Sample& sample : out) known = known || sample.value == value;
    if (!known) out.push_back({value, fmt::format("{}#16#{:X}", core::name_of(type), value.bits)});
  }
  return out;
}

/// A literal that reads back as exactly this number: as many digits as the type can tell apart.
std::string real_literal(TypeId type, double value) {
  const std::string digits = fmt::format("{:.{}e}", value, type == TypeId::kReal ? 8 : 16);
  return fmt::format("{}#{}", core::name_of(type), digits);
}
template <class Real>
std::vector<Sample> reals(TypeId type) {
  using Limits = std::numeric_limits<Real>;
  std::vector<Real> numbers = {Real{0},
                               Real{1},
                               Real{2},
                               Real(0.5),
                               Real(1.5),
                               Real(2.5),
                               Real(0.1),
                               Real(0.7),
                               Real(10),
                               Real(1000),
                               Real(3.14159265358979323846),
                               Real(1.57079632679489661923),
                               Real(1e-3),
                               Real(1e10),
                               Real(1e22),
                               Limits::denorm_min(),
                               Limits::min(),
                               std::nextafter(Limits::min(), Real{0}),
                               Limits::max(),
                               Limits::epsilon(),
                               std::nextafter(Real{1}, Real{2}),
                               std::nextafter(Real{1}, Real{0}),
                               Real(88.7),
                               Real(709.7)};
  // Where conversions to integers of each width begin to saturate, and their halves begin to round.
  for (const int bits : {7, 8, 15, 16, 31, 32, 63, 64}) {
    const Real power = std::ldexp(Real{1}, bits);
    for (const Real number : {power, power - Real(0.5), power - Real(1), power + Real(0.5), power + Real(1),
                              std::nextafter(power, Real{0}), power - Real(1.5)}) {
      numbers.push_back(number);
    }
  }
  std::vector<Sample> out;
  const auto add = [&](Real number, const std::string& st) {
    const Value value = real_value(type, static_cast<double>(number));
    for (const Sample& known : out) {
      if (known.value == value) return;
    }
    out.push_back({value, st.empty() ? real_literal(type, static_cast<double>(number)) : st});
  };
  for (const Real number : numbers) {
    add(number, "");
    add(-number, "");
  }
  // No literal is infinite or not a number: products that overflow, and a root.
  const std::string_view name = core::name_of(type);
  const std::string_view large = type == TypeId::kReal ? "3.0E+38" : "1.0E+308";
  add(Limits::infinity(), fmt::format("({0}#{1} * {0}#10.0)", name, large));
  add(-Limits::infinity(), fmt::format("({0}#{1} * {0}#-10.0)", name, large));
  add(Limits::quiet_NaN(), fmt::format("SQRT({}#-1.0)", name));
  return out;
}

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr std::int64_t kDayNs = 86'400 * kSecondNs;
constexpr std::int64_t kLeastNs = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kMostNs = std::numeric_limits<std::int64_t>::max();

Value count(TypeId type, std::int64_t ns) { return {type, static_cast<std::uint64_t>(ns), {}}; }

std::vector<Sample> durations(TypeId type) {
  std::vector<Sample> out;
  const std::string_view name = core::name_of(type);
  for (const std::int64_t ns :
       {std::int64_t{0}, std::int64_t{1}, std::int64_t{-1}, std::int64_t{999'999}, std::int64_t{1'000'000},
        std::int64_t{-1'500'000}, std::int64_t{1'234'567'890'123'456}, kSecondNs, 90 * kSecondNs, -kSecondNs, kDayNs,
        -kDayNs, 2 * kDayNs + 3'600 * kSecondNs + 1, std::int64_t{9'007'199'254'740'993}, kMostNs, -kMostNs}) {
    out.push_back({count(type, ns), fmt::format("{}#{}ns", name, ns)});
  }
  // Minus 2^63 is one more than a literal can say.
  out.push_back({count(type, kLeastNs), fmt::format("({0}#-{1}ns - {0}#1ns)", name, kMostNs)});
  return out;
}

std::vector<Sample> dates_and_times(TypeId type) {
  using enum TypeId;
  const std::string_view name = core::name_of(type);
  std::vector<Sample> out;
  const auto add = [&](std::int64_t ns, const std::string& literal) {
    out.push_back({count(type, ns), literal.empty() ? "" : fmt::format("{}#{}", name, literal)});
  };
  if (type == kTod || type == kLtod) {
    add(0, "00:00:00");
    add(1, "00:00:00.000000001");
    add(kSecondNs / 2, "00:00:00.5");
    add(45'296 * kSecondNs + 789'000'000, "12:34:56.789");
    add(kDayNs / 2, "12:00:00");
    add(kDayNs - kSecondNs, "23:59:59");
    add(kDayNs - 1, "23:59:59.999999999");
    return out;
  }
  // Days since 1970 of the ends of literals, leap days and the ends of years.
  struct Day {
    std::int64_t days;
    const char* literal;
  };
  constexpr Day kDays[] = {{0, "1970-01-01"},       {-1, "1969-12-31"},       {11'016, "2000-02-29"},
                           {19'782, "2024-02-29"},  {19'783, "2024-03-01"},   {-25'509, "1900-02-28"},
                           {-25'508, "1900-03-01"}, {-106'650, "1678-01-01"}, {106'650, "2261-12-31"},
                           {47'540, "2100-02-28"},  {10'956, "1999-12-31"},   {106'751, ""},
                           {-106'751, ""}};
  const bool has_time = type == kDt || type == kLdt;
  for (const Day& day : kDays) {
    const std::string literal = day.literal;
    add(day.days * kDayNs, literal.empty() || !has_time ? literal : literal + "-00:00:00");
    if (has_time && !literal.empty()) {
      add((day.days + 1) * kDayNs - 1, literal + "-23:59:59.999999999");
      add(day.days * kDayNs + 45'296 * kSecondNs, literal + "-12:34:56");
    }
  }
  if (has_time) {
    add(kMostNs, "");
    add(kLeastNs, "");
  }
  return out;
}

// ---- characters -------------------------------------------------------------------------------------------------

bool is_wide(TypeId type) { return type == TypeId::kWstring || type == TypeId::kWchar; }

std::string quoted(TypeId type, const std::u16string& text) {
  const bool wide = is_wide(type);
  std::string out(1, wide ? '"' : '\'');
  for (const char16_t unit : text) {
    const bool plain = unit >= ' ' && unit < 127 && unit != '$' && unit != '\'' && unit != '"';
    if (plain) {
      out += static_cast<char>(unit);
    } else {
      out += fmt::format("${:0{}X}", static_cast<unsigned>(unit), wide ? 4 : 2);
    }
  }
  return out + (wide ? '"' : '\'');
}

std::vector<Sample> characters(TypeId type) {
  std::vector<Sample> out;
  for (const char16_t unit : {u'\0', u'\x1', u'A', u'a', u'z', u'0', u' ', u'$', u'\'', u'"', u'\x7f', u'\x80', u'\xff',
                              u'\x100', u'\x3a9', u'\x8000', u'\xffff'}) {
    if (unit > 0xff && !is_wide(type)) continue;
    out.push_back({{type, unit, {}}, std::string(core::name_of(type)) + '#' + quoted(type, {unit})});
  }
  return out;
}

/// Texts that oracle_texts.cpp has in its table, and others.
constexpr std::u16string_view kTexts[] = {
    u"", u"a", u"ab", u"b", u"ABC", u"BC", u"ABCBC", u" ", u"a b",
#define PLC_READING(text, ...) text,
#include "tests/library/readings.def"
};

std::vector<Sample> strings(TypeId type) {
  std::vector<std::u16string> texts(std::begin(kTexts), std::end(kTexts));
  std::u16string full;
  for (std::size_t i = 0; i < core::kDefaultStringCapacity; ++i) full += static_cast<char16_t>(u'a' + i % 26);
  texts.push_back(full);
  texts.push_back(full.substr(1));
  texts.push_back(full.substr(0, 40));
  texts.push_back(std::u16string{u'\0', u'x', u'\xff', u'$', u'\''});
  texts.push_back(std::u16string(core::kDefaultStringCapacity, u'9'));
  if (is_wide(type)) {
    texts.push_back(std::u16string{u'a', u'\x3a9'});
    texts.push_back(std::u16string{u'\xd83d', u'\xde00'});
    texts.push_back(std::u16string{u'1', u'\xff12'});
  }
  std::vector<Sample> out;
  for (const std::u16string& text : texts) {
    bool known = false;
    for (const Sample& sample : out) known = known || sample.value.text == text;
    if (!known) out.push_back({{type, 0, text}, quoted(type, text)});
  }
  return out;
}

std::vector<Sample> make_samples(TypeId type) {
  if (is_string(type)) return strings(type);
  if (core::in_category(type, core::kAnyInt)) return integers(type);
  if (core::in_category(type, core::kAnyBit)) return bit_strings(type);
  if (type == TypeId::kReal) return reals<float>(type);
  if (type == TypeId::kLreal) return reals<double>(type);
  if (core::in_category(type, core::kAnyDuration)) return durations(type);
  if (core::in_category(type, core::kAnyDate)) return dates_and_times(type);
  return characters(type);
}

}  // namespace

bool is_string(TypeId type) { return core::in_category(type, core::kAnyString); }

unsigned width_of(TypeId type) { return type == TypeId::kBool ? 1 : 8 * core::rep_bytes(core::rep_of(type)); }

Value real_value(TypeId type, double value) {
  if (std::isnan(value)) return {type, type == TypeId::kReal ? 0x7fc0'0000u : 0x7ff8'0000'0000'0000u, {}};
  if (type == TypeId::kReal) return {type, std::bit_cast<std::uint32_t>(static_cast<float>(value)), {}};
  return {type, std::bit_cast<std::uint64_t>(value), {}};
}
double real_of(const Value& value) {
  return value.type == TypeId::kReal ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(value.bits)))
                                     : std::bit_cast<double>(value.bits);
}

std::string shown(const Value& value) {
  const std::string_view name = core::name_of(value.type);
  if (is_string(value.type)) return quoted(value.type, value.text);
  if (core::in_category(value.type, core::kAnyReal)) {
    return fmt::format("{}#{} (16#{:x})", name, real_of(value), value.bits);
  }
  const unsigned unused = 64 - 8 * core::rep_bytes(core::rep_of(value.type));
  if (core::in_category(value.type, core::kAnySigned | core::kAnyDuration | core::kAnyDate)) {
    return fmt::format("{}#{}", name, static_cast<std::int64_t>(value.bits << unused) >> unused);
  }
  return fmt::format("{}#16#{:x}", name, value.bits);
}
std::string shown(std::span<const Value> values) {
  std::string out = "(";
  for (const Value& value : values) out += (out.size() == 1 ? "" : ", ") + shown(value);
  return out + ")";
}

std::span<const Sample> samples_of(TypeId type) {
  static const auto kSamples = [] {
    std::array<std::vector<Sample>, core::kTypeCount> all;
    for (std::size_t i = 0; i < core::kTypeCount; ++i) all[i] = make_samples(static_cast<TypeId>(i));
    return all;
  }();
  return kSamples[static_cast<std::size_t>(type)];
}

Sequence::Sequence(std::string_view seed) {
  for (const char c : seed) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
}
std::uint64_t Sequence::next() {
  state_ += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

std::vector<Arguments> argument_lists(const Overload& overload, std::size_t count, std::size_t limit) {
  std::vector<std::span<const Sample>> choices;
  std::size_t product = 1, most = 1;
  for (std::size_t i = 0; i < count; ++i) {
    choices.push_back(samples_of(overload.param_type(i)));
    most = std::max(most, choices.back().size());
    product = std::min(product * choices.back().size(), limit + 1);
  }
  std::vector<Arguments> lists;
  if (product <= limit) {
    for (std::size_t n = 0; n < product; ++n) {
      Arguments list;
      std::size_t rest = n;
      for (const auto& choice : choices) {
        list.push_back(&choice[rest % choice.size()]);
        rest /= choice.size();
      }
      lists.push_back(std::move(list));
    }
    return lists;
  }
  Sequence sequence(stdlib::key_of(overload));
  for (std::size_t n = 0; n < std::max(limit, count * most); ++n) {
    Arguments list;
    for (const auto& choice : choices) list.push_back(&choice[sequence.below(choice.size())]);
    // First each sample at each place once.
    if (n < count * most) list[n / most] = &choices[n / most][n % most % choices[n / most].size()];
    lists.push_back(std::move(list));
  }
  return lists;
}

std::vector<Value> values_of(const Arguments& arguments) {
  std::vector<Value> out;
  for (const Sample* sample : arguments) out.push_back(sample->value);
  return out;
}

Cell::Cell(TypeId type, std::uint16_t capacity)
    : type_(type), bytes_(sizeof(core::StringHeader) + 2 * std::size_t{capacity} + 8) {
  const core::StringHeader header{capacity, 0};
  if (is_string(type)) std::memcpy(bytes_.data(), &header, sizeof header);
}

void Cell::write(std::byte* place, const Value& value) {
  if (!is_string(value.type)) {
    std::memcpy(place, &value.bits, core::rep_bytes(core::rep_of(value.type)));
    return;
  }
  core::StringHeader header;
  std::memcpy(&header, place, sizeof header);
  header.length = static_cast<std::uint16_t>(value.text.size());
  std::memcpy(place, &header, sizeof header);
  const std::size_t unit = is_wide(value.type) ? 2 : 1;
  for (std::size_t i = 0; i < value.text.size(); ++i) {
    std::memcpy(place + sizeof header + i * unit, &value.text[i], unit);
  }
}

Value Cell::read(const std::byte* place, TypeId type) {
  Value value{type, 0, {}};
  if (!is_string(type)) {
    std::memcpy(&value.bits, place, core::rep_bytes(core::rep_of(type)));
    return value;
  }
  core::StringHeader header;
  std::memcpy(&header, place, sizeof header);
  const std::size_t unit = is_wide(type) ? 2 : 1;
  for (std::size_t i = 0; i < header.length; ++i) {
    char16_t one = 0;
    std::memcpy(&one, place + sizeof header + i * unit, unit);
    value.text += one;
  }
  return value;
}

Outcome call_kernel(const Overload& overload, std::span<const Value> arguments, std::uint16_t room) {
  std::vector<Cell> cells;
  std::vector<const void*> places;
  cells.reserve(arguments.size());
  for (const Value& argument : arguments) {
    cells.emplace_back(argument.type);
    cells.back().set(argument);
    places.push_back(cells.back().place());
  }
  Cell result(overload.result_type(), room);
  const Event event = overload.kernel(result.place(), places.data(), static_cast<std::uint32_t>(places.size()));
  return {result.get(), event};
}

}  // namespace plc::test
