#include "examples/cnc/blocks/interpolator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "examples/cnc/blocks/gcode.h"
#include "tests/support/count_allocations.h"
#include "tests/unit/cnc/programmed_path.h"

namespace cnc {
namespace {

constexpr double kPeriod = 0.001;
constexpr double kDeviation = 0.01;

/// An interpolator with a program to run, and what its set points did so far.
class Machine {
 public:
  explicit Machine(const PathLimits& limits = {}) : limits_(limits) { core.start(limits, {}); }

  void load(const std::string& program) {
    Interpreter interpreter;
    interpreter.start(program, core.position());
    Interpreter::Segments some;
    while (!interpreter.finished()) {
      interpreter.next(some);
      segments.insert(segments.end(), some.all.begin(), some.all.begin() + static_cast<int>(some.count));
    }
    ASSERT_EQ(interpreter.mistake().text, nullptr) << interpreter.mistake().text << ' ' << interpreter.line();
  }
  void cycle() {
    while (!segments.empty() && core.wants_segment() && supply) {
      if (!core.resetting()) core.add(segments.front());
      segments.pop_front();
      if (one_at_a_time) break;
    }
    core.step(command, segments.empty() || !supply);
    // The PLC confirms at once.
    command.code_done = core.code_strobe();
    if (core.code_strobe() && (codes.empty() || !strobe_before_)) codes.push_back(core.code());
    strobe_before_ = core.code_strobe();
    watch();
    positions.push_back(core.position());
    lines.push_back(core.line());
  }
  /// Until the program is over; returns the number of cycles.
  int run(int most = 400000) {
    for (int i = 1; i <= most; ++i) {
      cycle();
      if (core.program_done()) return i;
    }
    ADD_FAILURE() << "the program does not end; line " << core.line() << ", speed " << core.speed();
    return most;
  }
  void expect_within_limits() const {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE(most_speed[i], limits_.speed[i] * (1 + 1e-6)) << "axis " << i;
      EXPECT_LE(most_acceleration[i], limits_.acceleration[i] * (1 + 1e-6)) << "axis " << i;
    }
  }

  Interpolator core;
  Interpolator::Command command;
  std::deque<Segment> segments;
  bool supply = true;
  bool one_at_a_time = false;
  std::vector<Vector> positions;
  std::vector<std::int32_t> lines;
  std::vector<int> codes;
  Vector most_speed{};
  Vector most_acceleration{};  ///< by differences of set points, as an axis sees it

