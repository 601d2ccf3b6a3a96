// Autotune of PID_2DOF against relay oscillations that can be computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>

#include "taskblocks/control/relay_tuner.h"
#include "tests/unit/taskblocks/pid_loop.h"

namespace plc::blocks {
namespace {

/// K exp(-L s) / (T s + 1) with a dead time of whole samples.
struct DeadTime {
  FirstOrder lag;
  std::deque<double> line;
  void step(double u) {
    line.push_back(u);
    lag.step(line.front());
    line.pop_front();
  }
};

// The limit cycle of a relay and a first-order lag with dead time is known exactly: half a period is
// T ln(2 exp(L/T) - 1), the amplitude K d (1 - exp(-L/T)) (Astrom, Hagglund, "Advanced PID Control", 2006, 2.7).
TEST(RelayTuner, FirstOrderWithDeadTimeOscillatesAsComputed) {
  const double h = 0.001;
  const double constant = 2;
  const double dead = 1;
  DeadTime plant{{.gain = 3, .decay = std::exp(-h / constant)}, std::deque<double>(1000, 0.0)};
  RelayTuner tuner;
  tuner.start({.setpoint = 0, .bias = 0, .step = 0.5, .low = -10, .high = 10, .timeout = 1000});
  int steps = 0;
  for (; tuner.running() && steps < 1000000; ++steps) plant.step(tuner.step(plant.lag.y, h));
  ASSERT_EQ(tuner.state(), RelayTuner::State::kDone);
  const double period = 2 * constant * std::log(2 * std::exp(dead / constant) - 1);
  const double amplitude = 3 * 0.5 * (1 - std::exp(-dead / constant));
  EXPECT_NEAR(tuner.ultimate_period(), period, 0.002 * period);
  EXPECT_NEAR(tuner.ultimate_gain(), 4 * 0.5 / (M_PI * amplitude), 0.004 * tuner.ultimate_gain());
  EXPECT_LT(steps * h, 6 * period);
}

// The phase of 1 / (s + 1)^3 is -180 degrees at sqrt(3) rad/s, where its gain is 1/8: the ultimate gain is 8, the
// period 2 pi / sqrt(3) (the standard example of relay tuning). The describing function leaves the
// harmonics out, which these three lags do not damp away: 5 % in gain here.
TEST(Pid2Dof, AutotuneFindsTheUltimatePointOfThreeLags) {
  const double h = 0.005;
  for (const bool direct : {false, true}) {
    Loop pid(milliseconds(5));
    ThreeLags plant;
    pid.port<bool>("DIRECT") = direct;
    pid.port<std::int16_t>("TUNE_RULE") = 0;
    const double sign = direct ? -1 : 1;
    pid["KP"] = 1;
    pid["TR"] = 2;
    pid["SP"] = 2;
    pid["XMIN"] = -10;
    pid["XMAX"] = 10;
    pid["TUNE_STEP"] = 1;
    pid["TUNE_NOISE"] = 0.001;
    const auto cycle = [&] {
      pid["PV"] = plant.x[2];
      pid.fire();
      plant.step(sign * pid.out(), h);
    };
    for (int k = 0; k < 20000; ++k) cycle();
    ASSERT_NEAR(plant.x[2], 2, 1e-3);
    EXPECT_EQ(pid.tune_state(), 0);
    EXPECT_EQ(pid["KU"], 0);
    pid.port<bool>("TUNE") = true;
    cycle();
    ASSERT_EQ(pid.tune_state(), 1);
    for (int k = 0; k < 20000 && pid.tune_state() == 1; ++k) {
      cycle();
      if (pid.tune_state() == 1) {
        EXPECT_NEAR(std::abs(pid.out() - sign * 2), 1, 0.2);
      }
    }
    ASSERT_EQ(pid.tune_state(), 2);
    EXPECT_NEAR(pid.out(), sign * 2, 0.02) << "goes on from the middle";
    const double period = 2 * M_PI / std::sqrt(3);
    EXPECT_NEAR(pid["KU"], 8, 0.06 * 8);
    EXPECT_NEAR(pid["TU"], period, 0.03 * period);
    EXPECT_DOUBLE_EQ(pid["KP_TUNED"], 0.6 * pid["KU"]);
    EXPECT_DOUBLE_EQ(pid["TR_TUNED"], 0.5 * pid["TU"]);
    EXPECT_DOUBLE_EQ(pid["TD_TUNED"], 0.125 * pid["TU"]);
    for (int k = 0; k < 20000; ++k) cycle();
    EXPECT_NEAR(plant.x[2], 2, 1e-3) << "the controller controls again";
    EXPECT_EQ(pid.tune_state(), 2);
  }
}

// Hysteresis of a third of the amplitude: -1 / N(a) leaves the axis, where its real part meets the plant's curve is
// computed here by bisection over the frequency: Im G = -pi h / (4 d).
TEST(RelayTuner, HysteresisMovesThePointAsTheDescribingFunctionSays) {
  const double h = 0.01;
  const double hysteresis = 0.05;
  const auto plant_at = [](double w) {  // real and imaginary part of 1 / (1 + j w)^3
    const double magnitude = std::pow(1 + w * w, -1.5);
    const double phase = -3 * std::atan(w);
    return std::pair(magnitude * std::cos(phase), magnitude * std::sin(phase));
  };
  double low = 1;
  double high = std::sqrt(3);
  for (int i = 0; i < 60; ++i) {
    const double w = (low + high) / 2;
    (plant_at(w).second < -M_PI * hysteresis / 4 ? low : high) = w;
  }
  ThreeLags plant;
  RelayTuner tuner;
  tuner.start({.bias = 0, .step = 1, .hysteresis = hysteresis, .low = -2, .high = 2, .timeout = 1000});
  while (tuner.running()) plant.step(tuner.step(plant.x[2], h), h);
  ASSERT_EQ(tuner.state(), RelayTuner::State::kDone);
  EXPECT_NEAR(tuner.ultimate_period(), 2 * M_PI / low, 0.05 * 2 * M_PI / low);
  EXPECT_NEAR(tuner.ultimate_gain(), -1 / plant_at(low).first, 0.07 * tuner.ultimate_gain());
}

// A load makes the oscillation lopsided; the relay's middle moves until it is even.
TEST(RelayTuner, ABiasThatIsWrongIsFound) {
  const double h = 0.01;
  ThreeLags plant;
  RelayTuner tuner;
  tuner.start({.setpoint = 0.6, .bias = 0, .step = 1, .low = -2, .high = 2, .timeout = 1000});
  while (tuner.running()) plant.step(tuner.step(plant.x[2], h), h);
  ASSERT_EQ(tuner.state(), RelayTuner::State::kDone);
  EXPECT_NEAR(tuner.bias(), 0.6, 0.05);
  EXPECT_NEAR(tuner.ultimate_gain(), 8, 0.07 * 8);
}

TEST(RelayTuner, GivesUpForAReason) {
  RelayTuner tuner;
  tuner.start({.step = 0, .low = -1, .high = 1, .timeout = 10});
  EXPECT_EQ(tuner.state(), RelayTuner::State::kNoRoom);
  tuner.start({.step = 1.1, .low = -1, .high = 1, .timeout = 10});
  EXPECT_EQ(tuner.state(), RelayTuner::State::kNoRoom);
  tuner.start({.step = kNan, .low = -1, .high = 1, .timeout = 10});
  EXPECT_EQ(tuner.state(), RelayTuner::State::kNoRoom);
  tuner.start({.setpoint = 1, .step = 1, .low = -1, .high = 1, .timeout = 10});
  int steps = 0;
  for (; tuner.running(); ++steps) EXPECT_EQ(tuner.step(0, 0.1), 1);
  EXPECT_NEAR(steps, 100, 1);
  EXPECT_EQ(tuner.state(), RelayTuner::State::kNoOscillation);
  EXPECT_EQ(tuner.ultimate_gain(), 0);
  // steps of no time change nothing
  tuner.start({.step = 1, .low = -1, .high = 1, .timeout = 10});
  for (int i = 0; i < 10; ++i) tuner.step(i % 2 == 0 ? 1 : -1, 0);
  EXPECT_TRUE(tuner.running());
  EXPECT_EQ(tuner.bias(), 0);
}

TEST(Pid2Dof, ATuningIsStopped) {
  const auto started = [](Loop& pid) {
    pid["XMIN"] = -10;
    pid["XMAX"] = 10;
    pid["TR"] = 1;
    pid["SP"] = 3;
    pid["TUNE_STEP"] = 2;
    pid.fire();
    pid.port<bool>("TUNE") = true;
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 1);
    pid.fire();
    EXPECT_NE(pid.out(), 3);
  };
  const double bias = 3 + 3 * 0.1;
  {
    Loop pid(milliseconds(100));
    started(pid);
    pid.port<bool>("TUNE") = false;
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 3);
    EXPECT_DOUBLE_EQ(pid.out(), bias);
  }
  {
    Loop pid(milliseconds(100));
    started(pid);
    pid.port<bool>("AUTO") = false;
    pid["X0"] = 1;
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 3);
    EXPECT_EQ(pid.out(), 1);
    pid.port<bool>("AUTO") = true;  // TUNE is still there, but does not rise
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 3);
    EXPECT_EQ(pid.out(), 1);
  }
  {
    Loop pid(milliseconds(100));
    started(pid);
    pid["PV"] = kNan;
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 6);
    EXPECT_DOUBLE_EQ(pid.out(), bias);
  }
  {
    Loop pid(milliseconds(100));
    pid.port<double>("TUNE_TIME") = 5;
    started(pid);
    for (int i = 0; i < 100; ++i) pid.fire();
    EXPECT_EQ(pid.tune_state(), 4);
  }
  {
    Loop pid(milliseconds(100));
    pid["XMIN"] = -1;
    pid["XMAX"] = 1;
    pid["TUNE_STEP"] = 2;
    pid.port<bool>("TUNE") = true;
    pid.fire();
    EXPECT_EQ(pid.tune_state(), 5);
  }
}

