// Guardian: a small process that outlives the runtime and drives the safe values when that one dies or hangs
// (docs/adr/0014).
//
// In: open drivers, before the first thread starts. Out: two processes. The parent, the guardian, keeps the line
// handles it shares with the child, forwards signals to it, waits, and never returns. The child is the runtime; it gets
// a Pulse, the listener that tells the guardian that cycles are completed. Does not belong here: what a driver does,
// what a signal means to the runtime.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "io-drivers/driver.h"
#include "runtime/sched/cycle_listener.h"

namespace plc::io {

/// A task whose cycle the guardian expects to be completed again and again.
struct WatchedTask {
  std::uint32_t task = 0;  ///< index into Image::tasks
  std::string name;
  core::TimeNs period_ns = 0;
};

struct GuardianOptions {
  core::TimeNs hang_timeout_ns = 1'000'000'000;    ///< 0 = deaths only; slower tasks get three periods
  core::TimeNs start_timeout_ns = 30'000'000'000;  ///< to the first completed cycle of every watched task
  core::TimeNs stop_timeout_ns = 5'000'000'000;    ///< for an orderly stop
  /// Tasks that serve outputs at regular intervals. Those that wait for an event may be still for good reason.
  std::vector<WatchedTask> watched;
  /// Called when the runtime has ended and outputs are safe, with the code that the guardian is about to exit with, and
  /// whether a signal has asked for the end: the place to become another program (plc-run starts anew by it). Gives the
  /// code to exit with. Single-threaded; signals are blocked.
  std::function<int(int code, bool asked)> ended = {};
};

/// What the guardian exits with when it had to act: another program must start the runtime again.
inline constexpr int kGuardianExit = 3;

/// The page both processes see.
struct GuardianPage;

/// The runtime's end: a listener, to be added after the drivers, and what the runtime says about its own end.
class Pulse final : public runtime::CycleListener {
 public:
  explicit Pulse(GuardianPage& page) : page_(page) {}

  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  /// Counts. RT: one store.
  void after_scan(const runtime::ReleaseContext& context) noexcept override;
  void safe_state() noexcept override {}
  /// A task that stopped under its policy does not hang.
  void task_stopped(std::uint32_t task) noexcept override;

  /// An orderly stop begins: pulses may cease, finished() is expected within stop_timeout_ns.
  void stopping() noexcept;
  /// Outputs are safe; the guardian has nothing more to do than to pass on the exit code.
  void finished() noexcept;

 private:
  GuardianPage& page_;
};

/// Splits this process. Returns in the child, or a problem (P7410) without a split. The parent never returns: it exits
/// with the child's code after finished(), else with kGuardianExit, outputs safe. `drivers` are open; no thread but the
/// caller runs yet. Buffered output is flushed first.
core::Result<std::unique_ptr<Pulse>> start_guardian(const GuardianOptions& options,
                                                    const std::vector<Driver*>& drivers);

}  // namespace plc::io
