// check_schedule(): do the tasks of a project meet their deadlines on this machine, by what plc.toml says and what
// instructions cost?
//
// In: configuration, image, plan. Out: P7605 for deadlines that may be missed, P7606 for those that will be. Does not
// belong here: the computation (runtime/sched/schedule.h), tables for people (plc explain --schedule).
#pragma once

#include <optional>
#include <span>
#include <string>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"
#include "runtime/sched/schedule.h"

namespace plc::io {

/// What a machine's instructions cost, by [scheduler] calibration.
struct MachineCosts {
  runtime::CostTable costs;
  double margin = 0;        ///< added to estimates, 1 = as much again
  bool calibrated = false;  ///< measured on this machine; else those of a typical one
};

/// Reads the calibration that plc.toml names. P7607 and nothing when it is none.
std::optional<MachineCosts> machine_costs(const Configuration& configuration, core::Diagnostics& diagnostics);

/// Reports what `schedule` says of the plan: an error where measured times cannot fit on the processors `cpus`, unless
/// [scheduler] unfit = "run"; a warning for every other task that may miss its deadline.
void report_schedule(const Configuration& configuration, const bytecode::Image& image,
                     std::span<const runtime::TaskPlan> plan, const runtime::Schedule& schedule,
                     const MachineCosts& machine, std::span<const int> cpus, core::Diagnostics& diagnostics);

/// All of it.
void check_schedule(const Configuration& configuration, const bytecode::Image& image,
                    std::span<const runtime::TaskPlan> plan, std::span<const int> cpus, core::Diagnostics& diagnostics,
                    std::uint32_t loop_budget = bytecode::kDefaultLoopBudget);

}  // namespace plc::io
