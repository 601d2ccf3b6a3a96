// Signal blocks against closed forms, and FILE_LOGGER against the file it leaves.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "taskblocks/signals/csv_log.h"
#include "taskblocks/signals/noise.h"
#include "tests/unit/taskblocks/allocations.h"

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
  EXPECT_EQ(refusal(Curve({{0, 1}}).block), "POINTS is not 2..64");
  Curve many({{0, 1}, {1, 2}});
  many.block.port<std::int32_t>("POINTS") = 65;
  EXPECT_EQ(refusal(many.block), "POINTS is not 2..64");
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
  EXPECT_EQ(refusal(Record(0, 0).block), "SAMPLES is not 1..4096");
  EXPECT_EQ(refusal(Record(4097, 0).block), "SAMPLES is not 1..4096");
  EXPECT_EQ(refusal(Record(10, 10).block), "PRETRIGGER is not 0..SAMPLES - 1");
  EXPECT_EQ(refusal(Record(10, -1).block), "PRETRIGGER is not 0..SAMPLES - 1");
  EXPECT_EQ(refusal(Record(10, 1, 0).block), "EVERY is not 1 or more");
}

// ---- FILE_LOGGER

/// A directory of its own that PICARD_LOG_DIRECTORY names.
class FileLogger : public testing::Test {
 protected:
  FileLogger() {
    std::string name = (fs::temp_directory_path() / "file_logger_XXXXXX").string();
    directory = mkdtemp(name.data());
    setenv("PICARD_LOG_DIRECTORY", directory.c_str(), 1);
  }
  ~FileLogger() override {
    unsetenv("PICARD_LOG_DIRECTORY");
    fs::remove_all(directory);
  }
  static std::unique_ptr<picard::Instance> logger(std::string_view columns, std::string_view if_exists = "NUMBER",
                                                  std::string_view file = "log.csv") {
    auto block = std::make_unique<picard::Instance>(signals_library(), "FILE_LOGGER", milliseconds(1));
    block->port<picard::Text<200>>("COLUMNS") = columns;
    block->port<picard::Text<16>>("IF_EXISTS") = if_exists;
    block->port<picard::Text<80>>("FILE") = file;
    return block;
  }
  [[nodiscard]] std::vector<std::string> lines(const std::string& file) const {
    std::vector<std::string> all;
    std::ifstream in(directory / file);
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  [[nodiscard]] std::string text(const std::string& file) const {
    std::ifstream in(directory / file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path directory;
};

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) all.push_back(field);
  return all;
}

TEST_F(FileLogger, WritesEachExecutionAsALine) {
  {
    const auto log = logger("speed, load[1]");
    for (int i = 0; i < 100; ++i) {
      log->port<double>("IN1") = i / 3.0;
      log->port<double>("IN2") = -i;
      log->port<bool>("ENABLE") = i % 2 == 0;
      log->fire();
    }
    EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), 0U);
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), 0);
  }
  const std::vector<std::string> all = lines("log.csv");
  ASSERT_EQ(all.size(), 51U);
  EXPECT_EQ(all[0], "utc,time_s,speed,load[1]");
  for (int i = 0; i < 50; ++i) {
    const std::vector<std::string> line = fields(all[static_cast<std::size_t>(i) + 1]);
    ASSERT_EQ(line.size(), 4U);
    EXPECT_EQ(line[1], "0.0" + std::string(i < 5 ? "0" : "") + std::to_string(2 * i) + "000000") << i;
    EXPECT_EQ(std::stod(line[2]), 2 * i / 3.0) << "must read back the same";
    EXPECT_EQ(line[3], std::to_string(-2 * i)) << i;
  }
}

TEST_F(FileLogger, TheDateIsThatOfTheFirstLinePlusTheTimeSince) {
  const auto before = std::chrono::system_clock::now();
  {
    const auto log = logger("x");
    for (int i = 0; i < 2500; ++i) log->fire();  // 2.5 s by the task's clock
  }
  const auto after = std::chrono::system_clock::now();
  const std::vector<std::string> all = lines("log.csv");
  const auto seconds = [](const std::string& line) {
    std::tm date{};
    const std::string utc = fields(line).at(0);
    const char* const rest = strptime(utc.c_str(), "%Y-%m-%dT%H:%M:%S", &date);
    EXPECT_EQ(utc.back(), 'Z');
    return static_cast<double>(timegm(&date)) + std::strtod(rest, nullptr);
  };
  const double first = seconds(all.at(1));
  EXPECT_GE(first, std::chrono::duration<double>(before.time_since_epoch()).count() - 1e-5);
  EXPECT_LE(first, std::chrono::duration<double>(after.time_since_epoch()).count());
  EXPECT_NEAR(seconds(all.at(2500)) - first, 2.499, 1e-5);
}

