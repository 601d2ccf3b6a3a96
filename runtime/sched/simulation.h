// Simulation: runs all tasks of a resource in virtual time, deterministically and as fast as the machine can.
//
// In: Resource, listeners. Out: release instants in order; at each, the tasks due run in priority order (0 first, ties
// as declared), each with now = the instant. Scans take no virtual time, so nothing overruns. One thread. Event tasks:
// their trigger is looked at once per instant, after the stimulus, and again after each task that ran, so that an edge
// made by a task is seen in the same instant. Without cyclic tasks the instants are kFreewheelNs apart. Does not belong
// here: files (io-drivers/), real time (realtime.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/clock.h"
#include "runtime/resource.h"
#include "runtime/sched/cycle_listener.h"
#include "runtime/sched/task.h"

namespace plc::runtime {

/// One release instant.
struct Instant {
  std::uint64_t cycle = 0;  ///< instants before this one
  core::TimeNs now_ns = 0;
  std::span<const std::uint32_t> ran;  ///< tasks in the order they ran; empty before they do
};

struct SimulationOptions {
  FaultPolicy on_fault = FaultPolicy::kSafeState;
  core::TimeNs program_time_ns = 0;  ///< what the clock of programs shows at virtual time 0: timers may run already
  core::TimeNs date_ns = 0;          ///< date and time of programs at virtual time 0, UTC; it goes on with virtual time
};

class Simulation {
 public:
  using Hook = std::function<void(const Instant&)>;
  explicit Simulation(Resource& resource, SimulationOptions options = {});

  /// Called at each instant before any task runs (stimulus) and after all have run (traces).
  void before_instant(Hook hook) { before_.push_back(std::move(hook)); }
  void after_instant(Hook hook) { after_.push_back(std::move(hook)); }
  /// Called around each scan; must outlive the simulation.
  void add_listener(CycleListener& listener) { listeners_.push_back(&listener); }

  /// Time of the next instant; nothing once stopped by a fault.
  [[nodiscard]] std::optional<core::TimeNs> next_instant_ns() const;
  /// Runs one instant. False when stopped by a fault.
  bool step();
  /// Runs `count` instants, or fewer when stopped. Returns how many ran.
  std::uint64_t run_cycles(std::uint64_t count);
  /// Runs every instant before `end_ns` (virtual time starts at 0, so 1 s of a 10 ms task is 100 instants).
  std::uint64_t run_until(core::TimeNs end_ns);

  [[nodiscard]] core::TimeNs now_ns() const { return clock_.now_ns(); }
  /// Sets the clock that programs have date and time of, as NTP does: nothing else moves. Between steps.
  void set_utc(core::TimeNs utc_ns, core::TimeNs at_ns) { options_.date_ns = utc_ns - at_ns; }
  [[nodiscard]] std::uint64_t cycles() const { return cycle_; }
  /// Scans of one task so far.
  [[nodiscard]] std::uint64_t scans(std::uint32_t task) const { return tasks_[task].scans; }
  [[nodiscard]] bool stopped() const { return stopped_; }
  [[nodiscard]] const std::vector<TaskFault>& faults() const { return faults_; }
  /// Faults beyond this many are counted in fault_count() but not kept.
  static constexpr std::size_t kMaxFaultsKept = 1000;
  [[nodiscard]] std::uint64_t fault_count() const { return fault_count_; }

 private:
  struct SimulatedTask {
    ReleaseGrid grid;
    std::optional<std::uint32_t> trigger;  ///< event tasks: offset in the global table
    bool trigger_was = false;
    bool due = false;
    bool halted = false;
    std::uint64_t scans = 0;
  };
  void look_at_triggers();
  void run_task(std::uint32_t index);

  Resource& resource_;
  SimulationOptions options_;
  core::VirtualClock clock_;
  std::vector<SimulatedTask> tasks_;
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> ran_;
  std::vector<Hook> before_;
  std::vector<Hook> after_;
  std::vector<CycleListener*> listeners_;
  std::vector<TaskFault> faults_;
  std::uint64_t fault_count_ = 0;
  std::uint64_t cycle_ = 0;
  bool stopped_ = false;
};

}  // namespace plc::runtime
