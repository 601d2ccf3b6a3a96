// PID in a closed loop with a simulated plant: settling, limits, windup, changes of mode, jitter, pins without a value.
// The plot in docs/guides/pid.md comes from here: PLC_GOLDEN_UPDATE=1 build/release/tests/test_stdlib
// --gtest_filter='PidLoop.PlotOfTheGuide' writes it.
#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <limits>
#include <random>
#include <vector>

#include "tests/support/golden.h"
#include "tests/support/svg_plot.h"
#include "tests/unit/stdlib/block_table.h"

namespace plc::test {
namespace {

/// An oven: first order with dead time. 1 % of heating is 1 degree above the room in the end.
class Oven {
 public:
  double room = 20;

  [[nodiscard]] double temperature() const { return temperature_; }
  /// `seconds` with `heating` in percent, in steps of 10 ms.
  void run(double heating, double seconds) {
    constexpr double kStep = 0.010, kTimeConstant = 30;
    for (rest_ += seconds; rest_ >= kStep / 2; rest_ -= kStep) {
      in_the_pipe_.push_back(heating);
      const double arrives = in_the_pipe_.front();
      in_the_pipe_.pop_front();
      temperature_ += (room + arrives - temperature_) * kStep / kTimeConstant;
    }
  }

 private:
  static constexpr std::size_t kDeadSteps = 300;  // 3 s

  double temperature_ = 20, rest_ = 0;
  std::deque<double> in_the_pipe_ = std::deque<double>(kDeadSteps, 0.0);
};

struct Sample {
  double at, sp, pv, out;
};

/// Oven and controller, tuned for a closed loop about as fast as the dead time allows (SIMC: Kc = 5 %/K, Ti = 24 s).
class Loop {
 public:
  Oven oven;
  Instance pid{"PID"};
  double sp = 60, time = 0;
  std::vector<Sample> log{};

