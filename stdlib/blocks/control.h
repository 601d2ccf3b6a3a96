// Blocks: closed loops and what they are made of (IEC 61131-3:2003, annex F): INTEGRAL, DERIVATIVE, PID, RAMP,
// HYSTERESIS.
//
// Pins are those of the annex, with more after them, so that drawings made for Beremiz, OpenPLC and the like fit.
// measured.h has the rules for time and for what is no number; docs/guides/pid.md says how to use PID.
#pragma once

#include <cstddef>

#include "stdlib/blocks/measured.h"

namespace plc::stdlib::fb {

struct Integral {
  struct Ports {
    std::uint8_t run = 0, r1 = 0, q = 0;
    float xin = 0, x0 = 0, xout = 0;
    std::int64_t cycle = 0;
    double sum = 0;
    Stopwatch watch;
  };
  static constexpr std::string_view name = "INTEGRAL";
  static constexpr std::string_view clause = kAnnexF;
  static constexpr std::string_view summary =
      "XOUT sums up XIN over the time in seconds while RUN; R1 sets it to X0. The time without a call counts, too.";
  static constexpr Field fields[] = {
      {"RUN", Direction::kInput, TypeId::kBool, offsetof(Ports, run), "integrates; FALSE holds XOUT"},
      {"R1", Direction::kInput, TypeId::kBool, offsetof(Ports, r1), "sets XOUT to X0, dominant"},
      {"XIN", Direction::kInput, TypeId::kReal, offsetof(Ports, xin), "what is integrated"},
      {"X0", Direction::kInput, TypeId::kReal, offsetof(Ports, x0), "value with R1"},
      {"CYCLE", Direction::kInput, TypeId::kTime, offsetof(Ports, cycle), kCycleSummary},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "NOT R1"},
      {"XOUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, xout), "integral"},
      {"SUM", Direction::kState, TypeId::kLreal, offsetof(Ports, sum), "integral, with all its digits"},
      {"LAST", Direction::kState, TypeId::kLtime, offsetof(Ports, watch.last), "clock at the last execution"},
      {"STARTED", Direction::kState, TypeId::kBool, offsetof(Ports, watch.started), "LAST is valid"}};
  static constexpr BlockExample examples[] = {{"XIN in litres per second gives litres, however long the cycles are",
                                               R"(
at       RUN R1 XIN  X0  | Q XOUT
T#0s     1   0  2.0  0.0 | 1 0.0
T#1s     .   .  .    .   | 1 2.0
T#1s500ms .  .  .    .   | 1 3.0
T#2s     .   .  -1.0 .   | 1 2.5
T#3s     0   .  .    .   | 1 2.5
T#4s     1   1  .    10.0 | 0 10.0
T#5s     .   0  .    .   | 1 9.0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    const double elapsed = p.watch.lap(context.now_ns);
    p.q = p.r1 ^ 1u;
    if (p.r1 != 0) {
      if (all_finite(p.x0)) p.sum = p.x0;
    } else if (p.run != 0 && all_finite(p.xin)) {
      p.sum = within_real(p.sum + static_cast<double>(p.xin) * elapsed);
    }
    p.xout = to_real(p.sum);
  }
};

struct Derivative {
  struct Ports {
    std::uint8_t run = 0;
    float xin = 0, xout = 0;
    std::int64_t cycle = 0;
    Slope slope;
  };
  static constexpr std::string_view name = "DERIVATIVE";
  static constexpr std::string_view clause = kAnnexF;
  static constexpr std::string_view summary =
      "XOUT is the change of XIN per second while RUN: the slope of the line through the last four samples.";
  static constexpr Field fields[] = {
      {"RUN", Direction::kInput, TypeId::kBool, offsetof(Ports, run), "FALSE sets XOUT to 0 and begins anew"},
      {"XIN", Direction::kInput, TypeId::kReal, offsetof(Ports, xin), "what is differentiated"},
      {"CYCLE", Direction::kInput, TypeId::kTime, offsetof(Ports, cycle), kCycleSummary},
      {"XOUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, xout), "slope, per second"},
      {"X1", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[0]), "last sample"},
      {"X2", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[1]), "the one before"},
      {"X3", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[2]), "the one before that"},
      {"T1", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[0]), "clock at X1"},
      {"T2", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[1]), "clock at X2"},
      {"T3", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[2]), "clock at X3"},
      {"SLOPE", Direction::kState, TypeId::kLreal, offsetof(Ports, slope.value), "slope, with all its digits"},
      {"COUNT", Direction::kState, TypeId::kUsint, offsetof(Ports, slope.count), "samples kept, 0 .. 3"}};
  static constexpr BlockExample examples[] = {
      {"2 per second, sampled at uneven times", R"(
at       RUN XIN | XOUT
T#0ms    1   5.0 | 0.0
T#100ms  .   5.2 | 2.0
T#150ms  .   5.3 | 2.0
T#400ms  .   5.8 | 2.0
T#500ms  0   9.0 | 0.0
)"},
      {"A step passes within four samples: (3 - 0 + 0 - 0) / (10 * 0.1 s) at first", R"(
at       RUN XIN | XOUT
T#0ms    1   0.0 | 0.0
T#100ms  .   .   | 0.0
T#200ms  .   .   | 0.0
T#300ms  .   1.0 | 3.0
T#400ms  .   .   | 4.0
T#500ms  .   .   | 3.0
T#600ms  .   .   | 0.0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    if (p.run == 0) {
      p.slope.forget();
      p.xout = 0;
    } else if (all_finite(p.xin)) {
      p.xout = to_real(p.slope.take(p.xin, context.now_ns));
    }
  }
};

