#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "picard/testing.h"
#include "taskblocks/motion/profile.h"
#include "taskblocks/set.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

using std::chrono::milliseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kPeriod = 1e-3;

// ---- one axis -----------------------------------------------------------------------------------------------------

/// Greatest finite differences of the positions that came out: what a drive would see, whatever SPEED and ACC say.
class Differences {
 public:
  void add(double position) {
    last_.insert(last_.begin(), position);
    if (last_.size() > 4) last_.pop_back();
    const auto& p = last_;
    if (p.size() > 1) speed = std::max(speed, std::fabs(p[0] - p[1]) / kPeriod);
    if (p.size() > 2) acceleration = std::max(acceleration, std::fabs(p[0] - 2 * p[1] + p[2]) / std::pow(kPeriod, 2));
    if (p.size() > 3) {
      jerk = std::max(jerk, std::fabs(p[0] - 3 * p[1] + 3 * p[2] - p[3]) / std::pow(kPeriod, 3));
    }
  }
  double speed = 0;
  double acceleration = 0;
  double jerk = 0;

 private:
  std::vector<double> last_;
};

struct Axis {
  explicit Axis(const char* block) : instance(motion_library(), block, milliseconds(1)) {}
  double& in(const char* name) { return instance.port<double>(name); }
  double out(const char* name) { return instance.port<double>(name); }
  bool flag(const char* name) { return instance.port<bool>(name); }
  void fire() {
    instance.fire();
    differences.add(out("POSITION"));
  }
  /// Cycles until DONE; fails after `most`.
  int run(int most = 100000) {
    for (int i = 1; i <= most; ++i) {
      fire();
      if (flag("DONE")) return i;
    }
    ADD_FAILURE() << "never done";
    return most;
  }
  picard::Instance instance;
  Differences differences;
};

std::unique_ptr<Axis> trapezoid(double speed, double acc, double dec) {
  auto axis = std::make_unique<Axis>("TRAPEZOID");
  axis->in("MAX_SPEED") = speed;
  axis->in("MAX_ACC") = acc;
  axis->in("MAX_DEC") = dec;
  return axis;
}
std::unique_ptr<Axis> s_curve(double speed, double acc, double jerk) {
  auto axis = std::make_unique<Axis>("S_CURVE");
  axis->in("MAX_SPEED") = speed;
  axis->in("MAX_ACC") = acc;
  axis->in("MAX_JERK") = jerk;
  return axis;
}

// L. Biagiotti, C. Melchiorri, Trajectory Planning for Automatic Machines and Robots, 2008, 3.2: the phases of a
// trapezoidal profile from rest to rest.
TEST(Trapezoid, FollowsTheClosedForm) {
  const auto axis = trapezoid(20, 100, 50);
  axis->in("TARGET") = 30;
  const double up = 20.0 / 100, down = 20.0 / 50;
  const double level = (30 - 20 * up / 2 - 20 * down / 2) / 20;
  const double total = up + level + down;
  for (int i = 0; i <= 2500; ++i) {
    axis->fire();
    const double t = std::min(i * kPeriod, total);
    double expected = 30 - 50 * (total - t) * (total - t) / 2;
    if (t < up)
      expected = 100 * t * t / 2;
    else if (t < up + level)
      expected = 20 * up / 2 + 20 * (t - up);
    ASSERT_NEAR(axis->out("POSITION"), expected, 1e-9) << i;
    ASSERT_NEAR(axis->out("TIME_LEFT"), total - t, 1e-9) << i;
    ASSERT_EQ(axis->flag("DONE"), i * kPeriod >= total - 1e-9) << i;
  }
  EXPECT_EQ(axis->out("POSITION"), 30.0) << "exactly";
  EXPECT_EQ(axis->out("SPEED"), 0.0);
}

TEST(Trapezoid, AShortWayHasThePeakOfTheClosedForm) {
  const auto axis = trapezoid(1000, 100, 50);
  axis->in("TARGET") = -3;
  double peak = 0;
  for (int i = 0; i < 1000; ++i) {
    axis->fire();
    peak = std::max(peak, -axis->out("SPEED"));
  }
  EXPECT_NEAR(peak, std::sqrt(2.0 * 3 * 100 * 50 / 150), 100 * kPeriod);
  EXPECT_EQ(axis->out("POSITION"), -3.0);
}

