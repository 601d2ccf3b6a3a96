// Signal blocks against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "taskblocks/signals/noise.h"
#include "tests/support/count_allocations.h"

namespace plc::blocks {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::numbers::pi;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double fire(picard::Instance& block, double in) {
  block.port<double>("IN") = in;
  block.fire();
  return block.port<double>("OUT");
}

/// Why ready() refuses, "" when it does not.
template <class Block>
std::string refusal(Block&& block) {
  try {
    block.ready();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// ---- LOOKUP_TABLE

struct Curve {
  picard::Instance block{signals_library(), "LOOKUP_TABLE", milliseconds(1)};

  explicit Curve(const std::vector<std::pair<double, double>>& points, bool extrapolate = false) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      block.port<std::array<double, 64>>("X")[i] = points[i].first;
      block.port<std::array<double, 64>>("Y")[i] = points[i].second;
    }
    block.port<std::int32_t>("POINTS") = static_cast<std::int32_t>(points.size());
    block.port<bool>("EXTRAPOLATE") = extrapolate;
  }
  double operator()(double in) { return fire(block, in); }
  bool outside() { return block.port<bool>("OUTSIDE"); }
};

TEST(LookupTable, ReadsAThermometerLikeItsStandard) {
  // Pt100, IEC 60751:2008 table 1, resistance in ohm at -100, 0, 100, 200, 300 degrees; the standard's value between
  // the points differs from the straight line by less than half a degree.
  Curve curve({{60.256, -100}, {100, 0}, {138.506, 100}, {175.856, 200}, {212.052, 300}});
  EXPECT_EQ(curve(60.256), -100);
  EXPECT_EQ(curve(100), 0);
  EXPECT_EQ(curve(138.506), 100);
  EXPECT_EQ(curve(212.052), 300);
  EXPECT_NEAR(curve(119.397), 50, 0.5);
  EXPECT_NEAR(curve(157.325), 150, 0.5);
}

TEST(LookupTable, IsTheLineBetweenTwoPoints) {
  Curve curve({{-2, 1}, {0, 5}, {4, -3}});
  for (double in = -2; in <= 4; in += 0.01) {
    EXPECT_NEAR(curve(in), in < 0 ? 1 + 2 * (in + 2) : 5 - 2 * in, 1e-12) << in;
    EXPECT_FALSE(curve.outside()) << in;
  }
}

TEST(LookupTable, WithAllPointsFindsEachOfThem) {
  std::vector<std::pair<double, double>> points;
  for (int i = 0; i < 64; ++i) points.emplace_back(i * i, 1.0 / (i + 1));
  Curve curve(points);
  for (const auto& [x, y] : points) EXPECT_EQ(curve(x), y) << x;
  EXPECT_DOUBLE_EQ(curve(0.5 * (62 * 62 + 63 * 63)), 0.5 * (1.0 / 63 + 1.0 / 64));
}

TEST(LookupTable, HoldsItsEndsOrGoesOn) {
  Curve held({{0, 1}, {1, 3}, {2, 4}});
  EXPECT_EQ(held(-10), 1);
  EXPECT_TRUE(held.outside());
  EXPECT_EQ(held(10), 4);
  EXPECT_EQ(held(kInfinity), 4);
  EXPECT_EQ(held(-kInfinity), 1);
  Curve longer({{0, 1}, {1, 3}, {2, 4}}, true);
  EXPECT_DOUBLE_EQ(longer(-10), -19);
  EXPECT_DOUBLE_EQ(longer(10), 12);
  EXPECT_TRUE(longer.outside());
  EXPECT_EQ(longer(kInfinity), 4);
  EXPECT_EQ(longer(-kInfinity), 1);
}

TEST(LookupTable, KeepsItsValueWhileThereIsNoNumber) {
  Curve curve({{0, 1}, {1, 3}});
  curve(0.5);
  EXPECT_EQ(curve(kNan), 2);
}

TEST(LookupTable, RefusesWhatIsNoCurve) {
  EXPECT_EQ(refusal(Curve({{0, 1}, {0, 2}}).block), "X does not rise from each point to the next");
  EXPECT_EQ(refusal(Curve({{0, 1}, {2, 2}, {1, 2}}).block), "X does not rise from each point to the next");
  EXPECT_EQ(refusal(Curve({{0, 1}, {kInfinity, 2}}).block), "X or Y is not finite at a point");
  EXPECT_EQ(refusal(Curve({{0, kNan}, {1, 2}}).block), "X or Y is not finite at a point");
  EXPECT_EQ(refusal(Curve({{0, 1}}).block), "POINTS is 1, its range is 2 .. 64");
  Curve many({{0, 1}, {1, 2}});
  many.block.port<std::int32_t>("POINTS") = 65;
  EXPECT_EQ(refusal(many.block), "POINTS is 65, its range is 2 .. 64");
}

// ---- RATE_LIMITER

struct Ramp {
  picard::Instance block{signals_library(), "RATE_LIMITER", milliseconds(125)};

