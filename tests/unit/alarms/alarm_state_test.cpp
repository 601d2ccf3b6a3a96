// The states of an alarm by a table worked out by hand from ISA-18.2, and its condition with hysteresis and delays.
#include "alarms/alarm_state.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "alarms/condition.h"

namespace plc::test {
namespace {

using namespace alarms;
constexpr core::TimeNs kMs = 1'000'000;

/// What is done, then the state after it.
struct Step {
  std::string does;
  Happened happens;
  State state;
};

struct Row {
  std::string name;
  bool latch = false;
  std::vector<Step> steps;
};

Happened act(AlarmState& alarm, const std::string& does, bool latch) {
  if (does == "begins" || does == "ends") return alarm.condition(does == "begins", latch);
  if (does == "ack") return alarm.acknowledge();
  if (does == "shelve") alarm.shelve(1000);
  if (does == "unshelve") alarm.unshelve();
  if (does == "suppress") alarm.suppress(true);
  if (does == "unsuppress") alarm.suppress(false);
  if (does == "out") alarm.take_out_of_service(true);
  if (does == "in") alarm.take_out_of_service(false);
  return alarm.take_shown();
}

using H = Happened;
using S = State;
const std::vector<Row> kRows = {
    {"acknowledged, then gone",
     false,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"ack", H::kAcknowledged, S::kAckedActive},
      {"ack", H::kNothing, S::kAckedActive},
      {"ends", H::kReturned, S::kNormal}}},
    {"gone, then acknowledged",
     false,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"ends", H::kReturned, S::kUnackedReturned},
      {"ack", H::kAcknowledged, S::kNormal}}},
    {"comes again before anybody has seen it",
     false,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"ends", H::kReturned, S::kUnackedReturned},
      {"begins", H::kRaised, S::kUnackedActive}}},
    {"a latched one stays until it was seen",
     true,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"ends", H::kNothing, S::kUnackedActive},
      {"begins", H::kNothing, S::kUnackedActive},
      {"ends", H::kNothing, S::kUnackedActive},
      {"ack", H::kReturned, S::kNormal}}},
    {"a latched one that was seen ends with its condition",
     true,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"ack", H::kAcknowledged, S::kAckedActive},
      {"ends", H::kReturned, S::kNormal}}},
    {"shelved while it is active: raised again at the end",
     false,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"shelve", H::kNothing, S::kShelved},
      {"ack", H::kNothing, S::kShelved},
      {"unshelve", H::kRaised, S::kUnackedActive}}},
    {"shelved, gone meanwhile",
     false,
     {{"begins", H::kRaised, S::kUnackedActive},
      {"shelve", H::kNothing, S::kShelved},
      {"ends", H::kNothing, S::kShelved},
      {"unshelve", H::kNothing, S::kNormal}}},
    {"comes while it is suppressed",
     false,
     {{"suppress", H::kNothing, S::kSuppressed},
      {"begins", H::kNothing, S::kSuppressed},
      {"unsuppress", H::kRaised, S::kUnackedActive}}},
    {"out of service counts before the others",
     false,
     {{"shelve", H::kNothing, S::kShelved},
      {"out", H::kNothing, S::kOutOfService},
      {"begins", H::kNothing, S::kOutOfService},
      {"unshelve", H::kNothing, S::kOutOfService},
      {"in", H::kRaised, S::kUnackedActive}}},
    {"what was never active is not raised by a shelf that ends",
     false,
     {{"shelve", H::kNothing, S::kShelved}, {"unshelve", H::kNothing, S::kNormal}}},
};

TEST(AlarmStates, AreThoseOfTheTable) {
  for (const Row& row : kRows) {
    AlarmState alarm;
    EXPECT_EQ(alarm.state(), State::kNormal);
    for (std::size_t i = 0; i < row.steps.size(); ++i) {
      const Step& step = row.steps[i];
      EXPECT_EQ(act(alarm, step.does, row.latch), step.happens) << row.name << ", step " << i << ": " << step.does;
      EXPECT_EQ(alarm.state(), step.state) << row.name << ", step " << i << ": " << step.does << " gives "
                                           << kStateTexts[static_cast<std::size_t>(alarm.state())];
    }
  }
}