// The same, 3.4: durations of profiles from rest to rest in which all, two or none of the limits are reached.
TEST(SCurve, DurationsAreThoseOfTheClosedForm) {
  struct {
    double way, speed, acc, jerk, seconds;
  } const rows[] = {
      {10, 5, 10, 30, 10.0 / 5 + 5.0 / 10 + 10.0 / 30},                        // all three
      {10, 5, 1000, 30, 10.0 / 5 + 2 * std::sqrt(5.0 / 30)},                   // speed and jerk
      {10, 1000, 10, 100, 10.0 / 100 + std::sqrt(0.1 * 0.1 + 4 * 10.0 / 10)},  // acceleration and jerk
      {10, 1000, 1000, 30, 4 * std::cbrt(10 / (2.0 * 30))},                    // jerk
      {-0.001, 1000, 1000, 30, 4 * std::cbrt(0.001 / (2.0 * 30))},
  };
  for (const auto& row : rows) {
    const MotionLimits limits{row.speed, row.acc, row.acc, row.jerk};
    EXPECT_NEAR(plan_s_curve({1, 0, 0}, 1 + row.way, limits).duration(), row.seconds, 1e-9) << row.way;
  }
}

TEST(SCurve, GoesThroughItsSevenPhases) {
  const auto axis = s_curve(5, 10, 40);
  axis->in("TARGET") = 10;
  // Phases integrated numerically, with the times of the closed form.
  const double tj = 10.0 / 40, ta = 5.0 / 10 + tj, tv = 10.0 / 5 - ta;
  const int steps = 100;  // a cycle
  double x = 0, v = 0;
  for (int i = 0; i <= 3000; ++i) {
    axis->fire();
    ASSERT_NEAR(axis->out("POSITION"), x, 1e-7) << i;
    ASSERT_NEAR(axis->out("SPEED"), v, 1e-6) << i;
    for (int k = 0; k < steps; ++k) {
      const double h = kPeriod / steps;
      double t = i * kPeriod + (k + 0.5) * h;
      const double sign = t < ta + tv ? 1 : -1;
      if (t > ta + tv) t -= ta + tv;
      double a = 0;
      if (t < tj)
        a = 40 * t;
      else if (t < ta - tj)
        a = 10;
      else if (t < ta)
        a = 40 * (ta - t);
      x += (v + sign * a * h / 2) * h;
      v += sign * a * h;
    }
  }
  EXPECT_EQ(axis->out("POSITION"), 10.0);
  EXPECT_LE(axis->differences.speed, 5 * (1 + 1e-9));
  EXPECT_LE(axis->differences.acceleration, 10 * (1 + 1e-6));
  EXPECT_LE(axis->differences.jerk, 40 * (1 + 1e-2));  // rounding of positions / period^3
}

// Bellman: what is left of an optimal way is the optimal way from there. A plan from any moment of a plan takes the
// time that was left of it. The tolerance is that of a cube root: positions rounded by 1e-15 are 1e-5 s apart.
TEST(SCurve, APlanFromTheMiddleIsTheRestOfThePlan) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 300; ++i) {
    const MotionLimits limits{2 + any(random), 5 + 4 * any(random), 1, 30 + 25 * any(random)};
    // A state that is really met: somewhere on the way to another target.
    const Profile before = plan_s_curve({0, 0, 0}, 10 * any(random), limits);
    const MotionState from = before.at(before.duration() * (0.5 + any(random) / 2));
    const double target = 10 * any(random);
    const Profile plan = plan_s_curve(from, target, limits);
    for (double part = 0; part < 1; part += 0.07) {
      const double t = part * plan.duration();
      ASSERT_NEAR(plan_s_curve(plan.at(t), target, limits).duration(), plan.duration() - t, 1e-4) << i << ' ' << part;
    }
  }
}