  Ramp(double rising, double falling) {
    block.port<double>("RISING") = rising;
    block.port<double>("FALLING") = falling;
  }
  double operator()(double in) { return fire(block, in); }
  bool limited() { return block.port<bool>("LIMITED"); }
};

TEST(RateLimiter, FollowsAStepInStraightLines) {
  Ramp ramp(2, 5);
  ramp(0);
  for (int i = 1; i <= 60; ++i) {
    EXPECT_EQ(ramp(10), std::min(10.0, 0.25 * i)) << i;
    EXPECT_EQ(ramp.limited(), i < 40) << i;
  }
  for (int i = 1; i <= 40; ++i) EXPECT_EQ(ramp(-6), std::max(-6.0, 10 - 0.625 * i)) << i;
}

TEST(RateLimiter, PassesWhatIsSlowEnough) {
  Ramp ramp(1, 1);
  for (int i = 0; i < 200; ++i) {
    const double in = std::sin(0.09 * i);
    EXPECT_EQ(ramp(in), in) << i;
    EXPECT_FALSE(ramp.limited()) << i;
  }
}

TEST(RateLimiter, DoesNotMoveWithoutARate) {
  for (const double none : {0.0, -3.0, kNan}) {
    Ramp ramp(none, 1);
    ramp(0);
    EXPECT_EQ(ramp(10), 0) << none;
    EXPECT_TRUE(ramp.limited()) << none;
    EXPECT_EQ(ramp(-10), -0.125) << none;
    Ramp other(1, none);
    other(0);
    EXPECT_EQ(other(-10), 0) << none;
  }
  Ramp free(kInfinity, kInfinity);
  free(0);
  EXPECT_EQ(free(1e300), 1e300);
}

TEST(RateLimiter, StartsAtTheFirstNumberAndHoldsWhileThereIsNone) {
  Ramp ramp(1, 1);
  EXPECT_EQ(ramp(kNan), 0);
  EXPECT_EQ(ramp(50), 50);
  EXPECT_EQ(ramp(kInfinity), 50);
  EXPECT_EQ(ramp(kNan), 50);
  EXPECT_EQ(ramp(60), 50.125);
  ramp.block.port<bool>("RESET") = true;
  EXPECT_EQ(ramp(-60), -60);
  EXPECT_FALSE(ramp.limited());
}

TEST(RateLimiter, DoesNotMoveWhenNoTimePassed) {
  picard::Instance ramp(signals_library(), "RATE_LIMITER", milliseconds(0));
  ramp.port<double>("RISING") = kInfinity;
  fire(ramp, 1);
  EXPECT_EQ(fire(ramp, 2), 1);
}

// ---- SIGNAL_GENERATOR

struct Generator {
  picard::Instance block;

