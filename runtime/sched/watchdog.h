// Watchdog: a thread of top priority that finds scans which take longer than their task may.
//
// In: the runs of tasks with a watchdog time. Out: one call for each scan that is too long, on the watchdog's thread,
// as soon as the time is over: it sleeps until the earliest instant at which that can be. Does not belong here: what
// becomes of the task (realtime.cpp).
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "runtime/sched/task_run.h"

namespace plc::runtime {

class Watchdog {
 public:
  /// RT: called on the watchdog's thread, once for each scan that is too long; it marked busy_since before.
  using OnTimeout = std::function<void(TaskRun&)>;

  /// Nothing in `watched` without a watchdog time. `cpu`: processor to run on, -1 = any.
  Watchdog(std::vector<TaskRun*> watched, int cpu, OnTimeout on_timeout);
  /// Stops and joins.
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  /// Starts the thread, with SCHED_FIFO when `realtime`. A sentence for the operator when the system refuses something.
  std::string start(bool realtime);

 private:
  void run() noexcept;

  std::vector<TaskRun*> watched_;
  int cpu_;
  OnTimeout on_timeout_;
  core::MonotonicClock clock_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace plc::runtime