template <class Make>
void chase(Make make, double speed, double acc, double jerk) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto axis = make();
  for (int i = 0; i < 500; ++i) {
    axis->in("TARGET") = 3 * any(random);
    axis->instance.template port<bool>("STOP") = i % 7 == 3;
    for (int k = std::uniform_int_distribution<int>(1, 700)(random); k > 0; --k) axis->fire();
    axis->instance.template port<bool>("STOP") = false;
    if (i % 5 == 0) {
      axis->run();
      ASSERT_EQ(axis->out("POSITION"), axis->in("TARGET")) << i;
      ASSERT_EQ(axis->out("SPEED"), 0.0);
      ASSERT_EQ(axis->out("ACC"), 0.0);
    }
  }
  EXPECT_LE(axis->differences.speed, speed * (1 + 1e-9));
  EXPECT_LE(axis->differences.acceleration, acc * (1 + 1e-6));
  EXPECT_LE(axis->differences.jerk, jerk * (1 + 1e-2));
  // And they are used: a profile that crawls would pass the lines above.
  EXPECT_GT(axis->differences.speed, speed * 0.99);
  EXPECT_GT(axis->differences.acceleration, acc * 0.99);
}

TEST(Trapezoid, TargetsThatChangeWhileMovingNeverBreakLimits) {
  chase([] { return trapezoid(5, 40, 25); }, 5, 40, std::numeric_limits<double>::infinity());
}
TEST(SCurve, TargetsThatChangeWhileMovingNeverBreakLimits) {
  chase([] { return s_curve(5, 40, 300); }, 5, 40, 300);
}

TEST(Trapezoid, StopComesToRestWithinTheDecelerationAndGoesOnAfterwards) {
  const auto axis = trapezoid(10, 100, 50);
  axis->in("TARGET") = 100;
  for (int i = 0; i < 1001; ++i) axis->fire();  // 1 s: at full speed
  const double from = axis->out("POSITION");
  axis->instance.port<bool>("STOP") = true;
  for (int i = 0; i < 500; ++i) axis->fire();
  EXPECT_NEAR(axis->out("POSITION"), from + 10 * kPeriod + 10.0 * 10 / (2 * 50), 1e-9);
  EXPECT_EQ(axis->out("SPEED"), 0.0);
  EXPECT_FALSE(axis->flag("DONE"));
  axis->instance.port<bool>("STOP") = false;
  axis->run();
  EXPECT_EQ(axis->out("POSITION"), 100.0);
}

TEST(Motion, LimitsThatAreLoweredWhileMovingHoldAsSoonAsTheyCan) {
  const auto curve = s_curve(10, 50, 400);
  curve->in("TARGET") = 50;
  for (int i = 0; i < 100; ++i) curve->fire();  // accelerating with about 40
  curve->in("MAX_ACC") = 5;
  curve->in("MAX_SPEED") = 4;
  for (int i = 0; i < 2000; ++i) curve->fire();
  EXPECT_LE(curve->differences.jerk, 400 * 1.01);
  EXPECT_NEAR(curve->out("SPEED"), 4, 1e-12);
  curve->differences = {};
  curve->run();
  EXPECT_EQ(curve->out("POSITION"), 50.0);
  EXPECT_LE(curve->differences.acceleration, 5 * (1 + 1e-6));

  const auto line = trapezoid(10, 50, 20);
  line->in("TARGET") = 50;
  for (int i = 0; i < 1000; ++i) line->fire();
  line->in("MAX_SPEED") = 4;
  for (int i = 0; i < 302; ++i) line->fire();
  EXPECT_NEAR(line->out("SPEED"), 4, 1e-12) << "(10 - 4) / 20 s later";
  line->run();
  EXPECT_EQ(line->out("POSITION"), 50.0);
}

