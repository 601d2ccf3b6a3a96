// The log of plc-run: forms, places, limits; and that control does not depend on it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// Counts; its 20th scan is a loop without end.
const char* const kFaulting =
    "PROGRAM Main VAR Count, Turn : DINT; END_VAR\n"
    "  Count := Count + 1;\n"
    "  IF Count = 20 THEN\n"
    "    FOR Turn := 0 TO 2000000000 DO Count := 21; END_FOR;\n"
    "  END_IF;\n"
    "END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC\n"
    "  TASK Fast(INTERVAL := T#5ms, PRIORITY := 0); PROGRAM main WITH Fast : Main;\n"
    "END_RESOURCE END_CONFIGURATION\n";

/// Logs signals into a file that cannot be made.
const char* const kLogging =
    "PROGRAM Main VAR Log : FILE_LOGGER := (FILE := 'signals.csv'); END_VAR\n"
    "  Log(IN1 := 1.0);\n"
    "END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC\n"
    "  TASK Fast(INTERVAL := T#5ms, PRIORITY := 0); PROGRAM main WITH Fast : Main;\n"
    "END_RESOURCE END_CONFIGURATION\n";

/// Tells a thousand lines a second, in one scan, and then a last one.
const char* const kTelling =
    "PROGRAM Main VAR Count, i : DINT; Message : ARRAY[1..300] OF LOG_MSG; Last : LOG_MSG; END_VAR\n"
    "  Count := Count + 1;\n"
    "  FOR i := 1 TO 300 DO Message[i](EXECUTE := Count = 10, SEVERITY := 1, TEXT := 'much {1}', VALUE1 := i); "
    "END_FOR;\n"
    "  Last(EXECUTE := Count = 40, SEVERITY := 2, TEXT := 'tank {1} is full: {2} bar', VALUE1 := 7, VALUE2 := 1.25);\n"
    "END_PROGRAM\n"
    "CONFIGURATION C RESOURCE R ON PLC\n"
    "  TASK Fast(INTERVAL := T#5ms, PRIORITY := 0); PROGRAM main WITH Fast : Main;\n"
    "END_RESOURCE END_CONFIGURATION\n";

class RunLog : public testing::Test {
 protected:
  std::string project(const std::string& text) {
    write_text(scratch.file("plant.st"), text);
    return scratch.file("plant.st");
  }
  ToolResult run(const std::string& text, std::vector<std::string> more, const std::string& duration = "300ms") {
    std::vector<std::string> words = {project(text), "--duration", duration};
    words.insert(words.end(), more.begin(), more.end());
    return run_plant(words);
  }
  /// Every line is an object; those with this value of `name`.
  static std::vector<nlohmann::json> records(const std::string& text, const std::string& name,
                                             const std::string& value) {
    std::vector<nlohmann::json> found;
    for (const std::string& line : lines_of(text)) {
      const auto record = nlohmann::json::parse(line, nullptr, false);
      EXPECT_TRUE(record.is_object()) << line;
      if (record.is_object() && record.value(name, "") == value) found.push_back(record);
    }
    return found;
  }
  ScratchFolder scratch;
};

TEST_F(RunLog, HasWhatAProgramTellsWithBlockTaskAndScan) {
  for (const char* const engine : {"--engine=interp", "--engine=native"}) {
    const auto result = run(kTelling, {"--log", "json", engine});
    EXPECT_EQ(result.code, 0) << result.all();
    const auto told = records(result.err, "block", "LOG_MSG main.Last");
    ASSERT_EQ(told.size(), 1u) << result.err;
    EXPECT_EQ(told[0]["message"], "LOG_MSG main.Last: tank 7 is full: 1.25 bar");
    EXPECT_EQ(told[0]["severity"], "error");
    EXPECT_EQ(told[0]["task"], "Fast");
    EXPECT_EQ(told[0]["scan"], 39);
    EXPECT_EQ(told[0]["source"], "taskblock");
    EXPECT_TRUE(contains(result.err, "172 messages of the taskblocks of task Fast are lost")) << "a ring has 128";
  }
}

TEST_F(RunLog, IsTextOnStderrByDefault) {
  const auto result = run(kFaulting, {});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.err, "Z error: fault R1001: ")) << result.all();
  EXPECT_TRUE(contains(result.out, "ends after ")) << result.all();
}

