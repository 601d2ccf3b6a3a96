// RealtimeScheduler: one thread per task, SCHED_FIFO where the system permits it, on a monotonic release grid.
//
// In: Resource, listeners. Out: running tasks, statistics, faults. It prints nothing: what the system refused is in the
// report. In the cycle a thread makes two kinds of system call, clock_nanosleep and clock_gettime (mostly without a
// call, vDSO), and those of bounded drivers. start() and stop() belong to one owner thread; everything else may be read
// from any thread. Event tasks look at their trigger every kFreewheelNs; freewheeling tasks scan at most once per
// kFreewheelNs. Does not belong here: signals (the tool calls request_stop() from its handler), drivers.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "runtime/resource.h"
#include "runtime/sched/cycle_listener.h"
#include "runtime/sched/statistics.h"
#include "runtime/sched/task.h"

namespace plc::runtime {

struct RealtimeOptions {
  FaultPolicy on_fault = FaultPolicy::kSafeState;
  bool realtime_priority = true;  ///< SCHED_FIFO, kHighestPriority for IEC priority 0, one less for each step down
  bool lock_memory = true;        ///< mlockall(MCL_CURRENT | MCL_FUTURE)
  std::vector<int> cpus{};        ///< CPU of each task; empty or -1 = any
  /// Called on each task's thread after it is set up and before its first cycle (tests install their guards here).
  void (*on_thread_start)(std::uint32_t task) = nullptr;
};

/// What the system granted. Every entry of `refused` is a sentence for the operator.
struct RealtimeReport {
  bool memory_locked = false;
  bool realtime_priority = false;  ///< every thread got it
  std::vector<std::string> refused;
};

class RealtimeScheduler {
 public:
  /// SCHED_FIFO priority of IEC priority 0; below the kernel's own threads that serve interrupts (50 is theirs by
  /// default, timers at 99). Lower IEC priorities go down to 1.
  static constexpr int kHighestPriority = 80;

  explicit RealtimeScheduler(Resource& resource, RealtimeOptions options = {});
  /// Stops and joins.
  ~RealtimeScheduler();
  RealtimeScheduler(const RealtimeScheduler&) = delete;
  RealtimeScheduler& operator=(const RealtimeScheduler&) = delete;

  /// Called around each scan on the task's thread; before start(); must outlive the scheduler.
  void add_listener(CycleListener& listener) { listeners_.push_back(&listener); }

  /// Starts all threads; the first release of every task is the same instant. Once.
  const RealtimeReport& start();
  /// Asks every task to stop after its present scan. Async-signal-safe; returns at once.
  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool stop_requested() const noexcept { return stop_.load(std::memory_order_relaxed); }
  /// Waits until all tasks have ended, then puts the outputs into their safe state.
  void join();

  [[nodiscard]] const RealtimeReport& report() const { return report_; }
  [[nodiscard]] const TaskStatistics& statistics(std::uint32_t task) const { return runs_[task]->statistics; }
  /// Faults so far, at most kMaxFaultsKept per task; the counter in the statistics has all of them.
  [[nodiscard]] std::vector<TaskFault> faults() const;
  static constexpr std::size_t kMaxFaultsKept = 64;

 private:
  struct TaskRun {
    std::uint32_t index = 0;
    TaskStatistics statistics;
    TaskFault faults[kMaxFaultsKept];
    std::atomic<std::uint32_t> fault_count{0};
    std::thread thread;
  };
  void run(TaskRun& run, core::TimeNs start_ns) noexcept;
  bool scan(TaskRun& run, const ReleaseContext& context) noexcept;
  void set_priority(TaskRun& run);
  void set_cpu(TaskRun& run);

  Resource& resource_;
  RealtimeOptions options_;
  core::MonotonicClock clock_;
  std::vector<std::unique_ptr<TaskRun>> runs_;
  std::vector<CycleListener*> listeners_;
  std::atomic<bool> stop_{false};
  RealtimeReport report_;
  bool started_ = false;
  bool joined_ = false;
};

}  // namespace plc::runtime