TEST(Motion, WhatMakesNoSenseStopsTheAxis) {
  for (const char* block : {"TRAPEZOID", "S_CURVE"}) {
    for (const char* port : {"TARGET", "MAX_SPEED", "MAX_ACC"}) {
      for (const double wrong : {kNan, std::numeric_limits<double>::infinity(), 0.0, -1.0}) {
        if (std::string(port) == "TARGET" && std::isfinite(wrong)) continue;
        Axis axis(block);
        axis.in("TARGET") = 5;
        axis.in(port) = wrong;
        for (int i = 0; i < 10; ++i) axis.fire();
        EXPECT_TRUE(axis.flag("ERROR")) << block << ' ' << port << ' ' << wrong;
        EXPECT_EQ(axis.out("POSITION"), 0.0) << "before anything was right nothing moves";
        axis.in(port) = std::string(port) == "TARGET" ? 5.0 : 1.0;
        for (int i = 0; i < 2000; ++i) axis.fire();
        EXPECT_FALSE(axis.flag("ERROR"));
        EXPECT_GT(axis.out("SPEED"), 0.9);
        axis.in(port) = wrong;
        for (int i = 0; i < 2000; ++i) axis.fire();
        EXPECT_EQ(axis.out("SPEED"), 0.0);
        EXPECT_FALSE(axis.flag("DONE"));
        EXPECT_LT(axis.out("POSITION"), 5.0);
        EXPECT_LE(axis.differences.acceleration, 1 + 1e-6);
        axis.in(port) = std::string(port) == "TARGET" ? 5.0 : 1.0;
        axis.run();
        EXPECT_EQ(axis.out("POSITION"), 5.0);
      }
    }
    Axis axis(block);
    axis.in("START") = kNan;
    EXPECT_THROW(axis.instance.ready(), std::runtime_error);
  }
}

TEST(Motion, TheFirstCycleIsAtStartAndDoneWhenThatIsTheTarget) {
  for (const char* block : {"TRAPEZOID", "S_CURVE"}) {
    Axis axis(block);
    axis.in("START") = 2;
    axis.in("TARGET") = 2;
    axis.fire();
    EXPECT_EQ(axis.out("POSITION"), 2.0) << block;
    EXPECT_EQ(axis.out("TIME_LEFT"), 0.0) << block;
    EXPECT_TRUE(axis.flag("DONE")) << block;
  }
}

// ---- arm ----------------------------------------------------------------------------------------------------------

// J. J. Craig, Introduction to Robotics, 3rd edition, 4.4: the planar arm, solved by the law of cosines. Here with
// angles of a right triangle that need no arithmetic.
TEST(Scara, SolvesTheRightTriangle) {
  picard::Instance arm(motion_library(), "SCARA", milliseconds(1));
  arm.port<double>("L1") = 3;
  arm.port<double>("L2") = 4;
  arm.port<double>("X") = 5;  // 3-4-5
  arm.fire();
  EXPECT_TRUE(arm.port<bool>("REACHABLE"));
  EXPECT_FALSE(arm.port<bool>("SINGULAR"));
  EXPECT_NEAR(arm.port<double>("Q2"), M_PI / 2, 1e-12);
  EXPECT_NEAR(arm.port<double>("Q1"), -std::atan2(4, 3), 1e-12);
  arm.port<bool>("ELBOW") = true;
  arm.fire();
  EXPECT_NEAR(arm.port<double>("Q2"), -M_PI / 2, 1e-12);
  EXPECT_NEAR(arm.port<double>("Q1"), std::atan2(4, 3), 1e-12);
}

TEST(Scara, ForwardIsARotationOfEachLink) {
  picard::Instance arm(motion_library(), "SCARA", milliseconds(1));
  arm.port<double>("L1") = 0.3;
  arm.port<double>("L2") = 0.2;
  for (double a = -3; a < 3; a += 0.37) {
    for (double b = -3; b < 3; b += 0.41) {
      arm.port<double>("Q1_ACTUAL") = a;
      arm.port<double>("Q2_ACTUAL") = b;
      arm.fire();
      const std::complex<double> hand = std::polar(0.3, a) + std::polar(0.2, a + b);
      ASSERT_NEAR(arm.port<double>("X_ACTUAL"), hand.real(), 1e-15);
      ASSERT_NEAR(arm.port<double>("Y_ACTUAL"), hand.imag(), 1e-15);
      arm.port<double>("X") = hand.real();
      arm.port<double>("Y") = hand.imag();
      for (const bool elbow : {false, true}) {
        arm.port<bool>("ELBOW") = elbow;
        arm.fire();
        const double q1 = arm.port<double>("Q1"), q2 = arm.port<double>("Q2");
        const std::complex<double> back = std::polar(0.3, q1) + std::polar(0.2, q1 + q2);
        ASSERT_NEAR(std::abs(back - hand), 0, 1e-9) << a << ' ' << b;
        ASSERT_TRUE(arm.port<bool>("REACHABLE"));
        ASSERT_EQ(elbow, q2 < 0);
      }
    }
  }
}

