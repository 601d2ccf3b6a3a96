// The template, as its README tells: installed, copied, built against the installed package alone, drawn, run.
#include <gtest/gtest.h>

#include <cstdio>
#include <regex>
#include <string>
#include <vector>

#include "tests/taskblocks/libraries.h"

namespace plc::test {
namespace {

class Template : public ::testing::Test {
 protected:
  /// In a shell, in the folder of the test.
  [[nodiscard]] ToolResult shell(const std::string& commands, unsigned seconds = 60) const {
    return run_tool(
        {"/bin/sh", "-ec", "umask 022; cd \"$0\"; PATH=\"$0/prefix/bin:$PATH\"\n" + commands, scratch.file("")},
        seconds);
  }
  ScratchFolder scratch;
};

TEST_F(Template, IsInstalledCopiedBuiltDrawnAndRun) {
  const std::string cmake = PLC_CMAKE;
  const ToolResult built = shell(cmake +
                                     " --install " PLC_BUILD
                                     " --prefix \"$0/prefix\"\n"
                                     "cp -r prefix/share/picard/template mine\n"
                                     "cd mine\n" +
                                     cmake +
                                     " -B build -DCMAKE_PREFIX_PATH=\"$0/prefix\" -DCMAKE_CXX_COMPILER=" PLC_CXX
                                     " -DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror'\n" +
                                     cmake +
                                     " --build build\n"
                                     "ctest --test-dir build --output-on-failure\n",
                                 300);
  ASSERT_EQ(built.code, 0) << built.all();
  EXPECT_NE(built.out.find("100% tests passed"), std::string::npos) << built.out;

  const ToolResult checked = shell("cd mine; plc check --werror heating.xml --config plc.toml");
  EXPECT_EQ(checked.code, 0) << checked.all();
  const ToolResult unknown = shell("cd mine; plc check heating.xml");
  EXPECT_EQ(unknown.code, 1) << "the block is known by plc.toml alone\n" << unknown.all();
  EXPECT_NE(unknown.err.find("THERMOSTAT"), std::string::npos) << unknown.err;
  const ToolResult misspelt =
      shell("cd mine; sed s/THERMOSTAT/THERMOSTATS/ heating.xml > wrong.xml; plc check wrong.xml --config plc.toml");
  EXPECT_EQ(misspelt.code, 1);
  EXPECT_NE(misspelt.err.find("did you mean \"THERMOSTAT\"?"), std::string::npos) << misspelt.all();

  // Its page: what the class declares, and where it comes from.
  const ToolResult page = shell("cd mine; plc blocks THERMOSTAT --config plc.toml");
  ASSERT_EQ(page.code, 0) << page.all();
  EXPECT_TRUE(page.out.starts_with("THERMOSTAT (Heating)\n  Two-point controller with hysteresis.\n")) << page.out;
  for (const std::vector<const char*>& cells :
       std::vector<std::vector<const char*>>{{"PV", "input", "LREAL", "degC", "0.0", "measured temperature"},
                                             {"SP", "input", "LREAL", "degC", "20.0", "wanted temperature"},
                                             {"BAND", "configuration", "LREAL", "K", ">= 0", "1.0", "hysteresis"},
                                             {"HEAT", "output", "BOOL", "the heater is on"},
                                             {"STARTS", "output", "UDINT", "how often it was switched on"}}) {
    std::string line = "\n *";
    for (const char* cell : cells) line += std::string(cell == cells.front() ? "" : " +") + cell;
    EXPECT_TRUE(std::regex_search(page.out, std::regex(line + "\n"))) << line << '\n' << page.out;
  }
  EXPECT_NE(page.out.find("HEAT becomes TRUE when PV is below SP - BAND / 2"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("thermostat1 : THERMOSTAT := (BAND := 1.0);"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("build/thermostat.so"), std::string::npos) << page.out;
  EXPECT_EQ(shell("cd mine; plc blocks THERMOSTAT").code, 1) << "without plc.toml there is no such block";

  // One minute: from the cold, 21 degrees by the hysteresis of half a degree.
  const ToolResult simulated = shell(
      "cd mine; plc sim heating.xml --config plc.toml --cycles 600 --watch main.Temperature "
      "--watch main.thermostat.STARTS | tail -n 1");
  ASSERT_EQ(simulated.code, 0) << simulated.all();
  double temperature = 0;
  int starts = 0;
  ASSERT_EQ(std::sscanf(simulated.out.c_str(), "%*d,%*d,%lf,%d", &temperature, &starts), 2) << simulated.all();
  EXPECT_NEAR(temperature, 21.0, 1.0);
  EXPECT_GE(starts, 2);

  const ToolResult ran = shell(
      "cd mine; plc-run heating.xml --config plc.toml --modbus off --engineering off --duration 1500ms --watch "
      "main.thermostat.STARTS");
  EXPECT_EQ(ran.code, 0) << ran.all();
  EXPECT_TRUE(std::regex_search(ran.out, std::regex("main\\.thermostat\\.STARTS=[1-9]"))) << ran.all();
}

}  // namespace
}  // namespace plc::test