/// As in annex F, with limits. What is different, and why: the derivative is that of PV, so that a step of SP makes no
/// kick; XOUT in manual is X0, not KP * X0; the integral part stops at a limit.
struct Pid {
  enum Mode : std::uint8_t { kFresh, kManual, kAutomatic };

  struct Ports {
    std::uint8_t automatic = 0, mode = kFresh;
    float pv = 0, sp = 0, x0 = 0, kp = 1, tr = 0, td = 0;
    std::int64_t cycle = 0;
    float xmin = 0, xmax = 0, xout = 0;
    double integral = 0;
    Slope slope;
    Stopwatch watch;
  };
  static constexpr std::string_view name = "PID";
  static constexpr std::string_view clause = kAnnexF;
  static constexpr std::string_view summary =
      "PID controller: XOUT = KP * (E + 1/TR * integral of E + TD * change of PV), E = PV - SP, held within XMIN .. "
      "XMAX. "
      "A KP above 0 cools, one below 0 heats. From manual to automatic XOUT goes on where it was, if TR > 0.";
  static constexpr Field fields[] = {
      {"AUTO", Direction::kInput, TypeId::kBool, offsetof(Ports, automatic), "automatic; FALSE: XOUT is X0"},
      {"PV", Direction::kInput, TypeId::kReal, offsetof(Ports, pv), "process value"},
      {"SP", Direction::kInput, TypeId::kReal, offsetof(Ports, sp), "set-point"},
      {"X0", Direction::kInput, TypeId::kReal, offsetof(Ports, x0), "output in manual"},
      {"KP", Direction::kInput, TypeId::kReal, offsetof(Ports, kp),
       "gain, 1.0 at first; below 0 where more output raises PV"},
      {"TR", Direction::kInput, TypeId::kReal, offsetof(Ports, tr), "reset time in s; 0 or less: no integral part"},
      {"TD", Direction::kInput, TypeId::kReal, offsetof(Ports, td), "derivative time in s; 0 or less: no such part"},
      {"CYCLE", Direction::kInput, TypeId::kTime, offsetof(Ports, cycle), kCycleSummary},
      {"XMIN", Direction::kInput, TypeId::kReal, offsetof(Ports, xmin), "least output; no limits where XMIN >= XMAX"},
      {"XMAX", Direction::kInput, TypeId::kReal, offsetof(Ports, xmax), "greatest output"},
      {"XOUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, xout), "output to the process"},
      {"MODE", Direction::kState, TypeId::kUsint, offsetof(Ports, mode), "last: 0 fresh, 1 manual, 2 automatic"},
      {"INTEGRAL", Direction::kState, TypeId::kLreal, offsetof(Ports, integral), "integral part of XOUT"},
      {"X1", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[0]), "last PV"},
      {"X2", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[1]), "the one before"},
      {"X3", Direction::kState, TypeId::kReal, offsetof(Ports, slope.x[2]), "the one before that"},
      {"T1", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[0]), "clock at X1"},
      {"T2", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[1]), "clock at X2"},
      {"T3", Direction::kState, TypeId::kLtime, offsetof(Ports, slope.at[2]), "clock at X3"},
      {"SLOPE", Direction::kState, TypeId::kLreal, offsetof(Ports, slope.value), "change of PV per second"},
      {"COUNT", Direction::kState, TypeId::kUsint, offsetof(Ports, slope.count), "samples kept, 0 .. 3"},
      {"LAST", Direction::kState, TypeId::kLtime, offsetof(Ports, watch.last), "clock at the last execution"},
      {"STARTED", Direction::kState, TypeId::kBool, offsetof(Ports, watch.started), "LAST is valid"}};
  static constexpr BlockExample examples[] = {
      {"Proportional and integral: 2 * (10 + 10 * t / 5 s), held at 100 without winding up", R"(
at     AUTO PV   SP   KP  TR  XMIN XMAX  | XOUT
T#0s   1    60.0 50.0 2.0 5.0 0.0  100.0 | 20.0
T#1s   .    .    .    .   .   .    .     | 24.0
T#2s   .    .    .    .   .   .    .     | 28.0
T#60s  .    .    .    .   .   .    .     | 100.0
T#61s  .    49.0 .    .   .   .    .     | 77.6
)"},
      {"From manual to automatic without a jump", R"(
at     AUTO PV   SP   X0   KP  TR  | XOUT
T#0s   0    60.0 50.0 33.0 2.0 5.0 | 33.0
T#1s   1    .    .    .    .   .   | 33.0
T#2s   .    .    .    .    .   .   | 37.0
T#3s   0    .    .    12.5 .   .   | 12.5
)"},
      {"A step of the set-point does not reach the derivative part, one of the process does", R"(
at     AUTO PV   SP   KP  TD  | XOUT
T#0s   1    50.0 50.0 1.0 2.0 | 0.0
T#1s   .    .    40.0 .   .   | 10.0
T#2s   .    51.0 .    .   .   | 12.0
)"},
      {"A broken sensor holds the output", R"(
at     AUTO PV   SP   KP  TR  | XOUT
T#0s   1    60.0 50.0 1.0 10.0 | 10.0
T#1s   .    NaN  .    .   .   | 10.0
T#9s   .    .    .    .   .   | 10.0
T#10s  .    60.0 .    .   .   | 11.0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    const double elapsed = p.watch.lap(context.now_ns);
    if (std::isnan(p.xmin) || std::isnan(p.xmax)) return;
    // The ends of REAL where there are no limits: nothing becomes infinite, and the integral part stops there, too.
    const bool limited = p.xmin < p.xmax;
    const double low = limited ? within_real(p.xmin) : -kMostReal;
    const double high = limited ? within_real(p.xmax) : kMostReal;
    if (p.automatic == 0) {
      p.mode = kManual;
      // Sampled in manual too: the derivative part is there at the switch, and the integral part takes it up.
      if (all_finite(p.pv)) p.slope.take(p.pv, context.now_ns);
      if (all_finite(p.x0)) p.xout = to_real(std::clamp<double>(p.x0, low, high));
      return;
    }
    if (!all_finite(p.pv, p.sp, p.kp, p.tr, p.td)) return;
    const double kp = p.kp;
    const double error = static_cast<double>(p.pv) - static_cast<double>(p.sp);
    const double direct = kp * (error + std::max<double>(p.td, 0) * p.slope.take(p.pv, context.now_ns));
    if (!(p.tr > 0)) {
      p.integral = 0;
    } else if (p.mode == kManual) {
      p.integral = canonical(static_cast<double>(p.xout) - direct);
    } else if (p.mode == kAutomatic) {
      // It grows toward a limit as far as the output does, and no further: nothing has to unwind later.
      const double growth = kp * error * elapsed / static_cast<double>(p.tr);
      const double output = direct + p.integral;
      p.integral = canonical(p.integral + (growth > 0 ? std::min(growth, std::max(high - output, 0.0))
                                                      : std::max(growth, std::min(low - output, 0.0))));
    }
    p.mode = kAutomatic;
    p.xout = to_real(std::clamp(direct + p.integral, low, high));
  }
};

