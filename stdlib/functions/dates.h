// Rows and bundles: dates put together and taken apart (IEC 61131-3:2013, table 36).
//
// A part out of its range (month 13, 30 February, hour 24) counts as the nearest one that is in it; a result beyond the
// range of 64 bits of nanoseconds, 1677-09-21 to 2262-04-11, is the nearest one in it; both with an event.
// Does not belong here: sums and differences of dates (durations.h), conversions between them (conversion.h).
#pragma once

#include <algorithm>
#include <limits>
#include <utility>

#include "stdlib/arithmetic.h"
#include "stdlib/calendar.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kDateClause = "IEC 61131-3:2013, table 36";

/// `value` within least .. greatest, with an event if it was not.
template <class V>
constexpr std::int64_t held(V value, std::int64_t least, std::int64_t greatest, Event& event) noexcept {
  if (std::cmp_greater_equal(value, least) && std::cmp_less_equal(value, greatest)) {
    return static_cast<std::int64_t>(value);
  }
  event = Event::kOutOfRange;
  return std::cmp_less(value, least) ? least : greatest;
}

/// Day count of year, month and day. Years are held where day counts stay small: what they give is out of range anyway.
template <class V>
constexpr std::int64_t days_from(V year, V month, V day, Event& event) noexcept {
  const std::int64_t y = held(year, -9999, 9999, event);
  const auto m = static_cast<unsigned>(held(month, 1, 12, event));
  const auto d = static_cast<unsigned>(held(day, 1, days_in_month(y, m), event));
  return days_of({y, m, d});
}
template <class V>
constexpr std::int64_t time_of_day(V hour, V minute, V second, V millisecond, Event& event) noexcept {
  const std::int64_t minutes = held(hour, 0, 23, event) * 60 + held(minute, 0, 59, event);
  const std::int64_t ms = (minutes * 60 + held(second, 0, 59, event)) * 1000 + held(millisecond, 0, 999, event);
  return ms * 1'000'000;
}
/// The instant `in_day` nanoseconds (0 .. kDayNs - 1) after the midnight of a day.
constexpr std::int64_t instant(std::int64_t days, std::int64_t in_day, Event& event) noexcept {
  // The first and the last day are there in part: a sum that leaves them wraps to another day.
  const std::int64_t near_by = held(days, -kMostDays - 1, kMostDays, event);
  const std::int64_t sum = wrap_add(wrap_mul(near_by, kDayNs), in_day);
  if (near_by == days && day_of(sum) == days) return sum;
  event = Event::kOutOfRange;
  return days < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}

