// The guardian: every way a runtime can end, with processes of our own and a driver that writes down what it was told.
#include "io-drivers/guardian/guardian.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <functional>
#include <new>
#include <thread>

namespace plc::io {
namespace {

using std::chrono::milliseconds;
constexpr core::TimeNs kMs = 1'000'000;

/// What the processes of a test tell each other.
struct Notes {
  std::atomic<int> output{1};  ///< the "line": 1 = running, 0 = safe
  std::atomic<int> safe_calls{0};
  std::atomic<pid_t> safe_by{0};
  std::atomic<pid_t> runtime{0};
  std::atomic<int> looks{0};  ///< release_if_gone()
  std::atomic<int> closed{0};
  std::atomic<int> stopped_in_order{0};
};

class NotedDriver final : public Driver {
 public:
  NotedDriver(Notes& notes, std::string name, bool outputs = true, bool works = true)
      : notes_(notes), name_(std::move(name)), outputs_(outputs), works_(works) {}
  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] Timing timing() const override { return Timing::kBounded; }
  [[nodiscard]] std::uint32_t task() const override { return 0; }
  std::optional<core::Problem> open() override { return std::nullopt; }
  std::vector<std::string> service(core::TimeNs) override { return {}; }
  [[nodiscard]] DriverStatus status() const override { return {}; }
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs) const override { return {}; }
  bool drive_safe() noexcept override {
    ++notes_.safe_calls;
    notes_.safe_by = getpid();
    if (works_) notes_.output = 0;
    return works_;
  }
  void release_if_gone() noexcept override { ++notes_.looks; }
  [[nodiscard]] bool has_outputs() const override { return outputs_; }
  void close() noexcept override { ++notes_.closed; }
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext&) noexcept override {}
  void safe_state() noexcept override {}

 private:
  Notes& notes_;
  std::string name_;
  bool outputs_, works_;
};

void cycle(Pulse& pulse, std::uint32_t task = 0) { pulse.after_scan({task, 0, 0, 0}); }

void cycle_for(Pulse& pulse, milliseconds duration, milliseconds period = milliseconds(10)) {
  for (const auto end = std::chrono::steady_clock::now() + duration; std::chrono::steady_clock::now() < end;) {
    cycle(pulse);
    std::this_thread::sleep_for(period);
  }
}

volatile std::sig_atomic_t got_signal = 0;
void note_signal(int number) { got_signal = number; }

