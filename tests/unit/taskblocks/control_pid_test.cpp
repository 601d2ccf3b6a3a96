// PID_2DOF against closed forms of loops, and its autotune against relay oscillations that can be computed.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>

#include "picard/testing.h"
#include "taskblocks/control/relay_tuner.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Loop : public picard::Instance {
 public:
  explicit Loop(nanoseconds period) : Instance(control_library(), "PID_2DOF", period) { port<bool>("AUTO") = true; }
  double& operator[](const char* name) { return port<double>(name); }
  double out() { return port<double>("XOUT"); }
  bool bad() { return port<bool>("BAD"); }
  std::int16_t tune_state() { return port<std::int16_t>("TUNE_STATE"); }
};

/// K / (T s + 1) behind a zero-order hold: exact.
struct FirstOrder {
  double gain;
  double decay;  ///< exp(-period / T)
  double y = 0;
  void step(double u) { y = decay * y + (1 - decay) * gain * u; }
};

TEST(Pid2Dof, ProportionalLoopIsAGeometricSeries) {
  Loop pid(milliseconds(100));
  FirstOrder plant{.gain = 2, .decay = 0.9};
  pid["KP"] = 1.5;
  pid["B"] = 0.8;
  pid["SP"] = 10;
  // y' = (decay - s) y + s B SP with s = (1 - decay) K KP
  const double s = 0.1 * 2 * 1.5;
  const double root = 0.9 - s;
  const double end = s * 0.8 * 10 / (1 - root);
  for (int k = 0; k < 60; ++k) {
    ASSERT_NEAR(plant.y, end * (1 - std::pow(root, k)), 1e-12) << k;
    pid["PV"] = plant.y;
    pid.fire();
    plant.step(pid.out());
  }
}

// With TR = h a / (1 - a) the zero of the controller cancels the plant's pole a: what is left is one integrator, whose
// closed loop is y = SP (1 - (1 - g)^k), g = KP K (1 - a) / a.
TEST(Pid2Dof, IntegralPartThatCancelsThePlantsPole) {
  const double h = 0.1;
  const double a = std::exp(-h / 2.0);
  Loop pid(milliseconds(100));
  FirstOrder plant{.gain = 4, .decay = a};
  pid["KP"] = 0.5;
  pid["TR"] = h * a / (1 - a);
  pid.fire();  // the first cycle has no integral part: at rest
  pid["SP"] = 3;
  const double g = 0.5 * 4 * (1 - a) / a;
  for (int k = 0; k < 200; ++k) {
    ASSERT_NEAR(plant.y, 3 * (1 - std::pow(1 - g, k)), 1e-12) << k;
    pid["PV"] = plant.y;
    pid.fire();
    plant.step(pid.out());
  }
}

TEST(Pid2Dof, TheDerivativePartOfARampRisesLikeTheExponential) {
  Loop pid(milliseconds(20));
  pid["KP"] = 3;
  pid["TD"] = 0.5;
  pid["N"] = 5;
  pid["B"] = 0;
  for (int k = 0; k < 100; ++k) {
    const double t = k * 0.02;
    pid["PV"] = -2 * t;
    pid.fire();
    EXPECT_NEAR(pid["XD"], 3 * 0.5 * 2 * (1 - std::exp(-t * 5 / 0.5)), 1e-12) << k;
    EXPECT_NEAR(pid["XP"], 3 * 2 * t, 1e-12);
    EXPECT_EQ(pid.out(), pid["XP"] + pid["XD"]);
  }
}

TEST(Pid2Dof, WeightsSayWhatAStepOfTheSetPointReaches) {
  Loop pid(milliseconds(100));
  pid["KP"] = 2;
  pid["TD"] = 1;
  pid["N"] = 0;  // not filtered
  pid["B"] = 0.25;
  pid.fire();
  pid["SP"] = 1;
  pid.fire();
  EXPECT_DOUBLE_EQ(pid.out(), 2 * 0.25);  // C = 0
  pid["C"] = 0.5;
  pid["SP"] = 0;
  pid.fire();
  pid["SP"] = 1;
  pid.fire();
  EXPECT_NEAR(pid.out(), 2 * 0.25 + 2 * 1 * 0.5 / 0.1, 1e-12);
  EXPECT_EQ(pid["E"], 1);
}

