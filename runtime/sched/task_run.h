// TaskRun: what the threads of the scheduler know of one running task.
//
// In: set up before the threads start. Out: read by the task's thread, the watchdog and, what is atomic, by anyone.
// Does not belong here: what they do with it (realtime.cpp, watchdog.cpp).
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "runtime/memory/global_table.h"
#include "runtime/sched/fault_log.h"
#include "runtime/sched/statistics.h"
#include "runtime/sched/task_plan.h"

namespace plc::runtime {

struct TaskRun {
  /// TaskRun::busy_since besides the instant at which the present scan began.
  static constexpr core::TimeNs kIdle = 0;
  static constexpr core::TimeNs kTimedOut = -1;  ///< the watchdog has found the present scan too long

  std::uint32_t index = 0;
  TaskPlan plan;
  bool realtime = false;          ///< its thread has a real-time priority
  std::vector<GlobalWrite> safe;  ///< of what it exports
  TaskStatistics statistics;
  std::atomic<core::TimeNs> busy_since{kIdle};
  std::atomic<std::uint64_t> cycle{0};  ///< scans begun
  std::atomic<bool> demoted{false};     ///< the watchdog took its priority
  std::atomic<bool> cut{false};         ///< its loops are cut short since everything stops
  std::atomic<bool> ended{false};
  FaultLog faults;               ///< found by its own thread
  FaultLog timeouts;             ///< found by the watchdog
  std::size_t faults_taken = 0;  ///< by RealtimeScheduler::new_faults()
  std::size_t timeouts_taken = 0;
  std::thread thread;
};

}  // namespace plc::runtime
