#include "io-drivers/config/plan_tasks.h"

#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <numeric>

#include "core/guess.h"
#include "core/text.h"

namespace plc::io {
namespace {

using core::Code;
using runtime::TaskPlan;

std::string cpu_list(std::span<const int> cpus) {
  std::string text;
  for (std::size_t i = 0; i < cpus.size();) {
    const std::size_t first = i;
    while (i + 1 < cpus.size() && cpus[i + 1] == cpus[i] + 1) ++i;
    text += text.empty() ? "" : ", ";
    text += first == i ? std::to_string(cpus[i]) : fmt::format("{} to {}", cpus[first], cpus[i]);
    ++i;
  }
  return text;
}

class Planner {
 public:
  Planner(const Configuration& configuration, const bytecode::Image& image, std::span<const int> cpus,
          core::Diagnostics& diagnostics)
      : configuration_(configuration), image_(image), cpus_(cpus), diagnostics_(diagnostics) {}

  std::vector<TaskPlan> run(runtime::FaultPolicy on_fault) {
    std::vector<TaskPlan> plan = runtime::default_plan(image_);
    if (configuration_.scheduler.priorities == Priorities::kRateMonotonic) runtime::make_rate_monotonic(image_, plan);
    if (configuration_.scheduler.cpu) check_cpu(*configuration_.scheduler.cpu, configuration_.scheduler.cpu_at);
    for (TaskPlan& task : plan) {
      task.on_fault = on_fault;
      if (configuration_.scheduler.cpu) task.cpu = static_cast<int>(*configuration_.scheduler.cpu);
    }
    std::vector<const TaskConfig*> said(plan.size(), nullptr);
    for (const TaskConfig& task : configuration_.tasks) {
      const auto index = find(task);
      if (!index) continue;
      apply(task, plan[*index]);
      said[*index] = &task;
    }
    for (std::size_t t = 0; t < plan.size(); ++t) plan[t].lead_ns = lead(image_.tasks[t], said[t]);
    if (image_.options.coherence == core::Coherence::kPriorityCeiling) use_one_cpu(plan);
    return plan;
  }

 private:
  void problem(Code code, const core::SourceRef& at, std::string message, std::string help) {
    diagnostics_.report(code, at, {}, std::move(message), std::move(help));
  }

  std::optional<std::size_t> find(const TaskConfig& task) {
    core::Guess guess(task.name);
    for (std::size_t t = 0; t < image_.tasks.size(); ++t) {
      if (core::iequals(image_.tasks[t].name, task.name)) return t;
      guess.offer(image_.tasks[t].name);
    }
    std::string help = guess.help();
    if (help.empty()) {
      for (const bytecode::ImageTask& known : image_.tasks) help += (help.empty() ? "it has: " : ", ") + known.name;
    }
    problem(Code::P7601, task.at, fmt::format("the project has no task \"{}\"", task.name), std::move(help));
    return std::nullopt;
  }

  void apply(const TaskConfig& task, TaskPlan& to) {
    if (task.priority) to.priority = static_cast<std::int32_t>(*task.priority);
    if (task.cpu) {
      check_cpu(*task.cpu, task.cpu_at);
      to.cpu = static_cast<int>(*task.cpu);
    }
    to.offset_ns = task.offset_ns;
    to.deadline_ns = task.deadline_ns.value_or(0);
    to.execution_ns = task.execution_ns;
    to.watchdog_ns = task.watchdog_ns;
    to.overrun = task.overrun;
    if (task.on_fault) to.on_fault = *task.on_fault;
  }

  /// `said`: the task's table, or null.
  std::optional<core::TimeNs> lead(const bytecode::ImageTask& task, const TaskConfig* said) {
    const bool own = said != nullptr && said->lead_ns;
    const std::optional<core::TimeNs> lead_ns = own ? said->lead_ns : configuration_.scheduler.lead_ns;
    const bool periodic = task.single.empty() && task.period_ns > 0;
    if (!lead_ns || (!own && !periodic)) return std::nullopt;
    const core::TimeNs longest = periodic ? task.period_ns / runtime::kLongestLeadPart : 0;
    if (*lead_ns > longest) {
      problem(Code::P7608, own ? said->at : configuration_.scheduler.at,
              periodic
                  ? fmt::format("a lead of {} ns is more than a quarter of the interval of task \"{}\", {} ns",
                                *lead_ns, task.name, task.period_ns)
                  : fmt::format("task \"{}\" has no interval, so it is not known when to wake it ahead", task.name),
              periodic ? fmt::format("at most {} ns: meanwhile less urgent tasks of its processor wait", longest)
                       : "omit `lead`");
    }
    return lead_ns;
  }

  void check_cpu(std::uint32_t cpu, const core::SourceRef& at) {
    if (std::find(cpus_.begin(), cpus_.end(), static_cast<int>(cpu)) != cpus_.end()) return;
    problem(Code::P7602, at, fmt::format("processor {} is not available", cpu),
            fmt::format("this process may use: {}", cpu_list(cpus_)));
  }

  // Raising the own priority keeps others off one processor only.
  void use_one_cpu(std::vector<TaskPlan>& plan) {
    int cpu = -1;
    for (const TaskPlan& task : plan) {
      if (task.cpu < 0) continue;
      if (cpu >= 0 && task.cpu != cpu) {
        return problem(
            Code::P7603, configuration_.scheduler.at.line != 0 ? configuration_.scheduler.at : configuration_.at,
            fmt::format("tasks are bound to processors {} and {}, but --coherence=priority-ceiling keeps tasks "
                        "of one processor apart",
                        cpu, task.cpu),
            "bind all tasks to one processor ([scheduler] cpu = ..), or compile with --coherence=wait-free");
      }
      cpu = task.cpu;
    }
    if (cpu < 0 && !cpus_.empty()) cpu = cpus_.front();
    for (TaskPlan& task : plan) task.cpu = cpu;
  }

  const Configuration& configuration_;
  const bytecode::Image& image_;
  std::span<const int> cpus_;
  core::Diagnostics& diagnostics_;
};

}  // namespace

std::vector<int> available_cpus() {
  cpu_set_t set;
  CPU_ZERO(&set);
  std::vector<int> cpus;
  if (::sched_getaffinity(0, sizeof set, &set) != 0) return cpus;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (CPU_ISSET(static_cast<unsigned>(cpu), &set)) cpus.push_back(cpu);
  }
  return cpus;
}

std::vector<int> every_cpu() {
  std::vector<int> cpus(CPU_SETSIZE);
  std::iota(cpus.begin(), cpus.end(), 0);
  return cpus;
}

std::optional<std::vector<TaskPlan>> plan_tasks(const Configuration& configuration, const bytecode::Image& image,
                                                std::span<const int> cpus, runtime::FaultPolicy on_fault,
                                                core::Diagnostics& diagnostics) {
  const std::size_t errors = diagnostics.error_count();
  std::vector<TaskPlan> plan = Planner(configuration, image, cpus, diagnostics).run(on_fault);
  if (diagnostics.error_count() != errors) return std::nullopt;
  return plan;
}

}  // namespace plc::io
