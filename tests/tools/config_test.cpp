#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <string>

#include "io-drivers/machine/driver_types.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

/// As `sed 's/^#\([^ ]\)/\1/'` would.
std::string uncommented(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    const std::size_t skip = text[at] == '#' && at + 1 < end && text[at + 1] != ' ' ? 1 : 0;
    out += text.substr(at + skip, end + 1 - at - skip);
    at = end + 1;
  }
  return out;
}

TEST(ConfigInit, WhatItWritesPassesTheCheck) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  const auto init = run_tool({PLC_TOOL, "config", "init", tank(), "-o", file});
  ASSERT_EQ(init.code, 0) << init.err;
  const std::string text = read_text(file);
  for (const char* part :
       {"StartButton", "%IW0", "LampRunning", "#listen = ", "#hang_timeout = ", "#task = \"Fast\""}) {
    EXPECT_NE(text.find(part), std::string::npos) << part;
  }
  const auto check = run_tool({PLC_TOOL, "config", "check", file, tank()});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_EQ(check.out, file + ": ok, 0 drivers, 0 inputs, 0 outputs mapped, 0 warnings\n");
  EXPECT_EQ(check.err, "");

  write_text(file, uncommented(text));
  const auto full = run_tool({PLC_TOOL, "config", "check", file, tank()});
  EXPECT_EQ(full.code, 0) << full.err;
  const std::string drivers = std::to_string(io::driver_types().size());
  EXPECT_EQ(full.out, file + ": ok, " + drivers + " drivers, 5 inputs, 6 outputs mapped, 0 warnings\n");
  EXPECT_EQ(full.err, "");
}

TEST(ConfigInit, PrintsWithoutAFile) {
  const auto result = run_tool({PLC_TOOL, "config", "init", tank()});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(result.out.substr(0, 11), "# plc.toml:");
}

TEST(ConfigInit, NeverOverwritesWithoutForce) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  write_text(file, "precious");
  const auto refused = run_tool({PLC_TOOL, "config", "init", tank(), "-o", file});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("--force"), std::string::npos) << refused.err;
  EXPECT_EQ(read_text(file), "precious");
  // A link that leads nowhere is something, too.
  const std::string link = scratch.file("link.toml");
  ASSERT_EQ(::symlink("/nowhere/plc.toml", link.c_str()), 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", tank(), "-o", link}).code, 2);

  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", tank(), "-o", file, "--force"}).code, 0);
  EXPECT_NE(read_text(file), "precious");
}

TEST(ConfigInit, NeverReplacesTheProject) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("plant.xml");
  write_text(project, small_project());
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", project, "-o", project, "--force"}).code, 2);
  EXPECT_EQ(read_text(project), small_project());
}

TEST(ConfigInit, AProjectWithErrorsHasNone) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("bad.xml");
  write_text(project, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "config", "init", project, "-o", scratch.file("plc.toml")});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(::access(scratch.file("plc.toml").c_str(), F_OK), 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "init", scratch.file("absent.xml")}).code, 2);
}

TEST(ConfigCheck, ProblemsHaveTheUsualForm) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  write_text(file,
             "[drivers.panel]\nkind = \"gpio\"\nchip = \"gpiochip0\"\n[inputs]\n"
             "StratButton = { driver = \"panel\", channel = 17 }\n");
  const auto result = run_tool({PLC_TOOL, "config", "check", file, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find(file + ":5:1: error P7320: \"StratButton\": no instance or global of this name\n"
                                   " 5 | StratButton = { driver = \"panel\", channel = 17 }\n   | ^\n"
                                   "  help: did you mean \"StartButton\"?\n"),
            std::string::npos)
      << result.err;
  EXPECT_EQ(result.out, file + ": 1 error, 1 warning\n") << "the outputs of the tank lead to no channel";
}

TEST(ConfigCheck, BothFilesAreCheckedInOneRun) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  const std::string project = scratch.file("bad.xml");
  write_text(file, "[modbus]\nlisten = 5\n");
  write_text(project, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "config", "check", file, project});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find(file + ":2:10: error P7304"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("Nowhere"), std::string::npos) << result.err;
  EXPECT_EQ(result.out.find(project + ": 1 error\n" + file + ": 1 error, "), 0u) << result.out;
}

TEST(ConfigCheck, FilesThatCannotBeOpened) {
  const ScratchFolder scratch;
  const auto absent = run_tool({PLC_TOOL, "config", "check", scratch.file("absent.toml"), tank()});
  EXPECT_EQ(absent.code, 2);
  EXPECT_NE(absent.err.find("P7001"), std::string::npos) << absent.err;
  const std::string pipe = scratch.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", pipe, tank()}, 10).code, 2);
  const std::string file = scratch.file("plc.toml");
  write_text(file, "");
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", file, scratch.file("absent.xml")}).code, 2);
}

TEST(ConfigCheck, FilesThatItNamesAreChecked) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  const auto check = [&](const std::string& text) {
    write_text(file, text);
    return run_tool({PLC_TOOL, "config", "check", file, tank()});
  };
  const std::string driver = "[drivers.plant]\nkind = \"simulated\"\nstimulus = \"in.csv\"\n";
  const auto absent = check(driver);
  EXPECT_EQ(absent.code, 1);
  EXPECT_NE(absent.err.find(file + ":3:12: error P7001"), std::string::npos) << absent.err;
  write_text(scratch.file("in.csv"), "time_ms,Nowhere\n0,1\n");
  const auto wrong = check(driver);
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find(file + ":3:12: error P7101"), std::string::npos) << wrong.err;
  write_text(scratch.file("in.csv"), "time_ms,StartButton\n0,1\n");
  EXPECT_EQ(check(driver).code, 0);

  const auto pattern = check("[modbus]\nexported = [\"Nowhere*\"]\n");
  EXPECT_EQ(pattern.code, 0);
  EXPECT_NE(pattern.err.find(file + ":2:13: warning P7503"), std::string::npos) << pattern.err;
  write_text(scratch.file("lock.csv"), "nonsense\n");
  const auto lock = check("[modbus]\nlock_file = \"lock.csv\"\n");
  EXPECT_EQ(lock.code, 1);
  EXPECT_NE(lock.err.find(file + ":2:13: error P7501"), std::string::npos) << lock.err;
}

TEST(ConfigCheck, TakesImages) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("tank.pbc");
  const std::string file = scratch.file("plc.toml");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", tank(), "-o", image}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "config", "init", image, "-o", file}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", file, image}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "check", file, image, "--order=document"}).code, 2);
}

TEST(ConfigCheck, JsonIsOneDocumentOnStdout) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plc.toml");
  write_text(file, "[guardian]\nhang_timout = \"1s\"\n");
  const auto result = run_tool({PLC_TOOL, "config", "check", "--json", file, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "");
  const auto document = nlohmann::json::parse(result.out);
  ASSERT_EQ(document["diagnostics"].size(), 1u);
  EXPECT_EQ(document["diagnostics"][0]["code"], "P7303");
  EXPECT_EQ(document["diagnostics"][0]["line"], 2);
  EXPECT_EQ(document["diagnostics"][0]["column"], 1);
  EXPECT_FALSE(document["files"][0]["ok"]);
}

TEST(Config, NeedsACommand) {
  EXPECT_EQ(run_tool({PLC_TOOL, "config"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "config", "--help"}).code, 0);
}

}  // namespace
}  // namespace plc::test