class GuardianTest : public testing::Test {
 protected:
  GuardianTest()
      : notes(*new (mmap(nullptr, sizeof(Notes), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Notes) {
    options.hang_timeout_ns = 200 * kMs;
    options.start_timeout_ns = 10'000 * kMs;
    options.stop_timeout_ns = 600 * kMs;
    options.watched = {{0, "Fast", 10 * kMs}};
  }
  ~GuardianTest() override {
    for (const pid_t pid : {guardian, notes.runtime.load()}) {
      if (pid > 0) kill(pid, SIGKILL);
    }
    munmap(&notes, sizeof(Notes));
  }

  /// Starts a guardian around `body`, which is the runtime; its return value is the exit code.
  void start(std::function<int(Pulse&)> body) {
    int ends[2];
    ASSERT_EQ(pipe(ends), 0);
    guardian = fork();
    if (guardian == 0) {
      dup2(ends[1], STDERR_FILENO);
      ::close(ends[0]);
      ::close(ends[1]);
      NotedDriver panel(notes, "panel"), inputs(notes, "inputs", false), broken(notes, "broken", true, false);
      std::vector<Driver*> drivers = {&panel, &inputs};
      if (with_broken) drivers.push_back(&broken);
      auto pulse = start_guardian(options, drivers);
      if (!pulse) _exit(99);
      notes.runtime = getpid();
      _exit(body(**pulse));
    }
    ::close(ends[1]);
    errors = ends[0];
  }

  /// Exit code of the guardian, -signal when it was killed, or -999 when it is still there after 15 s.
  int wait_for_guardian() {
    int status = 0;
    for (int i = 0; i < 3000; ++i) {
      if (waitpid(guardian, &status, WNOHANG) == guardian) {
        guardian = 0;
        char text[4096];
        for (ssize_t n = 0; (n = ::read(errors, text, sizeof text)) > 0;)
          said.append(text, static_cast<std::size_t>(n));
        ::close(errors);
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
      }
      std::this_thread::sleep_for(milliseconds(5));
    }
    return -999;
  }

  template <class Condition>
  static bool soon(Condition condition) {
    for (int i = 0; i < 2000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(milliseconds(5));
    }
    return false;
  }
  bool runtime_is_gone() {
    return soon([&] { return kill(notes.runtime, 0) != 0 && errno == ESRCH; });
  }
  void expect_guardian_acted(const std::string& reason) {
    EXPECT_EQ(wait_for_guardian(), kGuardianExit);
    EXPECT_EQ(notes.output, 0);
    EXPECT_EQ(notes.safe_calls, 1) << "once, and only of drivers with outputs";
    EXPECT_NE(notes.safe_by, notes.runtime);
    EXPECT_NE(said.find(reason), std::string::npos) << said;
    EXPECT_NE(said.find("the outputs of panel have their safe values"), std::string::npos) << said;
    EXPECT_TRUE(runtime_is_gone());
  }

  Notes& notes;
  GuardianOptions options;
  bool with_broken = false;
  pid_t guardian = 0;
  int errors = -1;
  std::string said;
};

TEST_F(GuardianTest, AnOrderlyEndPassesOnTheCode) {
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(300));
    pulse.stopping();
    pulse.finished();
    return 7;
  });
  EXPECT_EQ(wait_for_guardian(), 7);
  EXPECT_EQ(notes.safe_calls, 0) << "the runtime did that itself";
  EXPECT_EQ(said, "");
  EXPECT_GT(notes.looks, 0);
}

TEST_F(GuardianTest, AKilledRuntimeLeavesSafeOutputs) {
  start([](Pulse& pulse) {
    cycle(pulse);
    kill(getpid(), SIGKILL);
    return 0;
  });
  expect_guardian_acted("was killed by signal 9");
}

TEST_F(GuardianTest, ACrashBeforeTheFirstCycleCountsToo) {
  start([](Pulse&) {
    signal(SIGSEGV, SIG_DFL);
    raise(SIGSEGV);
    return 0;
  });
  expect_guardian_acted("was killed by signal 11");
}

TEST_F(GuardianTest, AnEndWithoutAWordIsNoOrderlyEnd) {
  start([](Pulse& pulse) {
    pulse.stopping();
    return 0;
  });
  expect_guardian_acted("ended with code 0 without having made its outputs safe");
}

