// Blocks: timers (IEC 61131-3:2013, table 46 and figure 15), at the resolution of the cycle.
//
// Time is StepContext::now_ns, which stands still within a cycle; a timer that is not executed goes on measuring. PT is
// read at every execution, so a change takes effect while the time runs; once it has run out, ET and Q keep what they
// have until IN changes. A negative PT counts as 0. A TRUE at IN in the first scan starts at once.
#pragma once

#include <algorithm>
#include <cstddef>

#include "stdlib/arithmetic.h"
#include "stdlib/row.h"

namespace plc::stdlib::fb {

inline constexpr std::string_view kTimerClause = "IEC 61131-3:2013, table 46";

struct TimerPorts {
  enum State : std::uint8_t { kIdle, kArmed, kRunning, kDone };

  std::uint8_t in = 0, q = 0, m = 0, state = kIdle;
  std::int64_t pt = 0, et = 0, start = 0;

  /// The time since the start has run to PT; ET follows it. A clock before the start counts as no time.
  bool has_run_out(core::TimeNs now) noexcept {
    const std::int64_t whole = std::max<std::int64_t>(pt, 0);
    et = std::min(std::max<std::int64_t>(wrap_sub(now, start), 0), whole);
    return et == whole;
  }
  void begin(core::TimeNs now) noexcept {
    state = kRunning;
    start = now;
  }
  /// No time runs; ET becomes 0 with the state, and is not written again.
  void rest(State at, std::uint8_t output) noexcept {
    et = state == at ? et : 0;
    state = at;
    q = output;
  }
};

template <TypeId T>
inline constexpr Field kTimerFields[] = {
    {"IN", Direction::kInput, TypeId::kBool, offsetof(TimerPorts, in), "starts the time"},
    {"PT", Direction::kInput, T, offsetof(TimerPorts, pt), "preset time"},
    {"Q", Direction::kOutput, TypeId::kBool, offsetof(TimerPorts, q), "timer output"},
    {"ET", Direction::kOutput, T, offsetof(TimerPorts, et), "elapsed time, 0 .. PT"},
    {"STATE", Direction::kState, TypeId::kUsint, offsetof(TimerPorts, state), "0 idle, 1 armed, 2 running, 3 run out"},
    {"M", Direction::kState, TypeId::kBool, offsetof(TimerPorts, m), "IN at the last execution"},
    {"START", Direction::kState, T, offsetof(TimerPorts, start), "clock when the time began"}};

struct OnDelay {
  using Ports = TimerPorts;
  static constexpr std::string_view clause = kTimerClause;
  static constexpr std::string_view summary = "On-delay: Q when IN has been TRUE for PT.";
  static constexpr BlockExample examples[] = {{"Q follows IN late, and a short IN not at all", R"(
at      IN PT      | Q ET
T#0ms   0  T#100ms | 0 T#0ms
T#50ms  1  .       | 0 T#0ms
T#90ms  1  .       | 0 T#40ms
T#150ms 1  .       | 1 T#100ms
T#900ms 1  .       | 1 T#100ms
T#910ms 0  .       | 0 T#0ms
T#920ms 1  .       | 0 T#0ms
T#990ms 0  .       | 0 T#0ms
)"},
                                              {"PT changed while the time runs", R"(
at      IN PT      | Q ET
T#0ms   1  T#100ms | 0 T#0ms
T#40ms  1  T#50ms  | 0 T#40ms
T#60ms  1  .       | 1 T#50ms
T#70ms  1  T#200ms | 1 T#50ms
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    p.m = p.in;
    if (p.in == 0) return p.rest(Ports::kIdle, 0);
    if (p.state == Ports::kIdle) p.begin(context.now_ns);
    if (p.state == Ports::kRunning && p.has_run_out(context.now_ns)) {
      p.state = Ports::kDone;
      p.q = 1;
    }
  }
};

struct OffDelay {
  using Ports = TimerPorts;
  static constexpr std::string_view clause = kTimerClause;
  static constexpr std::string_view summary = "Off-delay: Q with IN, and for PT after it.";
  static constexpr BlockExample examples[] = {{"Q outlasts IN; IN again starts the time anew", R"(
at      IN PT      | Q ET
T#0ms   1  T#100ms | 1 T#0ms
T#50ms  0  .       | 1 T#0ms
T#90ms  0  .       | 1 T#40ms
T#100ms 1  .       | 1 T#0ms
T#110ms 0  .       | 1 T#0ms
T#209ms 0  .       | 1 T#99ms
T#210ms 0  .       | 0 T#100ms
T#900ms 0  .       | 0 T#100ms
)"},
                                              {"Never TRUE, never timed", R"(
at      IN PT      | Q ET
T#0ms   0  T#100ms | 0 T#0ms
T#500ms 0  .       | 0 T#0ms
)"}};
  /// It waits for IN in the same state whether the time has run out or never ran.
  static void step(Ports& p, const StepContext& context) noexcept {
    p.m = p.in;
    if (p.in != 0) return p.rest(Ports::kArmed, 1);
    if (p.state == Ports::kArmed) p.begin(context.now_ns);
    if (p.state == Ports::kRunning && p.has_run_out(context.now_ns)) {
      p.state = Ports::kIdle;
      p.q = 0;
    }
  }
};

struct Pulse {
  using Ports = TimerPorts;
  static constexpr std::string_view clause = kTimerClause;
  static constexpr std::string_view summary =
      "Pulse: Q for PT from a rising edge of IN on, whatever IN does meanwhile.";
  static constexpr BlockExample examples[] = {{"A pulse of PT for each edge, but none while one runs", R"(
at      IN PT      | Q ET
T#0ms   0  T#100ms | 0 T#0ms
T#10ms  1  .       | 1 T#0ms
T#20ms  0  .       | 1 T#10ms
T#30ms  1  .       | 1 T#20ms
T#109ms 1  .       | 1 T#99ms
T#110ms 1  .       | 0 T#100ms
T#500ms 1  .       | 0 T#100ms
T#510ms 0  .       | 0 T#0ms
T#520ms 1  .       | 1 T#0ms
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    // Bytes one by one: who just wrote one of them would have to be waited for to read all of them.
    const std::uint8_t in = p.in;
    std::uint8_t state = p.state;
    if (in != 0 && p.m == 0 && state != Ports::kRunning) {
      p.begin(context.now_ns);
      state = Ports::kRunning;
    }
    p.m = in;
    if (state == Ports::kRunning) {
      const bool over = p.has_run_out(context.now_ns);
      p.q = !over;
      if (!over) return;
      p.state = state = Ports::kDone;
    }
    if (state == Ports::kDone && in == 0) {
      p.state = Ports::kIdle;
      p.et = 0;
    }
  }
};

#define PLC_TIMER(Row, Base, iec, T)                                             \
  struct Row : Base {                                                            \
    static constexpr std::string_view name = iec;                                \
    static constexpr std::span<const Field> fields = kTimerFields<TypeId::k##T>; \
  };
/// Overloaded for TIME and LTIME: both count nanoseconds, so one instance serves either.
#define PLC_OVERLOADED_TIMER(Row, Base, iec)   \
  PLC_TIMER(Row##OfTime, Base, iec, Time)      \
  struct Row : Row##OfTime {                   \
    static constexpr bool any_duration = true; \
  };
PLC_OVERLOADED_TIMER(Tp, Pulse, "TP")
PLC_TIMER(TpTime, Pulse, "TP_TIME", Time)
PLC_TIMER(TpLtime, Pulse, "TP_LTIME", Ltime)
PLC_OVERLOADED_TIMER(Ton, OnDelay, "TON")
PLC_TIMER(TonTime, OnDelay, "TON_TIME", Time)
PLC_TIMER(TonLtime, OnDelay, "TON_LTIME", Ltime)
PLC_OVERLOADED_TIMER(Tof, OffDelay, "TOF")
PLC_TIMER(TofTime, OffDelay, "TOF_TIME", Time)
PLC_TIMER(TofLtime, OffDelay, "TOF_LTIME", Ltime)
#undef PLC_OVERLOADED_TIMER
#undef PLC_TIMER

using TimerRows = Rows<Tp, TpTime, TpLtime, Ton, TonTime, TonLtime, Tof, TofTime, TofLtime>;

}  // namespace plc::stdlib::fb