TEST(Pid2Dof, DirectTurnsTheSense) {
  Loop heats(milliseconds(100));
  Loop cools(milliseconds(100));
  cools.port<bool>("DIRECT") = true;
  for (Loop* pid : {&heats, &cools}) {
    (*pid)["KP"] = 2;
    (*pid)["TR"] = 3;
    (*pid)["TD"] = 0.4;
  }
  for (int k = 0; k < 50; ++k) {
    for (Loop* pid : {&heats, &cools}) {
      (*pid)["SP"] = 1;
      (*pid)["PV"] = std::sin(0.1 * k);
      pid->fire();
    }
    EXPECT_EQ(heats.out(), -cools.out());
    EXPECT_EQ(heats["E"], -cools["E"]);
  }
  EXPECT_NE(heats.out(), 0);
}

// Annex F's block and this one, where they mean the same: the table in docs/reference/library/control.md, with the
// error the other way round.
TEST(Pid2Dof, ClampingHoldsTheIntegralAtTheLimit) {
  Loop pid(std::chrono::seconds(1));
  pid.port<bool>("DIRECT") = true;
  pid["PV"] = 60;
  pid["SP"] = 50;
  pid["KP"] = 2;
  pid["TR"] = 5;
  pid["XMAX"] = 100;
  for (const double expected : {20.0, 24.0, 28.0}) {
    pid.fire();
    EXPECT_DOUBLE_EQ(pid.out(), expected);
    EXPECT_FALSE(pid.port<bool>("LIMITED"));
  }
  for (int i = 0; i < 58; ++i) pid.fire();
  EXPECT_EQ(pid.out(), 100);
  EXPECT_TRUE(pid.port<bool>("LIMITED"));
  pid["PV"] = 49;
  pid.fire();
  EXPECT_DOUBLE_EQ(pid.out(), 77.6);
}

TEST(Pid2Dof, BackCalculationStandsWherePullAndGrowthAreEqual) {
  const double h = 0.1;
  Loop pid(milliseconds(100));
  pid.port<std::int16_t>("ANTIWINDUP") = 1;
  pid["KP"] = 2;
  pid["TR"] = 4;
  pid["TT"] = 0.7;
  pid["XMIN"] = -1;
  pid["XMAX"] = 1;
  pid["SP"] = 5;
  for (int k = 0; k < 400; ++k) pid.fire();
  EXPECT_EQ(pid.out(), 1);
  const double growth = 2 * 5 * h / 4;
  const double excess = growth / (1 - std::exp(-h / 0.7));
  EXPECT_NEAR(pid["XP"] + pid["XI"], 1 + excess, 1e-12);
  // TT = 0 stands for TR, and for sqrt(TR TD)
  pid["TT"] = 0;
  for (int k = 0; k < 2000; ++k) pid.fire();
  EXPECT_NEAR(pid["XP"] + pid["XI"], 1 + growth / (1 - std::exp(-h / 4)), 1e-9);
  pid["TD"] = 1;
  for (int k = 0; k < 2000; ++k) pid.fire();
  EXPECT_NEAR(pid["XP"] + pid["XI"], 1 + growth / (1 - std::exp(-h / 2)), 1e-9);
}

TEST(Pid2Dof, TheActuatorsPositionHoldsTheIntegral) {
  const double h = 0.1;
  Loop pid(milliseconds(100));
  pid.port<std::int16_t>("ANTIWINDUP") = 2;
  pid["KP"] = 2;
  pid["TR"] = 4;
  pid["TT"] = 0.7;
  pid["SP"] = 5;  // no limits of its own: the valve is stuck at 3
  for (int k = 0; k < 400; ++k) {
    pid.fire();
    pid["XACT"] = std::min(pid.out(), 3.0);
  }
  EXPECT_NEAR(pid.out(), 3 + 2 * 5 * h / 4 / (1 - std::exp(-h / 0.7)), 1e-12);
  // and one that follows pulls nothing: the integral is that of a controller without
  Loop plain(milliseconds(100));
  Loop followed(milliseconds(100));
  followed.port<std::int16_t>("ANTIWINDUP") = 2;
  for (int k = 0; k < 100; ++k) {
    for (Loop* p : {&plain, &followed}) {
      (*p)["TR"] = 2;
      (*p)["SP"] = std::cos(0.2 * k);
      p->fire();
    }
    EXPECT_EQ(plain.out(), followed.out());
    followed["XACT"] = followed.out();
  }
}

