#include "stdlib/text_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "core/text.h"
#include "stdlib/arithmetic.h"
#include "stdlib/calendar.h"

namespace plc::stdlib {
namespace {

constexpr std::uint64_t kNsPerDay = 86'400'000'000'000;

/// Appends to a ValueText; everything written here fits it.
class Writer {
 public:
  explicit Writer(ValueText& out) : out_(out) {}
  void put(char c) noexcept {
    if (size_ < kMaxValueText) out_[size_++] = c;
  }
  void put(std::string_view text) noexcept {
    for (const char c : text) put(c);
  }
  /// Decimal, with leading zeros up to `width` digits.
  void number(std::uint64_t value, unsigned width = 1) noexcept {
    char digits[20];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    for (auto n = static_cast<unsigned>(end - digits); n < width; ++n) put('0');
    put(std::string_view(digits, static_cast<std::size_t>(end - digits)));
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }

 private:
  ValueText& out_;
  std::size_t size_ = 0;
};

void put_fraction(Writer& w, std::uint64_t ns) noexcept {
  if (ns == 0) return;
  unsigned width = 9;
  while (ns % 10 == 0) {
    ns /= 10;
    --width;
  }
  w.put('.');
  w.number(ns, width);
}
void put_time_of_day(Writer& w, std::uint64_t ns) noexcept {
  const std::uint64_t seconds = ns / 1'000'000'000;
  w.number(seconds / 3600, 2);
  w.put(':');
  w.number(seconds / 60 % 60, 2);
  w.put(':');
  w.number(seconds % 60, 2);
  put_fraction(w, ns % 1'000'000'000);
}
void put_date(Writer& w, std::int64_t days) noexcept {
  const Civil c = civil_of(days);
  if (c.year < 0) w.put('-');
  w.number(magnitude(c.year), 4);
  w.put('-');
  w.number(c.month, 2);
  w.put('-');
  w.number(c.day, 2);
}

template <class T>
std::size_t format_any_real(T value, ValueText& out) noexcept {
  Writer w(out);
  if (value != value) {
    w.put("NaN");
    return w.size();
  }
  if (std::isinf(value)) {
    w.put(value < 0 ? "-Inf" : "Inf");
    return w.size();
  }
  char digits[48];
  const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
  const std::string_view text(digits, static_cast<std::size_t>(end - digits));
  const std::size_t exponent = std::min(text.find('e'), text.size());
  w.put(text.substr(0, exponent));
  if (text.substr(0, exponent).find('.') == std::string_view::npos) w.put(".0");
  if (exponent != text.size()) {
    w.put('E');
    w.put(text.substr(exponent + 1));
  }
  return w.size();
}

/// Cursor over a text being read.
struct Reader {
  std::string_view rest;

  explicit Reader(std::string_view text) : rest(core::trimmed(text)) {}
  bool take(char c) noexcept {
    if (rest.empty() || core::fold(rest.front()) != c) return false;
    rest.remove_prefix(1);
    return true;
  }
  /// Skips "PREFIX#" if it is there and PREFIX is a word.
  void skip_prefix() noexcept {
    const std::size_t hash = rest.find('#');
    if (hash == std::string_view::npos || hash == 0) return;
    for (const char c : rest.substr(0, hash)) {
      const char f = core::fold(c);
      if ((f < 'a' || f > 'z') && f != '_') return;
    }
    rest.remove_prefix(hash + 1);
  }
  [[nodiscard]] bool at_digit() const noexcept { return !rest.empty() && rest.front() >= '0' && rest.front() <= '9'; }
  /// Digits of `base` with single underscores between them; false when there are none. Saturates and says so.
  bool number(unsigned base, std::uint64_t& value, bool& overflow) noexcept {
    constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();
    value = 0;
    bool any = false;
    while (!rest.empty()) {
      if (rest.front() == '_' && any && rest.size() > 1 && rest[1] != '_') {
        rest.remove_prefix(1);
        continue;
      }
      const char c = core::fold(rest.front());
      const unsigned digit = c >= '0' && c <= '9'   ? static_cast<unsigned>(c - '0')
                             : c >= 'a' && c <= 'f' ? static_cast<unsigned>(c - 'a' + 10)
                                                    : 99;
      if (digit >= base) break;
      if (value > (kMax - digit) / base) {
        overflow = true;
        value = kMax;
      } else {
        value = value * base + digit;
      }
      any = true;
      rest.remove_prefix(1);
    }
    return any;
  }
  /// As many digits as there are, as a fraction of one second or unit: "5" is 500,000,000 billionths. Further ones
  /// drop.
  std::uint64_t billionths() noexcept {
    std::uint64_t value = 0, scale = 100'000'000;
    while (at_digit()) {
      value += static_cast<std::uint64_t>(rest.front() - '0') * scale;
      scale /= 10;
      rest.remove_prefix(1);
    }
    return value;
  }
};

struct Integer {
  bool negative = false;
  bool overflow = false;
  std::uint64_t magnitude = 0;
};
/// "-12", "16#FF", "INT#5", "1_000".
bool parse_integer(std::string_view text, Integer& out) noexcept {
  Reader r(text);
  r.skip_prefix();
  out.negative = r.take('-');
  if (!out.negative) r.take('+');
  if (!r.number(10, out.magnitude, out.overflow)) return false;
  if (r.take('#')) {
    const std::uint64_t base = out.magnitude;
    if (base != 2 && base != 8 && base != 16) return false;
    if (!r.number(static_cast<unsigned>(base), out.magnitude, out.overflow)) return false;
  }
  return r.rest.empty();
}

template <class T>
T parse_any_real(std::string_view text, Event& event) noexcept {
  Reader r(text);
  r.skip_prefix();
  if (core::iequals(r.rest, "nan")) return canonical(std::numeric_limits<T>::quiet_NaN());
  const bool negative = r.take('-');
  if (!negative) r.take('+');
  const T sign = negative ? T{-1} : T{1};
  if (core::iequals(r.rest, "inf")) return sign * std::numeric_limits<T>::infinity();
  char digits[128];
  std::size_t n = 0;
  const auto is_digit = [&](std::size_t i) { return i < r.rest.size() && r.rest[i] >= '0' && r.rest[i] <= '9'; };
  for (std::size_t i = 0; i < r.rest.size() && n < sizeof digits; ++i) {
    const bool between = r.rest[i] == '_' && i > 0 && is_digit(i - 1) && is_digit(i + 1);
    if (!between) digits[n++] = r.rest[i];
  }
  T value{};
  const auto [end, error] = std::from_chars(digits, digits + n, value);
  if (n == sizeof digits || n == 0 || digits[0] == '-' || end != digits + n || error == std::errc::invalid_argument ||
      !std::isfinite(value)) {
    event = Event::kInvalid;
    return 0;
  }
  if (error == std::errc::result_out_of_range) {
    event = Event::kOutOfRange;
    // Too small or too large: a negative exponent tells.
    const std::string_view all(digits, n);
    const bool tiny = all.find("e-") != std::string_view::npos || all.find("E-") != std::string_view::npos;
    return tiny ? T{0} : sign * std::numeric_limits<T>::max();
  }
  return sign * value;
}

bool parse_civil(Reader& r, std::int64_t& days) noexcept {
  std::uint64_t year = 0, month = 0, day = 0;
  bool overflow = false;
  if (!r.number(10, year, overflow) || !r.take('-') || !r.number(10, month, overflow) || !r.take('-') ||
      !r.number(10, day, overflow)) {
    return false;
  }
  if (overflow || year > 9999 || month < 1 || month > 12) return false;
  const Civil date{static_cast<std::int64_t>(year), static_cast<unsigned>(month), static_cast<unsigned>(day)};
  if (day < 1 || day > days_in_month(date.year, date.month)) return false;
  days = days_of(date);
  return true;
}
bool parse_day_time(Reader& r, std::int64_t& ns) noexcept {
  std::uint64_t hours = 0, minutes = 0, seconds = 0;
  bool overflow = false;
  if (!r.number(10, hours, overflow) || !r.take(':') || !r.number(10, minutes, overflow)) return false;
  if (r.take(':') && !r.number(10, seconds, overflow)) return false;
  const std::uint64_t fraction = r.take('.') ? r.billionths() : 0;
  if (overflow || hours > 23 || minutes > 59 || seconds > 59) return false;
  ns = static_cast<std::int64_t>(((hours * 60 + minutes) * 60 + seconds) * 1'000'000'000 + fraction);
  return true;
}

}  // namespace

std::size_t format_bool(bool value, ValueText& out) noexcept {
  Writer w(out);
  w.put(value ? "TRUE" : "FALSE");
  return w.size();
}
std::size_t format_signed(std::int64_t value, ValueText& out) noexcept {
  Writer w(out);
  if (value < 0) w.put('-');
  w.number(magnitude(value));
  return w.size();
}
std::size_t format_unsigned(std::uint64_t value, ValueText& out) noexcept {
  Writer w(out);
  w.number(value);
  return w.size();
}
std::size_t format_bits(std::uint64_t value, unsigned digits, ValueText& out) noexcept {
  Writer w(out);
  w.put("16#");
  for (unsigned i = digits; i > 0; --i) w.put("0123456789ABCDEF"[value >> (4 * (i - 1)) & 0xf]);
  return w.size();
}
std::size_t format_real(float value, ValueText& out) noexcept { return format_any_real(value, out); }
std::size_t format_real(double value, ValueText& out) noexcept { return format_any_real(value, out); }

std::size_t format_duration(std::int64_t ns, std::string_view prefix, ValueText& out) noexcept {
  struct Unit {
    std::uint64_t ns;
    std::string_view name;
  };
  constexpr Unit kUnits[] = {{kNsPerDay, "d"},
                             {3'600'000'000'000, "h"},
                             {60'000'000'000, "m"},
                             {1'000'000'000, "s"},
                             {1'000'000, "ms"},
                             {1'000, "us"},
                             {1, "ns"}};
  Writer w(out);
  w.put(prefix);
  if (ns < 0) w.put('-');
  if (ns == 0) w.put("0s");
  std::uint64_t rest = magnitude(ns);
  for (const Unit& unit : kUnits) {
    if (rest < unit.ns) continue;
    w.number(rest / unit.ns);
    w.put(unit.name);
    rest %= unit.ns;
  }
  return w.size();
}

std::size_t format_date(std::int64_t ns, TypeId type, ValueText& out) noexcept {
  const auto in_day = static_cast<std::uint64_t>(within_day(ns));
  const std::int64_t days = day_of(ns);
  Writer w(out);
  w.put(core::info(type).alias);
  w.put('#');
  switch (type) {
    case TypeId::kTod:
    case TypeId::kLtod:
      put_time_of_day(w, in_day);
      break;
    case TypeId::kDate:
    case TypeId::kLdate:
      put_date(w, days);
      break;
    default:
      put_date(w, days);
      w.put('-');
      put_time_of_day(w, in_day);
  }
  return w.size();
}

bool parse_bool(std::string_view text, Event& event) noexcept {
  Reader r(text);
  r.skip_prefix();
  if (core::iequals(r.rest, "true") || r.rest == "1") return true;
  if (!core::iequals(r.rest, "false") && r.rest != "0") event = Event::kInvalid;
  return false;
}

std::int64_t parse_signed(std::string_view text, std::int64_t least, std::int64_t greatest, Event& event) noexcept {
  Integer n;
  if (!parse_integer(text, n)) {
    event = Event::kInvalid;
    return 0;
  }
  const std::uint64_t limit = n.negative ? magnitude(least) : static_cast<std::uint64_t>(greatest);
  if (n.overflow || n.magnitude > limit) {
    event = Event::kOutOfRange;
    return n.negative ? least : greatest;
  }
  const auto value = static_cast<std::int64_t>(n.magnitude);
  return n.negative ? wrap_neg(value) : value;
}

std::uint64_t parse_unsigned(std::string_view text, std::uint64_t greatest, Event& event) noexcept {
  Integer n;
  if (!parse_integer(text, n)) {
    event = Event::kInvalid;
    return 0;
  }
  if (n.negative && n.magnitude != 0) {
    event = Event::kOutOfRange;
    return 0;
  }
  if (n.overflow || n.magnitude > greatest) {
    event = Event::kOutOfRange;
    return greatest;
  }
  return n.magnitude;
}

float parse_real(std::string_view text, Event& event) noexcept { return parse_any_real<float>(text, event); }
double parse_lreal(std::string_view text, Event& event) noexcept { return parse_any_real<double>(text, event); }

std::int64_t parse_duration(std::string_view text, Event& event) noexcept {
  struct Unit {
    std::string_view name;
    std::uint64_t ns;
  };
  // Longer names first: "ms" before "m".
  constexpr Unit kUnits[] = {{"ms", 1'000'000},        {"us", 1'000},         {"ns", 1},           {"d", kNsPerDay},
                             {"h", 3'600'000'000'000}, {"m", 60'000'000'000}, {"s", 1'000'000'000}};
  Reader r(text);
  r.skip_prefix();
  const bool negative = r.take('-');
  if (!negative) r.take('+');
  const std::int64_t end =
      negative ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
  const std::uint64_t limit = magnitude(end);
  std::uint64_t total = 0;
  bool overflow = false, any = false;
  while (!r.rest.empty()) {
    if (any) r.take('_');
    std::uint64_t whole = 0;
    if (!r.number(10, whole, overflow)) break;
    const std::uint64_t fraction = r.take('.') ? r.billionths() : 0;
    const Unit* unit = nullptr;
    for (const Unit& u : kUnits) {
      if (core::iequals(r.rest.substr(0, u.name.size()), u.name)) {
        unit = &u;
        break;
      }
    }
    if (unit == nullptr) break;
    r.rest.remove_prefix(unit->name.size());
    any = true;
    // A fraction of a day is 86400 seconds of billionths: split so that the product fits.
    const std::uint64_t part =
        unit->ns >= 1'000'000'000 ? fraction * (unit->ns / 1'000'000'000) : fraction * unit->ns / 1'000'000'000;
    if (whole > (limit - part) / unit->ns || total > limit - part - whole * unit->ns) {
      overflow = true;
    } else {
      total += whole * unit->ns + part;
    }
    if (r.rest.empty()) {
      if (overflow) {
        event = Event::kOutOfRange;
        return end;
      }
      const auto count = static_cast<std::int64_t>(total);
      return negative ? wrap_neg(count) : count;
    }
  }
  event = Event::kInvalid;
  return 0;
}

std::int64_t parse_date(std::string_view text, TypeId type, Event& event) noexcept {
  Reader r(text);
  r.skip_prefix();
  std::int64_t days = 0, ns = 0;
  const bool has_time = type != TypeId::kDate && type != TypeId::kLdate;
  const bool has_date = type != TypeId::kTod && type != TypeId::kLtod;
  bool good = !has_date || parse_civil(r, days);
  if (good && has_time) good = (!has_date || r.take('-')) && parse_day_time(r, ns);
  if (!good || !r.rest.empty()) {
    event = Event::kInvalid;
    return 0;
  }
  // Nanoseconds in 64 bits reach from 1677-09-21 to 2262-04-11, and to the ends of neither: a date is a whole day.
  __extension__ using Wide = __int128;
  const Wide least = has_time ? std::numeric_limits<std::int64_t>::min() : -kMostDays * kDayNs;
  const Wide most = has_time ? std::numeric_limits<std::int64_t>::max() : kMostDays * kDayNs;
  const Wide total = Wide{days} * kDayNs + ns;
  if (total < least || total > most) event = Event::kOutOfRange;
  return static_cast<std::int64_t>(std::clamp(total, least, most));
}

}  // namespace plc::stdlib
