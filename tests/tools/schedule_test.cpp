// plc calibrate, plc explain --schedule, and what plc config check says of the tasks.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

using nlohmann::json;

class ScheduleTool : public testing::Test {
 protected:
  void SetUp() override {
    write_text(project_, R"(
FUNCTION_BLOCK Counting
VAR_INPUT most : DINT; END_VAR
VAR n : DINT; END_VAR
  WHILE n < most DO
    n := n + 1;
  END_WHILE;
END_FUNCTION_BLOCK
PROGRAM Main
VAR x : LREAL; END_VAR
  x := SIN(x) + 1.0;
END_PROGRAM
PROGRAM Background
VAR counting : Counting; END_VAR
  counting(most := 100);
END_PROGRAM
CONFIGURATION C
  VAR_GLOBAL go : BOOL; END_VAR
  RESOURCE R ON PLC
    TASK Fast(INTERVAL := T#1ms, PRIORITY := 0);
    TASK Slow(INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM main WITH Fast : Main;
    PROGRAM background WITH Slow : Background;
  END_RESOURCE
END_CONFIGURATION
)");
  }
  ToolResult explain(std::vector<std::string> more) {
    std::vector<std::string> command = {PLC_TOOL, "explain", project_, "--schedule"};
    command.insert(command.end(), more.begin(), more.end());
    return run_tool(command);
  }
  json explained(const std::string& toml) {
    write_text(configuration_, toml);
    const auto result = explain({"--config", configuration_, "--json"});
    EXPECT_EQ(result.code, 0) << result.err;
    return json::parse(result.out, nullptr, false);
  }
  ScratchFolder scratch_;
  std::string project_ = scratch_.file("plant.st");
  std::string configuration_ = scratch_.file("plc.toml");
};

TEST_F(ScheduleTool, ShowsEveryTaskWithWhatIsKnownOfIt) {
  const auto result = explain({});
  ASSERT_EQ(result.code, 0) << result.err;
  for (const char* words :
       {"coherence=wait-free", "any processor", "Fast", "Slow", "estimate", "lead", " 50us ", "fits", "utilisation",
        "Liu and Layland's bound 82.8 %", "100 % more", "a typical machine (plc calibrate measures yours)",
        "plant.st:5:3: a loop whose number of rounds is not known counts as 10 rounds [POU Counting]",
        "tasks that are bound to no processor count as if they all ran on one"}) {
    EXPECT_NE(result.out.find(words), std::string::npos) << words << " is not in\n" << result.out;
  }
}

TEST_F(ScheduleTool, MeasuredTimesAndProcessorsOfTheConfiguration) {
  const json s = explained(R"(
[scheduler]
cpu = 1
[tasks.Fast]
execution = "400us"
deadline = "900us"
lead = "20us"
[tasks.Slow]
execution = "2ms"
lead = "0s"
)");
  ASSERT_EQ(s["processors"].size(), 1u);
  const json& processor = s["processors"][0];
  EXPECT_EQ(processor["cpu"], 1);
  EXPECT_EQ(processor["verdict"], "fits");
  const auto release = s["release_ns"].get<std::int64_t>();
  EXPECT_GT(release, 0);
  EXPECT_NEAR(processor["utilization"].get<double>(), 0.62 + static_cast<double>(release) * 1.1e-6, 1e-9);
  EXPECT_TRUE(processor["rate_monotonic"]);
  const json& fast = processor["tasks"][0];
  EXPECT_EQ(fast["name"], "Fast");
  EXPECT_TRUE(fast["measured"]);
  EXPECT_EQ(fast["deadline_ns"], 900'000);
  EXPECT_EQ(fast["lead_ns"], 20'000);
  EXPECT_EQ(fast["margin_ns"], 480'000 - release);
  EXPECT_EQ(processor["tasks"][1]["lead_ns"], 0);
  EXPECT_EQ(processor["tasks"][1]["response_ns"], 2'000'000 + 4 * 420'000 + 5 * release);
  EXPECT_EQ(processor["tasks"][1]["assumed_loops"][0]["line"], 5);
}

TEST_F(ScheduleTool, PrioritiesMayBeMadeRateMonotonic) {
  const json as_declared = explained("[tasks.Fast]\npriority = 5\n");
  EXPECT_FALSE(as_declared["processors"][0]["rate_monotonic"]);
  EXPECT_EQ(as_declared["processors"][0]["tasks"][0]["name"], "Slow");
  const json by_interval = explained("[scheduler]\npriorities = \"rate-monotonic\"\n");
  EXPECT_TRUE(by_interval["processors"][0]["rate_monotonic"]);
  EXPECT_EQ(by_interval["processors"][0]["tasks"][0]["name"], "Fast");
}

TEST_F(ScheduleTool, CalibrationIsMeasuredAndThenUsed) {
  const std::string file = scratch_.file("machine.toml");
  const auto made = run_tool({PLC_TOOL, "calibrate", "--repetitions", "5", "-o", file});
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* words : {"measuring: instructions", "release", "wide_record", "function blocks", "ratio",
                            "loops, sums over 1,000 elements", "machine.toml: name it in plc.toml"}) {
    EXPECT_NE(made.out.find(words), std::string::npos) << words << " is not in\n" << made.out;
  }
  const json s = explained("[scheduler]\ncalibration = \"machine.toml\"\n");
  EXPECT_TRUE(s["calibrated"]);
  EXPECT_DOUBLE_EQ(s["margin"].get<double>(), 0.3);
  EXPECT_GT(s["processors"][0]["tasks"][0]["execution_ns"].get<std::int64_t>(), 0);
  const auto text = explain({"--config", configuration_});
  EXPECT_NE(text.out.find("30 % more, by what they take on " + s["machine"].get<std::string>()), std::string::npos)
      << text.out;
}

TEST_F(ScheduleTool, ImagesHaveASchedule) {
  const std::string image = scratch_.file("plant.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", project_, "-o", image, "--coherence=global-lock"}).code, 0);
  const auto result = run_tool({PLC_TOOL, "explain", image, "--schedule"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("coherence=global-lock"), std::string::npos) << result.out;
}

TEST_F(ScheduleTool, WrongUse) {
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", project_, "--json"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "explain", project_, "--config", configuration_}).code, 2);
  EXPECT_EQ(explain({"Main"}).code, 2);
  EXPECT_EQ(explain({"--config", scratch_.file("none.toml")}).code, 2);
  write_text(configuration_, "[tasks.Fats]\ncpu = 1\n");
  const auto unknown = explain({"--config", configuration_});
  EXPECT_EQ(unknown.code, 1);
  EXPECT_NE(unknown.err.find("P7601"), std::string::npos) << unknown.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "calibrate", "--repetitions", "0"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "calibrate", "--repetitions", "1", "-o", "/nowhere/machine.toml"}).code, 2);
}

TEST_F(ScheduleTool, ConfigCheckSaysWhatPlcRunWould) {
  const std::string cpu = "cpu = " + std::to_string(0) + "\n";
  write_text(configuration_,
             "[scheduler]\n" + cpu + "[tasks.Fast]\nexecution = \"900us\"\n[tasks.Slow]\nexecution = \"3ms\"\n");
  const auto refused = run_tool({PLC_TOOL, "config", "check", configuration_, project_});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("error P7606: task \"Slow\""), std::string::npos) << refused.err;
  write_text(configuration_, "[tasks.Fast]\ncpu = 1023\n");
  const auto nowhere = run_tool({PLC_TOOL, "config", "check", configuration_, project_});
  EXPECT_NE(nowhere.err.find("error P7602"), std::string::npos) << nowhere.err;
}

}  // namespace
}  // namespace plc::test
