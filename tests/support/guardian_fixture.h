// A guardian around a runtime of the test's own, with drivers that write down what they were told.
//
// In: what the runtime does. Out: how the guardian ended, what it said, what became of the "line". Does not belong
// here: what a guardian should do.
#pragma once

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <functional>
#include <new>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "io-drivers/guardian/guardian.h"

namespace plc::io {

inline constexpr core::TimeNs kMs = 1'000'000;

/// What the processes of a test tell each other.
struct Notes {
  std::atomic<int> output{1};  ///< the "line": 1 = running, 0 = safe
  std::atomic<int> safe_calls{0};
  std::atomic<pid_t> safe_by{0};
  std::atomic<pid_t> runtime{0};
  std::atomic<int> looks{0};  ///< release_if_gone()
  std::atomic<int> hold{0};   ///< 1: the guardian waits in release_if_gone(), and makes it 2
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
  std::vector<io::Sentence> service(core::TimeNs) override { return {}; }
  [[nodiscard]] DriverStatus status() const override { return {}; }
  [[nodiscard]] std::vector<InputStatus> inputs(core::TimeNs) const override { return {}; }
  bool drive_safe() noexcept override {
    ++notes_.safe_calls;
    notes_.safe_by = getpid();
    if (works_) notes_.output = 0;
    return works_;
  }
  void release_if_gone() noexcept override {
    ++notes_.looks;
    for (int on = 1; notes_.hold != 0; on = 1) {
      notes_.hold.compare_exchange_strong(on, 2);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
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
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return -999;
  }

  template <class Condition>
  static bool soon(Condition condition) {
    for (int i = 0; i < 2000; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
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

}  // namespace plc::io