TEST(AlarmStates, AreTheSameAfterTheyWereKept) {
  for (const Row& row : kRows) {
    AlarmState alarm;
    for (const Step& step : row.steps) {
      act(alarm, step.does, row.latch);
      AlarmState again;
      again.unpack(alarm.packed(), alarm.shelved_until_ns());
      if (alarm.is_suppressed()) again.suppress(true);
      EXPECT_EQ(again.state(), alarm.state()) << row.name << " after " << step.does;
      EXPECT_EQ(again.is_active(), alarm.is_active()) << row.name << " after " << step.does;
    }
  }
}

/// "value at ms" for each scan, and whether the condition is there after it.
struct Scan {
  std::int64_t ms;
  double value;
  bool is;
};
void expect(const Definition& alarm, const std::vector<Scan>& scans) {
  Condition condition;
  for (const Scan& scan : scans) {
    condition.update(alarm, scan.value, scan.ms * kMs);
    EXPECT_EQ(condition.is(), scan.is) << scan.value << " at " << scan.ms << " ms";
  }
}

TEST(AlarmConditions, HaveHysteresis) {
  Definition high;
  high.comparison = Comparison::kAbove;
  high.limit = 90;
  high.hysteresis = 5;
  expect(high, {{0, 90, false}, {1, 90.1, true}, {2, 85.1, true}, {3, 85, false}, {4, 89, false}, {5, 91, true}});
  Definition low = high;
  low.comparison = Comparison::kBelow;
  low.limit = 10;
  expect(low, {{0, 10, false}, {1, 9.9, true}, {2, 14.9, true}, {3, 15, false}});
  // What is no number changes nothing.
  expect(high, {{0, 95, true}, {1, std::nan(""), true}, {2, 0, false}, {3, std::nan(""), false}});
}

TEST(AlarmConditions, HaveDelaysToTheScan) {
  Definition alarm;
  alarm.on_delay_ns = 100 * kMs;
  alarm.off_delay_ns = 50 * kMs;
  expect(alarm, {{0, 1, false},
                 {90, 1, false},
                 {95, 0, false},   // too short
                 {100, 1, false},  // begins anew
                 {199, 1, false},
                 {200, 1, true},
                 {210, 0, true},
                 {259, 0, true},
                 {260, 0, false}});
}

TEST(AlarmConditions, CompareAsTheySay) {
  Definition alarm;
  const auto holds = [&](Comparison comparison, double value) {
    alarm.comparison = comparison;
    alarm.limit = 3;
    return Condition::holds(alarm, value, false);
  };
  EXPECT_TRUE(holds(Comparison::kEqual, 3) && !holds(Comparison::kEqual, 4));
  EXPECT_TRUE(holds(Comparison::kUnequal, 4) && !holds(Comparison::kUnequal, 3));
  EXPECT_TRUE(holds(Comparison::kTrue, 1) && !holds(Comparison::kTrue, 0));
  EXPECT_TRUE(holds(Comparison::kFalse, 0) && !holds(Comparison::kFalse, 1));
}

TEST(AlarmConditions, GoOnWhileNoScanComes) {
  Definition alarm;
  alarm.on_delay_ns = 100 * kMs;
  Condition condition;
  EXPECT_FALSE(condition.update(alarm, 1, 0));
  EXPECT_TRUE(condition.waits());
  EXPECT_FALSE(condition.pass(alarm, 99 * kMs));
  EXPECT_TRUE(condition.pass(alarm, 100 * kMs));
  EXPECT_TRUE(condition.is());
}

}  // namespace
}  // namespace plc::test