TEST(Pid2Dof, ManualTrackingAndBackWithoutAJump) {
  Loop pid(milliseconds(500));
  pid.port<bool>("AUTO") = false;
  pid["X0"] = 33;
  pid["PV"] = 7;
  pid["SP"] = 9;
  pid["KP"] = 2;
  pid["TR"] = 5;
  pid["FF"] = 11;
  pid.fire();
  EXPECT_EQ(pid.out(), 33);
  pid.port<bool>("AUTO") = true;
  pid.fire();
  EXPECT_EQ(pid.out(), 33);
  pid.fire();
  EXPECT_DOUBLE_EQ(pid.out(), 33 + 2 * 2 * 0.5 / 5);
  pid["FF"] = 12;  // feedforward is at the output at once
  pid.fire();
  EXPECT_DOUBLE_EQ(pid.out(), 34 + 2 * 2 * 2 * 0.5 / 5);
  pid.port<bool>("TRACK") = true;
  pid["XTRACK"] = -4;
  for (int i = 0; i < 10; ++i) pid.fire();
  EXPECT_EQ(pid.out(), -4);
  pid.port<bool>("AUTO") = false;  // TRACK goes before manual
  pid.fire();
  EXPECT_EQ(pid.out(), -4);
  pid.port<bool>("AUTO") = true;
  pid.port<bool>("TRACK") = false;
  pid.fire();
  EXPECT_DOUBLE_EQ(pid.out(), -4);
  pid["XMIN"] = -1;
  pid["XMAX"] = 1;
  pid.port<bool>("TRACK") = true;
  pid.fire();
  EXPECT_EQ(pid.out(), -1);
}

TEST(Pid2Dof, TheDerivativePartIsThereAfterManual) {
  Loop pid(milliseconds(100));
  pid["TR"] = 1;
  pid["TD"] = 2;
  pid["N"] = 4;
  pid.port<bool>("AUTO") = false;
  for (int k = 0; k < 100; ++k) {
    pid["PV"] = 0.3 * k;
    pid.fire();
  }
  pid.port<bool>("AUTO") = true;
  pid["PV"] = 30;
  pid.fire();
  EXPECT_NEAR(pid["XD"], -2 * 3, 1e-6);
  EXPECT_NEAR(pid.out(), 0, 1e-12);
}

TEST(Pid2Dof, GainsChangeWithoutAJump) {
  Loop pid(milliseconds(100));
  pid["SP"] = 4;
  pid["PV"] = 1;
  pid["TR"] = 10;
  pid["KP"] = 2;
  for (int i = 0; i < 10; ++i) pid.fire();
  const double before = pid.out();
  pid["KP"] = 20;
  pid["B"] = 0.3;
  pid.fire();
  EXPECT_NEAR(pid.out(), before + 20 * 3 * 0.1 / 10, 1e-12);
  EXPECT_NEAR(pid["XP"], 20 * (0.3 * 4 - 1), 1e-12);
}

TEST(Pid2Dof, BadInputHoldsTheOutputAndItsTimeDoesNotCount) {
  Loop pid(std::chrono::seconds(1));
  pid["SP"] = 10;
  pid["TR"] = 10;
  pid["XMIN"] = -100;
  pid["XMAX"] = 100;
  pid.fire();
  ASSERT_EQ(pid.out(), 10);
  for (const char* name : {"PV", "SP", "KP", "TR", "TD", "N", "B", "C", "FF", "XMIN", "XMAX", "TT"}) {
    const double good = pid[name];
    pid[name] = kNan;
    pid.fire();
    EXPECT_EQ(pid.out(), 10) << name;
    EXPECT_TRUE(pid.bad()) << name;
    pid[name] = good;
  }
  for (const double wrong : {kInfinity, -kInfinity}) {
    pid["PV"] = wrong;
    pid.fire();
    EXPECT_EQ(pid.out(), 10);
  }
  pid["PV"] = 0;
  pid["KP"] = -1;
  pid.fire();
  EXPECT_EQ(pid.out(), 10);
  EXPECT_TRUE(pid.bad());
  pid["KP"] = 1;
  pid.fire();
  EXPECT_EQ(pid.out(), 11);
  EXPECT_FALSE(pid.bad());
  // sums that do not fit, too
  pid["KP"] = 1e308;
  pid["SP"] = 1e10;
  pid.fire();
  EXPECT_EQ(pid.out(), 11);
  EXPECT_TRUE(pid.bad());
  // in manual only X0 and the limits count
  pid.port<bool>("AUTO") = false;
  pid["PV"] = kNan;
  pid["X0"] = 5;
  pid.fire();
  EXPECT_EQ(pid.out(), 5);
  EXPECT_FALSE(pid.bad());
  pid["X0"] = kNan;
  pid.fire();
  EXPECT_EQ(pid.out(), 5);
  EXPECT_TRUE(pid.bad());
}