// Ziegler, Nichols 1942; Tyreus, Luyben 1992; McCormack, Godfrey 1998.
TEST(RelayTuner, RulesAreThoseOfTheirBooks) {
  const struct {
    TuningRule rule;
    double gain, reset, rate;
  } rows[] = {{TuningRule::kZieglerNicholsPid, 6, 2, 0.5},     {TuningRule::kZieglerNicholsPi, 4.5, 4 / 1.2, 0},
              {TuningRule::kZieglerNicholsP, 5, 0, 0},         {TuningRule::kTyreusLuybenPid, 10 / 2.2, 8.8, 4 / 6.3},
              {TuningRule::kTyreusLuybenPi, 10 / 3.2, 8.8, 0}, {TuningRule::kSomeOvershoot, 3.3, 2, 4 * 0.33},
              {TuningRule::kNoOvershoot, 2, 2, 4 * 0.33}};
  for (const auto& row : rows) {
    const TunedGains gains = tuned_gains(row.rule, 10, 4);
    EXPECT_DOUBLE_EQ(gains.gain, row.gain);
    EXPECT_DOUBLE_EQ(gains.reset, row.reset);
    EXPECT_DOUBLE_EQ(gains.rate, row.rate);
  }
}

}  // namespace
}  // namespace plc::blocks
