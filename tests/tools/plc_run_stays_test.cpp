// plc-run goes on and comes to its end whatever becomes of its streams, its log and its port.
#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <climits>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

bool soon(const std::function<bool()>& condition) {
  for (int i = 0; i < 1500; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(milliseconds(10));
  }
  return false;
}

const char* const kCounting =
    "PROGRAM Main\n"
    "VAR_EXTERNAL Speed, Count : INT; END_VAR\n"
    "VAR Turn : DINT; END_VAR\n"
    "  Speed := 1500;\n"
    "  Count := Count + 1;\n"
    "  IF Count = 20 THEN\n"
    "    FOR Turn := 0 TO 2000000000 DO Speed := 7; END_FOR;\n"
    "  END_IF;\n"
    "END_PROGRAM\n"
    "CONFIGURATION C\n"
    "  VAR_GLOBAL Speed AT %QW0 : INT; Count : INT := START; END_VAR\n"
    "  RESOURCE R ON PLC\n"
    "    TASK Fast(INTERVAL := T#5ms, PRIORITY := 0);\n"
    "    PROGRAM main WITH Fast : Main;\n"
    "  END_RESOURCE\n"
    "END_CONFIGURATION\n";

/// Counts from 30 on, and never comes to the loop that takes too long; or to it in the 20th scan.
std::string counting(bool faults = false) {
  std::string text = kCounting;
  return text.replace(text.find("START"), 5, faults ? "0" : "30");
}

