// Blocks for measured values: that time is measured, and that nothing makes a number of what is none.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/stdlib/block_table.h"

namespace plc::test {
namespace {

using stdlib::Direction;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();

/// Any bits at all inputs, at any times: every REAL output stays a finite number, every BOOL a BOOL.
TEST(MeasuredBlocks, NoInputMakesAnOutputInfinite) {
  std::mt19937_64 random(7);
  constexpr std::uint32_t kOdd[] = {0x7f7fffff, 0xff7fffff, 0x7f800000, 0xff800000, 0x7fc00000, 0xffc00001,
                                    0x00000001, 0x80000001, 0x80000000, 0x00000000, 0x3f800000, 0xbf800000};
  for (const stdlib::BlockSpec& block : stdlib::blocks()) {
    for (int run = 0; run < 50; ++run) {
      Instance instance(block.name);
      std::int64_t now = 0;
      for (int i = 0; i < 200; ++i) {
        for (const stdlib::Field& field : block.fields) {
          if (field.direction != Direction::kInput || random() % 3 == 0) continue;
          const bool odd = random() % 2 == 0;
          const auto bits = static_cast<std::int64_t>(odd ? kOdd[random() % std::size(kOdd)] : random());
          instance.set(field.name, field.type == TypeId::kBool ? bits & 1 : bits);
        }
        const std::uint64_t step = random() % 4 == 0 ? random() >> (random() % 64) : random() % (20 * kMs);
        now = static_cast<std::int64_t>(static_cast<std::uint64_t>(now) + step);
        if (now < 0 || random() % 50 == 0) now = 0;
        instance.step_ns(now);
        for (const stdlib::Field& field : block.fields) {
          if (field.type == TypeId::kBool) {
            ASSERT_LE(instance.get(field.name), 1) << block.name << "." << field.name;
          }
          if (field.type == TypeId::kReal && field.direction == Direction::kOutput) {
            ASSERT_TRUE(std::isfinite(instance.real(field.name))) << block.name << "." << field.name;
          }
        }
      }
      EXPECT_TRUE(instance.canary_is_whole()) << block.name;
    }
  }
}

/// Processors differ in the sign of a NaN that they make, so no block may leave one that it made.
TEST(MeasuredBlocks, ANaNThatAWrittenStateMakesIsTheCanonicalOne) {
  constexpr double kOdd[] = {kInf, -kInf, kNan, -kNan, 0.0, -0.0, 1e300, -1e300};
  constexpr std::int64_t kCanonicalReal = 0x7fc00000, kCanonicalLreal = 0x7ff8000000000000;
  std::mt19937_64 random(89);
  int made = 0;
  for (const stdlib::BlockSpec& block : stdlib::blocks()) {
    for (int run = 0; run < 300; ++run) {
      Instance instance(block.name);
      for (int i = 0; i < 20; ++i) {
        for (const stdlib::Field& field : block.fields) {
          if (random() % 3 == 0) continue;
          const double odd = random() % 4 != 0 ? kOdd[random() % std::size(kOdd)] : static_cast<double>(random() % 9);
          if (field.type == TypeId::kReal) instance.set_real(field.name, odd);
          if (field.type == TypeId::kLreal) instance.set(field.name, std::bit_cast<std::int64_t>(odd));
          if (field.type == TypeId::kBool) instance.set(field.name, static_cast<std::int64_t>(random() % 2));
          if (field.type == TypeId::kUsint) instance.set(field.name, static_cast<std::int64_t>(random() % 4));
          if (field.type == TypeId::kLtime) instance.set(field.name, static_cast<std::int64_t>(random() % 3) * kMs);
        }
        Instance before = instance;
        instance.step(static_cast<std::int64_t>(random() % 3));
        for (const stdlib::Field& field : block.fields) {
          const bool wide = field.type == TypeId::kLreal;
          if (!wide && (field.type != TypeId::kReal || field.direction != Direction::kOutput)) continue;
          const std::int64_t now = instance.get(field.name);
          if (now == before.get(field.name)) continue;
          const double value = wide ? std::bit_cast<double>(now) : instance.real(field.name);
          if (!std::isnan(value)) continue;
          ++made;
          ASSERT_EQ(now, wide ? kCanonicalLreal : kCanonicalReal) << block.name << "." << field.name;
        }
      }
    }
  }
  EXPECT_GT(made, 100);
}

TEST(MeasuredBlocks, PinsCalledCycleMakeNoDifference) {
  for (const char* name : {"PID", "INTEGRAL", "DERIVATIVE", "RAMP"}) {
    Instance without(name), with(name);
    for (Instance* instance : {&without, &with}) {
      for (const stdlib::Field& field : instance->spec().fields) {
        if (field.direction != Direction::kInput) continue;
        if (field.type == TypeId::kBool) instance->set(field.name, field.name != "R1");
        if (field.type == TypeId::kReal && !field.name.starts_with("XM")) instance->set_real(field.name, 3.0);
        if (field.name == "X1") instance->set_real(field.name, 9.0);
        if (field.type == TypeId::kTime && field.name != "CYCLE") instance->set(field.name, 1000 * kMs);
      }
    }
    with.set("CYCLE", 77 * kMs);
    const std::string moving = name == std::string("PID") ? "PV" : name == std::string("RAMP") ? "X1" : "XIN";
    for (int i = 0; i < 20; ++i) {
      for (Instance* instance : {&without, &with}) instance->set_real(moving, 9.0 + i), instance->step(i * 10);
      ASSERT_EQ(without.real("XOUT"), with.real("XOUT")) << name;
    }
    EXPECT_NE(without.real("XOUT"), 0.0) << name;
  }
}

TEST(Integral, DoesNotDependOnTheCycle) {
  Instance slow("INTEGRAL"), fast("INTEGRAL");
  slow.set("RUN", 1), slow.set_real("XIN", 0.1), fast.set("RUN", 1), fast.set_real("XIN", 0.1);
  slow.step(0), slow.step(3'600'000);
  // 3.6 million additions of 0.0001 to a REAL would be far off.
  for (std::int64_t ms = 0; ms <= 3'600'000; ++ms) fast.step(ms);
  EXPECT_NEAR(slow.real("XOUT"), 360.0, 1e-3);
  EXPECT_NEAR(fast.real("XOUT"), 360.0, 1e-3);
}
TEST(Integral, LeavesOutWhatIsNoNumber) {
  Instance block("INTEGRAL");
  block.set("RUN", 1), block.set_real("XIN", 1), block.step(0), block.step(1000);
  for (const double odd : {kNan, kInf, -kInf}) {
    block.set_real("XIN", odd), block.step(2000);
    EXPECT_EQ(block.real("XOUT"), 1.0);
  }
  block.set_real("XIN", 1), block.step(3000);
  EXPECT_EQ(block.real("XOUT"), 2.0) << "the second without a value is left out";
  block.set("R1", 1), block.set_real("X0", kNan), block.step(4000);
  EXPECT_EQ(block.real("XOUT"), 2.0);
  EXPECT_EQ(block.get("Q"), 0);
}

/// The formula of annex F, which knows one cycle time only.
TEST(Derivative, IsThatOfAnnexFWhereCyclesAreEqual) {
  Instance block("DERIVATIVE");
  block.set("RUN", 1);
  std::mt19937 random(3);
  double x1 = 0, x2 = 0, x3 = 0;
  for (int i = 0; i < 1000; ++i) {
    const double x = static_cast<double>(static_cast<float>(random() % 1000) / 8.0f);
    block.set_real("XIN", x);
    block.step(i * 20);
    if (i >= 3) {
      ASSERT_NEAR(block.real("XOUT"), (3 * x + x1 - x2 - 3 * x3) / (10 * 0.020), 1e-3) << i;
    }
    x3 = x2, x2 = x1, x1 = x;
  }
}
TEST(Derivative, OfALineIsItsSlopeUnderAnyJitter) {
  Instance block("DERIVATIVE");
  block.set("RUN", 1);
  std::mt19937 random(4);
  std::int64_t now = 0;
  for (int i = 0; i < 1000; ++i) {
    block.set_real("XIN", 5 - 3 * static_cast<double>(now) * 1e-9);
    block.step_ns(now);
    if (i > 0) {
      ASSERT_NEAR(block.real("XOUT"), -3.0, 1e-2) << i;
    }
    now += kMs + static_cast<std::int64_t>(random() % (100 * kMs));
  }
}
TEST(Derivative, TwiceInOneInstantAndAfterAClockThatWentBack) {
  Instance block("DERIVATIVE");
  block.set("RUN", 1);
  block.set_real("XIN", 0), block.step(1000), block.set_real("XIN", 2), block.step(2000);
  EXPECT_EQ(block.real("XOUT"), 2.0);
  block.set_real("XIN", 50), block.step(2000);
  EXPECT_EQ(block.real("XOUT"), 2.0) << "no time has passed";
  block.set_real("XIN", 7), block.step(0);
  EXPECT_EQ(block.real("XOUT"), 0.0);
  block.set_real("XIN", 8), block.step(1000);
  EXPECT_EQ(block.real("XOUT"), 1.0);
}

TEST(Derivative, AStateThatWasWrittenFromOutsideHasNoMoreSamplesThanRoom) {
  Instance written("DERIVATIVE"), whole("DERIVATIVE");
  for (Instance* block : {&written, &whole}) {
    block->set("RUN", 1);
    for (int i = 0; i < 5; ++i) block->set_real("XIN", i * i), block->step(i * 1000);
  }
  written.set("COUNT", 255);
  for (Instance* block : {&written, &whole}) block->set_real("XIN", 100), block->step(5000);
  EXPECT_EQ(written.real("XOUT"), whole.real("XOUT"));
  EXPECT_EQ(written.get("COUNT"), 3);
}

TEST(Ramp, PresetsThatAreNone) {
  for (const std::int64_t tr : {std::int64_t{0}, -5 * kMs}) {
    Instance block("RAMP");
    block.set_real("X0", 1), block.set_real("X1", 4), block.set("TR", tr), block.set("RUN", 1), block.step(10);
    EXPECT_EQ(block.real("XOUT"), 4.0);
    EXPECT_EQ(block.get("BUSY"), 0);
  }
}
TEST(Ramp, RunInTheFirstScanBeginsAtX0AndAMovingEndIsReached) {
  Instance block("RAMP");
  block.set_real("X0", 10), block.set_real("X1", 20), block.set("TR", 1000 * kMs), block.set("RUN", 1);
  block.step(500);
  EXPECT_EQ(block.real("XOUT"), 10.0);
  block.set_real("X1", 40), block.step(1000);
  EXPECT_EQ(block.real("XOUT"), 25.0);
  block.set_real("X1", kNan), block.step(1200);
  EXPECT_EQ(block.real("XOUT"), 25.0) << "held";
  block.set_real("X1", 30), block.step(1500);
  EXPECT_EQ(block.real("XOUT"), 30.0) << "on time all the same";
}

TEST(Hysteresis, HoldsWithoutNumbersAndTakesNoWidthBelowZero) {
  Instance block("HYSTERESIS");
  block.set_real("XIN1", 5), block.step();
  EXPECT_EQ(block.get("Q"), 1);
  for (const double odd : {kNan, kInf, -kInf}) {
    block.set_real("XIN1", odd), block.step();
    EXPECT_EQ(block.get("Q"), 1);
  }
  block.set_real("EPS", -3), block.set_real("XIN1", 1);
  for (int i = 0; i < 3; ++i) {
    block.step();
    EXPECT_EQ(block.get("Q"), 1) << "does not flutter";
  }
}

TEST(Lag1, DoesNotDependOnTheCycle) {
  Instance slow("LAG1"), fast("LAG1");
  for (Instance* lag : {&slow, &fast}) lag->set("T", 2000 * kMs), lag->step(0), lag->set_real("IN", 100);
  slow.step(2000);
  for (std::int64_t ms = 1; ms <= 2000; ++ms) fast.step(ms);
  EXPECT_NEAR(slow.real("OUT"), 100 * (1 - std::exp(-1.0)), 1e-4);
  EXPECT_NEAR(fast.real("OUT"), slow.real("OUT"), 1e-4);
}
TEST(Lag1, ReachesItsEndUnderALongTimeConstant) {
  // In REAL alone the step of 1 ms, 3e-7 of the way, would vanish before the end.
  Instance lag("LAG1");
  lag.set("T", 3'600'000 * kMs), lag.set_real("IN", 1000), lag.step(0), lag.set_real("IN", 1001);
  for (std::int64_t ms = 1; ms <= 3'600'000; ms += 10) lag.step(ms);
  EXPECT_NEAR(lag.real("OUT"), 1000 + (1 - std::exp(-1.0)), 1e-3);
}
TEST(Lag1, BeginsWithTheFirstNumber) {
  Instance lag("LAG1");
  lag.set("T", 1000 * kMs), lag.set_real("IN", kNan), lag.step(0);
  EXPECT_EQ(lag.real("OUT"), 0.0);
  lag.set_real("IN", 50), lag.step(10);
  EXPECT_EQ(lag.real("OUT"), 50.0);
}

TEST(Average, HoldsNWithinWhatThereIs) {
  Instance block("AVERAGE");
  for (int i = 1; i <= 100; ++i) {
    block.set("N", 1000), block.set_real("IN", i), block.step();
  }
  EXPECT_NEAR(block.real("AVG"), (69 + 100) / 2.0, 1e-4) << "the last 32";
  block.set("N", -7), block.step();
  EXPECT_EQ(block.real("AVG"), 100.0);
  block.set_real("IN", kNan), block.step();
  EXPECT_EQ(block.real("AVG"), 100.0);
}

TEST(LimitAlarm, SaysNothingOfANan) {
  Instance block("LIMITALARM_REAL");
  block.set_real("HIGH", 1), block.set_real("IN", kNan), block.step();
  EXPECT_EQ(block.get("O") + block.get("U") + block.get("IL"), 0);
  block.set_real("IN", kInf), block.step();
  EXPECT_EQ(block.get("O"), 1);
}

TEST(Scale, SaysErrorForWhatIsNoNumberAndKeepsItsOutput) {
  Instance block("SCALE");
  block.set_real("IN_MAX", 10), block.set_real("OUT_MAX", 100), block.set_real("IN", 4), block.step();
  EXPECT_EQ(block.real("OUT"), 40.0);
  for (const double odd : {kNan, kInf, -kInf}) {
    block.set_real("IN", odd), block.step();
    EXPECT_EQ(block.real("OUT"), 40.0);
    EXPECT_EQ(block.get("ERROR"), 1);
  }
}

TEST(Blink, KeepsItsGridUnderLateScansAndBeginsAnewAfterAGap) {
  Instance block("BLINK");
  block.set("ENABLE", 1), block.set("TIMELOW", 100 * kMs), block.set("TIMEHIGH", 100 * kMs);
  int changes = 0;
  std::int64_t before = 0;
  for (std::int64_t ms = 0; ms <= 100'000; ms += 7) {
    block.step(ms);
    changes += block.get("OUT") != before ? 1 : 0;
    before = block.get("OUT");
  }
  EXPECT_EQ(changes, 999) << "one each 100 ms; of the last the scan at 100 s has not come";
  block.step(200'000);
  const std::int64_t now = block.get("OUT");
  block.step(200'090);
  EXPECT_EQ(block.get("OUT"), now) << "a whole phase from the gap on";
  block.step(200'100);
  EXPECT_NE(block.get("OUT"), now);
}
TEST(Blink, PhasesOfNoLengthLastOneScan) {
  Instance block("BLINK");
  block.set("ENABLE", 1), block.set("TIMELOW", -1);
  std::string out;
  for (int ms = 0; ms < 6; ++ms) block.step(ms), out += block.get("OUT") != 0 ? '1' : '0';
  EXPECT_EQ(out, "010101");
}

TEST(Pwm, ShareOfTimeIsTheDuty) {
  for (const double duty : {-1.0, 0.0, 0.3, 0.5, 1.0, 7.0}) {
    Instance block("PWM");
    block.set("ENABLE", 1), block.set("PERIOD", 100 * kMs), block.set_real("DUTY", duty);
    int on = 0;
    for (std::int64_t ms = 0; ms < 10'000; ++ms) {
      block.step(ms);
      on += block.get("OUT") != 0 ? 1 : 0;
    }
    EXPECT_NEAR(on / 10'000.0, std::clamp(duty, 0.0, 1.0), 0.011) << duty;
  }
}
TEST(Pwm, NoPeriodIsOffAndNanIsAsBefore) {
  Instance block("PWM");
  block.set("ENABLE", 1), block.set_real("DUTY", 1), block.step(0);
  EXPECT_EQ(block.get("OUT"), 0);
  block.set("PERIOD", 10 * kMs), block.step(1);
  EXPECT_EQ(block.get("OUT"), 1);
  block.set_real("DUTY", kNan), block.step(11), block.step(20);
  EXPECT_EQ(block.get("OUT"), 1);
}

}  // namespace
}  // namespace plc::test
