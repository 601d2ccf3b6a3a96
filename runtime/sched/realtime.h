// RealtimeScheduler: one thread per task, released on an absolute monotonic grid (paper, 3.2.1).
//
// In: Resource, plans, listeners. Out: running tasks, statistics, faults. It prints nothing: what the system refused is
// in the report. In the cycle a thread makes two kinds of system call, clock_nanosleep and clock_gettime (mostly
// without a call, vDSO), and those of bounded drivers; under --coherence=priority-ceiling also sched_setparam, under
// global-lock futex. A task with real-time priority wakes a little before its release and waits for it awake (lead_of()
// in task_plan.h). start() and join() belong to one owner thread; everything else may be read from any thread. Event
// tasks look at their trigger every kFreewheelNs; freewheeling tasks scan at most once per kFreewheelNs. Does not
// belong here: signals (the tool calls request_stop() from its handler), drivers, who gets which priority
// (task_plan.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "runtime/resource.h"
#include "runtime/sched/cycle_listener.h"
#include "runtime/sched/stay_awake.h"
#include "runtime/sched/task_plan.h"
#include "runtime/sched/task_run.h"

namespace plc::runtime {

class Watchdog;

/// What a global has when the task that exports it has stopped by a fault.
struct SafeValue {
  std::uint32_t offset = 0;      ///< of a leaf in the global table
  std::uint32_t type = 0;        ///< of that leaf, index into Image::types
  std::vector<std::byte> value;  ///< as many bytes as the type has
};

struct RealtimeOptions {
  std::vector<TaskPlan> plan{};          ///< one a task; empty = as the image declares
  std::vector<SafeValue> safe_values{};  ///< of all tasks
  /// What the clock of the programs shows at the common start: timers that were kept go on where they were. Nothing:
  /// the machine's monotonic clock.
  std::optional<core::TimeNs> program_time_ns{};
  const core::Calendar* calendar = nullptr;  ///< date and time of programs; null: the machine's. Outlives the scheduler
  bool realtime_priority = true;             ///< SCHED_FIFO (priority.h), and idle processors stay awake
  bool lock_memory = true;                   ///< mlockall(MCL_CURRENT | MCL_FUTURE)
  /// Called on each task's thread after it is set up and before its first cycle: where guards are installed.
  void (*on_thread_start)(std::uint32_t task) = nullptr;
};

/// What the system granted. Every entry of `refused` is a sentence for the operator.
struct RealtimeReport {
  bool memory_locked = false;
  bool realtime_priority = false;  ///< every thread got it
  std::vector<std::string> refused;
  /// P7604: nothing was started, since the coherence protocol needs what the system refuses.
  std::optional<core::Problem> problem;
};

class RealtimeScheduler {
 public:
  explicit RealtimeScheduler(Resource& resource, RealtimeOptions options = {});
  /// Stops and joins. Ends the process when a task cannot be stopped: see join().
  ~RealtimeScheduler();
  RealtimeScheduler(const RealtimeScheduler&) = delete;
  RealtimeScheduler& operator=(const RealtimeScheduler&) = delete;

  /// Called around each scan on the task's thread; before start(); must outlive the scheduler.
  void add_listener(CycleListener& listener) { listeners_.push_back(&listener); }

  /// Starts all threads; the first release of every task is the same instant, but for offsets, when all are
  /// ready. Once.
  const RealtimeReport& start();
  /// Asks every task to stop after its present scan. Async-signal-safe; returns at once.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool stop_requested() const noexcept { return stop_.load(std::memory_order_relaxed); }
  /// What the clock of the programs shows at `now_ns` of the machine's monotonic clock.
  [[nodiscard]] core::TimeNs program_ns(core::TimeNs now_ns) const noexcept;
  /// Waits until all tasks have ended, then puts the outputs into their safe state. A scan that goes on and on is cut
  /// short at its next loop jump. Returns the tasks that still run after kStopPatienceNs: the process must end without
  /// destroying what they use.
  std::vector<std::uint32_t> join();
  static constexpr core::TimeNs kStopPatienceNs = 3'000'000'000;

  [[nodiscard]] const RealtimeReport& report() const { return report_; }
  [[nodiscard]] const TaskPlan& plan(std::uint32_t task) const { return runs_[task]->plan; }
  [[nodiscard]] const TaskStatistics& statistics(std::uint32_t task) const { return runs_[task]->statistics; }
  /// Faults so far, in no particular order; of each task the first FaultLog::kKept, and as many by the watchdog. The
  /// counter in the statistics has all of them.
  [[nodiscard]] std::vector<TaskFault> faults() const;
  /// Those that the last call did not return. Owner thread.
  std::vector<TaskFault> new_faults();

 private:
  void run(TaskRun& run) noexcept;
  core::TimeNs sleep_until_ns(core::TimeNs at_ns) noexcept;
  core::TimeNs expect(TaskRun& run, core::TimeNs now_ns, core::TimeNs release_ns) noexcept;
  void regain_priority(TaskRun& run) noexcept;
  bool scan(TaskRun& run, const ReleaseContext& context) noexcept;
  [[nodiscard]] CycleContext program_time(const ReleaseContext& context) const noexcept;
  bool fault(TaskRun& run, const ReleaseContext& context, const Fault& fault) noexcept;
  void stop_task(TaskRun& run) noexcept;
  void on_timeout(TaskRun& run) noexcept;
  void set_priority(TaskRun& run);
  void set_cpu(TaskRun& run);
  std::optional<core::Problem> cannot_raise() const;

  Resource& resource_;
  RealtimeOptions options_;
  core::MonotonicClock clock_;
  core::SystemCalendar machine_calendar_;
  const core::Calendar& calendar_;
  std::vector<std::unique_ptr<TaskRun>> runs_;
  std::vector<CycleListener*> listeners_;
  std::unique_ptr<Watchdog> watchdog_;
  std::atomic<bool> stop_{false};
  std::atomic<std::size_t> ready_{0};      ///< threads that are set up and wait for start_ns_
  std::atomic<core::TimeNs> start_ns_{0};  ///< the first release, offsets apart; 0 = not all threads are ready
  StayAwake awake_;
  RealtimeReport report_;
  std::vector<std::uint32_t> stuck_;
  bool started_ = false;
  bool joined_ = false;
};

}  // namespace plc::runtime