 private:
  void watch() {
    const Vector& p = core.position();
    for (std::size_t i = 0; i < 3; ++i) {
      const double speed = (p[i] - before_[i]) / kPeriod;
      most_speed[i] = std::max(most_speed[i], std::fabs(speed));
      most_acceleration[i] = std::max(most_acceleration[i], std::fabs(speed - speed_[i]) / kPeriod);
      speed_[i] = speed;
    }
    before_ = p;
  }
  PathLimits limits_;
  Vector before_{};
  Vector speed_{};
  bool strobe_before_ = false;
};

TEST(Interpolator, ALineTakesTheTimeOfTheTrapezoid) {
  Machine machine;
  machine.load("G1 X40 Y30 F3000\n");
  for (int i = 0; i < 60; ++i) machine.cycle();  // it waits for a second segment, or the end
  machine.run();
  // 50 mm at 50 mm/s; the axis that has most to do, X with 4/5 of the way, has 1000 mm/s2 less the share for steps.
  const double a = 1000 * (1 - kStepShare) / 0.8;
  int moving = 0;
  for (std::size_t i = 1; i < machine.positions.size(); ++i) moving += machine.positions[i] != machine.positions[i - 1];
  EXPECT_NEAR(moving * kPeriod, 50.0 / 50 + 50 / a, 2 * kPeriod);
  EXPECT_EQ(machine.core.position(), (Vector{40, 30, 0}));
  machine.expect_within_limits();
}

TEST(Interpolator, ARapidIsAsFastAsTheSlowestAxisAllows) {
  Machine machine({.speed = {100, 50, 10}, .acceleration = {1000, 1000, 200}});
  machine.load("G0 X40 Y40 Z-2\n");
  machine.run();
  machine.expect_within_limits();
  EXPECT_NEAR(machine.most_speed[1], 50, 1e-6) << "Y is the one with no reserve";
}

// The circle through a corner that is `deviation` away from it: radius = d cos(t/2) / (1 - cos(t/2)), t = the angle by
// which the path turns.
TEST(Interpolator, ACornerIsPassedWithTheSpeedOfItsDeviation) {
  for (const double degrees : {30.0, 60.0, 90.0, 120.0}) {
    Machine machine;
    const double angle = degrees * M_PI / 180;
    const Vector last{20 + 20 * std::cos(angle), 20 * std::sin(angle), 0};
    machine.core.add({.kind = Segment::kLine, .end = {20, 0, 0}, .feed = 80});
    machine.core.add({.kind = Segment::kLine, .end = last, .feed = 80});
    machine.core.add({.kind = Segment::kEnd});
    double slowest = 80;
    double nearest = 1;
    while (!machine.core.program_done()) {
      machine.cycle();
      const Vector& p = machine.core.position();
      const double distance = std::hypot(p[0] - 20, p[1]);
      if (distance < 0.2) slowest = std::min(slowest, machine.core.speed());
      nearest = std::min(nearest, distance);
    }
    const double half = std::cos(angle / 2);
    // Axes see the acceleration of the arc from any direction: 1000 less the share for steps, sqrt(3)/2 of it across.
    const double expected = std::sqrt(1000 * (1 - kStepShare) * std::sqrt(3) / 2 * kDeviation * half / (1 - half));
    EXPECT_NEAR(slowest, expected, 0.01 * expected) << degrees;
    EXPECT_LE(nearest, kDeviation + expected * kPeriod) << degrees;
    machine.expect_within_limits();
  }
}

TEST(Interpolator, ArcsAreExact) {
  Machine machine;
  machine.load("G1 X10 Y0 F6000\nG3 X10 Y0 I-10 J0\nG2 X-10 R10 Z-5\n");
  machine.run();
  machine.expect_within_limits();
  for (const Vector& p : machine.positions) {
    if (p[1] != 0) {
      EXPECT_NEAR(std::hypot(p[0], p[1]), 10, 1e-12);
    }
    if (p[2] < 0) {  // the helix: Z evenly with the angle, clockwise from X = 10 by half a turn
      EXPECT_NEAR(p[2], -5 * std::acos(std::clamp(p[0] / 10, -1.0, 1.0)) / M_PI, 1e-6);
      EXPECT_LE(p[1], 1e-9);
    }
  }
  EXPECT_EQ(machine.core.position(), (Vector{-10, 0, -5}));
}

TEST(Interpolator, CornersWithArcsThatAreNotTangentArePassedAtRest) {
  Machine machine;
  machine.load("G1 X10 F3000\nG3 X20 R5\nG1 X40\n");  // both corners turn by 90 degrees
  double slowest = 100;
  machine.core.step({}, false);
  while (!machine.core.program_done()) {
    machine.cycle();
    const Vector& p = machine.core.position();
    if (std::hypot(p[0] - 10, p[1]) < 0.01) slowest = std::min(slowest, machine.core.speed());
  }
  EXPECT_LT(slowest, 1.5);
  machine.expect_within_limits();
  EXPECT_LE(worst_deviation(machine.positions, machine.lines, programmed("G1 X10 F3000\nG3 X20 R5\nG1 X40\n")), 1e-9);
}

TEST(Interpolator, TangentsArePassedAtFullSpeed) {
  Machine machine;
  machine.load("G1 X20 F1200\nG3 X20 Y10 R5\nG1 X0\n");
  double slowest = 100;
  while (!machine.core.program_done()) {
    machine.cycle();
    const Vector& p = machine.core.position();
    if (p[0] > 15) slowest = std::min(slowest, machine.core.speed());
  }
  EXPECT_NEAR(slowest, 20, 1e-9);
  machine.expect_within_limits();
}

// Programs from CAM are full of lines of some micrometres: a cycle passes a bounded number of them, and so fast the
// tool is, smoothly.
TEST(Interpolator, TinyLinesArePassedFourInACycle) {
  Machine machine;
  for (int i = 1; i <= 4000; ++i) {
    const double angle = i * 0.002 / 5;
    machine.segments.push_back(
        {.kind = Segment::kLine, .end = {5 * std::sin(angle), 5 - 5 * std::cos(angle), 0}, .feed = 80});
  }
  machine.segments.push_back({.kind = Segment::kEnd});
  const int cycles = machine.run();
  EXPECT_NEAR(cycles * kPeriod, 4000 * 0.002 / (4 * 0.002 / kPeriod), 0.1);
  EXPECT_NEAR(machine.most_speed[0], 4 * 0.002 / kPeriod, 0.01);
  machine.expect_within_limits();
}

/// A program with something of everything, made at random.
std::string any_program(std::mt19937& random, int blocks) {
  std::uniform_real_distribution<double> any(-1, 1);
  std::string program = "G91 F" + std::to_string(1500 + 1400 * any(random)) + "\n";
  for (int i = 0; i < blocks; ++i) {
    const double size = std::pow(10.0, 1.5 * any(random));  // 0.03 to 30 mm
    const std::string x = std::to_string(size * any(random)), y = std::to_string(size * any(random));
    switch (random() % 8) {
      case 0:
        program += "G0 X" + x + " Y" + y + " Z" + std::to_string(any(random)) + "\n";
        break;
      case 1:
        program += "G2 X" + x + " Y" + y + " R" + std::to_string(size * (1 + std::fabs(any(random)))) + "\n";
        break;
      case 2:
        program += "G3 I" + x + " J" + y + " Z" + std::to_string(any(random)) + "\n";
        break;
      case 3:
        program += random() % 4 == 0 ? "M8\n" : "F" + std::to_string(1500 + 1400 * any(random)) + "\n";
        break;
      default:
        program += "G1 X" + x + " Y" + y + "\n";
    }
  }
  return program;
}

TEST(Interpolator, AnyProgramStaysWithinLimitsAndDeviation) {
  std::mt19937 random(5);
  for (int i = 0; i < 40; ++i) {
    const std::string program = any_program(random, 60);
    Machine machine({.speed = {100, 80, 30}, .acceleration = {1000, 700, 300}, .deviation = kDeviation});
    machine.load(program);
    machine.run();
    machine.expect_within_limits();
    EXPECT_LE(worst_deviation(machine.positions, machine.lines, programmed(program)), kDeviation + 1e-6) << program;
    EXPECT_LE(worst_miss(machine.positions, programmed(program)), kDeviation + 100 * kPeriod) << program;
    if (HasFailure()) break;
  }
}

TEST(Interpolator, WhateverTheOperatorDoesItStaysWithinLimitsAndDeviation) {
  std::mt19937 random(6);
  for (int i = 0; i < 20; ++i) {
    const std::string program = any_program(random, 60);
    Machine machine({.speed = {100, 80, 30}, .acceleration = {1000, 700, 300}, .deviation = kDeviation});
    machine.load(program);
    machine.one_at_a_time = i % 2 == 0;
    for (int k = 0; k < 400000 && !machine.core.program_done(); ++k) {
      if (random() % 50 == 0) machine.command.hold = random() % 3 == 0;
      if (random() % 50 == 0) machine.command.override_factor = static_cast<double>(random() % 9) / 4;
      if (random() % 100 == 0) machine.supply = random() % 4 != 0;  // the queue runs dry
      machine.cycle();
    }
    EXPECT_TRUE(machine.core.program_done());
    machine.expect_within_limits();
    EXPECT_LE(worst_deviation(machine.positions, machine.lines, programmed(program)), kDeviation + 1e-6) << program;
    if (HasFailure()) break;
  }
}

TEST(Interpolator, FeedHoldStopsInTheLeastWayAndGoesOn) {
  Machine machine;
  machine.load("G1 X200 F3000\n");
  while (machine.core.position()[0] < 50) machine.cycle();
  const double from = machine.core.position()[0];
  machine.command.hold = true;
  for (int i = 0; i < 200 && !machine.core.held(); ++i) machine.cycle();
  EXPECT_TRUE(machine.core.held());
  EXPECT_NEAR(machine.core.position()[0] - from, 50 * 50 / (2 * 950.0), 1e-6) << "v^2 / 2a";
  const Vector rest = machine.core.position();
  for (int i = 0; i < 100; ++i) machine.cycle();
  EXPECT_EQ(machine.core.position(), rest);
  machine.command.hold = false;
  machine.run();
  EXPECT_EQ(machine.core.position()[0], 200);
  machine.expect_within_limits();
}

TEST(Interpolator, ALimitStopsOnThePathUntilReset) {
  Machine machine;
  const std::string program = "G1 X10 F4000\nG3 X10 Y20 R10\nG1 X0\nG1 Y0\n";
  machine.load(program);
  while (machine.core.position()[1] < 8) machine.cycle();
  const double speed = machine.core.speed();
  const std::size_t from = machine.positions.size();
  machine.command.limit = true;
  machine.cycle();
  machine.command.limit = false;  // the axis has gone over the switch
  while (!machine.core.held()) machine.cycle();
  EXPECT_TRUE(machine.core.limited());
  // On an arc half of the acceleration is for braking.
  EXPECT_NEAR(static_cast<double>(machine.positions.size() - from) * kPeriod, speed / (950.0 / 2), 2 * kPeriod);
  for (int i = 0; i < 100; ++i) machine.cycle();
  EXPECT_EQ(machine.core.speed(), 0);
  machine.command.reset = true;
  for (int i = 0; i < 100; ++i) machine.cycle();
  machine.command.reset = false;
  machine.cycle();
  EXPECT_FALSE(machine.core.limited());
  EXPECT_EQ(machine.core.elements(), 0u);
  EXPECT_LE(worst_deviation(machine.positions, machine.lines, programmed(program)), kDeviation + 1e-9);
  // And it works again, from where it is.
  machine.load("G0 X0 Y0\nM30\n");
  machine.run();
  EXPECT_EQ(machine.core.position(), (Vector{0, 0, 0}));
  machine.expect_within_limits();
}

TEST(Interpolator, OverrideScalesTheFeedAndZeroHolds) {
  Machine machine;
  machine.load("G1 X200 F3000\n");
  machine.command.override_factor = 0.5;
  for (int i = 0; i < 500; ++i) machine.cycle();
  EXPECT_NEAR(machine.core.speed(), 25, 1e-9);
  machine.command.override_factor = 1.2;
  for (int i = 0; i < 500; ++i) machine.cycle();
  EXPECT_NEAR(machine.core.speed(), 60, 1e-9);
  for (const double none : {0.0, -1.0, std::nan("")}) {
    machine.command.override_factor = none;
    for (int i = 0; i < 200; ++i) machine.cycle();
    EXPECT_EQ(machine.core.speed(), 0) << none;
    machine.command.override_factor = 1;
    for (int i = 0; i < 200; ++i) machine.cycle();
  }
  machine.run();
  machine.expect_within_limits();
}

TEST(Interpolator, CodesWaitForThePlcWithFourEdges) {
  Interpolator core;
  core.start({}, {});
  core.add({.kind = Segment::kCode, .code = 3});
  core.add({.kind = Segment::kCode, .code = 8});
  core.add({.kind = Segment::kEnd});
  Interpolator::Command command;
  for (const int code : {3, 8}) {
    for (int i = 0; i < 10; ++i) core.step(command, true);
    EXPECT_TRUE(core.code_strobe());
    EXPECT_EQ(core.code(), code);
    command.code_done = true;
    for (int i = 0; i < 10; ++i) core.step(command, true);
    EXPECT_FALSE(core.code_strobe());
    EXPECT_FALSE(core.program_done());
    EXPECT_EQ(core.code(), code) << "an answer that stays confirms nothing else";
    command.code_done = false;
  }
  for (int i = 0; i < 3; ++i) core.step(command, true);
  EXPECT_TRUE(core.program_done());
}

TEST(Interpolator, DwellsAndCodesAreAtRestBetweenMotions) {
  Machine machine;
  machine.load("G1 X10 F3000 S100\nG4 P0.25\nG1 X20 M3 S200\nM5\nG1 X30\n");
  machine.run();
  EXPECT_EQ(machine.codes, (std::vector<int>{3, 5}));
  for (const double x : {10.0, 20.0}) {
    const auto at = [x](const Vector& p) { return p[0] == x; };
    EXPECT_GE(std::count_if(machine.positions.begin(), machine.positions.end(), at), x == 10 ? 250 : 3) << x;
  }
  machine.expect_within_limits();
}

TEST(Interpolator, SegmentsThatMakeNoSenseDoNoHarm) {
  Machine machine;
  const double nan = std::nan("");
  machine.core.add({.kind = Segment::kLine, .end = {nan, 0, 0}, .feed = 10});
  machine.core.add({.kind = Segment::kLine, .end = {0, 0, 0}, .feed = 10});
  machine.core.add({.kind = Segment::kArc, .end = {1, 0, 0}, .centre = {0, 0}, .sweep = 1, .feed = 10});
  machine.core.add({.kind = Segment::kLine, .end = {1, 0, 0}, .feed = 10});
  machine.core.add({.kind = 99});
  machine.run(2000);
  EXPECT_EQ(machine.core.position(), (Vector{1, 0, 0}));
}

TEST(Interpolator, NothingAllocates) {
  std::mt19937 random(8);
  Machine machine;
  machine.load(any_program(random, 200));
  EXPECT_EQ(plc::test::allocations_of([&machine] {
              for (int i = 0; i < 5000; ++i) {
                if (machine.core.wants_segment() && i % 20 == 0)
                  machine.core.add(machine.segments[static_cast<std::size_t>(i / 20) % machine.segments.size()]);
                machine.core.step({}, false);
              }
            }),
            0u);
}

}  // namespace
}  // namespace cnc