/// A process of plc-run with streams of the test's own.
class Running {
 public:
  Running(std::vector<std::string> arguments, int out, int err) {
    arguments.insert(arguments.begin(), PLC_RUN_TOOL);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    for (int fd = STDERR_FILENO + 1; fd < 64; ++fd) close(fd);
    alarm(60);
    execv(argv[0], argv.data());
    _exit(99);
  }
  ~Running() {
    if (pid_ > 0) kill(pid_, SIGKILL), waitpid(pid_, nullptr, 0);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  void signal(int number) const { kill(pid_, number); }
  /// Exit code, -signal, or -999 when it does not end within 15 s.
  int wait() {
    int status = 0;
    if (!soon([&] { return waitpid(pid_, &status, WNOHANG) == pid_; })) return -999;
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = 0;
};

struct Pipe {
  Pipe() { EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0); }
  ~Pipe() {
    close(ends[0]);
    close(ends[1]);
  }
  /// Reads until it has seen `part`.
  bool shows(const std::string& part) {
    while (!contains(seen, part)) {
      pollfd in{ends[0], POLLIN, 0};
      char text[4096];
      if (poll(&in, 1, 15'000) != 1) return false;
      const ssize_t count = ::read(ends[0], text, sizeof text);
      if (count <= 0) return false;
      seen.append(text, static_cast<std::size_t>(count));
    }
    return true;
  }
  /// Nothing more goes in.
  void fill() const {
    const std::string rubbish(PIPE_BUF, '.');
    pollfd out{ends[1], POLLOUT, 0};
    while (poll(&out, 1, 0) == 1 && (out.revents & POLLOUT) != 0) {
      ASSERT_GT(::write(ends[1], rubbish.data(), rubbish.size()), 0);
    }
  }
  int ends[2]{};
  std::string seen;
};

class Stays : public testing::Test {
 protected:
  std::string project(const std::string& text) {
    write_text(scratch.file("plant.st"), text);
    return scratch.file("plant.st");
  }
  ScratchFolder scratch;
};

TEST_F(Stays, EndsThoughNobodyReadsItsStreams) {
  Pipe pipe;
  Running run({project(counting()), "--modbus", "off", "--engineering", "off", "--stats"}, pipe.ends[1], pipe.ends[1]);
  ASSERT_TRUE(pipe.shows("task Fast: ")) << pipe.seen;
  ASSERT_TRUE(pipe.shows("modbus: off")) << pipe.seen;
  std::this_thread::sleep_for(milliseconds(200));
  pipe.fill();
  run.signal(SIGUSR1);
  std::this_thread::sleep_for(milliseconds(200));
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait(), 0);
}

TEST_F(Stays, ASignalWithoutAMeaningEndsNothing) {
  Pipe pipe;
  Running run({project(counting()), "--modbus", "off", "--engineering", "off"}, pipe.ends[1], pipe.ends[1]);
  ASSERT_TRUE(pipe.shows("modbus: off")) << pipe.seen;
  run.signal(SIGUSR2);
  run.signal(SIGUSR1);
  EXPECT_TRUE(pipe.shows("Fast, every 5ms")) << pipe.seen;
  run.signal(SIGTERM);
  EXPECT_TRUE(pipe.shows(": signal SIGTERM\n")) << pipe.seen;
  EXPECT_EQ(run.wait(), 0);
}

TEST_F(Stays, WhatASlowReaderMissedIsPrintedLater) {
  Pipe pipe;
  Running run({project(counting()), "--modbus", "off", "--engineering", "off"}, pipe.ends[1], pipe.ends[1]);
  ASSERT_TRUE(pipe.shows("modbus: off")) << pipe.seen;
  std::this_thread::sleep_for(milliseconds(200));
  pipe.fill();
  run.signal(SIGUSR1);
  std::this_thread::sleep_for(milliseconds(200));
  EXPECT_TRUE(pipe.shows("Fast, every 5ms")) << "the report waited";
  run.signal(SIGTERM);
  EXPECT_TRUE(pipe.shows(": signal SIGTERM\n")) << pipe.seen;
  EXPECT_EQ(run.wait(), 0);
}

TEST_F(Stays, MessagesComeBackWhenTheDiskHasSpace) {
  const fs::path disk = scratch.file("disk");
  fs::create_directory(disk);
  if (unshare(CLONE_NEWNS) != 0 || mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("none", disk.c_str(), "tmpfs", 0, "size=1m") != 0) {
    GTEST_SKIP() << "needs to mount a small disk: " << std::strerror(errno);
  }
  const std::string err = disk / "err";
  const int file = open(err.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  {
    Pipe out;
    Running run({project(counting()), "--modbus", "off", "--engineering", "off"}, out.ends[1], file);
    ASSERT_TRUE(out.shows("modbus: off")) << out.seen;
    std::this_thread::sleep_for(milliseconds(200));
    // The file's last page is filled, too.
    std::ofstream(err, std::ios::app) << std::string(5000, '.') << std::flush;
    std::ofstream(disk / "rubbish") << std::string(2'000'000, '.') << std::flush;
    std::ofstream(err, std::ios::app) << std::string(5000, '.') << std::flush;
    const auto reports = [&] { return contains(read_text(err), "Fast, every 5ms"); };
    run.signal(SIGUSR1);
    std::this_thread::sleep_for(milliseconds(300));
    EXPECT_FALSE(reports());
    fs::remove(disk / "rubbish");
    EXPECT_TRUE(soon(reports)) << "what waited comes first";
    run.signal(SIGTERM);
    EXPECT_EQ(run.wait(), 0);
  }
  close(file);
  umount(disk.c_str());
}

TEST_F(Stays, ClosedDescriptorsAreHarmless) {
  const std::string file = project(
      "PROGRAM Main\nVAR Log : FILE_LOGGER; END_VAR\n  Log(IN1 := 1.0, FILE := 'plant.csv', COLUMNS := "
      "'x');\nEND_PROGRAM\n"
      "CONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T(INTERVAL := T#5ms, PRIORITY := 0);\n    PROGRAM main WITH T : "
      "Main;\n"
      "  END_RESOURCE\nEND_CONFIGURATION\n");
  const std::string image = scratch.file("plant.pbc");
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", file, "-o", image}).code, 0);
  const auto result = run_tool({"/bin/sh", "-c",
                                "cd " + scratch.file("") + " && exec " PLC_RUN_TOOL " " + image +
                                    " --modbus off --engineering off --cycles 20 --stats <&- >&- 2>&-"});
  EXPECT_EQ(result.code, 0) << result.all();
  const std::string log = read_text(scratch.file("plant.csv"));
  EXPECT_EQ(log.rfind("utc,time_s,x\n", 0), 0u) << log;
  EXPECT_FALSE(contains(log, "PICARD")) << log;
  EXPECT_FALSE(contains(log, "every")) << log;
}

TEST_F(Stays, ALogThatCannotBeWrittenKeepsNothingFromStarting) {
  const std::string file = project(
      "PROGRAM Main\nVAR Log : FILE_LOGGER; Error : DINT; END_VAR\n  Log(IN1 := 1.0);\n  Error := "
      "Log.ERROR;\nEND_PROGRAM\n"
      "CONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T(INTERVAL := T#5ms, PRIORITY := 0);\n    PROGRAM main WITH T : "
      "Main;\n"
      "  END_RESOURCE\nEND_CONFIGURATION\n");
  const auto result = run_tool({"/bin/sh", "-c",
                                "PICARD_LOG_DIRECTORY=" + scratch.file("none") + " exec " PLC_RUN_TOOL " " + file +
                                    " --modbus off --engineering off --duration 1s --watch '*Error'"});
  EXPECT_EQ(result.code, 0) << result.all();
  EXPECT_TRUE(contains(result.out, "Error=2")) << result.all();
}

TEST_F(Stays, APortThatIsTakenIsTriedAgain) {
  const int taken = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(taken, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(taken, 1), 0);
  ASSERT_EQ(getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size), 0);
  Pipe out, err;
  Running run({project(counting()), "--modbus", "127.0.0.1:" + std::to_string(ntohs(address.sin_port))}, out.ends[1],
              err.ends[1]);
  EXPECT_TRUE(err.shows("warning: modbus: P7510: cannot listen for Modbus clients on 127.0.0.1")) << err.seen;
  EXPECT_TRUE(err.shows("it is tried again")) << err.seen;
  close(taken);
  EXPECT_TRUE(err.shows("note: modbus: listening on 127.0.0.1:")) << err.seen;
  run.signal(SIGTERM);
  EXPECT_EQ(run.wait(), 0);
}

TEST_F(Stays, ItsEndSaysThatItsGuardianHasDied) {
  write_text(scratch.file("plc.toml"),
             "[drivers.panel]\nkind = \"modbus\"\nbus = \"127.0.0.1:1\"\n[outputs]\n"
             "\"%QW0\" = { driver = \"panel\", table = \"holding-registers\", address = 0, safe = 0 }\n");
  Pipe out, err;
  Running run({project(counting()), "--config", scratch.file("plc.toml"), "--modbus", "off", "--engineering", "off"},
              out.ends[1], err.ends[1]);
  ASSERT_TRUE(out.shows("guardian: drives the safe values")) << out.seen << err.seen;
  ASSERT_TRUE(out.shows("engineering: off")) << out.seen;
  std::this_thread::sleep_for(milliseconds(300));
  run.signal(SIGKILL);
  EXPECT_EQ(run.wait(), -SIGKILL) << "the guardian is the parent";
  EXPECT_TRUE(out.shows("s: the guardian (process ")) << out.seen;
  EXPECT_TRUE(out.shows(") has died\n")) << out.seen;
}

TEST_F(Stays, AStopAfterHandledFaultsIsNoFailure) {
  const std::string file = project(counting(true));
  const auto ended = [&](const std::string& policy, std::vector<std::string> more, const std::string& why) {
    Pipe out, err;
    std::vector<std::string> arguments = {file, "--modbus", "off", "--engineering", "off", "--on-fault", policy};
    arguments.insert(arguments.end(), more.begin(), more.end());
    Running run(arguments, out.ends[1], err.ends[1]);
    EXPECT_TRUE(err.shows("Z error: fault R1001: ")) << err.seen;
    if (why == "signal SIGTERM") run.signal(SIGTERM);
    const int code = run.wait();
    EXPECT_TRUE(out.shows("ends after ") && out.shows("s: " + why + "\n")) << out.seen;
    return code;
  };
  EXPECT_EQ(ended("safe-state", {}, "signal SIGTERM"), 0);
  EXPECT_EQ(ended("continue", {}, "signal SIGTERM"), 0);
  EXPECT_EQ(ended("safe-state", {"--duration", "1500ms"}, "--duration"), 1);
  EXPECT_EQ(ended("stop", {}, "fault R1001 in task Fast, whose policy is stop"), 1);
}

}  // namespace
}  // namespace plc::test