#define PLC_CONCAT_TWO(Row, iec, A, B, R, ...)                                                                 \
  struct Row {                                                                                                 \
    static constexpr Example examples[] = {__VA_ARGS__};                                                       \
    static constexpr FunctionSpec spec{.name = iec,                                                            \
                                       .params = {{"IN1", fixed(TypeId::k##A)}, {"IN2", fixed(TypeId::k##B)}}, \
                                       .param_count = 2,                                                       \
                                       .result = fixed(TypeId::k##R),                                          \
                                       .events = events(Event::kOutOfRange),                                   \
                                       .clause = kDateClause,                                                  \
                                       .summary =                                                              \
                                           "The time of day IN2 on the date IN1; the first or last instant "   \
                                           "that there is with an event where the sum is beyond it.",          \
                                       .examples = examples};                                                  \
    static std::int64_t eval(std::int64_t date, std::int64_t tod, Event& event) noexcept {                     \
      return instant(day_of(date), within_day(tod), event);                                                    \
    }                                                                                                          \
    template <TypeId, TypeId>                                                                                  \
    static constexpr Kernel kernel = &binary<Row, std::int64_t>;                                               \
  }
PLC_CONCAT_TWO(ConcatDateTod, "CONCAT_DATE_TOD", Date, Tod, Dt,
               {"", "CONCAT_DATE_TOD(D#2024-02-29, TOD#12:34:56)", "DT#2024-02-29-12:34:56"});
PLC_CONCAT_TWO(ConcatDateLtod, "CONCAT_DATE_LTOD", Date, Ltod, Ldt,
               {"", "CONCAT_DATE_LTOD(D#2024-02-29, LTOD#12:34:56)", "LDT#2024-02-29-12:34:56"});
/// No name of the standard's, but one that projects have: the standard's takes a DATE.
PLC_CONCAT_TWO(ConcatLdateLtod, "CONCAT_LDATE_LTOD", Ldate, Ltod, Ldt,
               {"", "CONCAT_LDATE_LTOD(LDATE#2024-02-29, LTOD#12:34:56)", "LDT#2024-02-29-12:34:56"});
#undef PLC_CONCAT_TWO

struct ConcatDate {
  static constexpr Example examples[] = {{"INT", "CONCAT_DATE(2024, 2, 29)", "D#2024-02-29"},
                                         {"UINT", "CONCAT_DATE(2023, 2, 30)", "event:out_of_range D#2023-02-28"},
                                         {"INT", "CONCAT_DATE(2024, 13, 0)", "event:out_of_range D#2024-12-01"},
                                         {"DINT", "CONCAT_DATE(1, 1, 1)", "event:out_of_range D#1677-09-22"}};
  static constexpr FunctionSpec spec{
      .name = "CONCAT_DATE",
      .t_categories = core::kAnyInt,
      .params = {{"YEAR", kT}, {"MONTH", kT}, {"DAY", kT}},
      .param_count = 3,
      .result = fixed(TypeId::kDate),
      .events = events(Event::kOutOfRange),
      .clause = kDateClause,
      .summary =
          "The date of year, month and day; parts out of range count as the nearest ones, dates out of "
          "1677-09-22 to 2262-04-11 are the nearest of these, both with an event.",
      .examples = examples};
  template <class V>
  static std::int64_t eval(V year, V month, V day, Event& event) noexcept {
    return held(days_from(year, month, day, event), -kMostDays, kMostDays, event) * kDayNs;
  }
  template <TypeId T, TypeId>
  static constexpr Kernel kernel = &ternary<ConcatDate, ValueOf<T>>;
};

/// CONCAT_TOD and CONCAT_LTOD, CONCAT_DT and CONCAT_LDT: the same count of nanoseconds under two types.
template <class V>
Event tod_of_parts(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const std::int64_t tod = time_of_day(load<V>(args[0]), load<V>(args[1]), load<V>(args[2]), load<V>(args[3]), event);
  return either(event, store(result, tod));
}
template <class V>
Event dt_of_parts(void* result, const void* const* args, std::uint32_t) noexcept {
  Event event = Event::kNone;
  const std::int64_t days = days_from(load<V>(args[0]), load<V>(args[1]), load<V>(args[2]), event);
  const std::int64_t tod = time_of_day(load<V>(args[3]), load<V>(args[4]), load<V>(args[5]), load<V>(args[6]), event);
  const std::int64_t sum = instant(days, tod, event);
  return either(event, store(result, sum));
}
#define PLC_CONCAT_TOD(Row, iec, R, ...)                                                                          \
  struct Row {                                                                                                    \
    static constexpr Example examples[] = {__VA_ARGS__};                                                          \
    static constexpr FunctionSpec spec{                                                                           \
        .name = iec,                                                                                              \
        .t_categories = core::kAnyInt,                                                                            \
        .params = {{"HOUR", kT}, {"MINUTE", kT}, {"SECOND", kT}, {"MILLISECOND", kT}},                            \
        .param_count = 4,                                                                                         \
        .result = fixed(TypeId::k##R),                                                                            \
        .events = events(Event::kOutOfRange),                                                                     \
        .clause = kDateClause,                                                                                    \
        .summary = "The time of day of its parts; a part out of range counts as the nearest one, with an event.", \
        .examples = examples};                                                                                    \
    template <TypeId T, TypeId>                                                                                   \
    static constexpr Kernel kernel = &tod_of_parts<ValueOf<T>>;                                                   \
  }
PLC_CONCAT_TOD(ConcatTod, "CONCAT_TOD", Tod, {"INT", "CONCAT_TOD(12, 34, 56, 0)", "TOD#12:34:56"},
               {"USINT", "CONCAT_TOD(24, 0, 0, 0)", "event:out_of_range TOD#23:00:00"});
PLC_CONCAT_TOD(ConcatLtod, "CONCAT_LTOD", Ltod, {"INT", "CONCAT_LTOD(12, 34, 56, 0)", "LTOD#12:34:56"});
#undef PLC_CONCAT_TOD

#define PLC_CONCAT_DT(Row, iec, R, ...)                                                                  \
  struct Row {                                                                                           \
    static constexpr Example examples[] = {__VA_ARGS__};                                                 \
    static constexpr FunctionSpec spec{                                                                  \
        .name = iec,                                                                                     \
        .t_categories = core::kAnyInt,                                                                   \
        .params = {{"YEAR", kT},                                                                         \
                   {"MONTH", kT},                                                                        \
                   {"DAY", kT},                                                                          \
                   {"HOUR", kT},                                                                         \
                   {"MINUTE", kT},                                                                       \
                   {"SECOND", kT},                                                                       \
                   {"MILLISECOND", kT}},                                                                 \
        .param_count = 7,                                                                                \
        .result = fixed(TypeId::k##R),                                                                   \
        .events = events(Event::kOutOfRange),                                                            \
        .clause = kDateClause,                                                                           \
        .summary =                                                                                       \
            "The date and time of its parts; a part out of range counts as the nearest one, an instant " \
            "beyond the first or last that there is as that one, both with an event.",                   \
        .examples = examples};                                                                           \
    template <TypeId T, TypeId>                                                                          \
    static constexpr Kernel kernel = &dt_of_parts<ValueOf<T>>;                                           \
  }
PLC_CONCAT_DT(ConcatDt, "CONCAT_DT", Dt, {"INT", "CONCAT_DT(2024, 2, 29, 12, 34, 56, 0)", "DT#2024-02-29-12:34:56"},
              {"DINT", "CONCAT_DT(2024, 4, 31, 12, 60, 0, 0)", "event:out_of_range DT#2024-04-30-12:59:00"});
PLC_CONCAT_DT(ConcatLdt, "CONCAT_LDT", Ldt,
              {"INT", "CONCAT_LDT(2024, 2, 29, 12, 34, 56, 0)", "LDT#2024-02-29-12:34:56"});
#undef PLC_CONCAT_DT

struct DayOfWeek {
  static constexpr Example examples[] = {{"", "DAY_OF_WEEK(D#1970-01-01)", "4"},
                                         {"", "DAY_OF_WEEK(D#2024-02-25)", "0"},
                                         {"", "DAY_OF_WEEK(D#2024-03-02)", "6"}};
  static constexpr FunctionSpec spec{.name = "DAY_OF_WEEK",
                                     .params = {{"IN", fixed(TypeId::kDate)}},
                                     .param_count = 1,
                                     .result = fixed(TypeId::kInt),
                                     .clause = kDateClause,
                                     .summary = "0 on Sundays, 1 on Mondays, up to 6 on Saturdays.",
                                     .examples = examples};
  static std::int16_t eval(std::int64_t date, Event&) noexcept {
    const std::int64_t since_thursday = day_of(date) % 7;  // 1970-01-01 was a Thursday
    return static_cast<std::int16_t>((since_thursday + 11) % 7);
  }
  template <TypeId, TypeId>
  static constexpr Kernel kernel = &unary<DayOfWeek, std::int64_t>;
};

// ---- SPLIT_..: one row per output, found by the bundle alone
// ---------------------------------------------------------

constexpr std::int64_t year_of(std::int64_t ns) noexcept { return civil_of(day_of(ns)).year; }
constexpr std::int64_t month_of(std::int64_t ns) noexcept { return civil_of(day_of(ns)).month; }
constexpr std::int64_t day_in_month(std::int64_t ns) noexcept { return civil_of(day_of(ns)).day; }
constexpr std::int64_t hour_of(std::int64_t ns) noexcept { return within_day(ns) / 3'600'000'000'000; }
constexpr std::int64_t minute_of(std::int64_t ns) noexcept { return within_day(ns) / 60'000'000'000 % 60; }
constexpr std::int64_t second_of(std::int64_t ns) noexcept { return within_day(ns) / 1'000'000'000 % 60; }
constexpr std::int64_t millisecond_of(std::int64_t ns) noexcept { return within_day(ns) / 1'000'000 % 1000; }

/// A part of a date in the integer type T of its output: one that T does not have is the nearest, with an event.
template <TypeId T, std::int64_t (*Part)(std::int64_t) noexcept>
Event part_of_date(void* result, const void* const* args, std::uint32_t) noexcept {
  using V = ValueOf<T>;
  Event event = Event::kNone;
  const std::int64_t part = Part(load<std::int64_t>(args[0]));
  constexpr auto kLeast = std::numeric_limits<V>::min();
  constexpr auto kGreatest = std::numeric_limits<V>::max();
  V out = static_cast<V>(part);
  if (!std::in_range<V>(part)) {
    event = Event::kOutOfRange;
    out = part < 0 ? kLeast : kGreatest;
  }
  return either(event, store(result, out));
}

// Only years and milliseconds are ever too large for a type.
#define PLC_SPLIT_PART(Row, iec, A, function, happens, text, ...)               \
  struct Row {                                                                  \
    static constexpr Example examples[] = {__VA_ARGS__};                        \
    static constexpr FunctionSpec spec{.name = iec,                             \
                                       .t_categories = core::kAnyInt,           \
                                       .params = {{"IN", fixed(TypeId::k##A)}}, \
                                       .param_count = 1,                        \
                                       .result = kT,                            \
                                       .events = happens,                       \
                                       .clause = kDateClause,                   \
                                       .summary = text,                         \
                                       .examples = examples};                   \
    template <TypeId T, TypeId>                                                 \
    static constexpr Kernel kernel = &part_of_date<T, function>;                \
  }
#define PLC_SPLIT_OF_DATE(Prefix, iec, A, literal)                                                       \
  PLC_SPLIT_PART(Prefix##Year, iec ".YEAR", A, year_of, events(Event::kOutOfRange), "The year.",         \
                 {"INT", iec ".YEAR(" literal ")", "2024"},                                              \
                 {"SINT", iec ".YEAR(" literal ")", "event:out_of_range 127"});                          \
  PLC_SPLIT_PART(Prefix##Month, iec ".MONTH", A, month_of, EventSet{}, "The month, 1 .. 12.",            \
                 {"USINT", iec ".MONTH(" literal ")", "2"});                                             \
  PLC_SPLIT_PART(Prefix##Day, iec ".DAY", A, day_in_month, EventSet{}, "The day of the month, 1 .. 31.", \
                 {"INT", iec ".DAY(" literal ")", "29"})
#define PLC_SPLIT_OF_TIME(Prefix, iec, A, literal)                                                       \
  PLC_SPLIT_PART(Prefix##Hour, iec ".HOUR", A, hour_of, EventSet{}, "The hour, 0 .. 23.",                \
                 {"INT", iec ".HOUR(" literal ")", "12"});                                               \
  PLC_SPLIT_PART(Prefix##Minute, iec ".MINUTE", A, minute_of, EventSet{}, "The minute, 0 .. 59.",        \
                 {"INT", iec ".MINUTE(" literal ")", "34"});                                             \
  PLC_SPLIT_PART(Prefix##Second, iec ".SECOND", A, second_of, EventSet{}, "The second, 0 .. 59.",        \
                 {"INT", iec ".SECOND(" literal ")", "56"});                                             \
  PLC_SPLIT_PART(Prefix##Millisecond, iec ".MILLISECOND", A, millisecond_of, events(Event::kOutOfRange), \
                 "The millisecond, 0 .. 999; what is finer is left out.",                                \
                 {"INT", iec ".MILLISECOND(" literal ")", "0"})
PLC_SPLIT_OF_DATE(SplitDate, "SPLIT_DATE", Date, "D#2024-02-29");
PLC_SPLIT_OF_TIME(SplitTod, "SPLIT_TOD", Tod, "TOD#12:34:56");
PLC_SPLIT_OF_TIME(SplitLtod, "SPLIT_LTOD", Ltod, "LTOD#12:34:56");
PLC_SPLIT_OF_DATE(SplitDt, "SPLIT_DT", Dt, "DT#2024-02-29-12:34:56");
PLC_SPLIT_OF_TIME(SplitDt, "SPLIT_DT", Dt, "DT#2024-02-29-12:34:56");
PLC_SPLIT_OF_DATE(SplitLdt, "SPLIT_LDT", Ldt, "LDT#2024-02-29-12:34:56");
PLC_SPLIT_OF_TIME(SplitLdt, "SPLIT_LDT", Ldt, "LDT#2024-02-29-12:34:56");
#undef PLC_SPLIT_OF_TIME
#undef PLC_SPLIT_OF_DATE
#undef PLC_SPLIT_PART

using DateRows =
    Rows<ConcatDateTod, ConcatDateLtod, ConcatLdateLtod, ConcatDate, ConcatTod, ConcatLtod, ConcatDt, ConcatLdt,
         DayOfWeek, SplitDateYear, SplitDateMonth, SplitDateDay, SplitTodHour, SplitTodMinute, SplitTodSecond,
         SplitTodMillisecond, SplitLtodHour, SplitLtodMinute, SplitLtodSecond, SplitLtodMillisecond, SplitDtYear,
         SplitDtMonth, SplitDtDay, SplitDtHour, SplitDtMinute, SplitDtSecond, SplitDtMillisecond, SplitLdtYear,
         SplitLdtMonth, SplitLdtDay, SplitLdtHour, SplitLdtMinute, SplitLdtSecond, SplitLdtMillisecond>;

inline constexpr const FunctionSpec* kSplitDateOutputs[] = {&SplitDateYear::spec, &SplitDateMonth::spec,
                                                            &SplitDateDay::spec};
inline constexpr const FunctionSpec* kSplitTodOutputs[] = {&SplitTodHour::spec, &SplitTodMinute::spec,
                                                           &SplitTodSecond::spec, &SplitTodMillisecond::spec};
inline constexpr const FunctionSpec* kSplitLtodOutputs[] = {&SplitLtodHour::spec, &SplitLtodMinute::spec,
                                                            &SplitLtodSecond::spec, &SplitLtodMillisecond::spec};
inline constexpr const FunctionSpec* kSplitDtOutputs[] = {
    &SplitDtYear::spec,   &SplitDtMonth::spec,  &SplitDtDay::spec,        &SplitDtHour::spec,
    &SplitDtMinute::spec, &SplitDtSecond::spec, &SplitDtMillisecond::spec};
inline constexpr const FunctionSpec* kSplitLdtOutputs[] = {
    &SplitLdtYear::spec,   &SplitLdtMonth::spec,  &SplitLdtDay::spec,        &SplitLdtHour::spec,
    &SplitLdtMinute::spec, &SplitLdtSecond::spec, &SplitLdtMillisecond::spec};

inline constexpr BundleSpec kDateBundles[] = {
    {"SPLIT_DATE",
     {"IN", fixed(TypeId::kDate)},
     kSplitDateOutputs,
     kDateClause,
     "Year, month and day of a date.",
     "SPLIT_DATE(IN := d, YEAR => y, MONTH => m, DAY => n);"},
    {"SPLIT_TOD",
     {"IN", fixed(TypeId::kTod)},
     kSplitTodOutputs,
     kDateClause,
     "The parts of a time of day.",
     "SPLIT_TOD(IN := t, HOUR => h, MINUTE => m, SECOND => s, MILLISECOND => ms);"},
    {"SPLIT_LTOD",
     {"IN", fixed(TypeId::kLtod)},
     kSplitLtodOutputs,
     kDateClause,
     "The parts of a time of day.",
     "SPLIT_LTOD(t, h, m, s, ms);"},
    {"SPLIT_DT",
     {"IN", fixed(TypeId::kDt)},
     kSplitDtOutputs,
     kDateClause,
     "The parts of a date and time.",
     "SPLIT_DT(IN := t, YEAR => y, HOUR => h);"},
    {"SPLIT_LDT",
     {"IN", fixed(TypeId::kLdt)},
     kSplitLdtOutputs,
     kDateClause,
     "The parts of a date and time.",
     "SPLIT_LDT(IN := t, YEAR => y, HOUR => h);"}};

}  // namespace plc::stdlib::rows
