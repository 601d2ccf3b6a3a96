// PID_2DOF against closed forms of loops.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>

#include "tests/support/count_allocations.h"
#include "tests/unit/taskblocks/pid_loop.h"

namespace plc::blocks {
namespace {

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
