// plan_tasks(): what plc.toml says about tasks, against the tasks of a project.
//
// In: Configuration, image, the processors this process may use. Out: one TaskPlan a task, or diagnostics (P76xx) with
// the place in plc.toml. Does not belong here: what the tasks cost (runtime/sched/analysis.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"
#include "runtime/sched/task_plan.h"

namespace plc::io {

/// Processors this process may use, ascending.
std::vector<int> available_cpus();
/// Those of any machine: for a plan that another one is to carry out.
std::vector<int> every_cpu();

/// `on_fault` is the policy of the tasks that declare none. The coherence protocol priority-ceiling binds every task to
/// one processor: the one they name, or the first of `cpus`.
std::optional<std::vector<runtime::TaskPlan>> plan_tasks(const Configuration& configuration,
                                                         const bytecode::Image& image, std::span<const int> cpus,
                                                         runtime::FaultPolicy on_fault, core::Diagnostics& diagnostics);

}  // namespace plc::io
