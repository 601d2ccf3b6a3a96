// Task: when a program is released, and what happens when it faults. Shared by both schedulers.
//
// In: ImageTask. Out: the release grid. A task stays on its grid after an overrun: the next release is the first grid
// point after now, and those in between are counted as missed. Freewheeling tasks (period 0) run back to back, at most
// once per kFreewheelNs. Does not belong here: threads, clocks.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"
#include "runtime/program.h"
#include "runtime/sched/task_plan.h"

namespace plc::runtime {

/// Shortest distance between two scans of a freewheeling task, and the poll distance of event tasks that have no other
/// release instants to be looked at (simulation and real time alike).
inline constexpr core::TimeNs kFreewheelNs = 1'000'000;

/// A fault with its task and time; schedulers keep them for their owner to report.
struct TaskFault {
  std::uint32_t task = 0;
  std::uint64_t cycle = 0;
  core::TimeNs now_ns = 0;
  Fault fault;
};

/// Release instants of one cyclic task: start, start + period, ...
class ReleaseGrid {
 public:
  ReleaseGrid(core::TimeNs start_ns, core::TimeNs period_ns) : next_(start_ns), period_(period_ns) {}
  [[nodiscard]] core::TimeNs next_ns() const noexcept { return next_; }
  [[nodiscard]] core::TimeNs period_ns() const noexcept { return period_; }
  /// Moves to the first instant after now, but at least one on. Returns the number of instants left out.
  std::uint64_t advance(core::TimeNs now_ns) noexcept;

 private:
  core::TimeNs next_;
  core::TimeNs period_;
};

/// Period of the grid a task is on: its own, or kFreewheelNs for freewheeling ones and event tasks.
core::TimeNs grid_period(const bytecode::ImageTask& task);
/// Task indices in the order in which tasks due together run: priority 0 first, ties as declared.
std::vector<std::uint32_t> priority_order(const bytecode::Image& image);
/// Event tasks: byte offset in the global table of the BOOL that releases them (it is there: verifier, rule V414).
std::optional<std::uint32_t> trigger_of(const bytecode::Image& image, const bytecode::ImageTask& task);

}  // namespace plc::runtime