TEST_F(FileLogger, DropsWhatDoesNotFitIntoTheRingAndCountsIt) {
  constexpr std::uint64_t kLines = 20000;
  std::uint64_t dropped = 0;
  {
    const auto log = logger("x");
    log->port<std::int32_t>("BUFFER") = 16;
    for (std::uint64_t i = 0; i < kLines; ++i) {
      log->port<double>("IN1") = static_cast<double>(i);
      log->fire();
    }
    dropped = log->port<std::uint64_t>("DROPPED");
    EXPECT_GT(dropped, 0U);
  }
  const std::vector<std::string> all = lines("log.csv");
  EXPECT_EQ(all.size() - 1 + dropped, kLines);
  double last = -1;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double value = std::stod(fields(all[i]).at(2));
    EXPECT_GT(value, last) << "lines keep their order";
    last = value;
  }
}

TEST_F(FileLogger, AllThatIsPacedIsWritten) {
  const auto log = logger("x");
  log->ready();
  for (int i = 0; i < 50; ++i) {
    for (int j = 0; j < 100; ++j) log->fire();
    std::this_thread::sleep_for(milliseconds(1));
  }
  // fire() shows what was written before it: the count comes after the writer's next round.
  for (int i = 0; i < 500 && log->port<std::uint64_t>("WRITTEN") < 5000; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    log->port<bool>("ENABLE") = false;
    log->fire();
  }
  EXPECT_EQ(log->port<std::uint64_t>("WRITTEN"), 5000U);
  EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), 0U);
  EXPECT_EQ(lines("log.csv").size(), 5001U) << "also while it runs";
}

TEST_F(FileLogger, NumbersFilesThatAreThereAndOverwritesNone) {
  for (int i = 0; i < 3; ++i) {
    const auto log = logger("x");
    log->port<double>("IN1") = i;
    log->fire();
  }
  EXPECT_EQ(fields(lines("log.csv").at(1)).at(2), "0");
  EXPECT_EQ(fields(lines("log-1.csv").at(1)).at(2), "1");
  EXPECT_EQ(fields(lines("log-2.csv").at(1)).at(2), "2");
  EXPECT_EQ(refusal(*logger("x", "REFUSE")),
            "FILE 'log.csv' cannot be made in '" + directory.string() + "': File exists");
  EXPECT_EQ(lines("log.csv").size(), 2U);
}

TEST_F(FileLogger, AppendsToAFileWithTheSameColumns) {
  for (int i = 0; i < 3; ++i) {
    const auto log = logger("a,b", "APPEND");
    log->fire();
  }
  EXPECT_EQ(lines("log.csv").size(), 4U);
  EXPECT_EQ(refusal(*logger("a,c", "APPEND")), "FILE 'log.csv' has other columns");
  EXPECT_EQ(refusal(*logger("a", "APPEND")), "FILE 'log.csv' has other columns");
  EXPECT_EQ(lines("log.csv").size(), 4U);
}

TEST_F(FileLogger, EndsALineThatALossOfPowerLeftUnfinished) {
  std::ofstream(directory / "log.csv") << "utc,time_s,a\n2024-01-01T00:00:00.000000Z,0.0000";
  logger("a", "APPEND")->fire();
  const std::vector<std::string> all = lines("log.csv");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1], "2024-01-01T00:00:00.000000Z,0.0000");
  EXPECT_EQ(fields(all[2]).size(), 3U);
}

TEST_F(FileLogger, TwoDoNotWriteOneFile) {
  const auto first = logger("a", "APPEND");
  first->ready();
  EXPECT_EQ(refusal(*logger("a", "APPEND")), "FILE 'log.csv' is being written by another logger");
}

TEST_F(FileLogger, RefusesWhatIsNoFileNameInItsDirectory) {
  for (const char* const bad : {"", "..", ".", "../log.csv", "a/b.csv", "/log.csv", ".hidden", "-rf", "a b", "a\nb"}) {
    EXPECT_NE(refusal(*logger("x", "NUMBER", bad)).find("is not a name of"), std::string::npos) << bad;
  }
  EXPECT_TRUE(fs::is_empty(directory));
  EXPECT_EQ(refusal(*logger("x", "REFUSED")), "IF_EXISTS is none of NUMBER, APPEND, REFUSE");
  setenv("PICARD_LOG_DIRECTORY", (directory / "none").c_str(), 1);
  EXPECT_NE(refusal(*logger("x")).find("cannot be opened: No such file or directory"), std::string::npos);
}

