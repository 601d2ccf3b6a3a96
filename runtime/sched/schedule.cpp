#include "runtime/sched/schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>

#include "runtime/sched/priority.h"
#include "runtime/sched/task.h"

namespace plc::runtime {
namespace {

using bytecode::Image;
using core::TimeNs;
using What = BodyStep::What;

TimeNs whole(double ns) {
  constexpr double kMost = 9e18;
  return static_cast<TimeNs>(std::ceil(std::min(ns, kMost)));
}
TimeNs add(TimeNs a, TimeNs b) {
  TimeNs sum = 0;
  return __builtin_add_overflow(a, b, &sum) ? std::numeric_limits<TimeNs>::max() : sum;
}

/// IEC priorities as far as Linux threads can tell them apart: 0 is the most urgent.
std::int32_t told_apart(std::int32_t priority) { return kHighestPriority - fifo_priority(priority); }

/// What a task does at a stretch in which others wait, in ns.
struct Stretch {
  std::int32_t level = 0;  ///< tasks of this priority and less urgent ones wait
  double ns = 0;
};

/// Who waits for whom, by the coherence protocol of the image (docs/guides/coherence.md).
class Protocol {
 public:
  Protocol(const Image& image, std::span<const TaskPlan> plan, const std::vector<TaskEstimate>& estimates)
      : image_(image), plan_(plan), estimates_(estimates), ceilings_(image.globals.size()) {
    for (std::size_t t = 0; t < estimates.size(); ++t) {
      for (const BodyStep& step : estimates[t].body) {
        if (step.what != What::kCopy) continue;
        for (std::uint32_t f = step.first; f < step.first + step.count; ++f) {
          ceilings_[f] = std::min(ceilings_[f].value_or(plan[t].priority), plan[t].priority);
        }
      }
    }
    for (std::size_t t = 0; t < estimates.size(); ++t) {
      longest_locked_.push_back(longest_locked(estimates[t].body));
      locks_.push_back(static_cast<double>(std::count_if(estimates[t].body.begin(), estimates[t].body.end(),
                                                         [](const BodyStep& s) { return s.what == What::kLock; })));
    }
  }

  /// Longest time for which less urgent tasks of the processor hold up `task`: with ceilings once, with the lock each
  /// time it takes it (while it waits for another processor they may take it anew).
  [[nodiscard]] double blocking(std::uint32_t task) const {
    double longest = 0;
    for (std::uint32_t other = 0; other < estimates_.size(); ++other) {
      if (other == task || !may_meet(task, other) || !less_urgent(other, task)) continue;
      longest = std::max({longest, longest_raised(other, plan_[task].priority), longest_locked_[other] * locks_[task]});
    }
    return longest;
  }

  /// Longest time for which tasks that run elsewhere hold the lock when `task` wants it: each of them once, each time.
  [[nodiscard]] double waiting(std::uint32_t task) const {
    double sum = 0;
    for (std::uint32_t other = 0; other < estimates_.size(); ++other) {
      const bool together = plan_[task].cpu >= 0 && plan_[task].cpu == plan_[other].cpu;
      if (other != task && !together) sum += longest_locked_[other];
    }
    return sum * locks_[task];
  }

 private:
  [[nodiscard]] bool may_meet(std::uint32_t a, std::uint32_t b) const {
    return plan_[a].cpu < 0 || plan_[b].cpu < 0 || plan_[a].cpu == plan_[b].cpu;
  }
  [[nodiscard]] bool less_urgent(std::uint32_t a, std::uint32_t b) const {
    return told_apart(plan_[a].priority) > told_apart(plan_[b].priority);
  }

  static double longest_locked(const std::vector<BodyStep>& body) {
    double longest = 0, now = 0;
    bool locked = false;
    for (const BodyStep& step : body) {
      if (step.what == What::kLock) {
        locked = true;
        now = 0;
      }
      if (locked) longest = std::max(longest, now += step.ns);
      if (step.what == What::kUnlock) locked = false;
    }
    return longest;
  }

  /// Longest time that `task` runs as urgently as `priority` or more. Every copy rises to the ceiling of what it
  /// copies, and only RESCHEDULE and the end of the scan go back (runtime/memory/ceiling_exchange.cpp).
  [[nodiscard]] double longest_raised(std::uint32_t task, std::int32_t priority) const {
    if (image_.options.coherence != core::Coherence::kPriorityCeiling) return 0;
    std::int32_t level = plan_[task].priority;
    double longest = 0, now = 0;
    for (const BodyStep& step : estimates_[task].body) {
      if (step.what == What::kCopy || step.what == What::kRaise) level = std::min(level, ceiling(step));
      if (level <= priority) longest = std::max(longest, now += step.ns);
      if (step.what == What::kReschedule) {
        level = plan_[task].priority;
        now = 0;
      }
    }
    return longest;
  }
  /// Of what one task alone exports: nothing else is copied under the protocol.
  [[nodiscard]] std::int32_t ceiling(const BodyStep& step) const {
    std::int32_t least = std::numeric_limits<std::int32_t>::max();
    for (std::uint32_t f = step.first; f < step.first + step.count; ++f) {
      if (image_.globals[f].writers == 1 && ceilings_[f]) least = std::min(least, *ceilings_[f]);
    }
    return least;
  }

