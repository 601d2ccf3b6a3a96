// EndGuard: the end of plc-run does not wait for ever for a disk that hangs.
//
// In: what is left to be done when the outputs are safe, from begin() to the end of this object, which outlives all
// that may wait for a disk. Out: an end of the process, with a sentence, when that takes too long. Threads: one of its
// own, which touches no disk; other calls are the owner's. A thread that the kernel does not let go of (state D) keeps
// every end from coming, this one and SIGKILL, too. Does not belong here: tasks that do not end
// (io-drivers/machine/plant.h), readers of the output that are slow (output.h).
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

#include "runtime/sched/ordinary_thread.h"

namespace plc::tools {

class EndGuard {
 public:
  /// How long the end may take, the stop of the tasks included: less than TimeoutStopSec of the unit (packaging/), and
  /// after a signal under a guardian less than its stop_timeout_ns (io-drivers/guardian/guardian.h).
  static constexpr std::chrono::milliseconds kPatience{10'000}, kPatienceUnderGuardian{4'000};
  /// ..and what is left of it at least, however long the tasks took.
  static constexpr std::chrono::milliseconds kShortestPatience{1'000};

  /// Tells a service manager, on the thread of the guard, that the process lives.
  struct Alive {
    std::function<void()> tell;
    std::chrono::milliseconds every{0};  ///< 0 = nobody wants to know
  };

  EndGuard() = default;
  ~EndGuard();
  EndGuard(const EndGuard&) = delete;
  EndGuard& operator=(const EndGuard&) = delete;

  /// From now on the process has `patience` in all to end, else it ends with this code; kExitRelaunch: it is started
  /// anew, as otherwise. Once.
  void begin(int code, std::chrono::milliseconds patience, Alive alive);
  /// Another code from now on.
  void expect(int code) { code_ = code; }
  /// The process is not to end for now: no time passes, and nothing is told, until go_on().
  void rest() { rests_ = true; }
  void go_on() { rests_ = false; }
  /// The owner waits for a reader of its output: this does not count. Again about every 50 ms.
  void waits_for_reader() { ++reader_; }

 private:
  void run(std::chrono::milliseconds patience, const Alive& alive);

  std::mutex mutex_;  ///< of done_
  std::condition_variable changed_;
  bool done_ = false;
  std::atomic<int> code_{0};
  std::atomic<bool> rests_{false};
  std::atomic<std::uint32_t> reader_{0};  ///< how often it was waited for
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::tools