TEST(Scara, LimitsOfItsReach) {
  picard::Instance arm(motion_library(), "SCARA", milliseconds(1));
  arm.port<double>("L1") = 3;
  arm.port<double>("L2") = 2;
  const auto at = [&arm](double x, double y) {
    arm.port<double>("X") = x;
    arm.port<double>("Y") = y;
    arm.fire();
    return arm.port<bool>("REACHABLE");
  };
  EXPECT_TRUE(at(0, 5));
  EXPECT_TRUE(arm.port<bool>("SINGULAR"));
  EXPECT_NEAR(arm.port<double>("Q1"), M_PI / 2, 1e-6);
  EXPECT_TRUE(at(-1, 0));
  EXPECT_TRUE(arm.port<bool>("SINGULAR"));
  EXPECT_TRUE(at(0, -3));
  const double q1 = arm.port<double>("Q1"), q2 = arm.port<double>("Q2");
  for (const auto& [x, y] : {std::pair{5.001, 0.0}, {0.0, 0.999}, {kNan, 1.0}, {1.0, kNan}, {1e200, 1e200}}) {
    EXPECT_FALSE(at(x, y)) << x << ' ' << y;
    EXPECT_EQ(arm.port<double>("Q1"), q1);
    EXPECT_EQ(arm.port<double>("Q2"), q2);
  }
  for (const double wrong : {0.0, -1.0, kNan}) {
    picard::Instance broken(motion_library(), "SCARA", milliseconds(1));
    broken.port<double>("L2") = wrong;
    EXPECT_THROW(broken.ready(), std::runtime_error);
  }
}

TEST(Scara, JointOneTurnsOnThroughTheCut) {
  picard::Instance arm(motion_library(), "SCARA", milliseconds(1));
  arm.port<double>("X") = 1.2;
  arm.fire();
  double before = arm.port<double>("Q1");
  const double start = before;
  for (int i = 1; i <= 3000; ++i) {  // three turns
    arm.port<double>("X") = 1.2 * std::cos(i * 2 * M_PI / 1000);
    arm.port<double>("Y") = 1.2 * std::sin(i * 2 * M_PI / 1000);
    arm.fire();
    ASSERT_NEAR(arm.port<double>("Q1") - before, 2 * M_PI / 1000, 1e-9) << i;
    before = arm.port<double>("Q1");
  }
  EXPECT_NEAR(before - start, 6 * M_PI, 1e-9);
}

TEST(Scara, InTheBaseTheFirstJointStays) {
  picard::Instance arm(motion_library(), "SCARA", milliseconds(1));
  arm.port<double>("X") = 0.5;
  arm.port<double>("Y") = 0.5;
  arm.fire();
  const double q1 = arm.port<double>("Q1");
  arm.port<double>("X") = arm.port<double>("Y") = 0;
  arm.fire();
  EXPECT_TRUE(arm.port<bool>("REACHABLE"));
  EXPECT_TRUE(arm.port<bool>("SINGULAR"));
  EXPECT_EQ(arm.port<double>("Q1"), q1);
  EXPECT_NEAR(arm.port<double>("Q2"), M_PI, 1e-12);
}

// ---- matrix -------------------------------------------------------------------------------------------------------

using Six = std::array<double, 6>;
using Elements = std::array<double, 36>;

// CoreXY: motor A = x + y, motor B = x - y.
TEST(Kinematics, CoreXy) {
  picard::Instance gantry(motion_library(), "KINEMATICS", milliseconds(1));
  gantry.port<Elements>("MATRIX") = {1, 1, 1, -1};
  gantry.port<Six>("OFFSET") = {10, 20};
  gantry.port<Six>("AXES") = {3, 2};
  gantry.port<Six>("MOTORS_ACTUAL") = {17, 19};
  gantry.fire();
  EXPECT_EQ(gantry.port<Six>("MOTORS"), (Six{15, 21}));
  const Six back = gantry.port<Six>("AXES_ACTUAL");
  EXPECT_NEAR(back[0], 3, 1e-12);
  EXPECT_NEAR(back[1], 4, 1e-12);
  EXPECT_NEAR(gantry.port<double>("CONDITION"), 1, 1e-12) << "orthogonal rows of one length";
}

