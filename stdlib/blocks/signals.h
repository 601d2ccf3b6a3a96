// Blocks: date and time, a clock that runs from a preset time, signals that switch by themselves, the bits of a byte.
//
// Time is that of the cycle, as for the timers (timers.h): edges come with the first execution at or after their time.
// Date and time are taken with it, once a cycle.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/time_zone.h"
#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::fb {

/// While it runs, CDT is PDT and what has passed since by the clock of the timers: setting the machine's clock moves it
/// only while IN is FALSE.
struct Rtc {
  struct Ports {
    std::uint8_t in = 0, q = 0, m = 0;
    std::int64_t pdt = 0, cdt = 0, loaded = 0, start = 0;
  };
  static constexpr std::string_view name = "RTC";
  static constexpr std::string_view clause = "not in the third edition; IEC 61131-3:2003, table 37";
  static constexpr std::string_view summary =
      "Clock: a rising edge of IN sets it to PDT, and CDT runs from there while IN is TRUE, also when the clock of the "
      "machine is set. With IN FALSE CDT is the date and time of the machine in UTC, as in Beremiz.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, TypeId::kBool, offsetof(Ports, in), "sets the clock at its rising edge, and runs it"},
      {"PDT", Direction::kInput, TypeId::kDt, offsetof(Ports, pdt), "preset date and time, read at the edge"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "IN: the clock runs from PDT"},
      {"CDT", Direction::kOutput, TypeId::kDt, offsetof(Ports, cdt), "date and time"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "IN at the last execution"},
      {"LOADED", Direction::kState, TypeId::kDt, offsetof(Ports, loaded), "PDT at the edge"},
      {"START", Direction::kState, TypeId::kLtime, offsetof(Ports, start), "clock at the edge"}};
  static constexpr BlockExample examples[] = {{"Set at the edge only, and over the end of a year", R"(
at     IN PDT                    | Q CDT
T#0s   0  DT#2023-12-31-23:59:58 | 0 DT#1970-01-01-00:00:00
T#5s   1  .                      | 1 DT#2023-12-31-23:59:58
T#7s   .  DT#1999-01-01-00:00:00 | 1 DT#2024-01-01-00:00:00
T#8s   0  .                      | 0 DT#1970-01-01-00:00:08
T#9s   1  .                      | 1 DT#1999-01-01-00:00:00
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    if (p.in != 0 && p.m == 0) {
      p.start = context.now_ns;
      p.loaded = p.pdt;
    }
    p.m = p.in;
    p.q = p.in;
    p.cdt =
        p.in != 0 ? wrap_add(p.loaded, std::max<std::int64_t>(wrap_sub(context.now_ns, p.start), 0)) : context.utc_ns;
  }
};