TEST_F(GuardianTest, ATaskWhoseCyclesCeaseIsAHang) {
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(300));
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, AStoppedProcessIsAHang) {
  start([](Pulse& pulse) {
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(notes.output, 1);
  kill(notes.runtime, SIGSTOP);
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, OneHangingTaskOfTwoIsEnough) {
  options.watched.push_back({1, "Other", 10 * kMs});
  start([](Pulse& pulse) {
    cycle(pulse, 1);
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Other\"");
}

TEST_F(GuardianTest, ASlowTaskHasThreePeriods) {
  options.watched = {{0, "Slow", 400 * kMs}};  // time-out 200 ms
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(1600), milliseconds(400));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, TheFirstCycleMayTakeLonger) {
  start([](Pulse& pulse) {
    std::this_thread::sleep_for(milliseconds(700));
    cycle_for(pulse, milliseconds(100));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, ButNotForever) {
  options.start_timeout_ns = 400 * kMs;
  start([](Pulse&) {
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, AFaultedTaskDoesNotHang) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.task_stopped(0);
    std::this_thread::sleep_for(milliseconds(700));
    pulse.finished();
    return 1;
  });
  EXPECT_EQ(wait_for_guardian(), 1) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, AnOrderlyStopMayTakeItsTime) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.stopping();
    std::this_thread::sleep_for(milliseconds(350));
    pulse.finished();
    std::this_thread::sleep_for(milliseconds(1000));  // its report; outputs are safe by now
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, AnOrderlyStopThatDoesNotEndIsAHang) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.stopping();
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("did not end within 0.6 s of an orderly stop");
}

TEST_F(GuardianTest, SignalsAreForwarded) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    notes.runtime = 0;
    start([number](Pulse& pulse) {
      got_signal = 0;
      signal(number, note_signal);
      while (got_signal != number) {
        cycle(pulse);
        std::this_thread::sleep_for(milliseconds(5));
      }
      pulse.stopping();
      pulse.finished();
      return 40 + number;
    });
    ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
    std::this_thread::sleep_for(milliseconds(50));
    kill(guardian, number);
    EXPECT_EQ(wait_for_guardian(), 40 + number) << said;
  }
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, AWishForAReportIsForwardedAndEndsNothing) {
  start([](Pulse& pulse) {
    signal(SIGUSR1, note_signal);
    while (got_signal != SIGUSR1) {
      cycle(pulse);
      std::this_thread::sleep_for(milliseconds(5));
    }
    // Longer than an orderly stop may take.
    cycle_for(pulse, milliseconds(900));
    pulse.finished();
    return 41;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(50));
  kill(guardian, SIGUSR1);
  EXPECT_EQ(wait_for_guardian(), 41) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, ARuntimeThatIgnoresTheSignalIsKilled) {
  start([](Pulse& pulse) {
    signal(SIGTERM, SIG_IGN);
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(50));
  kill(guardian, SIGTERM);
  expect_guardian_acted("did not end within 0.6 s of an orderly stop");
}

TEST_F(GuardianTest, WithoutItsGuardianTheRuntimeStops) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  Notes& shared = notes;
  start([&shared](Pulse& pulse) {
    signal(SIGTERM, note_signal);
    shared.closed = 1;
    while (got_signal != SIGTERM) {
      cycle(pulse);
      std::this_thread::sleep_for(milliseconds(5));
    }
    shared.stopped_in_order = 1;
    pulse.finished();
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.closed == 1; }));
  kill(guardian, SIGKILL);
  EXPECT_EQ(wait_for_guardian(), -SIGKILL);
  EXPECT_TRUE(soon([&] { return notes.stopped_in_order == 1; }));
  int status = 0;
  EXPECT_EQ(waitpid(notes.runtime, &status, 0), notes.runtime);
  EXPECT_TRUE(WIFEXITED(status));
  notes.runtime = 0;
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST_F(GuardianTest, WithoutATimeOutOnlyDeathsCount) {
  options.hang_timeout_ns = 0;
  start([](Pulse& pulse) {
    cycle(pulse);
    std::this_thread::sleep_for(milliseconds(1500));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, OutputsThatCannotBeDrivenAreNamed) {
  with_broken = true;
  start([](Pulse&) {
    kill(getpid(), SIGKILL);
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), kGuardianExit);
  EXPECT_EQ(notes.safe_calls, 2);
  EXPECT_EQ(notes.output, 0);
  EXPECT_NE(said.find("the outputs of panel have their safe values"), std::string::npos) << said;
  EXPECT_NE(said.find("THE OUTPUTS OF broken COULD NOT BE MADE SAFE"), std::string::npos) << said;
}

TEST(Pulse, TasksThatNobodyWatchesAreIgnored) {
  const pid_t child = fork();
  if (child == 0) {
    auto pulse = start_guardian({}, {});
    if (!pulse) _exit(99);
    (*pulse)->after_scan({17, 0, 0, 0});
    (*pulse)->task_stopped(17);
    (*pulse)->finished();
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace plc::io
