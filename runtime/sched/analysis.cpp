#include "runtime/sched/analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "runtime/sched/task.h"

namespace plc::runtime {
namespace {

using core::TimeNs;

constexpr TimeNs kMaxTime = std::numeric_limits<TimeNs>::max();
/// No busy period is followed further and no jitter beyond this is believed, so that sums of the two never overflow.
constexpr TimeNs kLongest = kMaxTime / 2;
/// Sums of quotients in double are right to much less than this, so a load above 1 + kLoadError is an overload.
constexpr double kLoadError = 1e-12;
constexpr TimeNs kFactorScale = 1'000'000;  ///< breakdown factors are integers of this unit
constexpr TimeNs kMaxFactor = kFactorScale * kFactorScale;

// Times are not negative; results stay at kMaxTime, which every comparison takes as "at least this".
TimeNs add(TimeNs a, TimeNs b) { return a > kMaxTime - b ? kMaxTime : a + b; }
TimeNs multiply(TimeNs a, TimeNs b) { return b != 0 && a > kMaxTime / b ? kMaxTime : a * b; }

/// What a task asks of its processor.
struct Demand {
  TimeNs execution = 1;
  TimeNs period = 1;
  TimeNs jitter = 0;

  /// Releases in [0, time], the first at 0 with all its jitter used up, the others with none. `time` <= kLongest.
  [[nodiscard]] TimeNs releases_until(TimeNs time) const { return (time + jitter) / period + 1; }
  /// The same in [0, time).
  [[nodiscard]] TimeNs releases_before(TimeNs time) const { return releases_until(time - 1); }
  /// The first such release after `time`.
  [[nodiscard]] TimeNs next_after(TimeNs time) const { return multiply(releases_until(time), period) - jitter; }
};

/// A task and all that delays it.
struct Level {
  Demand own;
  std::vector<Demand> equal;   ///< the other tasks of its priority
  std::vector<Demand> higher;  ///< what preempts it
  TimeNs blocking = 0;
  TimeNs deadline = 0;
  bool complete = true;  ///< no task with unknown releases was left out
};

struct Response {
  TimeNs longest = 0;
  bool exact = false;  ///< otherwise the longest response is at least that
};

/// The fixed point of `queued` + preemption, from `finish` on, which must not be beyond it. False when out of steps or
/// of bits; `finish` is then too low.
bool iterate(const std::vector<Demand>& higher, TimeNs queued, TimeNs& finish, std::uint32_t& steps) {
  while (finish <= kLongest && steps != 0) {
    TimeNs next = queued;
    for (const Demand& h : higher) next = add(next, multiply(h.releases_before(finish), h.execution));
    if (next == finish) return true;
    finish = next;
    --steps;
  }
  return false;
}

/// Longest response over the busy period that begins with everything released at once. A job's place in the queue is
/// given by its release `at`: jobs of its own priority released up to then run before it, those of higher priority as
/// long as it is not finished. Between two releases of its priority a later job only has less to wait, so the releases
/// are the only instants to look at; the busy period ends where all released so far is done before the next one.
/// Its own jitter delays a job at most by all of it, and releases of its own that keep the distance of a period are
/// then the worst: it adds to the response and is no part of `at`.
Response longest_response(const Level& level, bool stop_at_miss) {
  Demand own = level.own;
  own.jitter = 0;
  std::uint32_t steps = kMaxSteps;
  Response result;
  TimeNs finish = 0;
  for (TimeNs at = 0;;) {
    TimeNs queued = add(level.blocking, multiply(own.releases_until(at), own.execution));
    TimeNs next = own.next_after(at);
    for (const Demand& e : level.equal) {
      queued = add(queued, multiply(e.releases_until(at), e.execution));
      next = std::min(next, e.next_after(at));
    }
    finish = std::max(finish, queued);
    const bool found = iterate(level.higher, queued, finish, steps);
    result.longest = std::max(result.longest, add(finish - at, level.own.jitter));
    if (!found || steps == 0) return result;
    if (stop_at_miss && result.longest > level.deadline) return result;
    if (next >= finish) break;
    at = next;
    --steps;
  }
  result.exact = true;
  return result;
}

double load_of(const Demand& demand) {
  return static_cast<double>(demand.execution) / static_cast<double>(demand.period);
}

bool overloaded(const Level& level) {
  double load = load_of(level.own);
  for (const Demand& e : level.equal) load += load_of(e);
  for (const Demand& h : level.higher) load += load_of(h);
  return load > 1 + kLoadError;
}

Verdict verdict_of(const Level& level, const Response& response) {
  if (response.longest > level.deadline) return Verdict::kDoesNotFit;
  return response.exact && level.complete ? Verdict::kFits : Verdict::kUnknown;
}

bool freewheeling(const TaskLoad& task) { return task.period_ns <= 0 && !task.event; }
bool has_period(const TaskLoad& task) { return task.period_ns > 0 && task.jitter_ns <= kLongest; }

/// `factor` in units of 1 / kFactorScale, rounded up.
TimeNs scaled(TimeNs time, TimeNs factor) {
  const TimeNs rest = multiply(time % kFactorScale, factor);  // below 1e18: exact
  return add(multiply(time / kFactorScale, factor), rest / kFactorScale + (rest % kFactorScale != 0 ? 1 : 0));
}

/// Nothing when it is not known how often the task is released. A freewheeling task keeps a distance of kFreewheelNs as
/// long as its scan is shorter; then it is a task with that period to those below and beside it.
std::optional<Demand> demand_of(const TaskLoad& task, TimeNs factor) {
  Demand demand;
  demand.execution = std::max<TimeNs>(scaled(std::max<TimeNs>(task.execution_ns, 0), factor), 1);
  demand.jitter = std::max<TimeNs>(task.jitter_ns, 0);
  demand.period = freewheeling(task) ? kFreewheelNs : task.period_ns;
  const bool known = freewheeling(task) ? demand.execution < kFreewheelNs : has_period(task);
  return known ? std::optional(demand) : std::nullopt;
}

TimeNs deadline_of(const TaskLoad& task) {
  return task.deadline_ns > 0 ? task.deadline_ns : std::max<TimeNs>(task.period_ns, 0);
}

/// `task` has a period; `order` are the tasks of its processor.
Level level_of(std::span<const TaskLoad> tasks, std::span<const std::uint32_t> order, std::uint32_t task,
               TimeNs factor) {
  Level level;
  level.own = *demand_of(tasks[task], factor);
  level.deadline = deadline_of(tasks[task]);
  for (const std::uint32_t i : order) {
    const TaskLoad& other = tasks[i];
    if (other.priority > tasks[task].priority) break;
    const bool equal = other.priority == tasks[task].priority;
    // What blocks a task of the same priority blocks the queue they share.
    if (equal) level.blocking = std::max(level.blocking, other.blocking_ns);
    if (i == task) continue;
    if (const std::optional<Demand> demand = demand_of(other, factor)) {
      (equal ? level.equal : level.higher).push_back(*demand);
    } else {
      level.complete = false;
    }
  }
  return level;
}

TaskTiming time_task(std::span<const TaskLoad> tasks, std::span<const std::uint32_t> order, std::uint32_t task) {
  TaskTiming timing;
  timing.deadline_ns = deadline_of(tasks[task]);
  std::size_t count = 0;
  for (const std::uint32_t i : order) {
    if (tasks[i].priority > tasks[task].priority || !has_period(tasks[i])) continue;
    timing.level_load += load_of(*demand_of(tasks[i], kFactorScale));
    ++count;
  }
  timing.level_bound = liu_layland_bound(count);
  if (!has_period(tasks[task])) {
    if (freewheeling(tasks[task])) timing.verdict = Verdict::kNoDeadline;
    return timing;
  }
  const Level level = level_of(tasks, order, task, kFactorScale);
  timing.utilization = load_of(level.own);
  timing.level_load += static_cast<double>(level.blocking) / static_cast<double>(level.own.period);
  if (overloaded(level)) {
    timing.verdict = Verdict::kDoesNotFit;
    return timing;
  }
  const Response response = longest_response(level, false);
  timing.verdict = verdict_of(level, response);
  if (response.exact && level.complete) {
    timing.response_ns = response.longest;
    timing.margin_ns = timing.deadline_ns - response.longest;
  }
  return timing;
}

bool all_fit(std::span<const TaskLoad> tasks, std::span<const std::uint32_t> order, TimeNs factor) {
  return std::all_of(order.begin(), order.end(), [&](std::uint32_t i) {
    if (!has_period(tasks[i])) return true;
    const Level level = level_of(tasks, order, i, factor);
    return !overloaded(level) && verdict_of(level, longest_response(level, true)) == Verdict::kFits;
  });
}

/// Largest factor that fits, by bisection: more execution time never makes a response shorter.
TimeNs breakdown(std::span<const TaskLoad> tasks, std::span<const std::uint32_t> order) {
  if (all_fit(tasks, order, kMaxFactor)) return kMaxFactor;
  TimeNs fits = 0;
  TimeNs too_much = kMaxFactor;
  while (too_much - fits > 1) {
    const TimeNs middle = fits + (too_much - fits) / 2;
    (all_fit(tasks, order, middle) ? fits : too_much) = middle;
  }
  return fits;
}

/// The task with the longest period of those at or above a task's priority must not have a longer one than it.
std::optional<std::pair<std::uint32_t, std::uint32_t>> broken_order(std::span<const TaskLoad> tasks,
                                                                    std::span<const std::uint32_t> order) {
  for (const std::uint32_t later : order) {
    if (!has_period(tasks[later])) continue;
    for (const std::uint32_t sooner : order) {
      if (tasks[sooner].priority > tasks[later].priority) break;
      if (tasks[sooner].period_ns > tasks[later].period_ns) return std::pair{sooner, later};
    }
  }
  return std::nullopt;
}

/// `cpu.tasks` is set; the timing of its tasks is in `timings`.
void time_cpu(std::span<const TaskLoad> tasks, std::span<const TaskTiming> timings, CpuTiming& cpu) {
  std::size_t count = 0;
  bool foreign = false;  // a task without a period has come
  std::int32_t foreign_priority = 0;
  for (const std::uint32_t i : cpu.tasks) {
    if (timings[i].verdict == Verdict::kDoesNotFit) cpu.verdict = Verdict::kDoesNotFit;
    if (timings[i].verdict == Verdict::kUnknown && cpu.verdict == Verdict::kFits) cpu.verdict = Verdict::kUnknown;
    if (!has_period(tasks[i])) {
      if (!foreign) foreign_priority = tasks[i].priority;
      foreign = true;
      continue;
    }
    ++count;
    cpu.utilization += timings[i].utilization;
    cpu.hyperbolic_product *= timings[i].utilization + 1;
    if (tasks[i].jitter_ns > 0 || timings[i].deadline_ns < tasks[i].period_ns) cpu.bounds_apply = false;
  }
  for (const std::uint32_t i : cpu.tasks) {
    if (foreign && has_period(tasks[i]) && tasks[i].priority >= foreign_priority) cpu.bounds_apply = false;
  }
  cpu.liu_layland_bound = liu_layland_bound(count);
  cpu.not_rate_monotonic = broken_order(tasks, cpu.tasks);
  if (cpu.not_rate_monotonic) cpu.bounds_apply = false;
  if (count != 0 && cpu.verdict != Verdict::kUnknown) {
    cpu.breakdown_factor = static_cast<double>(breakdown(tasks, cpu.tasks)) / static_cast<double>(kFactorScale);
  }
}

}  // namespace

double liu_layland_bound(std::size_t tasks) {
  if (tasks == 0) return 1;
  const auto n = static_cast<double>(tasks);
  return n * std::expm1(std::log(2.0) / n);
}

Schedulability analyze_schedule(std::span<const TaskLoad> tasks) {
  Schedulability result;
  result.tasks.resize(tasks.size());
  std::map<int, std::vector<std::uint32_t>> by_cpu;
  for (std::uint32_t i = 0; i < tasks.size(); ++i) by_cpu[tasks[i].cpu].push_back(i);
  for (auto& [number, order] : by_cpu) {
    std::stable_sort(order.begin(), order.end(),
                     [tasks](std::uint32_t a, std::uint32_t b) { return tasks[a].priority < tasks[b].priority; });
    for (const std::uint32_t i : order) result.tasks[i] = time_task(tasks, order, i);
    CpuTiming& cpu = result.cpus.emplace_back();
    cpu.cpu = number;
    cpu.tasks = std::move(order);
    time_cpu(tasks, result.tasks, cpu);
  }
  return result;
}

}  // namespace plc::runtime