  explicit Generator(std::string_view shape, std::chrono::nanoseconds period = milliseconds(1))
      : block(signals_library(), "SIGNAL_GENERATOR", period) {
    block.port<picard::Text<12>>("SHAPE") = shape;
  }
  double& operator[](const char* port) { return block.port<double>(port); }
  double operator()() {
    block.fire();
    return block.port<double>("OUT");
  }
};

TEST(SignalGenerator, SineIsTheSine) {
  Generator sine("SINE");
  sine["FREQUENCY"] = 7;
  sine["AMPLITUDE"] = 3;
  sine["OFFSET"] = -2;
  sine["PHASE"] = 30;
  for (int i = 0; i < 5000; ++i)
    EXPECT_NEAR(sine(), -2 + 3 * std::sin(2 * pi * (7 * i * 1e-3 + 30 / 360.0)), 1e-10) << i;
}

TEST(SignalGenerator, DoesNotDrift) {
  // A million cycles of 0.1 periods are a whole number of periods.
  Generator sine("SINE");
  sine["FREQUENCY"] = 100;
  for (int i = 0; i < 1'000'000; ++i) sine();
  EXPECT_NEAR(sine(), 0, 1e-9);
}

TEST(SignalGenerator, SquareIsHighForItsPart) {
  Generator square("SQUARE");
  square["FREQUENCY"] = 10;
  square["DUTY"] = 0.255;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(square(), i % 100 <= 25 ? 1 : -1) << i;
  for (const auto& [duty, out] : {std::pair{0.0, -1.0}, {-1.0, -1.0}, {1.0, 1.0}, {2.0, 1.0}, {kNan, -1.0}}) {
    square["DUTY"] = duty;
    for (int i = 0; i < 100; ++i) EXPECT_EQ(square(), out) << duty;
  }
}

TEST(SignalGenerator, TriangleIsTheArcsineOfTheSineAndSawtoothRises) {
  Generator triangle("TRIANGLE");
  Generator sawtooth("SAWTOOTH");
  triangle["FREQUENCY"] = sawtooth["FREQUENCY"] = 4;
  for (int i = 0; i < 1000; ++i) {
    const double turns = 4 * i * 1e-3;
    EXPECT_NEAR(triangle(), 2 / pi * std::asin(std::sin(2 * pi * turns)), 1e-7) << i;
    const double saw = sawtooth();
    if (i % 250 == 0) continue;  // the edge: either side is right
    EXPECT_NEAR(saw, 2 * (turns - std::floor(turns)) - 1, 1e-10) << i;
  }
}

TEST(SignalGenerator, ChirpHasThePhaseOfTheIntegral) {
  Generator chirp("CHIRP");
  chirp["FREQUENCY"] = 2;
  chirp["FREQUENCY_END"] = 20;
  chirp.block.port<picard::Time>("SWEEP") = std::chrono::seconds(3);
  for (int i = 0; i < 9000; ++i) {
    const double time = (i % 3000) * 1e-3;
    const double before = i / 3000 * (2 + 20) / 2.0 * 3;
    EXPECT_NEAR(chirp(), std::sin(2 * pi * (before + 2 * time + (20 - 2) / 3.0 * time * time / 2)), 1e-8) << i;
  }
}

TEST(SignalGenerator, ChirpIsRightWhenACycleIsLongerThanItsSweep) {
  // 2 1/2 sweeps of 1 s in a cycle: 2 * 5.5 turns and the first half of a sweep, 1 * 0.5 + 9 * 0.5^2 / 2 turns.
  Generator chirp("CHIRP", milliseconds(2500));
  chirp["FREQUENCY"] = 1;
  chirp.block.port<picard::Time>("SWEEP") = std::chrono::seconds(1);
  chirp();
  EXPECT_NEAR(chirp(), std::sin(2 * pi * (11 + 0.5 + 1.125)), 1e-12);
}

TEST(SignalGenerator, ChangesWithoutAJumpAndRunsBackwards) {
  Generator sine("SINE");
  sine["FREQUENCY"] = 10;
  for (int i = 0; i < 7; ++i) sine();
  sine["FREQUENCY"] = 20;
  EXPECT_NEAR(sine(), std::sin(2 * pi * (0.06 + 0.02)), 1e-12);
  sine["FREQUENCY"] = -10;
  EXPECT_NEAR(sine(), std::sin(2 * pi * (0.06 + 0.02 - 0.01)), 1e-12);
  for (const double none : {kNan, kInfinity}) {
    sine["FREQUENCY"] = none;
    EXPECT_NEAR(sine(), std::sin(2 * pi * 0.07), 1e-12);
  }
  sine["PHASE"] = kNan;
  EXPECT_NEAR(sine(), std::sin(2 * pi * 0.07), 1e-12);
  sine["PHASE"] = -1e-300;
  sine.block.port<bool>("RESET") = true;
  EXPECT_EQ(sine(), 0);
}

TEST(Noise, IsSplitMix64) {
  // The reference implementation of S. Vigna (prng.di.unimi.it/splitmix64.c) with the seed 1234567.
  Noise noise(1234567);
  for (const std::uint64_t expected : {6457827717110365317U, 3203168211198807973U, 9817491932198370423U,
                                       4593380528125082431U, 16408922859458223821U}) {
    EXPECT_EQ(noise.next(), expected);
  }
}

TEST(SignalGenerator, NoiseHasTheMomentsOfItsDistribution) {
  constexpr int kCount = 1'000'000;
  for (const auto& [shape, second, fourth] :
       {std::tuple{"NOISE", 1 / 3.0, 1 / 5.0}, std::tuple{"GAUSSIAN", 1.0, 3.0}}) {
    Generator noise(shape);
    double m1 = 0, m2 = 0, m4 = 0, next = 0, before = 0;
    for (int i = 0; i < kCount; ++i) {
      const double x = noise();
      m1 += x;
      m2 += x * x;
      m4 += x * x * x * x;
      next += x * before;
      before = x;
    }
    // Five standard deviations of each mean.
    EXPECT_NEAR(m1 / kCount, 0, 5 * std::sqrt(second / kCount)) << shape;
    EXPECT_NEAR(m2 / kCount, second, 5 * std::sqrt(2.0 / kCount)) << shape;
    EXPECT_NEAR(m4 / kCount, fourth, 5 * std::sqrt(96.0 / kCount)) << shape;
    EXPECT_NEAR(next / kCount, 0, 5 * second / std::sqrt(kCount)) << shape;
  }
}

TEST(SignalGenerator, NoiseIsTheSameForTheSameSeed) {
  Generator one("NOISE"), same("NOISE"), other("NOISE");
  other.block.port<std::uint32_t>("SEED") = 2;
  std::vector<double> begin;
  for (int i = 0; i < 10; ++i) {
    begin.push_back(one());
    EXPECT_EQ(same(), begin.back());
    EXPECT_NE(other(), begin.back());
  }
  one.block.port<bool>("RESET") = true;
  EXPECT_EQ(one(), begin[0]);
  one.block.port<bool>("RESET") = false;
  EXPECT_EQ(one(), begin[1]);
}

TEST(SignalGenerator, RefusesWhatItCannotMake) {
  EXPECT_NE(refusal(Generator("COSINE").block), "");
  EXPECT_NE(refusal(Generator("").block), "");
  Generator chirp("CHIRP");
  chirp.block.port<picard::Time>("SWEEP") = picard::Time(0);
  EXPECT_EQ(refusal(chirp.block), "SWEEP is not above 0");
  Generator other("CHIRP");
  other["FREQUENCY_END"] = kNan;
  EXPECT_EQ(refusal(other.block), "FREQUENCY_END is not finite");
}

// ---- RECORDER

struct Record {
  picard::Instance block{signals_library(), "RECORDER", milliseconds(10)};
  int cycle = 0;