TEST_F(RunLog, InJsonEverythingOnStderrIsARecord) {
  const auto result = run(kFaulting, {"--log", "json"});
  EXPECT_EQ(result.code, 1);
  const auto faults = records(result.err, "code", "R1001");
  ASSERT_EQ(faults.size(), 1u) << result.all();
  EXPECT_EQ(faults[0]["severity"], "error");
  EXPECT_EQ(faults[0]["task"], "Fast");
  EXPECT_EQ(faults[0]["scan"], 19);
  EXPECT_TRUE(contains(faults[0]["message"], "fault R1001: ")) << faults[0];
  EXPECT_TRUE(contains(result.err, R"("severity": "note", "message": "ends after )")) << result.err;
  EXPECT_TRUE(contains(result.out, "ends after ")) << "people read it on stdout";
}

TEST_F(RunLog, WhatIsWrongBeforeTheRunIsARecordToo) {
  const auto result = run("PROGRAM Main x := 1; END_PROGRAM", {"--log", "json"});
  EXPECT_EQ(result.code, 1);
  const auto errors = records(result.err, "severity", "error");
  ASSERT_FALSE(errors.empty()) << result.err;
  EXPECT_TRUE(errors[0].contains("code")) << errors[0];
  EXPECT_TRUE(errors[0].contains("details")) << "the line of the program: " << errors[0];
}

TEST_F(RunLog, LeavesOutWhatIsNotSevere) {
  const auto result = run(kFaulting, {"--log", "json", "--log-level", "error"});
  EXPECT_EQ(lines_of(result.err).size(), records(result.err, "severity", "error").size()) << result.err;
  EXPECT_EQ(records(result.err, "code", "R1001").size(), 1u);
}

TEST_F(RunLog, AFileHasAllOfItAndStreamsStayAsTheyAre) {
  const std::string file = scratch.file("plant.log");
  const auto result = run(kFaulting, {"--log", "text:" + file});
  EXPECT_EQ(result.code, 1);
  const std::string text = read_text(file);
  for (const char* const part : {"note: task Fast: every 5ms", "error: fault R1001: ", "note: ends after "})
    EXPECT_TRUE(contains(text, part)) << part << ":\n" << text;
  EXPECT_TRUE(contains(result.out, "task Fast: every 5ms")) << result.all();
  const auto again = run(kFaulting, {"--log", "text:" + file});
  EXPECT_EQ(read_text(file).rfind(text, 0), 0u) << "a restart goes on in it";
}

TEST_F(RunLog, IsConfiguredInPlcToml) {
  write_text(scratch.file("plc.toml"),
             "[modbus]\nlisten = \"off\"\n[log]\nformat = \"json\"\nfile = \"plant.jsonl\"\nlevel = \"warning\"\n");
  const auto result = run_plant({project(kFaulting), "--duration", "300ms", "--config", scratch.file("plc.toml")});
  EXPECT_EQ(result.code, 1) << result.all();
  const std::string text = read_text(scratch.file("plant.jsonl"));
  EXPECT_EQ(records(text, "code", "R1001").size(), 1u) << text;
  EXPECT_TRUE(records(text, "severity", "note").empty()) << text;
}

TEST_F(RunLog, ADiskThatIsFullHoldsNothingUpAndIsTold) {
  const auto result = run(kFaulting, {"--log", "json:/dev/full", "--on-fault", "continue"}, "1500ms");
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(contains(result.err, "warning: P7620: the log cannot be written to /dev/full: No space left on device"))
      << result.all();
  EXPECT_TRUE(contains(result.out, "ends after 1.5")) << result.all();
}

TEST_F(RunLog, WhatAFileNeverGetsIsOnStderrOnce) {
  const auto result = run(kFaulting, {"--log", "text:" + scratch.file("none/plant.log"), "--on-fault", "continue"});
  EXPECT_EQ(result.code, 1);
  const auto times = [&result](const std::string& part) {
    std::size_t count = 0;
    for (const std::string& line : lines_of(result.err)) count += contains(line, part) ? 1 : 0;
    return count;
  };
  EXPECT_EQ(times("warning: P7620: the log cannot be written to "), 1u) << result.all();
  EXPECT_EQ(times("error: fault R1001: "), 1u) << result.all();
  // What stdout has is not said again.
  EXPECT_TRUE(contains(result.out, "task Fast: every 5ms")) << result.all();
  EXPECT_EQ(times("task Fast: every 5ms"), 0u) << result.all();
}

TEST_F(RunLog, AnEndIsNotDelayedByAPipeThatNobodyReads) {
  const std::string pipe = scratch.file("pipe");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const int reader = open(pipe.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  const auto begin = std::chrono::steady_clock::now();
  const auto result = run(kFaulting, {"--log", "json:" + pipe, "--stats"});
  EXPECT_EQ(result.code, 1);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
  close(reader);
}

TEST_F(RunLog, TellsWhatATaskblockTells) {
  ::setenv("PICARD_LOG_DIRECTORY", scratch.file("none").c_str(), 1);
  const auto result = run(kLogging, {"--log", "json"});
  const auto simulated = run_tool({PLC_TOOL, "sim", project(kLogging), "--cycles", "200000"});
  ::unsetenv("PICARD_LOG_DIRECTORY");
  EXPECT_EQ(result.code, 0) << result.all();
  const auto told = records(result.err, "source", "taskblock");
  ASSERT_EQ(told.size(), 1u) << result.err;
  EXPECT_EQ(told[0]["severity"], "warning");
  EXPECT_EQ(told[0]["block"], "FILE_LOGGER main.Log");
  EXPECT_EQ(told[0]["task"], "Fast");
  EXPECT_EQ(told[0]["message"],
            "FILE_LOGGER main.Log: signals.csv is not written: No such file or directory; it is tried again");
  EXPECT_TRUE(contains(simulated.err, ": warning: FILE_LOGGER main.Log: signals.csv is not written: "))
      << simulated.all();
}

TEST_F(RunLog, TheJournalGetsFields) {
  const std::string path = scratch.file("journal");
  const int journal = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(journal, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::atomic<bool> ended{false};
  std::vector<std::string> entries;
  std::thread reader([&] {
    char text[8192];
    for (;;) {
      pollfd descriptor{journal, POLLIN, 0};
      if (poll(&descriptor, 1, 20) > 0) {
        const ssize_t n = recv(journal, text, sizeof text, 0);
        if (n > 0) entries.emplace_back(text, static_cast<std::size_t>(n));
      } else if (ended) {
        return;
      }
    }
  });
  const auto result = run(kFaulting, {"--log", "journal:" + path});
  ended = true;
  reader.join();
  close(journal);
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "") << "all of it is in the journal";
  std::string fault, end;
  for (const std::string& entry : entries) {
    if (contains(entry, "MESSAGE=fault R1001: ")) fault = entry;
    if (contains(entry, "MESSAGE=ends after ")) end = entry;
  }
  for (const char* const field : {"\nPRIORITY=3\n", "\nSYSLOG_IDENTIFIER=plc-run\n", "\nPICARD_CODE=R1001\n",
                                  "\nPICARD_TASK=Fast\n", "\nPICARD_SCAN=19\n"})
    EXPECT_TRUE(contains(fault, field)) << field << fault;
  EXPECT_TRUE(contains(end, "\nPRIORITY=6\n")) << end;
}

// Without a journal here, what tells that it was tried is that nobody is there.
TEST_F(RunLog, IsTheJournalWhereStderrIs) {
  if (fs::exists("/run/systemd/journal/socket")) GTEST_SKIP() << "this machine has a journal, which is not for tests";
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  struct stat status {};
  ASSERT_EQ(fstat(ends[1], &status), 0);
  const std::string stream = std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
  const std::string file = project(kFaulting);
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDERR_FILENO);
    setenv("JOURNAL_STREAM", stream.c_str(), 1);
    execl(PLC_RUN_TOOL, PLC_RUN_TOOL, file.c_str(), "--modbus", "off", "--engineering", "off", "--duration", "300ms",
          nullptr);
    _exit(99);
  }
  close(ends[1]);
  std::string text;
  char part[4096];
  for (ssize_t n = 0; (n = read(ends[0], part, sizeof part)) > 0;) text.append(part, static_cast<std::size_t>(n));
  close(ends[0]);
  EXPECT_TRUE(contains(text, "P7620: the log cannot be written to the journal: No such file or directory")) << text;
  EXPECT_TRUE(contains(text, "error: fault R1001")) << "an operator has to learn of it: " << text;
}

TEST_F(RunLog, RefusesOtherPlaces) {
  for (const char* const place : {"xml", "json:", "syslog:x", ""}) {
    const auto result = run(kFaulting, {"--log", place});
    EXPECT_EQ(result.code, 2) << place;
    EXPECT_TRUE(contains(result.err, "is not a place for messages") || contains(result.err, "--log")) << result.err;
  }
}

}  // namespace
}  // namespace plc::test