/// What UTC_DT(), LOCAL_DT() and the like of texts run.
struct SysTime {
  struct Ports {
    std::int64_t utc = 0, local = 0, offset = 0;
  };
  static constexpr std::string_view name = "SYS_TIME";
  static constexpr std::string_view clause =
      "not in the standard; PICARD's own. UTC_DT(), UTC_LDT(), LOCAL_DT() and LOCAL_LDT() in texts";
  static constexpr std::string_view summary =
      "The date and time of the machine, taken once a cycle. It jumps when that clock is set; timers do not.";
  static constexpr Field fields[] = {
      {"UTC", Direction::kOutput, TypeId::kDt, offsetof(Ports, utc), "date and time, UTC"},
      {"LOCAL", Direction::kOutput, TypeId::kDt, offsetof(Ports, local), "the same in the time zone of the plant"},
      {"OFFSET", Direction::kOutput, TypeId::kTime, offsetof(Ports, offset), "LOCAL - UTC"}};
  static constexpr BlockExample examples[] = {{"In UTC, from 1970-01-01 on, as plc sim without --date", R"(
at     | UTC                    LOCAL                  OFFSET
T#0s   | DT#1970-01-01-00:00:00 DT#1970-01-01-00:00:00 T#0s
T#90s  | DT#1970-01-01-00:01:30 DT#1970-01-01-00:01:30 T#0s
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    p.utc = context.utc_ns;
    p.offset = context.zone == nullptr ? 0 : context.zone->offset_ns(context.utc_ns);
    p.local = wrap_add(p.utc, p.offset);
  }
};

/// Phases follow each other on the grid of their lengths: late scans do not add up. After a whole phase without a call
/// the grid begins anew.
struct Blink {
  struct Ports {
    std::uint8_t enable = 0, out = 0, m = 0;
    std::int64_t timelow = 0, timehigh = 0, start = 0;
  };
  static constexpr std::string_view name = "BLINK";
  static constexpr std::string_view clause = "not in the standard; as in CODESYS";
  static constexpr std::string_view summary =
      "While ENABLE, OUT is FALSE for TIMELOW and TRUE for TIMEHIGH in turns; it begins with the value it has. Without "
      "ENABLE it keeps its value: AND it with ENABLE where a lamp must go out.";
  static constexpr Field fields[] = {
      {"ENABLE", Direction::kInput, TypeId::kBool, offsetof(Ports, enable), "OUT changes"},
      {"TIMELOW", Direction::kInput, TypeId::kTime, offsetof(Ports, timelow),
       "how long OUT is FALSE; one scan at least"},
      {"TIMEHIGH", Direction::kInput, TypeId::kTime, offsetof(Ports, timehigh),
       "how long it is TRUE; one scan at least"},
      {"OUT", Direction::kOutput, TypeId::kBool, offsetof(Ports, out), "signal"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "ENABLE at the last execution"},
      {"START", Direction::kState, TypeId::kLtime, offsetof(Ports, start), "clock when this phase began"}};
  static constexpr BlockExample examples[] = {{"300 ms off, 200 ms on; a late scan does not shift what follows", R"(
at      ENABLE TIMELOW TIMEHIGH | OUT
T#0ms   1      T#300ms T#200ms  | 0
T#290ms .      .       .        | 0
T#310ms .      .       .        | 1
T#490ms .      .       .        | 1
T#500ms .      .       .        | 0
T#800ms .      .       .        | 1
T#850ms 0      .       .        | 1
T#5s    .      .       .        | 1
T#6s    1      .       .        | 1
T#6s200ms .    .       .        | 0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    const core::TimeNs now = context.now_ns;
    const bool began = p.enable != 0 && p.m == 0;
    p.m = p.enable;
    if (began || wrap_sub(now, p.start) < 0) p.start = now;
    if (p.enable == 0 || began) return;
    const std::int64_t length = std::max<std::int64_t>(p.out != 0 ? p.timehigh : p.timelow, 0);
    if (wrap_sub(now, p.start) < length) return;
    p.out ^= 1u;
    p.start = wrap_add(p.start, length);
    if (wrap_sub(now, p.start) >= (p.out != 0 ? p.timehigh : p.timelow)) p.start = now;
  }
};

/// One pulse a period at most: what DUTY does within a period counts for the next one, so that a contactor switches no
/// more often than it was chosen for.
struct Pwm {
  struct Ports {
    std::uint8_t enable = 0, out = 0, m = 0;
    float duty = 0;
    std::int64_t period = 0, start = 0, on = 0;
  };
  static constexpr std::string_view name = "PWM";
  static constexpr std::string_view clause =
      "not in the standard; as PWM_DC in OSCAT, with the period, not the frequency";
  static constexpr std::string_view summary =
      "Pulse width modulation: in each PERIOD OUT is TRUE for the share DUTY, which is read at its begin. Pulses are "
      "whole "
      "scans: let PERIOD be a hundred of them.";
  static constexpr Field fields[] = {
      {"ENABLE", Direction::kInput, TypeId::kBool, offsetof(Ports, enable), "FALSE: OUT is FALSE"},
      {"DUTY", Direction::kInput, TypeId::kReal, offsetof(Ports, duty),
       "0.0 .. 1.0, the nearest of these; NaN: as before"},
      {"PERIOD", Direction::kInput, TypeId::kTime, offsetof(Ports, period), "0 or less: OUT is FALSE"},
      {"OUT", Direction::kOutput, TypeId::kBool, offsetof(Ports, out), "pulses"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "a period runs"},
      {"START", Direction::kState, TypeId::kLtime, offsetof(Ports, start), "clock when it began"},
      {"ON", Direction::kState, TypeId::kLtime, offsetof(Ports, on), "how long OUT is TRUE in it"}};
  static constexpr BlockExample examples[] = {{"A quarter of a second, then three quarters", R"(
at       ENABLE DUTY PERIOD | OUT
T#0ms    1      0.25 T#1s   | 1
T#200ms  .      0.75 .      | 1
T#250ms  .      .    .      | 0
T#1s     .      .    .      | 1
T#1s740ms .     .    .      | 1
T#1s750ms .     .    .      | 0
T#2s     0      .    .      | 0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    if (p.enable == 0 || p.period <= 0) {
      p.m = 0;
      p.out = 0;
      return;
    }
    const std::int64_t passed = wrap_sub(context.now_ns, p.start);
    if (p.m == 0 || passed < 0) {
      p.m = 1;
      begin(p, context.now_ns);
    } else if (passed >= p.period) {
      begin(p, wrap_sub(context.now_ns, passed % p.period));
    }
    p.out = wrap_sub(context.now_ns, p.start) < p.on;
  }