  Record(std::int32_t samples, std::int32_t pretrigger, std::int32_t every = 1) {
    block.port<std::int32_t>("SAMPLES") = samples;
    block.port<std::int32_t>("PRETRIGGER") = pretrigger;
    block.port<std::int32_t>("EVERY") = every;
  }
  /// One execution; the signals are the number of the cycle, from 0, times 1 to 4.
  void operator()(bool arm, bool trigger) {
    block.port<bool>("ARM") = arm;
    block.port<bool>("TRIGGER") = trigger;
    for (int i = 1; i <= 4; ++i) block.port<double>("IN" + std::to_string(i)) = cycle * i;
    block.fire();
    ++cycle;
  }
  /// The numbers of the cycles in the record, read through INDEX in executions that change nothing else.
  std::vector<int> cycles() {
    std::vector<int> all;
    const std::int32_t count = block.port<std::int32_t>("COUNT");
    for (std::int32_t i = 0; i < count; ++i) {
      block.port<std::int32_t>("INDEX") = i;
      block.fire();
      EXPECT_TRUE(block.port<bool>("VALID"));
      all.push_back(static_cast<int>(block.port<double>("OUT1")));
      EXPECT_EQ(block.port<double>("OUT4"), 4 * block.port<double>("OUT1"));
      EXPECT_EQ(block.port<double>("OUT3"), 3 * block.port<double>("OUT1"));
      EXPECT_EQ(block.port<double>("OUT2"), 2 * block.port<double>("OUT1"));
    }
    return all;
  }
  bool flag(const char* name) { return block.port<bool>(name); }
  std::int32_t number(const char* name) { return block.port<std::int32_t>(name); }
};

TEST(Recorder, KeepsWhatWasBeforeAndAfterTheTrigger) {
  Record record(10, 4);
  record(false, false);
  EXPECT_FALSE(record.flag("ARMED"));
  EXPECT_EQ(record.number("COUNT"), 0);
  record(true, false);  // cycle 1
  EXPECT_TRUE(record.flag("ARMED"));
  while (record.cycle < 50) record(true, false);
  EXPECT_EQ(record.number("COUNT"), 10);
  EXPECT_EQ(record.number("TRIGGER_AT"), -1);
  record(true, true);  // cycle 50
  EXPECT_TRUE(record.flag("TRIGGERED"));
  EXPECT_FALSE(record.flag("ARMED"));
  while (record.cycle < 55) record(true, true);
  EXPECT_FALSE(record.flag("DONE"));
  record(true, true);  // cycle 55, the sixth with the trigger's
  EXPECT_TRUE(record.flag("DONE"));
  while (record.cycle < 100) record(true, record.cycle % 2 == 0);
  EXPECT_EQ(record.cycles(), (std::vector<int>{46, 47, 48, 49, 50, 51, 52, 53, 54, 55}));
  EXPECT_EQ(record.number("TRIGGER_AT"), 4);
  record.block.port<std::int32_t>("INDEX") = 1;
  record.block.fire();
  EXPECT_EQ(record.block.port<picard::Time>("TIME_AT"), milliseconds(-30));
  record.block.port<std::int32_t>("INDEX") = 9;
  record.block.fire();
  EXPECT_EQ(record.block.port<picard::Time>("TIME_AT"), milliseconds(50));
}

TEST(Recorder, ATriggerSoonAfterArmHasLessBefore) {
  Record record(10, 4);
  record(true, false);
  record(true, false);
  record(true, true);  // cycle 2
  while (!record.flag("DONE")) record(true, true);
  EXPECT_EQ(record.cycles(), (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(record.number("TRIGGER_AT"), 2);
}

TEST(Recorder, ArmAndTriggerInTheFirstExecutionAreEdges) {
  Record record(3, 0);
  record(true, true);
  record(true, true);
  record(true, true);
  EXPECT_TRUE(record.flag("DONE"));
  EXPECT_EQ(record.cycles(), (std::vector<int>{0, 1, 2}));
}

TEST(Recorder, ATriggerThatStoodBeforeIsNone) {
  Record record(3, 0);
  record(false, true);
  for (int i = 0; i < 10; ++i) record(true, true);
  EXPECT_TRUE(record.flag("ARMED"));
  record(true, false);
  record(true, true);
  EXPECT_TRUE(record.flag("TRIGGERED"));
}

TEST(Recorder, ArmStartsAnew) {
  Record record(4, 1);
  record(true, true);
  record(false, false);
  record(true, false);  // cycle 2, before the first record was done
  EXPECT_TRUE(record.flag("ARMED"));
  EXPECT_FALSE(record.flag("TRIGGERED"));
  EXPECT_EQ(record.number("COUNT"), 1);
  record(true, false);
  record(true, true);  // cycle 4
  record(true, true);
  record(true, true);
  EXPECT_EQ(record.cycles(), (std::vector<int>{3, 4, 5, 6}));
}

TEST(Recorder, TakesEachNthExecutionAndTheTriggersOwn) {
  Record record(6, 3, 10);
  while (record.cycle < 47) record(true, false);
  record(true, true);  // cycle 47
  while (!record.flag("DONE")) record(true, true);
  EXPECT_EQ(record.cycle, 68);
  EXPECT_EQ(record.cycles(), (std::vector<int>{20, 30, 40, 47, 57, 67}));
}

TEST(Recorder, ShowsNothingOutsideOfTheRecord) {
  Record record(5, 0);
  record(true, false);
  EXPECT_TRUE(record.flag("VALID"));
  for (const std::int32_t none : {-1, 1, 5, 2147483647}) {
    record.block.port<std::int32_t>("INDEX") = none;
    record.block.port<bool>("ARM") = false;
    record.block.fire();
    record.block.port<bool>("ARM") = true;
    record(true, false);  // one sample again
    EXPECT_FALSE(record.flag("VALID")) << none;
    EXPECT_EQ(record.block.port<double>("OUT1"), 0) << none;
    EXPECT_EQ(record.block.port<picard::Time>("TIME_AT"), picard::Time(0)) << none;
  }
}

TEST(Recorder, HoldsItsLongestRecord) {
  Record record(4096, 4095);
  while (record.cycle < 10000) record(true, false);
  record(true, true);
  EXPECT_TRUE(record.flag("DONE"));
  EXPECT_EQ(record.number("COUNT"), 4096);
  EXPECT_EQ(record.number("TRIGGER_AT"), 4095);
  record.block.port<std::int32_t>("INDEX") = 0;
  record.block.fire();
  EXPECT_EQ(record.block.port<double>("OUT1"), 10000 - 4095);
}

TEST(Recorder, RefusesSizesOutsideOfTheRange) {
  EXPECT_EQ(refusal(Record(0, 0).block), "SAMPLES is 0, its range is 1 .. 4096");
  EXPECT_EQ(refusal(Record(4097, 0).block), "SAMPLES is 4097, its range is 1 .. 4096");
  EXPECT_EQ(refusal(Record(10, 10).block), "PRETRIGGER is not below SAMPLES");
  EXPECT_EQ(refusal(Record(10, -1).block), "PRETRIGGER is -1, its range is 0 .. 4095");
  EXPECT_EQ(refusal(Record(10, 1, 0).block), "EVERY is 0, its range is 1 .. inf");
}

// ---- all of them

TEST(SignalBlocks, DoNotAllocateInFire) {
  std::string name = (fs::temp_directory_path() / "signals_XXXXXX").string();
  setenv("PICARD_LOG_DIRECTORY", mkdtemp(name.data()), 1);
  for (std::uint32_t i = 0; i < signals_library()->block_count; ++i) {
    const std::string block = signals_library()->blocks[i].name;
    picard::Instance instance(signals_library(), block, milliseconds(1));
    if (block == "SIGNAL_GENERATOR") instance.port<picard::Text<12>>("SHAPE") = std::string_view("CHIRP");
    if (block == "LOOKUP_TABLE") instance.port<std::array<double, 64>>("X")[1] = 1;
    if (block == "FILE_LOGGER") {
      instance.port<picard::Text<80>>("FILE") = std::string_view("log.csv");
      instance.port<picard::Text<200>>("COLUMNS") = std::string_view("x");
      instance.port<picard::Text<16>>("IF_EXISTS") = std::string_view("REFUSE");
    }
    instance.ready();
    const std::size_t before = test::allocations();
    for (int cycle = 0; cycle < 5000; ++cycle) {
      if (block == "RECORDER") {
        instance.port<bool>("ARM") = cycle > 10;
        instance.port<bool>("TRIGGER") = cycle > 1000;
      }
      instance.fire();
    }
    EXPECT_EQ(test::allocations(), before) << block;
  }
  unsetenv("PICARD_LOG_DIRECTORY");
  fs::remove_all(name);
}

}  // namespace
}  // namespace plc::blocks
