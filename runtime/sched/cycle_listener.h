// CycleListener: who wants to act at the exchange points of a task's cycle: drivers, traces, stimuli.
//
// In: calls from a scheduler at the start and the end of each scan and at stop. Out: whatever the listener moves
// between its device and the global table. Threads: called on the task's own thread; a listener that serves several
// tasks is called by several threads. Does not belong here: what a driver is (io-drivers/driver.h).
#pragma once

#include <cstdint>

#include "core/clock.h"

namespace plc::runtime {

/// One release of one task.
struct ReleaseContext {
  std::uint32_t task = 0;       ///< index into Image::tasks
  std::uint64_t cycle = 0;      ///< scans of this task before this one
  core::TimeNs now_ns = 0;      ///< the cycle's `now`
  core::TimeNs release_ns = 0;  ///< the instant on the task's release grid
  core::TimeNs utc_ns = 0;      ///< date and time, taken with `now_ns`
};

class CycleListener {
 public:
  virtual ~CycleListener() = default;
  /// Before the scan: inputs into the global table. RT: bounded.
  virtual void before_scan(const ReleaseContext& context) noexcept = 0;
  /// After the scan: outputs from the global table. RT: bounded.
  virtual void after_scan(const ReleaseContext& context) noexcept = 0;
  /// All outputs into their declared safe state: every task has ended. Called once, after the last after_scan().
  virtual void safe_state() noexcept = 0;
  /// `task` faulted under a policy that does not release it again; the others go on. On its thread, after its last
  /// after_scan(); safe_state() comes all the same when the scheduler stops. RT: bounded.
  virtual void task_stopped(std::uint32_t /*task*/) noexcept { safe_state(); }
};

}  // namespace plc::runtime
