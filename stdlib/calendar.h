// The calendar of DATE, TOD, DT and their long forms: days and civil dates, proleptic Gregorian, without time zones and
// leap seconds.
//
// In: nanoseconds since 1970-01-01 (DATE, DT) or since midnight (TOD), or years, months and days. Out: the other form.
// All is constexpr, noexcept and free of division by anything but constants, so it is RT.
// Does not belong here: text (text_values.h), rows (functions/dates.h).
#pragma once

#include <cstdint>

#include "stdlib/arithmetic.h"

namespace plc::stdlib {

inline constexpr std::int64_t kDayNs = 86'400'000'000'000;
/// Whole days that 64 bits of nanoseconds reach on both sides of 1970-01-01: 1677-09-22 to 2262-04-11.
inline constexpr std::int64_t kMostDays = 106'751;

/// Nanoseconds since the last midnight, 0 .. kDayNs - 1, before 1970 too.
constexpr std::int64_t within_day(std::int64_t ns) noexcept {
  const std::int64_t rest = ns % kDayNs;
  return rest < 0 ? rest + kDayNs : rest;
}
/// Days since 1970-01-01, rounded down.
constexpr std::int64_t day_of(std::int64_t ns) noexcept { return ns / kDayNs - (ns % kDayNs < 0 ? 1 : 0); }

struct Civil {
  std::int64_t year;
  unsigned month;  ///< 1 .. 12
  unsigned day;    ///< 1 .. 31
};

/// The date of a day count since 1970-01-01, after the usual era arithmetic (periods of 400 years from a 1st of March).
constexpr Civil civil_of(std::int64_t days) noexcept {
  const std::int64_t z = days + 719468;  // from 0000-03-01
  const std::int64_t era = (z >= 0 ? z : z - 146096) / 146097;
  const auto doe = static_cast<unsigned>(z - era * 146097);
  const unsigned yoe = (doe - doe / 1460 + doe / 36524 - doe / 146096) / 365;
  const unsigned doy = doe - (365 * yoe + yoe / 4 - yoe / 100);
  const unsigned mp = (5 * doy + 2) / 153;
  const unsigned month = mp < 10 ? mp + 3 : mp - 9;
  return {static_cast<std::int64_t>(yoe) + era * 400 + (month <= 2 ? 1 : 0), month, doy - (153 * mp + 2) / 5 + 1};
}
/// Its inverse, for valid dates.
constexpr std::int64_t days_of(Civil c) noexcept {
  const std::int64_t y = c.month <= 2 ? c.year - 1 : c.year;
  const std::int64_t era = (y >= 0 ? y : y - 399) / 400;
  const auto yoe = static_cast<unsigned>(y - era * 400);
  const unsigned doy = (153 * (c.month > 2 ? c.month - 3 : c.month + 9) + 2) / 5 + c.day - 1;
  const unsigned doe = yoe * 365 + yoe / 4 - yoe / 100 + doy;
  return era * 146097 + static_cast<std::int64_t>(doe) - 719468;
}

/// Days of a month, 1 .. 12.
constexpr unsigned days_in_month(std::int64_t year, unsigned month) noexcept {
  constexpr unsigned kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  const bool leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
  return kDays[month - 1] + (leap && month == 2 ? 1 : 0);
}

}  // namespace plc::stdlib
