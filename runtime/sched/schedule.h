// Schedule: the tasks of an image on one machine, held against their deadlines before they run.
//
// In: a verified image, the plan of its tasks, what instructions cost here. Out: for each processor the answer of
// analyze_schedule(), with execution times that were measured or else estimated, and what the coherence protocol adds.
// Configuration time: allocates. Does not belong here: files (io-drivers/config/calibration.h), refusing, printing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bytecode/image.h"
#include "runtime/sched/analysis.h"
#include "runtime/sched/estimate.h"
#include "runtime/sched/task_plan.h"

namespace plc::runtime {

struct TaskDemand {
  bool measured = false;
  double estimate_ns = 0;            ///< from the instructions, without margin
  core::TimeNs execution_ns = 0;     ///< measured, or the estimate with its margin
  core::TimeNs lead_ns = 0;          ///< awake before each release: processor time beside that of the scan
  core::TimeNs waiting_ns = 0;       ///< for the lock of the global table while tasks on other processors hold it
  core::TimeNs blocking_ns = 0;      ///< by less urgent tasks of its processor that hold it off
  std::int32_t priority = 0;         ///< as the kernel tells them apart (runtime/sched/priority.h)
  std::vector<AssumedLoop> assumed;  ///< loops of the estimate whose number of rounds is not known
};

/// The tasks that may meet on one processor.
struct ProcessorSchedule {
  int cpu = -1;                      ///< -1: no task is bound to a processor
  std::vector<std::uint32_t> tasks;  ///< of the image; priority 0 first, ties as declared
  std::vector<TaskTiming> timings;   ///< parallel to `tasks`
  CpuTiming timing;                  ///< its task numbers are places in `tasks`
};

struct Schedule {
  std::vector<TaskDemand> tasks;  ///< parallel to Image::tasks
  core::TimeNs release_ns = 0;    ///< what the system takes around each scan, measured or not, with the margin
  /// Ascending by processor. A task that is bound to none is in each: a processor that it meets everybody on and
  /// has for its own is the worst that can happen to any of them, as long as a task that is ready runs where a less
  /// urgent one would.
  std::vector<ProcessorSchedule> processors;
};

/// `margin`: what is added to estimates, 1 = as much again. `plan` is parallel to the tasks.
Schedule make_schedule(const bytecode::Image& image, std::span<const TaskPlan> plan, const CostTable& costs,
                       double margin, std::uint32_t loop_budget = bytecode::kDefaultLoopBudget);

/// Tasks that miss their deadlines on a machine with these processors by measured times alone, ascending: only tasks on
/// intervals that were measured count, nothing is added to their times, and where they have different offsets they are
/// taken to keep out of each other's way as long as the processor is not overloaded.
std::vector<std::uint32_t> certain_misses(const bytecode::Image& image, std::span<const TaskPlan> plan,
                                          std::span<const int> cpus);

}  // namespace plc::runtime