 private:
  static void begin(Ports& p, core::TimeNs at) noexcept {
    p.start = at;
    if (std::isnan(p.duty)) return;
    p.on =
        p.duty >= 1 ? p.period : static_cast<std::int64_t>(std::max<double>(p.duty, 0) * static_cast<double>(p.period));
  }
};

struct Unpack {
  struct Ports {
    std::uint8_t b = 0, bits[8] = {};
  };
  static constexpr std::string_view name = "UNPACK";
  static constexpr std::string_view clause = "not in the standard; as in CODESYS. PACK is the way back";
  static constexpr std::string_view summary = "The bits of a byte, B0 the lowest.";
  static constexpr Field fields[] = {{"B", Direction::kInput, TypeId::kByte, offsetof(Ports, b), "byte"},
                                     {"B0", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[0]), "bit 0"},
                                     {"B1", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[1]), "bit 1"},
                                     {"B2", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[2]), "bit 2"},
                                     {"B3", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[3]), "bit 3"},
                                     {"B4", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[4]), "bit 4"},
                                     {"B5", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[5]), "bit 5"},
                                     {"B6", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[6]), "bit 6"},
                                     {"B7", Direction::kOutput, TypeId::kBool, offsetof(Ports, bits[7]), "bit 7"}};
  static constexpr BlockExample examples[] = {{"16#A5 is 2#1010_0101", R"(
at     B     | B0 B1 B2 B3 B4 B5 B6 B7
T#0s   16#A5 | 1  0  1  0  0  1  0  1
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    for (unsigned i = 0; i < 8; ++i) p.bits[i] = static_cast<std::uint8_t>(p.b >> i & 1u);
  }
};

/// What TIME() of texts runs.
struct Uptime {
  struct Ports {
    std::int64_t out = 0;
  };
  static constexpr std::string_view name = "UPTIME";
  static constexpr std::string_view clause = "not in the standard; PICARD's own. TIME() in texts, as in CODESYS";
  static constexpr std::string_view summary = "The time since the PLC started.";
  static constexpr Field fields[] = {
      {"OUT", Direction::kOutput, TypeId::kTime, offsetof(Ports, out), "time since the start"}};
  static constexpr BlockExample examples[] = {{"It goes on whether the block is executed or not", R"(
at     | OUT
T#0s   | T#0s
T#20ms | T#20ms
T#9s   | T#9s
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    p.out = std::max<std::int64_t>(wrap_sub(context.now_ns, context.start_ns), 0);
  }
};

using SignalRows = Rows<Rtc, SysTime, Blink, Pwm, Unpack, Uptime>;

}  // namespace plc::stdlib::fb