TEST(Kinematics, SixAxesThereAndBack) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  for (std::int16_t n = 1; n <= 6; ++n) {
    picard::Instance block(motion_library(), "KINEMATICS", milliseconds(1));
    block.port<std::int16_t>("COUNT") = n;
    Elements& m = block.port<Elements>("MATRIX");
    for (int i = 0; i < n * n; ++i) m[static_cast<std::size_t>(i)] = any(random) + (i % (n + 1) == 0 ? 3 : 0);
    Six& offset = block.port<Six>("OFFSET");
    for (double& o : offset) o = any(random);
    Six& axes = block.port<Six>("AXES");
    for (double& a : axes) a = 100 * any(random);
    block.fire();
    const Six motors = block.port<Six>("MOTORS");
    for (std::size_t row = 0; row < 6; ++row) {
      double expected = 0;
      if (row < static_cast<std::size_t>(n)) {
        expected = offset[row];
        for (std::size_t c = 0; c < static_cast<std::size_t>(n); ++c) {
          expected += m[static_cast<std::size_t>(n) * row + c] * axes[c];
        }
      }
      EXPECT_NEAR(motors[row], expected, 1e-10) << n << ' ' << row;
    }
    block.port<Six>("MOTORS_ACTUAL") = motors;
    block.fire();
    const Six back = block.port<Six>("AXES_ACTUAL");
    for (std::size_t i = 0; i < 6; ++i) {
      EXPECT_NEAR(back[i], i < static_cast<std::size_t>(n) ? axes[i] : 0.0, 1e-10) << n << ' ' << i;
    }
  }
}

TEST(Kinematics, ConditionOfADiagonalIsTheRatioAndMayBeTooHigh) {
  const auto make = [](double smallest, double most) {
    auto block = std::make_unique<picard::Instance>(motion_library(), "KINEMATICS", milliseconds(1));
    block->port<Elements>("MATRIX") = {2, 0, 0, smallest};
    block->port<double>("MAX_CONDITION") = most;
    block->ready();
    block->fire();
    return block->port<double>("CONDITION");
  };
  EXPECT_NEAR(make(0.5, 10), 4, 1e-12);
  EXPECT_NEAR(make(-0.5, 10), 4, 1e-12);
  EXPECT_THROW(make(0.1, 10), std::runtime_error);
  EXPECT_THROW(make(0, 1e300), std::runtime_error);
  EXPECT_THROW(make(kNan, 10), std::runtime_error);
  for (const int wrong : {0, 7, -1}) {
    picard::Instance block(motion_library(), "KINEMATICS", milliseconds(1));
    block.port<Elements>("MATRIX") = {1, 0, 0, 1};
    block.port<std::int16_t>("COUNT") = static_cast<std::int16_t>(wrong);
    EXPECT_THROW(block.ready(), std::runtime_error);
  }
}

// ---- gear ---------------------------------------------------------------------------------------------------------

struct Wheels {
  Wheels(double numerator, double denominator) {
    gear.port<double>("NUMERATOR") = numerator;
    gear.port<double>("DENOMINATOR") = denominator;
  }
  double at(double master) {
    gear.port<double>("MASTER") = master;
    gear.fire();
    return gear.port<double>("SLAVE");
  }
  picard::Instance gear{motion_library(), "GEAR", milliseconds(1)};
};

