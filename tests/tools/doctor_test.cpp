// plc doctor as one types it. What it finds is tested in tests/unit/doctor.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

using nlohmann::json;

void write_file(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

TEST(DoctorCommand, ShowsATableOfThisMachine) {
  const auto result = run_tool({PLC_TOOL, "doctor"});
  EXPECT_TRUE(result.code == 0 || result.code == 1) << result.all();
  EXPECT_NE(result.out.find("kernel: preemption"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find(" problems, "), std::string::npos) << result.out;
  EXPECT_EQ(result.err, "");
}

TEST(DoctorCommand, EndsWithOneForAProblemAndWithNothingForAWarning) {
  const ScratchFolder scratch;
  write_file(scratch.file("machine/proc/version"), "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC\n");
  const auto warned = run_tool({PLC_TOOL, "doctor", "--root", scratch.file("machine")});
  EXPECT_EQ(warned.code, 0) << warned.all();
  EXPECT_NE(warned.out.find("warning P7920 kernel: preemption"), std::string::npos) << warned.out;
  write_file(scratch.file("plc.toml"), "[drivers.a]\nkind = \"gpio\"\nchip = \"/dev/gpiochip7\"\n");
  const auto refused = run_tool({PLC_TOOL, "doctor", scratch.file("plc.toml"), "--root", scratch.file("machine")});
  EXPECT_EQ(refused.code, 1) << refused.all();
  EXPECT_NE(refused.out.find("problem P7955 devices: nodes"), std::string::npos) << refused.out;
  EXPECT_NE(refused.out.find("a: /dev/gpiochip7 is not there"), std::string::npos) << refused.out;
}

TEST(DoctorCommand, GivesOneDocumentOfJson) {
  const ScratchFolder scratch;
  write_file(scratch.file("machine/proc/swaps"), "Filename Type\n/dev/sda5 partition\n");
  const auto result = run_tool({PLC_TOOL, "doctor", "--json", "--root", scratch.file("machine")});
  EXPECT_EQ(result.code, 0) << result.all();
  const json document = json::parse(result.out);
  std::size_t notes = 0;
  for (const json& line : document.at("lines")) {
    for (const char* const key : {"state", "code", "area", "what", "seen", "help"}) {
      EXPECT_TRUE(line.at(key).is_string()) << line;
    }
    if (line.at("state") != "note") continue;
    ++notes;
    EXPECT_EQ(line.at("code"), "P7926");
    EXPECT_NE(line.at("seen").get<std::string>().find("/dev/sda5"), std::string::npos);
  }
  EXPECT_EQ(notes, 1u);
  EXPECT_EQ(document.at("counts").at("note"), 1);
  EXPECT_EQ(document.at("counts").at("problem"), 0);
}

TEST(DoctorCommand, RefusesWhatMakesNoSense) {
  const ScratchFolder scratch;
  write_file(scratch.file("plc.toml"), "");
  EXPECT_EQ(run_tool({PLC_TOOL, "doctor", "--root", scratch.file("nowhere")}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "doctor", scratch.file("nowhere.toml")}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "doctor", scratch.file("nowhere.st")}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "doctor", "--process", "x"}).code, 2);
  const auto nobody = run_tool({PLC_TOOL, "doctor", "--process", "4194305"});  // one more than the kernel ever gives
  EXPECT_EQ(nobody.code, 2);
  EXPECT_EQ(nobody.out, "");
  EXPECT_NE(nobody.err.find("there is no process 4194305"), std::string::npos) << nobody.err;
  const auto two = run_tool({PLC_TOOL, "doctor", scratch.file("plc.toml"), "--config", scratch.file("plc.toml")});
  EXPECT_EQ(two.code, 2);
  EXPECT_NE(two.err.find("two configurations"), std::string::npos) << two.err;
}

/// What the kernel has of a process that is another's, and of this one.
TEST(DoctorCommand, LooksAtAnotherProcess) {
  const auto own = run_tool({PLC_TOOL, "doctor", "--process", std::to_string(::getpid())});
  EXPECT_NE(own.out.find("kernel: /proc and /sys"), std::string::npos) << own.all();
  EXPECT_EQ(own.out.find("/proc is not there"), std::string::npos) << own.out;
}

}  // namespace
}  // namespace plc::test
