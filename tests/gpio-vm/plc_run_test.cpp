// plc-run with a guardian on a simulated chip: what arrives at the lines while it runs, and what they are set to when
// it ends in each of the ways it can. gpio-sim lets a line fall back to its pull as soon as nobody holds it, so the end
// is read from the kernel's trace of every value that was set, which also names the process.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "io-drivers/gpio/gpio_lines.h"
#include "tests/gpio-vm/sim_chip.h"

namespace plc::test {
namespace {

constexpr int kStart = 0, kPulse = 1, kLamp = 8, kEcho = 9, kFull = 10, kAlive = 11, kSeen = 12;
const char* const kProject = "/srv/panel.xml";
const char* const kConfiguration = "/tmp/plc.toml";
const char* const kOutput = "/tmp/plc-run.out";

/// Generous: the guest is slow and its host may be busy.
bool soon(const std::function<bool()>& condition, int seconds = 30) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
  for (; !condition(); usleep(2000)) {
    if (std::chrono::steady_clock::now() > end) return false;
  }
  return true;
}

/// Lamp is TRUE when safe, though the program says FALSE; Alive is FALSE when safe, though the program says TRUE.
std::string panel(const std::string& more = "") {
  return "[drivers.panel]\nkind = \"gpio\"\nchip = \"plc-a\"\nretry = \"200ms\"\n"
         "[guardian]\nhang_timeout = \"3s\"\n" +
         more + R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 0 }
"%IX0.1" = { driver = "panel", channel = 1, latch = "rising" }
[outputs]
"%QX0.0" = { driver = "panel", channel = 8, safe = true }
"%QX0.1" = { driver = "panel", channel = 9 }
"%QX0.2" = { driver = "panel", channel = 10 }
"%QX0.4" = { driver = "panel", channel = 12 }
)";
}
const char* const kAliveLine = "\"%QX0.3\" = { driver = \"panel\", channel = 11 }\n";

class PlcRun : public testing::Test {
 protected:
  PlcRun() : chip("plc-a", {}) {}
  ~PlcRun() override {
    for (const pid_t process : {runtime, guardian}) {
      if (process > 0) kill(process, SIGKILL);
    }
    if (guardian > 0) waitpid(guardian, nullptr, 0);
  }

  void start(const std::string& toml) {
    write_text(kConfiguration, toml);
    guardian = fork();
    if (guardian == 0) {
      const int out = ::open(kOutput, O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0644);
      dup2(out, STDOUT_FILENO);
      dup2(out, STDERR_FILENO);
      execl("/usr/bin/plc-run", "plc-run", kProject, "--config", kConfiguration, "--modbus", "off", "--engineering",
            "off", nullptr);
      _exit(127);
    }
  }
  /// Starts it and waits until cycles are completed.
  void start_running(const std::string& toml = panel() + kAliveLine) {
    start(toml);
    ASSERT_TRUE(soon([&] { return chip.value(kAlive); })) << text_of(kOutput);
    const std::string id = std::to_string(guardian);
    runtime = std::atoi(text_of("/proc/" + id + "/task/" + id + "/children").c_str());
    ASSERT_GT(runtime, 0) << text_of(kOutput);
    // The first cycle's outputs are out before it is over, and until it is the guardian is more patient: two more.
    for (const bool level : {true, false}) {
      chip.pull(kStart, level);
      ASSERT_TRUE(soon([&] { return chip.value(kLamp) == level; })) << text_of(kOutput);
    }
  }
  /// Exit code of the process that was started, -signal when it was killed.
  int wait_for_end() {
    int status = 0;
    const bool ended = soon([&] { return waitpid(guardian, &status, WNOHANG) == guardian; });
    EXPECT_TRUE(ended) << text_of(kOutput);
    if (!ended) return -999;
    guardian = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  void expect_last_set(const KernelTrace& trace, int line, int value, const std::string& process) const {
    const auto sets = trace.sets(chip.number(line));
    ASSERT_FALSE(sets.empty()) << "line " << line << " was never set";
    EXPECT_EQ(sets.back().value, value) << "line " << line;
    EXPECT_EQ(sets.back().process, process) << "line " << line;
  }
  void expect_safe(const KernelTrace& trace, const std::string& process) const {
    expect_last_set(trace, kLamp, 1, process);
    expect_last_set(trace, kAlive, 0, process);
  }
  void expect_lines_free() const {
    io::LinesRequest all{"plc-a", {}, {}};
    for (int line = 0; line < 16; ++line) all.inputs.push_back({.line = std::to_string(line), .variable = "x"});
    const auto problem = io::kernel_gpio().check(all);
    EXPECT_FALSE(problem) << problem->message;
  }
  /// True when the kernel has counted an interrupt of the rising edge. WHY: while its thread has not left the last one,
  /// the simulated line is masked and forgets edges, which a line of hardware does not.
  [[nodiscard]] bool make_pulse() const {
    const long before = interrupts();
    chip.pull(kPulse, true);
    usleep(3000);
    chip.pull(kPulse, false);
    return interrupts() > before;
  }
  /// Interrupts of the lines that plc-run has, as /proc/interrupts counts them.
  static long interrupts() {
    std::istringstream all(text_of("/proc/interrupts"));
    long sum = 0;
    for (std::string line; std::getline(all, line);) {
      if (line.find("plc-run") == std::string::npos) continue;
      std::istringstream words(line.substr(line.find(':') + 1));
      for (long count = 0; words >> count;) sum += count;
    }
    return sum;
  }
  [[nodiscard]] static bool said(const std::string& text) { return text_of(kOutput).find(text) != std::string::npos; }

  SimChip chip;
  pid_t guardian = 0, runtime = 0;
};

TEST_F(PlcRun, FollowsItsInputsAndEndsSafelyOnSigterm) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  EXPECT_FALSE(chip.value(kLamp));
  for (const bool level : {true, false, true, false}) {
    chip.pull(kStart, level);
    EXPECT_TRUE(soon([&] { return chip.value(kLamp) == level; }));
  }
  const KernelTrace trace;
  kill(guardian, SIGTERM);
  EXPECT_EQ(wait_for_end(), 0) << text_of(kOutput);
  expect_safe(trace, "plc-run");
  expect_lines_free();
}

