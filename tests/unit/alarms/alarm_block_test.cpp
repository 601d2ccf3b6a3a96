// Instances of the block ALARM are alarms without any configuration, wherever they lie.
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "alarms/alarms.h"
#include "compiler/compile.h"
#include "shadow/shadow.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

using namespace alarms;

constexpr const char* kSource = R"(
FUNCTION_BLOCK Valve
VAR_INPUT opens, isOpen : BOOL; END_VAR
VAR stuck : ALARM := (TEXT := 'Valve is stuck', PRIORITY := 4, ALARM_CLASS := 'drive', FIRST_OUT := 'line'); END_VAR
stuck(IN := opens AND NOT isOpen, ON_DELAY := T#50ms);
END_FUNCTION_BLOCK
VAR_GLOBAL Level : REAL; END_VAR
PROGRAM Main
VAR_EXTERNAL Level : REAL; END_VAR
VAR n : INT; valves : ARRAY [1..2] OF Valve; high : ALARM := (TEXT := 'Zu voll: ä', FIRST_OUT := 'line', LATCH := TRUE); END_VAR
n := n + 1;
Level := INT_TO_REAL(n);
high(VALUE := Level, HIGH := 20.0, HYST := 5.0);
valves[1](opens := TRUE, isOpen := TRUE);
valves[2](opens := n > 18, isOpen := n > 40);
IF n = 30 THEN n := 100; Level := 0.0; high(VALUE := 0.0); END_IF;
END_PROGRAM
CONFIGURATION C
RESOURCE R ON PLC
TASK Fast(INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM main WITH Fast : Main;
END_RESOURCE
END_CONFIGURATION
)";

std::unique_ptr<runtime::Resource> compiled() {
  const ScratchFolder scratch;
  const std::string path = scratch.file("plant.st");
  std::ofstream(path) << kSource;
  compiler::Compilation compilation;
  compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
  EXPECT_TRUE(compilation.ok());
  auto loaded = runtime::Resource::load(std::move(*compilation.image));
  EXPECT_TRUE(loaded) << loaded.error().message;
  return std::move(*loaded);
}

TEST(AlarmBlocks, AreFoundByThemselves) {
  const auto loaded = compiled();
  runtime::Resource& resource = *loaded;
  core::Diagnostics diagnostics;
  Alarms alarms(resource, {}, true, diagnostics);
  EXPECT_EQ(alarms.count(), 3u);
  auto shadow = shadow::Shadow::start(
      resource, {}, {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource.image())});
  ASSERT_TRUE(shadow) << shadow.error().message;
  (*shadow)->observe(alarms);
  for (core::TimeNs scan = 0; scan < 60; ++scan)
    ASSERT_FALSE(resource.program(0).execute({scan * 10'000'000, 0, scan * 10'000'000}));
  std::vector<Event> events;
  std::vector<Kept> states;
  for (int turn = 0; turn < 1000 && events.size() < 3; ++turn) {
    alarms.take(events, states);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(events.size(), 3u);
  // n is 21 in scan 20. The valve opens in scan 18, and 50 ms are five scans. In scan 29 the level was 0; that is no
  // end of a latched alarm. In scan 30 n is 101, and the valve is open.
  EXPECT_EQ(events[0].alarm, "main.high");
  EXPECT_EQ(events[0].scan, 20u);
  EXPECT_EQ(events[0].text, "Zu voll: ä");
  EXPECT_EQ(events[0].priority, Priority::kMedium);
  EXPECT_EQ(events[0].value, 21);
  EXPECT_EQ(events[1].alarm, "main.valves[2].stuck");
  EXPECT_EQ(events[1].scan, 23u);
  EXPECT_EQ(events[1].text, "Valve is stuck");
  EXPECT_EQ(events[1].category, "drive");
  EXPECT_EQ(events[1].priority, Priority::kCritical);
  EXPECT_EQ(events[2].alarm, "main.valves[2].stuck");
  EXPECT_EQ(events[2].what, Happened::kReturned);
  EXPECT_EQ(events[2].scan, 30u);
  for (const View& view : alarms.list(false)) {
    EXPECT_EQ(view.order, view.definition.name == "main.high" ? 1u : 2u);
    EXPECT_EQ(view.state, view.definition.name == "main.high" ? State::kUnackedActive : State::kUnackedReturned);
  }
}

TEST(AlarmBlocks, KeepTheirPinsOverARestart) {
  const auto loaded = compiled();
  runtime::Resource& resource = *loaded;
  core::Diagnostics diagnostics;
  Alarms alarms(resource, {}, true, diagnostics);
  // Active, raised, not acknowledged.
  alarms.restore({{"main.high", 7, std::nullopt, 1}, {"main.valves[2].stuck", 7, std::nullopt, 2}}, 10);
  auto shadow = shadow::Shadow::start(
      resource, {}, {"PICARD test", "", 0, bytecode::kDefaultLoopBudget, "UTC", bytecode::save(resource.image())});
  ASSERT_TRUE(shadow) << shadow.error().message;
  (*shadow)->observe(alarms);
  ASSERT_FALSE(resource.program(0).execute({0, 0, 0}));
  std::vector<Event> events;
  std::vector<Kept> states;
  for (int turn = 0; turn < 1000 && events.empty(); ++turn) {
    alarms.take(events, states);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_EQ(events.size(), 1u) << "one that is latched does not return";
  EXPECT_EQ(events[0].alarm, "main.valves[2].stuck");
  EXPECT_EQ(events[0].what, Happened::kReturned);
  EXPECT_EQ(events[0].text, "Valve is stuck");
  EXPECT_EQ(events[0].priority, Priority::kCritical);
  for (const View& view : alarms.list(false)) {
    if (view.definition.name != "main.high") continue;
    EXPECT_EQ(view.state, State::kUnackedActive);
    EXPECT_EQ(view.definition.text, "Zu voll: ä");
    EXPECT_EQ(view.definition.group, "line");
    EXPECT_TRUE(view.definition.latch);
  }
}

}  // namespace
}  // namespace plc::test
