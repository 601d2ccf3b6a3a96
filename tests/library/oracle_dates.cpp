// Dates of the oracle: taken apart by gmtime_r, put together by timegm.
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "tests/library/oracle.h"

namespace plc::test {
namespace {

constexpr Wide kSecondNs = 1'000'000'000;
constexpr Wide kDayNs = 86'400 * kSecondNs;

struct Parts {
  std::tm calendar{};
  Wide fraction_ns = 0;  ///< of the second
};
Parts parts_of(const Value& in) {
  Parts out;
  out.fraction_ns = (wide_of(in) % kSecondNs + kSecondNs) % kSecondNs;
  const auto seconds = static_cast<std::time_t>((wide_of(in) - out.fraction_ns) / kSecondNs);
  ::gmtime_r(&seconds, &out.calendar);
  return out;
}

/// A part that is out of its range counts as the nearest in it, and says so.
int held(const Value& part, int least, int greatest, bool& outside) {
  const Wide number = std::clamp<Wide>(wide_of(part), least, greatest);
  outside = outside || number != wide_of(part);
  return static_cast<int>(number);
}
Wide midnight_of(int year, int month, int day) {
  std::tm calendar{};
  calendar.tm_year = year - 1900;
  calendar.tm_mon = month - 1;
  calendar.tm_mday = day;
  return Wide{::timegm(&calendar)} * kSecondNs;
}

}  // namespace

Expected date_of_parts(TypeId type, std::span<const Value> parts) {
  using enum TypeId;
  const bool has_date = type != kTod && type != kLtod;
  const bool has_time = type != kDate && type != kLdate;
  bool outside = false;
  Wide ns = 0;
  if (has_date) {
    // No year beyond these has an instant in 64 bits.
    const int year = held(parts[0], -9999, 9999, outside);
    const int month = held(parts[1], 1, 12, outside);
    const Wide length = (midnight_of(year, month + 1, 1) - midnight_of(year, month, 1)) / kDayNs;
    ns = midnight_of(year, month, held(parts[2], 1, static_cast<int>(length), outside));
    parts = parts.subspan(3);
  }
  if (has_time) {
    const Wide minutes = Wide{held(parts[0], 0, 23, outside)} * 60 + held(parts[1], 0, 59, outside);
    ns += (minutes * 60 + held(parts[2], 0, 59, outside)) * kSecondNs;
    ns += Wide{held(parts[3], 0, 999, outside)} * 1'000'000;
  }
  Expected out = saturated(type, ns);
  if (!has_time) {
    const Wide last_day = greatest_of(type) / kDayNs * kDayNs;
    out.value = wrapped(type, std::clamp(ns, -last_day, last_day));
    outside = outside || ns < -last_day || ns > last_day;
  }
  if (outside) out.event = Event::kOutOfRange;
  return out;
}

Expected part_of_date(TypeId type, std::string_view part, const Value& in) {
  const Parts parts = parts_of(in);
  const auto number = [&]() -> Wide {
    if (part == "YEAR") return parts.calendar.tm_year + 1900;
    if (part == "MONTH") return parts.calendar.tm_mon + 1;
    if (part == "DAY") return parts.calendar.tm_mday;
    if (part == "HOUR") return parts.calendar.tm_hour;
    if (part == "MINUTE") return parts.calendar.tm_min;
    if (part == "SECOND") return parts.calendar.tm_sec;
    return parts.fraction_ns / 1'000'000;
  };
  return saturated(type, number());
}

Expected day_of_week(TypeId type, const Value& in) {
  return {Expected::As::kExactly, wrapped(type, parts_of(in).calendar.tm_wday)};
}

std::string date_text(const Value& in) {
  using enum TypeId;
  const Parts parts = parts_of(in);
  char day[32], time[32];
  static_cast<void>(std::strftime(day, sizeof day, "%Y-%m-%d", &parts.calendar));
  static_cast<void>(std::strftime(time, sizeof time, "%H:%M:%S", &parts.calendar));
  std::string tail = fmt::format(".{:09}", static_cast<std::int64_t>(parts.fraction_ns));
  tail.erase(tail.find_last_not_of('0') + 1);
  if (tail == ".") tail.clear();
  switch (in.type) {
    case kDate:
      return std::string("D#") + day;
    case kLdate:
      return std::string("LD#") + day;
    case kTod:
      return std::string("TOD#") + time + tail;
    case kLtod:
      return std::string("LTOD#") + time + tail;
    default:
      return std::string(in.type == kDt ? "DT#" : "LDT#") + day + "-" + time + tail;
  }
}

}  // namespace plc::test
