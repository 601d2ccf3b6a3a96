// Analysis of a schedule before it runs: does every task end before its deadline, and by how much?
//
// In: for each task its processor, priority, period and worst execution time. Out: for each processor the utilisation
// and the bounds of Liu and Layland; for each task its longest response time and its margin. The model is the
// real-time scheduler's: fixed priorities, preemptive, tasks of one priority in the order of their release without
// preempting each other (SCHED_FIFO), every task bound to one processor. The result holds for any offsets between the
// tasks, and is exact in the sense that some offsets, releases and ties bring about each response time.
// Two things differ from a running resource, both on the safe side: jobs that come while an earlier one of their task
// is unfinished wait here and are left out there (ReleaseGrid), and two tasks released together run here in whichever
// order is worse. Configuration time: allocates; bounded work for any input.
// Does not belong here: measuring execution times (statistics.h), choosing priorities, printing.
//
// Liu, Layland 1973 (bounds); Joseph, Pandya 1986 and Lehoczky, Sha, Ding 1989 (exact test); Lehoczky 1990 (deadlines
// beyond the period); Sha, Rajkumar, Lehoczky 1990 (blocking); Tindell, Burns, Wellings 1994 (jitter); Bini, Buttazzo
// 2003 (hyperbolic bound); Martin, Minet, George 2005 (tasks of one priority in FIFO order).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/clock.h"

namespace plc::runtime {

/// One task as the analysis sees it. Negative times count as 0.
struct TaskLoad {
  std::string name;
  int cpu = 0;                ///< tasks with the same number share a processor, others never meet
  std::int32_t priority = 0;  ///< 0 is the highest
  /// Released by a trigger: period_ns is the shortest distance of two releases, 0 = nothing is known about it. (The
  /// real-time scheduler looks at triggers every kFreewheelNs, so that is a distance it guarantees.)
  bool event = false;
  core::TimeNs period_ns = 0;     ///< 0 = freewheeling, unless `event`
  core::TimeNs deadline_ns = 0;   ///< from the instant on the release grid, may exceed the period; 0 = the period
  core::TimeNs jitter_ns = 0;     ///< at most this much passes between the instant on the grid and the release
  core::TimeNs execution_ns = 0;  ///< longest time of one scan on its own; counts as at least 1 ns
  /// Longest time for which a task of lower priority holds up this one, at most once until the processor has no more
  /// work of this priority or above: its copy to the global table at a raised priority, interrupts switched off.
  core::TimeNs blocking_ns = 0;
};

enum class Verdict : std::uint8_t {
  kFits,        ///< no offsets and no execution times within the given ones make it miss its deadline
  kDoesNotFit,  ///< there are such that do
  kUnknown,     ///< a task that precedes it (or itself) has unknown releases, or the answer is beyond kMaxSteps or 146
                ///< years
  kNoDeadline,  ///< freewheeling: it takes what is left
};

struct TaskTiming {
  Verdict verdict = Verdict::kUnknown;
  core::TimeNs deadline_ns = 0;  ///< the one it was held against
  /// Longest time from the instant on the grid to the end of the scan. Nothing when it has no bound (more than 100 %
  /// load), is unknown or does not fit into 64 bits.
  std::optional<core::TimeNs> response_ns;
  std::optional<core::TimeNs> margin_ns;  ///< deadline - response; negative when it does not fit
  double utilization = 0;                 ///< execution / period; 0 without a period
  /// Utilisation by all tasks with a period at this priority and above, and blocking / period of this one. Where
  /// CpuTiming::bounds_apply, every task with level_load <= level_bound fits.
  double level_load = 0;
  double level_bound = 1;  ///< Liu and Layland's bound for that number of tasks
};

struct CpuTiming {
  int cpu = 0;
  std::vector<std::uint32_t> tasks;  ///< indices, priority 0 first, ties as declared
  Verdict verdict = Verdict::kFits;  ///< the worst of its tasks, those without a deadline left out
  double utilization = 0;            ///< of the tasks with a period, this and the next two
  double liu_layland_bound = 1;      ///< utilisation up to this fits where bounds_apply and nothing blocks
  double hyperbolic_product = 1;     ///< product of (utilisation + 1); up to 2 fits under the same conditions
  /// Two tasks that break the rate-monotonic order: the first does not come after the second and has the longer
  /// period. Nothing when priorities are rate-monotonic.
  std::optional<std::pair<std::uint32_t, std::uint32_t>> not_rate_monotonic;
  /// The sufficient tests mean something: rate-monotonic, no jitter, no deadline before the end of the period, nothing
  /// freewheeling or unknown above or beside a task with a period.
  bool bounds_apply = true;
  /// Largest factor (in steps of 1e-6, up to 1e6) by which all execution times may be multiplied so that all still
  /// fits (with what kMaxSteps can tell); below 1 when it does not fit as it is. Blocking stays. Nothing when the
  /// verdict is unknown or no task has a deadline.
  std::optional<double> breakdown_factor;
};

struct Schedulability {
  std::vector<TaskTiming> tasks;  ///< parallel to the input
  std::vector<CpuTiming> cpus;    ///< ascending by number
};

/// n * (2^(1/n) - 1); 1 for no task.
[[nodiscard]] double liu_layland_bound(std::size_t tasks);

/// Steps of the fixed-point iteration spent on one task before its verdict is kUnknown. Sets of practice need a few
/// tens; only loads within a hair of 100 % with periods that hardly ever meet come near.
inline constexpr std::uint32_t kMaxSteps = 100'000;

[[nodiscard]] Schedulability analyze_schedule(std::span<const TaskLoad> tasks);

}  // namespace plc::runtime