// A clutch that closes evenly over T while the master turns with w: the slave turns by w r T / 2 until then, as a body
// that is accelerated evenly does, and with w r afterwards.
TEST(Gear, EngagesLikeAnEvenAcceleration) {
  Wheels wheels(3, 4);
  wheels.gear.port<double>("START") = 7;
  wheels.gear.port<double>("SLEW") = 1.5;  // 0.75 in 0.5 s
  for (int i = 0; i <= 100; ++i) EXPECT_EQ(wheels.at(0.01 * i), 7);
  wheels.gear.port<bool>("ENGAGE") = true;
  for (int i = 1; i <= 2000; ++i) {
    const double t = i * kPeriod;
    const double expected = 7 + 10 * 0.75 * (t < 0.5 ? t * t : t - 0.25);
    ASSERT_NEAR(wheels.at(1 + 10 * t), expected, 1e-9) << i;
    const bool near = i >= 499 && i <= 501;
    ASSERT_TRUE(near || wheels.gear.port<bool>("ENGAGED") == (i > 500)) << i;
  }
  wheels.gear.port<bool>("ENGAGE") = false;
  const double from = wheels.gear.port<double>("SLAVE");
  for (int i = 1; i <= 1000; ++i) wheels.at(21 + 10 * i * kPeriod);
  EXPECT_NEAR(wheels.gear.port<double>("SLAVE"), from + 10 * 0.75 * 0.25, 1e-9);
  EXPECT_EQ(wheels.gear.port<double>("RATIO"), 0);
}

TEST(Gear, ARotaryMasterMayGoAroundForLongInBothDirections) {
  Wheels wheels(-1, 3);
  wheels.gear.port<double>("MODULO") = 360;
  wheels.gear.port<double>("SLEW") = 1e9;
  wheels.gear.port<bool>("ENGAGE") = true;
  wheels.at(0);
  wheels.at(0);  // engaged
  for (int i = 1; i <= 1000000; ++i) wheels.at(std::fmod(0.7 * i, 360));
  EXPECT_NEAR(wheels.gear.port<double>("SLAVE"), -0.7 * 1000000 / 3, 1e-6);
  for (int i = 999999; i >= 0; --i) wheels.at(std::fmod(0.7 * i, 360));
  EXPECT_NEAR(wheels.gear.port<double>("SLAVE"), 0, 1e-9) << "nothing has added up";
}

TEST(Gear, WhatMakesNoSenseHoldsTheSlave) {
  for (const char* port : {"MASTER", "NUMERATOR", "DENOMINATOR", "SLEW"}) {
    Wheels wheels(2, 1);
    wheels.gear.port<bool>("ENGAGE") = true;
    wheels.gear.port<double>("SLEW") = 4000;
    for (int i = 0; i < 10; ++i) wheels.at(i);
    const double slave = wheels.gear.port<double>("SLAVE");
    EXPECT_GT(slave, 10);
    const double right = wheels.gear.port<double>(port);
    for (int i = 10; i < 20; ++i) {
      wheels.gear.port<double>("MASTER") = i;
      wheels.gear.port<double>(port) = port == std::string("DENOMINATOR") ? 0 : kNan;
      wheels.gear.fire();
      EXPECT_TRUE(wheels.gear.port<bool>("ERROR")) << port;
      EXPECT_EQ(wheels.gear.port<double>("SLAVE"), slave) << port;
    }
    wheels.gear.port<double>(port) = right;
    EXPECT_EQ(wheels.at(20), slave) << port;
    EXPECT_NEAR(wheels.at(21), slave + 1, 1e-12) << "the clutch closes anew, within one cycle";
    EXPECT_NEAR(wheels.at(22), slave + 3, 1e-12);
  }
  for (const char* port : {"START", "MODULO"}) {
    Wheels wheels(1, 1);
    wheels.gear.port<double>(port) = kNan;
    EXPECT_THROW(wheels.gear.ready(), std::runtime_error);
  }
}

// ---- all ----------------------------------------------------------------------------------------------------------

TEST(Motion, FireAllocatesNothing) {
  const picard_library& library = *motion_library();
  ASSERT_GE(library.block_count, 4u);
  for (std::uint32_t i = 0; i < library.block_count; ++i) {
    picard::Instance block(&library, library.blocks[i].name, milliseconds(1));
    if (std::string(library.blocks[i].name) == "KINEMATICS") block.port<Elements>("MATRIX") = {1, 0, 0, 1};
    block.ready();
    EXPECT_EQ(test::allocations_of([&block] {
                for (int k = 0; k < 100; ++k) block.fire();
              }),
              0u)
        << library.blocks[i].name;
  }
}

}  // namespace
}  // namespace plc::blocks
