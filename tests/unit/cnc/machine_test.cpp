// The blocks together, as the project of the example wires them: GCODE every 10 ms, INTERPOLATOR and a SERVO for each
// axis every 1 ms, a PLC that answers M-codes.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "examples/cnc/blocks/axis.h"
#include "examples/cnc/blocks/element.h"
#include "picard/testing.h"
#include "tests/support/count_allocations.h"
#include "tests/unit/cnc/programmed_path.h"

extern "C" const picard_library* picard_library_v1(void);

namespace cnc {
namespace {

using std::chrono::milliseconds;
using FileName = picard::Text<255>;

constexpr double kPeriod = 0.001;
constexpr double kAcceleration = 1000;
/// What the example promises (README.md), in mm.
constexpr double kPathTolerance = 0.01;
constexpr double kFollowingTolerance = 0.02;

std::string part_program() { return std::string(PLC_SOURCE_ROOT) + "/examples/cnc/part.nc"; }
std::string text_of(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Plant {
 public:
  Plant() {
    gcode.port<FileName>("FILE") = std::string_view(part_program());
    path.port<Vector>("MAX_SPEED") = {120, 120, 60};
    path.port<Vector>("MAX_ACC") = {kAcceleration, kAcceleration, kAcceleration};
    for (int i = 0; i < 3; ++i)
      axes.push_back(std::make_unique<picard::Instance>(picard_library_v1(), "SERVO", milliseconds(1)));
  }
  void cycle() {
    if (cycles++ % 10 == 0) {
      gcode.fire();
      auto& from = gcode.queue("PATH").elements;
      auto& to = path.queue("PATH").elements;
      while (!from.empty() && to.size() < 64) {
        to.push_back(from.front());
        from.pop_front();
      }
    }
    path.port<bool>("CODE_DONE") = path.port<bool>("STROBE");
    path.fire();
    Vector actual;
    for (std::size_t i = 0; i < 3; ++i) {
      const char* const names[] = {"X", "Y", "Z"};
      axes[i]->port<double>("SET") = path.port<double>(names[i]);
      axes[i]->fire();
      // The set point of this cycle is where the axis has to be in the next one.
      following_error = std::max(following_error, std::fabs(axes[i]->port<double>("FOLLOWING_ERROR")));
      actual[i] = axes[i]->port<double>("ACTUAL");
      const double set = path.port<double>(names[i]);
      const double speed = (set - before_[i]) / kPeriod;
      acceleration = std::max(acceleration, std::fabs(speed - speed_[i]) / kPeriod);
      speed_[i] = speed;
      before_[i] = set;
    }
    sets.push_back(before_);
    actuals.push_back(actual);
    lines.push_back(path.port<std::int32_t>("LINE"));
  }

  picard::Instance gcode{picard_library_v1(), "GCODE", milliseconds(10)};
  picard::Instance path{picard_library_v1(), "INTERPOLATOR", milliseconds(1)};
  std::vector<std::unique_ptr<picard::Instance>> axes;
  std::vector<Vector> sets;
  std::vector<Vector> actuals;
  std::vector<std::int32_t> lines;
  double following_error = 0;
  double acceleration = 0;  ///< greatest of all set points' differences
  int cycles = 0;

 private:
  Vector before_{};
  Vector speed_{};
};

TEST(Machine, MillsThePartWithinItsTolerances) {
  Plant plant;
  plant.gcode.ready();
  ASSERT_FALSE(plant.gcode.port<bool>("ERROR"))
      << plant.gcode.port<picard::Text<80>>("MESSAGE").view() << " in line " << plant.gcode.port<std::int32_t>("LINE");
  plant.gcode.port<bool>("START") = true;
  while (!plant.path.port<bool>("DONE") && plant.cycles < 300000) plant.cycle();
  ASSERT_TRUE(plant.path.port<bool>("DONE"));
  const auto path = programmed(text_of(part_program()));
  ASSERT_GT(path.size(), 60u);
  EXPECT_LE(worst_deviation(plant.sets, plant.lines, path), kPathTolerance + 1e-6);
  EXPECT_LE(worst_deviation(plant.actuals, plant.lines, path), kPathTolerance + kFollowingTolerance);
  EXPECT_LE(worst_miss(plant.sets, path), kPathTolerance + 120 * kPeriod);
  EXPECT_LE(plant.following_error, kFollowingTolerance);
  EXPECT_LE(plant.acceleration, kAcceleration * (1 + 1e-6));
  EXPECT_LT(plant.cycles * kPeriod, 120) << "seconds";
  RecordProperty("seconds", std::to_string(plant.cycles * kPeriod));
  RecordProperty("following_error_mm", std::to_string(plant.following_error));
}

TEST(Machine, ALimitSwitchStopsWithinTheAccelerationsAndResetStartsAnew) {
  Plant plant;
  plant.axes[0]->port<double>("HIGH") = 80;
  plant.gcode.port<bool>("START") = true;
  // As the ladder does it: a switch is LIMIT.
  const auto cycle = [&plant] {
    plant.path.port<bool>("LIMIT") = plant.axes[0]->port<bool>("AT_HIGH");
    plant.cycle();
  };
  while (!plant.path.port<bool>("LIMITED") && plant.cycles < 300000) cycle();
  ASSERT_TRUE(plant.path.port<bool>("LIMITED"));
  const double speed = plant.path.port<double>("SPEED");
  EXPECT_GT(speed, 10);
  const int from = plant.cycles;
  while (!plant.path.port<bool>("HELD")) cycle();
  EXPECT_LE((plant.cycles - from) * kPeriod, speed / (kAcceleration * (1 - kStepShare) / 2) + 2 * kPeriod);
  for (int i = 0; i < 200; ++i) cycle();
  EXPECT_LE(plant.acceleration, kAcceleration * (1 + 1e-6));
  EXPECT_LE(plant.sets.back()[0], 80 + 120.0 * 120 / kAcceleration) << "braking way";

  // RESET until both are at rest; then the switch is bridged, and the program begins anew from where the tool is.
  plant.path.port<bool>("RESET") = plant.gcode.port<bool>("RESET") = true;
  plant.gcode.port<bool>("START") = false;
  for (int i = 0; i < 100; ++i) cycle();
  EXPECT_FALSE(plant.gcode.port<bool>("RUNNING"));
  EXPECT_TRUE(plant.path.port<bool>("LIMITED"));
  plant.axes[0]->port<double>("HIGH") = 1000;
  cycle();
  plant.path.port<bool>("RESET") = plant.gcode.port<bool>("RESET") = false;
  const Vector rest = plant.sets.back();
  for (int i = 0; i < 300; ++i) cycle();
  EXPECT_FALSE(plant.path.port<bool>("LIMITED"));
  EXPECT_EQ(plant.sets.back(), rest) << "nothing of the old program is left, neither here nor in the queue";
  const char* const names[] = {"X", "Y", "Z"};
  for (const char* name : names) plant.gcode.port<double>(name) = plant.path.port<double>(name);
  plant.gcode.port<bool>("START") = true;
  while (!plant.path.port<bool>("DONE") && plant.cycles < 300000) cycle();
  EXPECT_TRUE(plant.path.port<bool>("DONE"));
  EXPECT_EQ(plant.sets.back(), (Vector{0, 0, 25}));
  EXPECT_LE(plant.acceleration, kAcceleration * (1 + 1e-6));
}

// As the ladder does it when an axis does not follow: no drive has power any more.
TEST(Machine, AxesThatWereSwitchedOffStayWhereTheyAre) {
  Plant plant;
  plant.gcode.port<bool>("START") = true;
  while (plant.path.port<double>("SPEED") < 50) plant.cycle();
  const auto switch_drives = [&plant](bool on) {
    plant.path.port<bool>("ENABLE") = on;
    plant.path.port<bool>("RESET") = plant.path.port<bool>("HOLD") = plant.gcode.port<bool>("RESET") = !on;
    for (auto& axis : plant.axes) axis->port<bool>("ENABLE") = on;
  };
  const auto cycles = [&plant](int n) {
    for (int i = 0; i < n; ++i) {
      const char* const names[] = {"ACTUAL_X", "ACTUAL_Y", "ACTUAL_Z"};
      for (std::size_t k = 0; k < 3; ++k) plant.path.port<double>(names[k]) = plant.axes[k]->port<double>("ACTUAL");
      plant.cycle();
    }
  };
  switch_drives(false);
  cycles(300);
  EXPECT_TRUE(plant.path.port<bool>("HELD"));
  EXPECT_FALSE(plant.gcode.port<bool>("RUNNING"));
  const Vector rest = plant.actuals.back();
  switch_drives(true);
  cycles(500);
  EXPECT_LE(distance(plant.actuals.back(), rest), 0.001) << "no jump, and nothing is left of the program";
  EXPECT_EQ(plant.sets.back(), rest);
  for (auto& axis : plant.axes) EXPECT_FALSE(axis->port<bool>("EXCESS"));
}

TEST(Machine, ResetForgetsWhatIsInTheQueueAsWell) {
  Plant plant;
  const auto put = [&plant](int n) {
    for (int i = 0; i < n; ++i) {
      const Segment move{.kind = Segment::kLine, .end = {static_cast<double>(i + 1), 0, 0}, .feed = 10};
      picard::TestQueue& queue = plant.path.queue("PATH");
      queue.push(&queue, &move);
    }
  };
  plant.path.port<bool>("HOLD") = true;
  for (int i = 0; i < 4; ++i) {
    put(64);
    for (int k = 0; k < 20; ++k) plant.path.fire();
  }
  put(64);
  plant.path.fire();
  ASSERT_FALSE(plant.path.queue("PATH").elements.empty()) << "more than the interpolator can look ahead";
  plant.path.port<bool>("HOLD") = false;
  plant.path.port<bool>("RESET") = true;
  plant.path.fire();
  plant.path.port<bool>("RESET") = false;
  for (int k = 0; k < 200; ++k) plant.path.fire();
  EXPECT_TRUE(plant.path.queue("PATH").elements.empty());
  EXPECT_EQ(plant.path.port<double>("X"), 0);
}

TEST(Machine, AProgramWithAMistakeIsNotBegun) {
  const std::string file = testing::TempDir() + "cnc_mistake.nc";
  std::ofstream(file) << "G0 X1\nG1 X2 F\n";
  Plant plant;
  plant.gcode.port<FileName>("FILE") = std::string_view(file);
  plant.gcode.port<bool>("START") = true;
  for (int i = 0; i < 100; ++i) plant.cycle();
  EXPECT_TRUE(plant.gcode.port<bool>("ERROR"));
  EXPECT_FALSE(plant.gcode.port<bool>("RUNNING"));
  EXPECT_EQ(plant.gcode.port<std::int32_t>("LINE"), 2);
  EXPECT_EQ(plant.gcode.port<std::int32_t>("COLUMN"), 8);
  EXPECT_EQ(plant.gcode.port<picard::Text<80>>("MESSAGE").view(), "a number must be here");
  EXPECT_EQ(plant.sets.back(), (Vector{0, 0, 0}));
}

TEST(Machine, WhatCannotWorkIsRefusedBeforeTheFirstCycle) {
  Plant plant;
  plant.gcode.port<FileName>("FILE") = std::string_view("/no/such/file.nc");
  EXPECT_THROW(plant.gcode.ready(), std::runtime_error);
  plant.path.port<Vector>("MAX_ACC") = {1, 0, 1};
  EXPECT_THROW(plant.path.ready(), std::runtime_error);
  plant.axes[0]->port<double>("TIME_CONSTANT") = 0;
  EXPECT_THROW(plant.axes[0]->ready(), std::runtime_error);
  for (const char* block : {"INTERPOLATOR", "SERVO"}) {
    picard::Instance event(picard_library_v1(), block, milliseconds(0));
    EXPECT_THROW(event.ready(), std::runtime_error) << block;
  }
}

// Step response of 1 / (s (1 + s T)) from rest: x(t) = c (t - T (1 - exp(-t / T))).
TEST(Servo, TheSimulatedAxisIsTheTransferFunction) {
  SimulatedAxis axis;
  axis.start(0.01, 0.001, kPeriod, 0);
  for (int i = 1; i <= 100; ++i) {
    axis.step(30);
    const double t = i * kPeriod;
    EXPECT_NEAR(axis.position(), 30 * (t - 0.01 * (1 - std::exp(-t / 0.01))), 1e-12);
    EXPECT_NEAR(axis.encoder(), axis.position(), 0.0005 + 1e-12);
    EXPECT_NEAR(std::remainder(axis.encoder(), 0.001), 0, 1e-12);
  }
}

// Without feed-forward an axis with gain K lags a ramp by v / K (type 1 loop); with it, not at all.
TEST(Servo, FollowsARampWithTheErrorOfTheLoop) {
  for (const double share : {0.0, 1.0}) {
    picard::Instance servo(picard_library_v1(), "SERVO", milliseconds(1));
    servo.port<double>("SPEED_SHARE") = share;
    servo.port<double>("ACC_TIME") = 0;
    servo.port<double>("RESOLUTION") = 1e-6;
    for (int i = 0; i < 2000; ++i) {
      servo.port<double>("SET") = 20 * kPeriod * i;
      servo.fire();
    }
    EXPECT_NEAR(servo.port<double>("FOLLOWING_ERROR"), (1 - share) * 20 / 50, 1e-5);
  }
}

TEST(Servo, ALargeErrorOpensTheLoopUntilItIsSwitchedOff) {
  picard::Instance servo(picard_library_v1(), "SERVO", milliseconds(1));
  servo.port<bool>("ENABLE") = true;
  const auto cycles = [&servo](int n) {
    for (int i = 0; i < n; ++i) servo.fire();
  };
  for (const double wrong : {2.0, std::nan("")}) {
    servo.port<double>("SET") = servo.port<double>("ACTUAL");
    cycles(2);
    EXPECT_FALSE(servo.port<bool>("EXCESS"));
    servo.port<double>("SET") = servo.port<double>("ACTUAL") + wrong;
    cycles(1);
    EXPECT_TRUE(servo.port<bool>("EXCESS"));
    EXPECT_EQ(servo.port<double>("COMMAND"), 0);
    servo.port<double>("SET") = servo.port<double>("ACTUAL");
    cycles(100);
    EXPECT_TRUE(servo.port<bool>("EXCESS"));
    servo.port<bool>("ENABLE") = false;
    cycles(1);
    servo.port<bool>("ENABLE") = true;
    cycles(1);
    EXPECT_FALSE(servo.port<bool>("EXCESS"));
  }
}

TEST(Machine, FireAllocatesNothing) {
  Plant plant;
  plant.gcode.port<bool>("START") = true;
  plant.cycle();
  plant.gcode.queue("PATH").elements.clear();
  // The queues of the test allocate; so the interpolator works on what it has, and GCODE has no room.
  for (int i = 0; i < 100; ++i) plant.cycle();
  EXPECT_EQ(plc::test::allocations_of([&plant] {
              for (int i = 0; i < 500; ++i) {
                plant.path.fire();
                for (auto& axis : plant.axes) axis->fire();
              }
            }),
            0u);
}

}  // namespace
}  // namespace cnc
