// Rows: arithmetic with durations, dates and times of day (IEC 61131-3:2013, table 35).
//
// All are signed 64-bit counts of nanoseconds: DATE and DT since 1970-01-01, TOD since midnight. Sums wrap, a time of
// day stays within its day; a duration times or by a real rounds half to even and saturates with an event.
#pragma once

#include "stdlib/arithmetic.h"
#include "stdlib/calendar.h"
#include "stdlib/row.h"

namespace plc::stdlib::rows {

inline constexpr std::string_view kDurationClause = "IEC 61131-3:2013, table 35";

constexpr std::int64_t later(std::int64_t t, std::int64_t by) noexcept { return wrap_add(t, by); }
constexpr std::int64_t earlier(std::int64_t t, std::int64_t by) noexcept { return wrap_sub(t, by); }
constexpr std::int64_t later_in_day(std::int64_t t, std::int64_t by) noexcept {
  return within_day(within_day(t) + by % kDayNs);
}
constexpr std::int64_t earlier_in_day(std::int64_t t, std::int64_t by) noexcept {
  return within_day(within_day(t) - by % kDayNs);
}

/// One row on fixed types; the standard gives each meaning an overloaded name and a typed one.
#define PLC_TIME_ROW(Row, iec, A, B, R, function, text, ...)                                                   \
  struct Row {                                                                                                 \
    static constexpr Example examples[] = {__VA_ARGS__};                                                       \
    static constexpr FunctionSpec spec{.name = iec,                                                            \
                                       .params = {{"IN1", fixed(TypeId::k##A)}, {"IN2", fixed(TypeId::k##B)}}, \
                                       .param_count = 2,                                                       \
                                       .result = fixed(TypeId::k##R),                                          \
                                       .clause = kDurationClause,                                              \
                                       .summary = text,                                                        \
                                       .examples = examples};                                                  \
    static std::int64_t eval(std::int64_t a, std::int64_t b, Event&) noexcept { return function(a, b); }       \
    template <TypeId, TypeId>                                                                                  \
    static constexpr Kernel kernel = &binary<Row, std::int64_t>;                                               \
  };
PLC_TIME_ROW(AddTime, "ADD_TIME", Time, Time, Time, later, "Sum of two durations.",
             {"", "ADD_TIME(T#1s, T#2s)", "T#3s"})
PLC_TIME_ROW(AddLtime, "ADD_LTIME", Ltime, Ltime, Ltime, later, "Sum of two durations.",
             {"", "ADD_LTIME(LTIME#1s, LTIME#2ns)", "LTIME#1s2ns"})
PLC_TIME_ROW(SubTime, "SUB_TIME", Time, Time, Time, earlier, "Difference of two durations.",
             {"", "SUB_TIME(T#1s, T#2s)", "T#-1s"})
PLC_TIME_ROW(SubLtime, "SUB_LTIME", Ltime, Ltime, Ltime, earlier, "Difference of two durations.",
             {"", "SUB_LTIME(LTIME#1us, LTIME#1ns)", "LTIME#999ns"})
PLC_TIME_ROW(TodAddTime, "ADD", Tod, Time, Tod, later_in_day,
             "Time of day after a duration, past midnight from 0 again.",
             {"", "ADD(TOD#23:59:59, T#2s)", "TOD#00:00:01"})
PLC_TIME_ROW(TodAddTimeTyped, "ADD_TOD_TIME", Tod, Time, Tod, later_in_day,
             "Time of day after a duration, past midnight from 0 again.",
             {"", "ADD_TOD_TIME(TOD#23:59:59, T#2s)", "TOD#00:00:01"})
PLC_TIME_ROW(DtAddTime, "ADD", Dt, Time, Dt, later, "Date and time after a duration.",
             {"", "ADD(DT#2024-02-28-23:59:59, T#2s)", "DT#2024-02-29-00:00:01"})
PLC_TIME_ROW(DtAddTimeTyped, "ADD_DT_TIME", Dt, Time, Dt, later, "Date and time after a duration.",
             {"", "ADD_DT_TIME(DT#2024-02-28-23:59:59, T#2s)", "DT#2024-02-29-00:00:01"})
PLC_TIME_ROW(TodSubTime, "SUB", Tod, Time, Tod, earlier_in_day,
             "Time of day before a duration, before midnight from the end of the day again.",
             {"", "SUB(TOD#00:00:01, T#2s)", "TOD#23:59:59"})
PLC_TIME_ROW(TodSubTimeTyped, "SUB_TOD_TIME", Tod, Time, Tod, earlier_in_day,
             "Time of day before a duration, before midnight from the end of the day again.",
             {"", "SUB_TOD_TIME(TOD#00:00:01, T#2s)", "TOD#23:59:59"})
PLC_TIME_ROW(DtSubTime, "SUB", Dt, Time, Dt, earlier, "Date and time before a duration.",
             {"", "SUB(DT#1970-01-02-00:00:00, T#1s)", "DT#1970-01-01-23:59:59"})
PLC_TIME_ROW(DtSubTimeTyped, "SUB_DT_TIME", Dt, Time, Dt, earlier, "Date and time before a duration.",
             {"", "SUB_DT_TIME(DT#1970-01-02-00:00:00, T#1s)", "DT#1970-01-01-23:59:59"})
PLC_TIME_ROW(DateSub, "SUB", Date, Date, Time, earlier, "Duration between two dates.",
             {"", "SUB(DATE#2024-03-01, DATE#2024-02-28)", "T#2d"})
PLC_TIME_ROW(DateSubTyped, "SUB_DATE_DATE", Date, Date, Time, earlier, "Duration between two dates.",
             {"", "SUB_DATE_DATE(DATE#2024-03-01, DATE#2024-02-28)", "T#2d"})
PLC_TIME_ROW(TodSub, "SUB", Tod, Tod, Time, earlier, "Duration between two times of day.",
             {"", "SUB(TOD#10:00:00, TOD#11:00:00)", "T#-1h"})
PLC_TIME_ROW(TodSubTyped, "SUB_TOD_TOD", Tod, Tod, Time, earlier, "Duration between two times of day.",
             {"", "SUB_TOD_TOD(TOD#10:00:00, TOD#11:00:00)", "T#-1h"})
PLC_TIME_ROW(DtSub, "SUB", Dt, Dt, Time, earlier, "Duration between two dates and times.",
             {"", "SUB(DT#2024-01-01-12:00:00, DT#2024-01-01-00:00:00)", "T#12h"})
PLC_TIME_ROW(DtSubTyped, "SUB_DT_DT", Dt, Dt, Time, earlier, "Duration between two dates and times.",
             {"", "SUB_DT_DT(DT#2024-01-01-12:00:00, DT#2024-01-01-00:00:00)", "T#12h"})
PLC_TIME_ROW(LtodAddTime, "ADD", Ltod, Ltime, Ltod, later_in_day,
             "Time of day after a duration, past midnight from 0 again.",
             {"", "ADD(LTOD#23:59:59, LTIME#2s)", "LTOD#00:00:01"})
PLC_TIME_ROW(LtodAddTimeTyped, "ADD_LTOD_LTIME", Ltod, Ltime, Ltod, later_in_day,
             "Time of day after a duration, past midnight from 0 again.",
             {"", "ADD_LTOD_LTIME(LTOD#23:59:59, LTIME#2s)", "LTOD#00:00:01"})
PLC_TIME_ROW(LdtAddTime, "ADD", Ldt, Ltime, Ldt, later, "Date and time after a duration.",
             {"", "ADD(LDT#2024-02-28-23:59:59, LTIME#2s)", "LDT#2024-02-29-00:00:01"})
PLC_TIME_ROW(LdtAddTimeTyped, "ADD_LDT_LTIME", Ldt, Ltime, Ldt, later, "Date and time after a duration.",
             {"", "ADD_LDT_LTIME(LDT#2024-02-28-23:59:59, LTIME#2s)", "LDT#2024-02-29-00:00:01"})
PLC_TIME_ROW(LtodSubTime, "SUB", Ltod, Ltime, Ltod, earlier_in_day,
             "Time of day before a duration, before midnight from the end of the day again.",
             {"", "SUB(LTOD#00:00:01, LTIME#2s)", "LTOD#23:59:59"})
PLC_TIME_ROW(LtodSubTimeTyped, "SUB_LTOD_LTIME", Ltod, Ltime, Ltod, earlier_in_day,
             "Time of day before a duration, before midnight from the end of the day again.",
             {"", "SUB_LTOD_LTIME(LTOD#00:00:01, LTIME#2s)", "LTOD#23:59:59"})
PLC_TIME_ROW(LdtSubTime, "SUB", Ldt, Ltime, Ldt, earlier, "Date and time before a duration.",
             {"", "SUB(LDT#1970-01-02-00:00:00, LTIME#1s)", "LDT#1970-01-01-23:59:59"})
PLC_TIME_ROW(LdtSubTimeTyped, "SUB_LDT_LTIME", Ldt, Ltime, Ldt, earlier, "Date and time before a duration.",
             {"", "SUB_LDT_LTIME(LDT#1970-01-02-00:00:00, LTIME#1s)", "LDT#1970-01-01-23:59:59"})
PLC_TIME_ROW(LdateSub, "SUB", Ldate, Ldate, Ltime, earlier, "Duration between two dates.",
             {"", "SUB(LDATE#2024-03-01, LDATE#2024-02-28)", "LTIME#2d"})
PLC_TIME_ROW(LdateSubTyped, "SUB_LDATE_LDATE", Ldate, Ldate, Ltime, earlier, "Duration between two dates.",
             {"", "SUB_LDATE_LDATE(LDATE#2024-03-01, LDATE#2024-02-28)", "LTIME#2d"})
PLC_TIME_ROW(LtodSub, "SUB", Ltod, Ltod, Ltime, earlier, "Duration between two times of day.",
             {"", "SUB(LTOD#10:00:00, LTOD#11:00:00)", "LTIME#-1h"})
PLC_TIME_ROW(LtodSubTyped, "SUB_LTOD_LTOD", Ltod, Ltod, Ltime, earlier, "Duration between two times of day.",
             {"", "SUB_LTOD_LTOD(LTOD#10:00:00, LTOD#11:00:00)", "LTIME#-1h"})
PLC_TIME_ROW(LdtSub, "SUB", Ldt, Ldt, Ltime, earlier, "Duration between two dates and times.",
             {"", "SUB(LDT#2024-01-01-12:00:00, LDT#2024-01-01-00:00:00)", "LTIME#12h"})
PLC_TIME_ROW(LdtSubTyped, "SUB_LDT_LDT", Ldt, Ldt, Ltime, earlier, "Duration between two dates and times.",
             {"", "SUB_LDT_LDT(LDT#2024-01-01-12:00:00, LDT#2024-01-01-00:00:00)", "LTIME#12h"})
#undef PLC_TIME_ROW

template <class U>
constexpr std::int64_t scale(std::int64_t t, U factor, Event& event) noexcept {
  if constexpr (std::is_floating_point_v<U>) {
    return multiply_rounded(t, static_cast<double>(factor), event);
  } else {
    return wrap_mul(t, static_cast<std::int64_t>(factor));
  }
}
/// Zero divisors of either kind give 0 with an event: a duration has no infinity.
template <class U>
constexpr std::int64_t divide(std::int64_t t, U divisor, Event& event) noexcept {
  if (divisor == U{0}) {
    event = Event::kDivideByZero;
    return 0;
  }
  if constexpr (std::is_floating_point_v<U>) {
    return divide_rounded(t, static_cast<double>(divisor), event);
  } else if constexpr (std::is_same_v<U, std::uint64_t>) {
    // From 2^63 on only the least duration, of magnitude 2^63, is not smaller than the divisor.
    constexpr std::uint64_t kTop = 0x8000000000000000ull;
    if (divisor >= kTop) return divisor == kTop && t == std::numeric_limits<std::int64_t>::min() ? -1 : 0;
    return div_wrap(t, static_cast<std::int64_t>(divisor), event);
  } else {
    return div_wrap(t, static_cast<std::int64_t>(divisor), event);
  }
}

inline constexpr EventSet kScaleEvents = events(Event::kOutOfRange);
inline constexpr EventSet kDivideEvents = events(Event::kDivideByZero, Event::kOutOfRange);

/// Rows of a duration by a number. T is a type variable in the overloaded ones and fixed in the typed ones.
#define PLC_SCALE_ROW(Row, iec, categories, A, function, reports, text, ...) \
  struct Row {                                                               \
    static constexpr Example examples[] = {__VA_ARGS__};                     \
    static constexpr FunctionSpec spec{.name = iec,                          \
                                       .t_categories = categories,           \
                                       .u_categories = core::kAnyNum,        \
                                       .params = {{"IN1", A}, {"IN2", kU}},  \
                                       .param_count = 2,                     \
                                       .result = A,                          \
                                       .events = reports,                    \
                                       .clause = kDurationClause,            \
                                       .summary = text,                      \
                                       .examples = examples};                \
    template <class U>                                                       \
    static std::int64_t eval(std::int64_t a, U b, Event& event) noexcept {   \
      return function(a, b, event);                                          \
    }                                                                        \
    template <TypeId, TypeId U>                                              \
    static constexpr Kernel kernel = &binary<Row, std::int64_t, ValueOf<U>>; \
  };
PLC_SCALE_ROW(MulDuration, "MUL", core::kAnyDuration, kT, scale, kScaleEvents,
              "A duration times a number; integers wrap, reals round half to even and saturate with an event.",
              {"TIME,INT", "MUL(T#1s, 3)", "T#3s"}, {"TIME,REAL", "MUL(T#1s, 0.5)", "T#500ms"})
PLC_SCALE_ROW(DivDuration, "DIV", core::kAnyDuration, kT, divide, kDivideEvents,
              "A duration divided by a number, integers toward zero; 0 with an event if the number is 0.",
              {"TIME,INT", "DIV(T#1s, -4)", "T#-250ms"}, {"TIME,LREAL", "DIV(T#1s, 0.0)", "event:divide_by_zero T#0s"})
PLC_SCALE_ROW(MulTime, "MUL_TIME", 0, fixed(TypeId::kTime), scale, kScaleEvents,
              "A duration times a number; integers wrap, reals round half to even and saturate with an event.",
              {"INT", "MUL_TIME(T#1s, 3)", "T#3s"}, {"REAL", "MUL_TIME(T#1s, 0.5)", "T#500ms"})
PLC_SCALE_ROW(MulTimeSecond, "MULTIME", 0, fixed(TypeId::kTime), scale, kScaleEvents,
              "A duration times a number; integers wrap, reals round half to even and saturate with an event.",
              {"INT", "MULTIME(T#1s, 3)", "T#3s"}, {"REAL", "MULTIME(T#1s, 0.5)", "T#500ms"})
PLC_SCALE_ROW(MulLtime, "MUL_LTIME", 0, fixed(TypeId::kLtime), scale, kScaleEvents,
              "A duration times a number; integers wrap, reals round half to even and saturate with an event.",
              {"INT", "MUL_LTIME(LTIME#1s, 3)", "LTIME#3s"}, {"REAL", "MUL_LTIME(LTIME#1s, 0.5)", "LTIME#500ms"})
PLC_SCALE_ROW(DivTime, "DIV_TIME", 0, fixed(TypeId::kTime), divide, kDivideEvents,
              "A duration divided by a number, integers toward zero; 0 with an event if the number is 0.",
              {"INT", "DIV_TIME(T#1s, -4)", "T#-250ms"}, {"LREAL", "DIV_TIME(T#1s, 0.0)", "event:divide_by_zero T#0s"})
PLC_SCALE_ROW(DivTimeSecond, "DIVTIME", 0, fixed(TypeId::kTime), divide, kDivideEvents,
              "A duration divided by a number, integers toward zero; 0 with an event if the number is 0.",
              {"INT", "DIVTIME(T#1s, -4)", "T#-250ms"}, {"LREAL", "DIVTIME(T#1s, 0.0)", "event:divide_by_zero T#0s"})
PLC_SCALE_ROW(DivLtime, "DIV_LTIME", 0, fixed(TypeId::kLtime), divide, kDivideEvents,
              "A duration divided by a number, integers toward zero; 0 with an event if the number is 0.",
              {"INT", "DIV_LTIME(LTIME#1s, -4)", "LTIME#-250ms"},
              {"LREAL", "DIV_LTIME(LTIME#1s, 0.0)", "event:divide_by_zero LTIME#0s"})
#undef PLC_SCALE_ROW

using DurationRows =
    Rows<AddTime, AddLtime, SubTime, SubLtime, TodAddTime, TodAddTimeTyped, DtAddTime, DtAddTimeTyped, TodSubTime,
         TodSubTimeTyped, DtSubTime, DtSubTimeTyped, DateSub, DateSubTyped, TodSub, TodSubTyped, DtSub, DtSubTyped,
         LtodAddTime, LtodAddTimeTyped, LdtAddTime, LdtAddTimeTyped, LtodSubTime, LtodSubTimeTyped, LdtSubTime,
         LdtSubTimeTyped, LdateSub, LdateSubTyped, LtodSub, LtodSubTyped, LdtSub, LdtSubTyped, MulDuration, DivDuration,
         MulTime, MulTimeSecond, MulLtime, DivTime, DivTimeSecond, DivLtime>;

}  // namespace plc::stdlib::rows
