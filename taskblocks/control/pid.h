// PID_2DOF: PID controller with set-point weights, feedforward, two kinds of anti-windup, tracking and autotune.
//
// The pins that the PID of annex F has too are called as there (docs/guides/pid.md): AUTO, PV, SP, X0, KP, TR, TD,
// XMIN, XMAX, XOUT. What differs is the sense of the error, SP - PV, for which DIRECT stands in place of KP's sign.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "picard/taskblock.h"
#include "taskblocks/control/pid_law.h"
#include "taskblocks/control/relay_tuner.h"
#include "taskblocks/elapsed.h"

namespace plc::blocks {

class Pid final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "PID_2DOF",
      .group = "Control",
      .summary = "PID controller with two degrees of freedom, feedforward, anti-windup, tracking and autotune.",
      .details =
          "The law, with s the derivative:\n\n"
          "`XOUT = KP * ((B*SP - PV) + 1/(TR*s) * (SP - PV) + TD*s/(1 + s*TD/N) * (C*SP - PV)) + FF`\n\n"
          "held within XMIN .. XMAX. With DIRECT the three differences have the other sign: more PV gives more XOUT, "
          "as "
          "cooling needs it. KP is never below 0. Pins that the PID of the standard library has too mean the same "
          "here; "
          "there the sign of KP says what DIRECT says here. Time between executions is measured, so tasks without a "
          "period may have a controller.\n\n"
          "**Who gives XOUT.** TRACK first: XOUT is XTRACK. Then manual, with AUTO FALSE: XOUT is X0. Then a tuning "
          "that "
          "is running. Else the controller. When it takes over, XOUT goes on where it is, if TR > 0: the integral part "
          "takes up the difference. Changes of KP, TR, TD and B while it controls make no jump either. In a cascade "
          "the "
          "outer controller has TRACK := NOT AUTO of the inner one and XTRACK := PV of the inner one.\n\n"
          "**Limits.** Where XMIN is not below XMAX (both 0 when not connected) there are none. ANTIWINDUP = 0: the "
          "integral part grows toward a limit as far as XOUT does. 1: back-calculation, the integral part moves by "
          "(XOUT - sum of the parts) / TT per second. 2: the same with XACT, what the actuator did with the last XOUT: "
          "for "
          "valves with a position, and for controllers of which a selector takes one. TT of 0 or less stands for "
          "sqrt(TR * TD), or TR where TD is 0.\n\n"
          "**Autotune.** While the loop is closed and at rest, let TUNE become TRUE and stay so. XOUT jumps by "
          "TUNE_STEP to both sides of where it was, whenever PV passes SP by TUNE_NOISE; when two oscillations in a "
          "row "
          "are alike within 2 %, KU = 4 * TUNE_STEP / (pi * sqrt(amplitude^2 - TUNE_NOISE^2)) and TU, their period, "
          "are "
          "there, and KP_TUNED, TR_TUNED, TD_TUNED follow from them by TUNE_RULE: 0, 1, 2 Ziegler-Nichols PID, PI, P; "
          "3, 4 "
          "Tyreus-Luyben PID, PI; 5 some, 6 no overshoot. They are suggestions: nothing changes before they are wired "
          "or "
          "written to KP, TR, TD. The period of the task should be a twentieth of TU or less. SP is that of the start. "
          "TUNE_STATE: 0 never tuned, 1 tuning, 2 done, 3 stopped by TUNE, AUTO or TRACK, 4 no even oscillation within "
          "TUNE_TIME, 5 TUNE_STEP is 0 or does not fit between the limits, 6 bad input. However it ends, XOUT goes on "
          "from the middle of the relay's swing.\n\n"
          "**Bad input.** While a pin that the present mode needs is NaN or infinite, a limit is NaN, or KP is below "
          "0, "
          "XOUT and the integral part stay as they are and BAD is TRUE; that time does not count for the integral.\n\n"
          "**First cycle.** No derivative and no integral part: in automatic XOUT starts at KP * (B*SP - PV) + FF."};

  picard::Input<bool> automatic{this, "AUTO", "the loop is closed; FALSE: XOUT is X0"};
  picard::Input<double> pv{this, "PV", "process value"};
  picard::Input<double> sp{this, "SP", "set-point, in the unit of PV"};
  picard::Input<double> x0{this, "X0", "output in manual"};
  picard::Input<double> kp{this, "KP", "gain, output per unit of the error", {.lowest = 0, .initial = "1.0"}};
  picard::Input<double> tr{this, "TR", "reset time; 0 or less: no integral part", {.unit = "s"}};
  picard::Input<double> td{this, "TD", "derivative time; 0 or less: no derivative part", {.unit = "s"}};
  picard::Input<double> n{
      this, "N", "the derivative is filtered with TD / N; 0 or less: it is not filtered", {.initial = "10.0"}};
  picard::Input<double> b{this, "B", "share of a change of SP that the proportional part sees", {.initial = "1.0"}};
  picard::Input<double> c{this, "C", "share of a change of SP that the derivative part sees"};
  picard::Input<double> ff{this, "FF", "feedforward, added to the output"};
  picard::Input<double> xmin{this, "XMIN", "least output; no limits where XMIN >= XMAX"};
  picard::Input<double> xmax{this, "XMAX", "greatest output"};
  picard::Input<bool> track{this, "TRACK", "XOUT is XTRACK, in manual too"};
  picard::Input<double> xtrack{this, "XTRACK", "output while TRACK"};
  picard::Input<double> xact{this, "XACT", "what the actuator did with the last XOUT; for ANTIWINDUP = 2"};
  picard::Input<double> tt{
      this, "TT", "tracking time of the back-calculation; 0 or less: from TR and TD", {.unit = "s"}};
  picard::Input<bool> tune{this, "TUNE", "a rising edge starts the autotune, FALSE stops it"};
  picard::Input<double> tune_step{this, "TUNE_STEP", "jump of XOUT to each side while tuning", {.lowest = 0}};
  picard::Input<double> tune_noise{
      this, "TUNE_NOISE", "PV must pass SP by this: somewhat more than its noise", {.lowest = 0}};

  picard::Config<bool> direct{this, "DIRECT", "more PV gives more XOUT (cooling); FALSE: less (heating)"};
  picard::Config<std::int16_t> anti_windup{
      this, "ANTIWINDUP", "0 clamping, 1 back-calculation, 2 with XACT", {.lowest = 0, .highest = 2}};
  picard::Config<std::int16_t> tune_rule{
      this, "TUNE_RULE", "how gains follow from KU and TU", {.lowest = 0, .highest = kTuningRules - 1, .initial = "4"}};
  picard::Config<double> tune_time{
      this, "TUNE_TIME", "the autotune gives up after this", {.unit = "s", .lowest = 1e-3, .initial = "3600.0"}};

  picard::Output<double> xout{this, "XOUT", "output to the process"};
  picard::Output<double> error{this, "E", "SP - PV; PV - SP with DIRECT"};
  picard::Output<double> xp{this, "XP", "proportional part of XOUT"};
  picard::Output<double> xi{this, "XI", "integral part of XOUT"};
  picard::Output<double> xd{this, "XD", "derivative part of XOUT"};
  picard::Output<bool> limited{this, "LIMITED", "XOUT is at a limit"};
  picard::Output<bool> bad{this, "BAD", "XOUT is held because an input is bad"};
  picard::Output<std::int16_t> tune_state{this, "TUNE_STATE", "0 never, 1 tuning, 2 done, 3 to 6: failed, and why"};
  picard::Output<double> ku{this, "KU", "ultimate gain that the autotune found"};
  picard::Output<double> tu{this, "TU", "ultimate period that the autotune found", {.unit = "s"}};
  picard::Output<double> kp_tuned{this, "KP_TUNED", "suggestion for KP"};
  picard::Output<double> tr_tuned{this, "TR_TUNED", "suggestion for TR; 0: no integral part", {.unit = "s"}};
  picard::Output<double> td_tuned{this, "TD_TUNED", "suggestion for TD; 0: no derivative part", {.unit = "s"}};

  void ready() override { law_ = PidLaw(direct, static_cast<AntiWindup>(anti_windup.get())); }

  void fire() override {
    const double seconds = elapsed_.until(now());
    const bool tune_rises = tune && !tune_before_;
    tune_before_ = tune;

    const PidSignals signals{pv, sp, ff};
    const PidGains gains{kp, tr, td, n, b, c};
    const bool measured = finite(pv, sp, td, n, c);
    if (measured) {
      law_.sample(signals, gains, seconds);
      error = law_.error(signals);
    } else {
      law_.skip_sample();
    }

    const std::optional<PidLimits> limits = limits_now();
    const bool controls = automatic && !track;
    if (!controls || !tune) end_tuning(RelayTuner::State::kStopped);
    if (!controls) {
      bad = !(limits && give(track ? xtrack : x0, *limits));
      law_.stand_at(xout);
    } else {
      bad = !(limits && measured && control(signals, gains, *limits, seconds, tune_rises));
      if (bad) end_tuning(RelayTuner::State::kBadInput);
    }
    limited = limits && (xout >= limits->high || xout <= limits->low);
    show();
  }

 private:
  template <class... V>
  static bool finite(const V&... values) {
    return (std::isfinite(static_cast<double>(values)) && ...);
  }

  /// Nothing while one of them is NaN: the limits are then not known.
  [[nodiscard]] std::optional<PidLimits> limits_now() const {
    if (std::isnan(xmin) || std::isnan(xmax)) return {};
    return xmin < xmax ? PidLimits{xmin, xmax} : PidLimits{};
  }

  /// XOUT from somewhere else. False, and nothing changed, when that is no number; so do the next ones.
  bool give(double value, const PidLimits& limits) {
    if (!std::isfinite(value)) return false;
    xout = std::clamp(value, limits.low, limits.high);
    return true;
  }

  bool control(const PidSignals& signals, const PidGains& gains, const PidLimits& limits, double seconds,
               bool tune_rises) {
    if (tuning_) {
      const double output = tuner_.step(pv, seconds);
      if (tuner_.running()) return give(output, limits);
      end_tuning(tuner_.state());
    }
    if (!finite(kp, tr, b, ff) || kp < 0 || std::isnan(tt)) return false;
    if (anti_windup == static_cast<std::int16_t>(AntiWindup::kActuator) && !finite(xact)) return false;
    const std::optional<double> output = law_.step(signals, gains, limits, {tt, xact}, seconds);
    if (!output) return false;
    xout = *output;
    if (tune_rises) start_tuning(limits);
    return true;
  }

  void start_tuning(const PidLimits& limits) {
    tuner_.start({.setpoint = sp,
                  .bias = xout,
                  .step = tune_step,
                  .hysteresis = tune_noise,
                  .low = limits.low,
                  .high = limits.high,
                  .timeout = tune_time,
                  .direct = direct});
    tuning_ = tuner_.running();
  }

  /// What gives XOUT next begins in the middle of the relay's swing.
  void end_tuning(RelayTuner::State why) {
    if (!tuning_) return;
    tuning_ = false;
    tuner_.stop(why);
    xout = tuner_.bias();
    law_.stand_at(xout);
  }

  void show() {
    xp = law_.proportional();
    xi = law_.integral();
    xd = law_.derivative();
    tune_state = static_cast<std::int16_t>(tuner_.state());
    ku = tuner_.ultimate_gain();
    tu = tuner_.ultimate_period();
    const TunedGains gains = tuned_gains(static_cast<TuningRule>(tune_rule.get()), ku, tu);
    kp_tuned = gains.gain;
    tr_tuned = gains.reset;
    td_tuned = gains.rate;
  }

  Elapsed elapsed_;
  PidLaw law_;
  RelayTuner tuner_;
  bool tuning_ = false;
  bool tune_before_ = false;
};

}  // namespace plc::blocks