struct Ramp {
  struct Ports {
    std::uint8_t run = 0, busy = 0, m = 0;
    float x0 = 0, x1 = 0, xout = 0, xi = 0;
    std::int64_t tr = 0, cycle = 0, start = 0;
  };
  static constexpr std::string_view name = "RAMP";
  static constexpr std::string_view clause = kAnnexF;
  static constexpr std::string_view summary =
      "While RUN, XOUT goes from X0 to X1 in a straight line within TR, and stays with X1. Otherwise it is X0.";
  static constexpr Field fields[] = {
      {"RUN", Direction::kInput, TypeId::kBool, offsetof(Ports, run), "starts at its rising edge; FALSE: XOUT is X0"},
      {"X0", Direction::kInput, TypeId::kReal, offsetof(Ports, x0), "where the ramp begins"},
      {"X1", Direction::kInput, TypeId::kReal, offsetof(Ports, x1), "where it ends"},
      {"TR", Direction::kInput, TypeId::kTime, offsetof(Ports, tr), "how long it takes; 0 or less: XOUT is X1 at once"},
      {"CYCLE", Direction::kInput, TypeId::kTime, offsetof(Ports, cycle), kCycleSummary},
      {"BUSY", Direction::kOutput, TypeId::kBool, offsetof(Ports, busy), "on the way"},
      {"XOUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, xout), "value"},
      {"XI", Direction::kState, TypeId::kReal, offsetof(Ports, xi), "X0 when the ramp began"},
      {"START", Direction::kState, TypeId::kLtime, offsetof(Ports, start), "clock when it began"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "the ramp has begun"}};
  static constexpr BlockExample examples[] = {{"From 10 to 50 in 4 s, and back at once", R"(
at     RUN X0   X1   TR   | BUSY XOUT
T#0s   0   10.0 50.0 T#4s | 0    10.0
T#1s   1   .    .    .    | 1    10.0
T#2s   .   .    .    .    | 1    20.0
T#3s   .   .    .    .    | 1    30.0
T#5s   .   .    .    .    | 0    50.0
T#6s   .   .    60.0 .    | 0    60.0
T#7s   0   .    .    .    | 0    10.0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    if (p.run == 0) {
      p.m = 0;
      p.busy = 0;
      if (all_finite(p.x0)) p.xout = p.x0;
      return;
    }
    if (!all_finite(p.x0, p.x1)) return;
    if (p.m == 0) {
      p.m = 1;
      p.start = context.now_ns;
      p.xi = p.x0;
    }
    const std::int64_t passed = std::max<std::int64_t>(wrap_sub(context.now_ns, p.start), 0);
    p.busy = passed < p.tr;
    const double way = static_cast<double>(p.x1) - static_cast<double>(p.xi);
    const double share = p.busy != 0 ? static_cast<double>(passed) / static_cast<double>(p.tr) : 1.0;
    p.xout = p.busy != 0 ? to_real(static_cast<double>(p.xi) + way * share) : p.x1;
  }
};

struct Hysteresis {
  struct Ports {
    float xin1 = 0, xin2 = 0, eps = 0;
    std::uint8_t q = 0;
  };
  static constexpr std::string_view name = "HYSTERESIS";
  static constexpr std::string_view clause = kAnnexF;
  static constexpr std::string_view summary =
      "Q when XIN1 has gone above XIN2 + EPS, until it is below XIN2 - EPS. (The block of this name in CODESYS has "
      "other "
      "pins.)";
  static constexpr Field fields[] = {
      {"XIN1", Direction::kInput, TypeId::kReal, offsetof(Ports, xin1), "value"},
      {"XIN2", Direction::kInput, TypeId::kReal, offsetof(Ports, xin2), "what it is compared with"},
      {"EPS", Direction::kInput, TypeId::kReal, offsetof(Ports, eps), "half the width; below 0 it counts as 0"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "XIN1 is the greater"}};
  static constexpr BlockExample examples[] = {{"Between 18 and 22 nothing changes", R"(
at     XIN1 XIN2 EPS | Q
T#0s   19.0 20.0 2.0 | 0
T#1s   22.0 .    .   | 0
T#2s   22.5 .    .   | 1
T#3s   18.0 .    .   | 1
T#4s   17.5 .    .   | 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    if (!all_finite(p.xin1, p.xin2, p.eps)) return;
    const double above = static_cast<double>(p.xin1) - static_cast<double>(p.xin2);
    const double eps = std::max<double>(p.eps, 0);
    p.q = p.q != 0 ? above >= -eps : above > eps;
  }
};

using ControlRows = Rows<Integral, Derivative, Pid, Ramp, Hysteresis>;

}  // namespace plc::stdlib::fb
