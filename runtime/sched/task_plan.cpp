#include "runtime/sched/task_plan.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace plc::runtime {

std::vector<TaskPlan> default_plan(const bytecode::Image& image) {
  std::vector<TaskPlan> plan(image.tasks.size());
  for (std::size_t t = 0; t < plan.size(); ++t) plan[t].priority = image.tasks[t].priority;
  return plan;
}

core::TimeNs lead_of(const bytecode::ImageTask& task, const TaskPlan& plan) {
  if (!task.single.empty() || task.period_ns <= 0) return 0;
  return plan.lead_ns.value_or(std::min(task.period_ns / 20, kDefaultLeadNs));
}

void make_rate_monotonic(const bytecode::Image& image, std::vector<TaskPlan>& plan) {
  // What has no interval keeps its order after all that has one.
  const auto rank = [&](std::size_t t) {
    const bytecode::ImageTask& task = image.tasks[t];
    const bool periodic = task.single.empty() && task.period_ns > 0;
    return std::tuple(!periodic, periodic ? task.period_ns : std::int64_t{plan[t].priority});
  };
  std::vector<std::size_t> order(plan.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
  std::vector<std::int32_t> priority(plan.size());
  for (std::size_t i = 1; i < order.size(); ++i) {
    priority[order[i]] = priority[order[i - 1]] + (rank(order[i]) != rank(order[i - 1]) ? 1 : 0);
  }
  for (std::size_t t = 0; t < plan.size(); ++t) plan[t].priority = priority[t];
}

}  // namespace plc::runtime