  const Image& image_;
  std::span<const TaskPlan> plan_;
  const std::vector<TaskEstimate>& estimates_;
  std::vector<std::optional<std::int32_t>> ceilings_;  ///< by global
  std::vector<double> longest_locked_;
  std::vector<double> locks_;  ///< times that a scan takes the lock
};

TaskLoad load_of(const Image& image, const TaskPlan& plan, std::uint32_t task) {
  const bytecode::ImageTask& declared = image.tasks[task];
  TaskLoad load;
  load.name = declared.name;
  load.cpu = plan.cpu;
  load.priority = told_apart(plan.priority);
  load.event = !declared.single.empty();
  // The scheduler looks at triggers that often, so they come no sooner.
  load.period_ns = load.event ? kFreewheelNs : declared.period_ns;
  load.deadline_ns = plan.deadline_ns;
  return load;
}

/// The loads of `tasks` as if they shared one processor.
ProcessorSchedule on_one_processor(int cpu, std::vector<std::uint32_t> tasks, const std::vector<TaskLoad>& loads) {
  std::stable_sort(tasks.begin(), tasks.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return loads[a].priority < loads[b].priority; });
  std::vector<TaskLoad> here;
  for (const std::uint32_t t : tasks) {
    here.push_back(loads[t]);
    here.back().cpu = cpu;
  }
  Schedulability answer = analyze_schedule(here);
  return {cpu, std::move(tasks), std::move(answer.tasks), std::move(answer.cpus.front())};
}

std::vector<ProcessorSchedule> by_processor(std::span<const TaskPlan> plan, const std::vector<TaskLoad>& loads) {
  std::set<int> cpus;
  for (const TaskPlan& task : plan) {
    if (task.cpu >= 0) cpus.insert(task.cpu);
  }
  if (cpus.empty() && !plan.empty()) cpus.insert(-1);
  std::vector<ProcessorSchedule> processors;
  for (const int cpu : cpus) {
    std::vector<std::uint32_t> tasks;
    for (std::uint32_t t = 0; t < plan.size(); ++t) {
      if (plan[t].cpu == cpu || plan[t].cpu < 0) tasks.push_back(t);
    }
    processors.push_back(on_one_processor(cpu, std::move(tasks), loads));
  }
  return processors;
}

}  // namespace

Schedule make_schedule(const Image& image, std::span<const TaskPlan> plan, const CostTable& costs, double margin,
                       std::uint32_t loop_budget) {
  std::vector<TaskEstimate> estimates;
  for (std::uint32_t t = 0; t < image.tasks.size(); ++t) {
    estimates.push_back(estimate_task(image, t, costs, loop_budget));
  }
  const Protocol protocol(image, plan, estimates);
  Schedule schedule;
  schedule.release_ns = whole(costs[CostKind::kRelease].first * (1 + margin));
  std::vector<TaskLoad> loads;
  for (std::uint32_t t = 0; t < image.tasks.size(); ++t) {
    TaskDemand demand;
    demand.measured = plan[t].execution_ns.has_value();
    demand.estimate_ns = estimates[t].scan.first;
    demand.execution_ns = plan[t].execution_ns.value_or(whole(demand.estimate_ns * (1 + margin)));
    demand.lead_ns = lead_of(image.tasks[t], plan[t]);
    demand.waiting_ns = whole(protocol.waiting(t) * (1 + margin));
    demand.blocking_ns = whole(protocol.blocking(t) * (1 + margin));
    demand.priority = told_apart(plan[t].priority);
    demand.assumed = std::move(estimates[t].assumed);
    TaskLoad load = load_of(image, plan[t], t);
    // As if it came after the release: by so much a response is found longer than it is.
    load.execution_ns = add(add(schedule.release_ns, demand.lead_ns), add(demand.execution_ns, demand.waiting_ns));
    load.blocking_ns = demand.blocking_ns;
    loads.push_back(std::move(load));
    schedule.tasks.push_back(std::move(demand));
  }
  schedule.processors = by_processor(plan, loads);
  return schedule;
}

std::vector<std::uint32_t> certain_misses(const Image& image, std::span<const TaskPlan> plan,
                                          std::span<const int> cpus) {
  std::map<int, std::vector<std::uint32_t>> by_cpu;
  std::vector<TaskLoad> loads;
  std::vector<std::uint32_t> measured;
  std::set<std::uint32_t> misses;
  double everything = 0;
  for (std::uint32_t t = 0; t < plan.size(); ++t) {
    TaskLoad load = load_of(image, plan[t], t);
    load.execution_ns = plan[t].execution_ns.value_or(0);
    loads.push_back(load);
    if (!plan[t].execution_ns || load.event || load.period_ns <= 0) continue;
    measured.push_back(t);
    if (load.execution_ns > (load.deadline_ns > 0 ? load.deadline_ns : load.period_ns)) misses.insert(t);
    everything += static_cast<double>(load.execution_ns) / static_cast<double>(load.period_ns);
    // On a machine of one processor there is no choice.
    const int cpu = cpus.size() == 1 ? cpus.front() : plan[t].cpu;
    if (cpu >= 0) by_cpu[cpu].push_back(t);
  }
  // Which of them it will be is not known; on one processor the analysis tells.
  const bool overloaded = cpus.size() > 1 && everything > static_cast<double>(cpus.size());
  if (overloaded) misses.insert(measured.begin(), measured.end());
  for (const auto& [cpu, tasks] : by_cpu) {
    const ProcessorSchedule answer = on_one_processor(cpu, tasks, loads);
    const core::TimeNs offset_ns = plan[tasks.front()].offset_ns;
    const bool together =
        std::all_of(tasks.begin(), tasks.end(), [&](std::uint32_t t) { return plan[t].offset_ns == offset_ns; });
    for (std::size_t i = 0; i < answer.tasks.size(); ++i) {
      const bool late = together ? answer.timings[i].verdict == Verdict::kDoesNotFit : answer.timings[i].level_load > 1;
      if (late) misses.insert(answer.tasks[i]);
    }
  }
  return {misses.begin(), misses.end()};
}

}  // namespace plc::runtime