  Loop() {
    // More heating raises PV, so KP is below 0: the standard's error is PV - SP.
    pid.set_real("KP", -5), pid.set_real("TR", 24), pid.set_real("XMIN", 0), pid.set_real("XMAX", 100);
    pid.set("AUTO", 1);
  }
  double out() { return pid.real("XOUT"); }
  /// One cycle, and then `seconds` in which the plant has its output.
  void cycle(double seconds = 0.1) {
    pid.set_real("PV", oven.temperature()), pid.set_real("SP", sp);
    pid.step_ns(std::llround(time * 1e9));
    log.push_back({time, sp, oven.temperature(), out()});
    oven.run(out(), seconds);
    time += seconds;
  }
  void run(double seconds) {
    for (const double end = time + seconds - 1e-6; time < end;) cycle();
  }
  [[nodiscard]] double highest_pv(double from) const {
    double highest = -1e9;
    for (const Sample& s : log) highest = s.at >= from ? std::max(highest, s.pv) : highest;
    return highest;
  }
};

TEST(PidLoop, SettlesWithoutRemainingErrorAndHardlyOvershoots) {
  Loop loop;
  loop.run(300);
  EXPECT_NEAR(loop.oven.temperature(), 60, 0.1);
  EXPECT_NEAR(loop.out(), 40, 0.5);
  EXPECT_LT(loop.highest_pv(0), 62);
  loop.oven.room = 10;
  loop.run(300);
  EXPECT_NEAR(loop.oven.temperature(), 60, 0.1) << "the colder room is made up for";
  EXPECT_NEAR(loop.out(), 50, 0.5);
}

TEST(PidLoop, OutputStaysWithinItsLimits) {
  Loop loop;
  loop.pid.set_real("XMIN", 10), loop.pid.set_real("XMAX", 70), loop.pid.set_real("TD", 1);
  for (const double sp : {60.0, 20.0, 500.0, -500.0, 60.0}) {
    loop.sp = sp;
    loop.run(50);
  }
  double least = 1e9, most = -1e9;
  for (const Sample& s : loop.log) least = std::min(least, s.out), most = std::max(most, s.out);
  EXPECT_EQ(least, 10);
  EXPECT_EQ(most, 70);
}

TEST(PidLoop, NoLimitsWhereXminIsNotBelowXmax) {
  for (const double limit : {0.0, 50.0, -1e30}) {
    Loop loop;
    loop.pid.set_real("XMIN", 50), loop.pid.set_real("XMAX", limit);
    loop.cycle();
    EXPECT_NEAR(loop.out(), 200, 1e-3);
  }
  Loop loop;
  loop.pid.set_real("XMAX", std::numeric_limits<double>::infinity());
  loop.cycle();
  EXPECT_NEAR(loop.out(), 200, 1e-3) << "a limit on one side";
}

/// The same loop with an integral that nothing stops, held only within the limits after it.
struct Windup {
  Oven oven{};
  double integral = 0, out = 0, highest = -1e9;
  void run(double sp, double seconds) {
    highest = -1e9;
    for (double t = 0; t < seconds; t += 0.1) {
      const double error = sp - oven.temperature();
      integral += 5 * error * 0.1 / 24;
      out = std::clamp(5 * error + integral, 0.0, 100.0);
      oven.run(out, 0.1);
      highest = std::max(highest, oven.temperature());
    }
  }
};
TEST(PidLoop, DoesNotWindUpAtALimit) {
  // 150 degrees cannot be reached; after two minutes the operator gives in.
  Loop loop;
  Windup windup;
  loop.sp = 150, loop.run(120), windup.run(150, 120);
  EXPECT_EQ(loop.out(), 100);
  const double from = loop.time;
  loop.sp = 110, loop.run(1), windup.run(110, 1);
  EXPECT_LT(loop.out(), 100) << "leaves the limit at once";
  EXPECT_EQ(windup.out, 100) << "the plant must be one that shows windup";
  loop.run(300), windup.run(110, 300);
  EXPECT_LT(loop.highest_pv(from + 60), 111);
  EXPECT_GT(windup.highest, 115);
  EXPECT_NEAR(loop.oven.temperature(), 110, 0.2);
}

TEST(PidLoop, ManualToAutomaticGoesOnWhereItWas) {
  Loop loop;
  loop.pid.set("AUTO", 0), loop.pid.set_real("X0", 33);
  loop.run(60);
  EXPECT_EQ(loop.out(), 33);
  loop.pid.set("AUTO", 1);
  loop.cycle();
  EXPECT_NEAR(loop.out(), 33, 1e-4) << "in spite of an error of " << 60 - loop.oven.temperature();
  double before = loop.out();
  for (int i = 0; i < 100; ++i) {
    loop.cycle();
    // One cycle's action: what the integral part grows, and P and D make of the change of PV.
    const Sample &now = loop.log.back(), &last = loop.log[loop.log.size() - 2];
    const double action = 5 * std::fabs(now.sp - now.pv) * 0.1 / 24 + 5 * std::fabs(now.pv - last.pv);
    EXPECT_LE(std::fabs(loop.out() - before), action + 1e-3) << now.at;
    before = loop.out();
  }
}

TEST(PidLoop, ManualToAutomaticIsSmoothWhilePvMovesWithTd) {
  Loop loop;
  loop.pid.set_real("TD", 3);
  loop.pid.set("AUTO", 0), loop.pid.set_real("X0", 80);
  loop.run(10);  // heating up: PV rises by about 1.5 degrees a second
  loop.pid.set("AUTO", 1);
  double before = loop.out();
  for (int i = 0; i < 5; ++i) {
    loop.cycle();
    EXPECT_LT(std::fabs(loop.out() - before), 2.5) << "the derivative part alone is 20 and more, in scan " << i;
    before = loop.out();
  }
}

TEST(PidLoop, AutomaticToManualIsWhatX0IsAndWithoutAJumpWhereX0FollowsXout) {
  Loop loop;
  for (int i = 0; i < 600; ++i) {
    loop.cycle();
    loop.pid.set_real("X0", loop.out());  // as the guide draws it: X0 := XOUT while AUTO
  }
  const double before = loop.out();
  loop.pid.set("AUTO", 0), loop.cycle();
  EXPECT_EQ(loop.out(), before);
  loop.pid.set_real("X0", 5), loop.cycle();
  EXPECT_EQ(loop.out(), 5);
  loop.pid.set_real("X0", 500), loop.cycle();
  EXPECT_EQ(loop.out(), 100) << "limits hold in manual";
  loop.pid.set_real("X0", std::nan("")), loop.cycle();
  EXPECT_EQ(loop.out(), 100);
  loop.pid.set_real("X0", 7), loop.pid.set_real("KP", std::nan("")), loop.cycle();
  EXPECT_EQ(loop.out(), 7) << "in manual nothing but X0 and the limits counts";
}

TEST(PidLoop, WithoutIntegralPartItIsProportional) {
  for (const double tr : {0.0, -3.0}) {
    Loop loop;
    loop.pid.set_real("TR", tr);
    loop.run(300);
    // 5 * (60 - T) = T - 20 in the end.
    EXPECT_NEAR(loop.oven.temperature(), 320.0 / 6, 0.1);
    EXPECT_NEAR(loop.out(), 5 * (60 - loop.oven.temperature()), 0.1);
  }
}

TEST(PidLoop, FirstScanHasNoDerivativeAndNoIntegralPart) {
  Instance pid("PID");
  pid.set("AUTO", 1), pid.set_real("KP", 2), pid.set_real("TR", 1e-30), pid.set_real("TD", 1e6);
  pid.set_real("PV", 30), pid.set_real("SP", 20);
  pid.step(123'456);
  EXPECT_EQ(pid.real("XOUT"), 20);
  pid.step(123'456);
  EXPECT_EQ(pid.real("XOUT"), 20) << "no time has passed";
}

TEST(PidLoop, DerivativeDampsAndDoesNotKick) {
  Loop loop;
  loop.pid.set_real("TD", 2), loop.pid.set_real("XMAX", 0);
  loop.run(300);
  const double before = loop.out();
  loop.sp = 61, loop.cycle();
  EXPECT_NEAR(loop.out() - before, 5, 0.1) << "a step of the set-point: KP times the step, no more";
}

TEST(PidLoop, JitterOfTheCyclesHardlyShows) {
  Loop even, uneven;
  even.pid.set_real("TD", 1), uneven.pid.set_real("TD", 1);
  std::mt19937 random(11);
  even.run(400);
  while (uneven.time < 400) uneven.cycle(0.01 * static_cast<double>(2 + random() % 17));  // 20 .. 180 ms
  std::size_t i = 0;
  for (const Sample& s : uneven.log) {
    while (i + 1 < even.log.size() && even.log[i + 1].at <= s.at) ++i;
    ASSERT_NEAR(s.pv, even.log[i].pv, 0.5) << s.at;
  }
}

TEST(PidLoop, SensorThatBreaksHoldsTheOutputAndComesBackWithoutAJump) {
  Loop loop;
  loop.run(300);
  const double before = loop.out();
  const double pv = loop.oven.temperature();
  for (int i = 0; i < 50; ++i) {
    loop.pid.set_real("PV", i % 2 != 0 ? std::nan("") : std::numeric_limits<double>::infinity());
    loop.time += 0.1;
    loop.pid.step_ns(std::llround(loop.time * 1e9));
    EXPECT_EQ(loop.out(), before);
  }
  EXPECT_EQ(loop.oven.temperature(), pv);
  loop.cycle();
  EXPECT_NEAR(loop.out(), before, 0.1);
}

TEST(PidLoop, PlotOfTheGuide) {
  Loop loop;
  loop.sp = 20;
  loop.run(10);
  loop.sp = 60, loop.run(140);
  loop.oven.room = 10, loop.run(120);
  loop.pid.set("AUTO", 0), loop.pid.set_real("X0", loop.out()), loop.run(15);
  loop.pid.set_real("X0", 70), loop.run(45);
  loop.pid.set("AUTO", 1), loop.run(90);
  loop.sp = 150, loop.run(90);
  loop.sp = 60, loop.run(90);

  PlotSeries sp{"SP", kGrey, true}, pv{"PV", kBlue}, out{"XOUT", kOrange};
  for (std::size_t i = 0; i < loop.log.size(); i += 10) {
    const Sample& s = loop.log[i];
    sp.points.emplace_back(s.at, s.sp), pv.points.emplace_back(s.at, s.pv), out.points.emplace_back(s.at, s.out);
  }
  const Plot plot{"PID with an oven: KP = -5, TR = 24 s, XMIN = 0, XMAX = 100",
                  "time in s",
                  loop.time,
                  60,
                  {{"temperature in degrees", 0, 160, 20, {sp, pv}}, {"heating in %", 0, 100, 20, {out}}},
                  {{10, 150, "step of SP"}, {270, 330, "manual"}, {420, 510, "SP out of reach"}}};
  expect_golden("docs/guides/pid.svg", svg_of(plot));
}

}  // namespace
}  // namespace plc::test