TEST_F(FileLogger, FollowsNoLinkAndWaitsForNoPipe) {
  std::ofstream(directory / "target") << "utc,time_s,x\n";  // what APPEND would go on with
  fs::create_symlink("target", directory / "log.csv");
  EXPECT_NE(refusal(*logger("x", "APPEND")), "");
  EXPECT_NE(refusal(*logger("x", "REFUSE")), "");
  logger("x", "NUMBER")->fire();
  EXPECT_EQ(text("target"), "utc,time_s,x\n");
  EXPECT_EQ(lines("log-1.csv").size(), 2U);
  ASSERT_EQ(mkfifo((directory / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(refusal(*logger("x", "APPEND", "pipe")), "FILE 'pipe' is no regular file");
}

TEST_F(FileLogger, RefusesNamesOfColumnsThatWouldSpoilTheFile) {
  for (const char* const bad : {"", "a,,b", "a,", "a\"", "a;b", "a b"}) {
    EXPECT_NE(refusal(*logger(bad)).find("COLUMNS has a name"), std::string::npos) << bad;
  }
  EXPECT_EQ(refusal(*logger("1,2,3,4,5,6,7,8,9")), "COLUMNS has more than 8 names");
  EXPECT_EQ(refusal(*logger("1,2,3,4,5,6,7,8")), "");
}

TEST_F(FileLogger, StopsAtItsLimitWithWholeLines) {
  std::uint64_t written = 0;
  std::uint64_t dropped = 0;
  constexpr int kLines = 60000;  // of 40 bytes or more: 1 MB are some 20000
  {
    const auto log = logger("x");
    log->port<std::int32_t>("LIMIT") = 1;
    log->port<std::int32_t>("BUFFER") = 65536;
    for (int i = 0; i < kLines; ++i) log->fire();
    log->port<bool>("ENABLE") = false;
    for (int i = 0; i < 500 && log->port<std::int32_t>("ERROR") == 0; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
    }
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), EFBIG);
    for (int i = 0; i < 500 && written + dropped < kLines; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
      written = log->port<std::uint64_t>("WRITTEN");
      dropped = log->port<std::uint64_t>("DROPPED");
    }
    EXPECT_EQ(written + dropped, static_cast<std::uint64_t>(kLines));
    log->port<bool>("ENABLE") = true;
    log->fire();
    EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), dropped + 1);
  }
  EXPECT_LE(fs::file_size(directory / "log.csv"), 1'000'000U);
  EXPECT_GT(fs::file_size(directory / "log.csv"), 900'000U);
  EXPECT_EQ(text("log.csv").back(), '\n');
  EXPECT_EQ(lines("log.csv").size(), written + 1);
}

TEST_F(FileLogger, LeavesWholeLinesWhenTheSystemRefusesToWrite) {
  // The system's own limit of files: the write is cut short first, then refused with a signal that would end the
  // process if the writer did not block it.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::uint64_t written = 0;
  std::uint64_t dropped = 0;
  {
    const auto log = logger("x");
    log->port<std::int32_t>("LIMIT") = 0;
    log->port<std::int32_t>("BUFFER") = 65536;
    for (int i = 0; i < 10000; ++i) log->fire();
    log->port<bool>("ENABLE") = false;
    for (int i = 0; i < 500 && written + dropped < 10000; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
      written = log->port<std::uint64_t>("WRITTEN");
      dropped = log->port<std::uint64_t>("DROPPED");
    }
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), EFBIG);
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(written + dropped, 10000U);
  EXPECT_EQ(text("log.csv").back(), '\n');
  EXPECT_EQ(lines("log.csv").size(), written + 1);
}

TEST_F(FileLogger, WritesValuesThatAreNoNumbersAsWords) {
  {
    const auto log = logger("a,b,c");
    log->port<double>("IN1") = std::abs(kNan);
    log->port<double>("IN2") = kInfinity;
    log->port<double>("IN3") = -kInfinity;
    log->fire();
  }
  EXPECT_NE(lines("log.csv").at(1).find(",nan,inf,-inf"), std::string::npos);
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
    const std::size_t before = allocations();
    for (int cycle = 0; cycle < 5000; ++cycle) {
      if (block == "RECORDER") {
        instance.port<bool>("ARM") = cycle > 10;
        instance.port<bool>("TRIGGER") = cycle > 1000;
      }
      instance.fire();
    }
    EXPECT_EQ(allocations(), before) << block;
  }
  unsetenv("PICARD_LOG_DIRECTORY");
  fs::remove_all(name);
}

}  // namespace
}  // namespace plc::blocks