TEST_F(PlcRun, CountsAThousandPulsesShorterThanItsCycle) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  bool echo = chip.value(kEcho);
  for (int pulse = 1; pulse <= 1000; ++pulse) {
    ASSERT_TRUE(soon([&] { return make_pulse(); }));
    echo = !echo;
    ASSERT_TRUE(soon([&] { return chip.value(kEcho) == echo; })) << "pulse " << pulse << " was not seen";
    // Pulses that merge in one cycle are one: the next has to wait for a cycle that saw the line low.
    ASSERT_TRUE(soon([&] { return !chip.value(kSeen); }));
    if (pulse == 999) {
      usleep(50'000);
      EXPECT_EQ(chip.value(kEcho), echo) << "no pulse was seen twice";
      EXPECT_FALSE(chip.value(kFull)) << "more than 999";
    }
  }
  EXPECT_TRUE(soon([&] { return chip.value(kFull); })) << "fewer than 1000";
}

TEST_F(PlcRun, AKilledRuntimeLeavesSafeValues) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  const KernelTrace trace;
  kill(runtime, SIGKILL);
  EXPECT_EQ(wait_for_end(), 3) << text_of(kOutput);
  expect_safe(trace, "plc-guardian");
  EXPECT_TRUE(said("was killed by signal 9")) << text_of(kOutput);
  EXPECT_TRUE(said("the outputs of panel have their safe values")) << text_of(kOutput);
  expect_lines_free();
}

TEST_F(PlcRun, AStoppedRuntimeLeavesSafeValues) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  const KernelTrace trace;
  kill(runtime, SIGSTOP);
  EXPECT_EQ(wait_for_end(), 3) << text_of(kOutput);
  expect_safe(trace, "plc-guardian");
  EXPECT_TRUE(said("has not completed a cycle of task \"Fast\"")) << text_of(kOutput);
  expect_lines_free();
}

TEST_F(PlcRun, WithoutItsGuardianTheRuntimeEndsSafely) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  const KernelTrace trace;
  kill(guardian, SIGKILL);
  EXPECT_EQ(wait_for_end(), -SIGKILL);
  EXPECT_TRUE(soon([&] { return kill(runtime, 0) != 0; })) << text_of(kOutput);
  expect_safe(trace, "plc-run");
  expect_lines_free();
}

TEST_F(PlcRun, AWrongConfigurationTouchesNoLine) {
  const SimChip second("plc-b", {});
  const KernelTrace trace;
  const std::string other = "[drivers.second]\nkind = \"gpio\"\nchip = \"plc-b\"\n";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {panel(other) + "\"%QX0.3\" = { driver = \"second\", channel = 99 }\n", "P7402"},
      {panel(other) + "\"%QX0.3\" = { driver = \"second\", channel = 3, latch = \"rising\" }\n", "P73"},
      {panel() + "\"%QX0.3\" = { driver = \"panel\", channel = 11 \n", "P73"},
      {panel() + "\"%QX9.3\" = { driver = \"panel\", channel = 11 }\n", "P73"},
  };
  for (const auto& [toml, code] : wrong) {
    start(toml);
    EXPECT_EQ(wait_for_end(), 1) << text_of(kOutput);
    EXPECT_TRUE(said(code)) << text_of(kOutput);
    for (int line = 0; line < 16; ++line) {
      EXPECT_TRUE(trace.sets(chip.number(line)).empty()) << line;
      EXPECT_TRUE(trace.sets(second.number(line)).empty()) << line;
    }
  }
  expect_lines_free();
}

TEST_F(PlcRun, ABusyLineIsNamedWithItsUser) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  const pid_t first = guardian, first_runtime = runtime;
  start(panel() + kAliveLine);
  EXPECT_EQ(wait_for_end(), 4);
  EXPECT_TRUE(said("line 0 of " + chip.name() + " is in use by \"plc-run\"")) << text_of(kOutput);
  guardian = first;
  runtime = first_runtime;
  EXPECT_TRUE(chip.value(kAlive)) << "the first one goes on";
}

TEST_F(PlcRun, AChipMayGoAndComeBack) {
  ASSERT_NO_FATAL_FAILURE(start_running());
  chip.unplug();
  EXPECT_TRUE(soon([] { return said("panel: plc-a does not answer: No such device"); })) << text_of(kOutput);
  chip.plug();
  EXPECT_TRUE(soon([] { return said("panel: plc-a is back after"); })) << text_of(kOutput);
  for (const bool level : {true, false}) {
    chip.pull(kStart, level);
    EXPECT_TRUE(soon([&] { return chip.value(kLamp) == level; }));
  }
  // The guardian's own handle died with the chip: it has to ask for the lines afresh.
  const KernelTrace trace;
  kill(runtime, SIGKILL);
  EXPECT_EQ(wait_for_end(), 3) << text_of(kOutput);
  expect_safe(trace, "plc-guardian");
  EXPECT_TRUE(said("the outputs of panel have their safe values")) << text_of(kOutput);
}

}  // namespace
}  // namespace plc::test