// No slope across a gap: PV is 5 away when the sensor is back, which is no jump of the process.
TEST(Pid2Dof, NoDerivativeKickAfterABrokenSensor) {
  Loop pid(milliseconds(100));
  pid["TD"] = 10;
  pid.fire();
  pid["PV"] = kNan;
  pid.fire();
  pid["PV"] = 5;
  pid.fire();
  EXPECT_EQ(pid["XD"], 0);
  pid.fire();
  EXPECT_EQ(pid["XD"], 0);
}

TEST(Pid2Dof, WithoutLimitsOfItsOwnThereAreNone) {
  Loop pid(milliseconds(100));
  pid["KP"] = 1e6;
  pid["SP"] = 1e6;
  pid.fire();
  EXPECT_EQ(pid.out(), 1e12);
  pid["XMAX"] = -1;  // below XMIN = 0
  pid.fire();
  EXPECT_EQ(pid.out(), 1e12);
  EXPECT_FALSE(pid.port<bool>("LIMITED"));
}

// Executions at a standing clock, as in event tasks that fire twice in the same instant.
TEST(Pid2Dof, NoTimeNoIntegral) {
  Loop pid(nanoseconds(0));
  pid["TR"] = 1;
  pid["TD"] = 1;
  pid["SP"] = 3;
  for (int i = 0; i < 10; ++i) {
    pid["PV"] = 0.1 * i;
    pid.fire();
    EXPECT_DOUBLE_EQ(pid.out(), 3 - 0.1 * i);
  }
}

TEST(Pid2Dof, ConfigurationIsChecked) {
  const auto refused = [](auto set) {
    Loop pid(milliseconds(1));
    set(pid);
    EXPECT_THROW(pid.ready(), std::runtime_error);
  };
  refused([](Loop& p) { p.port<std::int16_t>("ANTIWINDUP") = 3; });
  refused([](Loop& p) { p.port<std::int16_t>("ANTIWINDUP") = -1; });
  refused([](Loop& p) { p.port<std::int16_t>("TUNE_RULE") = 7; });
  refused([](Loop& p) { p["TUNE_TIME"] = 0; });
  refused([](Loop& p) { p["TUNE_TIME"] = kNan; });
}

// ---- autotune

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

/// 1 / (s + 1)^3, Euler in steps small enough.
struct ThreeLags {
  double x[3] = {};
  void step(double u, double h) {
    constexpr int kFine = 20;
    for (int i = 0; i < kFine; ++i) {
      x[2] += (x[1] - x[2]) * h / kFine;
      x[1] += (x[0] - x[1]) * h / kFine;
      x[0] += (u - x[0]) * h / kFine;
    }
  }
};

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

// The outer controller of a cascade follows the inner process value while the inner loop is open, and goes on from it.
TEST(Pid2Dof, ACascadeClosesWithoutAJump) {
  Loop outer(milliseconds(100));
  Loop inner(milliseconds(100));
  FirstOrder flow{.gain = 1, .decay = std::exp(-0.1 / 0.5)};
  FirstOrder level{.gain = 1, .decay = std::exp(-0.1 / 10)};
  outer["KP"] = 3;
  outer["TR"] = 10;
  inner["KP"] = 1;
  inner["TR"] = 0.5;
  inner["X0"] = 2;
  outer["SP"] = 4;
  inner.port<bool>("AUTO") = false;
  double last = 2;
  for (int k = 0; k < 3000; ++k) {
    if (k == 300) inner.port<bool>("AUTO") = true;
    outer.port<bool>("TRACK") = !inner.port<bool>("AUTO");
    outer["XTRACK"] = flow.y;
    outer["PV"] = level.y;
    outer.fire();
    inner["SP"] = outer.out();
    inner["PV"] = flow.y;
    inner.fire();
    if (k < 300) {
      EXPECT_EQ(inner.out(), 2);
    }
    if (k == 300) {
      EXPECT_NEAR(inner.out(), last, 1e-9);
    }
    last = inner.out();
    flow.step(inner.out());
    level.step(flow.y);
  }
  EXPECT_NEAR(level.y, 4, 1e-6);
}

TEST(Pid2Dof, FireAllocatesNothing) {
  Loop pid(milliseconds(20));
  ThreeLags plant;
  pid["TR"] = 2;
  pid["TD"] = 0.3;
  pid["SP"] = 1;
  pid["TUNE_STEP"] = 1;
  pid.ready();
  const std::size_t before = test::allocations();
  for (int k = 0; k < 2000; ++k) {
    pid.port<bool>("TUNE") = k == 1000 || (k > 1000 && k < 1900);
    pid.port<bool>("AUTO") = k > 20;
    pid["PV"] = plant.x[2];
    pid.fire();
    plant.step(pid.out(), 0.02);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace plc::blocks
