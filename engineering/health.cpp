#include "engineering/health.h"

namespace plc::engineering {

std::string_view task_state(std::uint32_t task, const runtime::RealtimeScheduler& scheduler) {
  const runtime::TaskStatistics& statistics = scheduler.statistics(task);
  if (statistics.faults.load(std::memory_order_relaxed) != 0) {
    return scheduler.plan(task).on_fault == runtime::FaultPolicy::kContinue ? "faulted" : "stopped";
  }
  return statistics.scans.load(std::memory_order_relaxed) != 0 ? "runs" : "starts";
}

std::string_view plant_state(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler) {
  if (scheduler.stop_requested()) return "stops";
  bool stopped = false, faulted = false, runs = false;
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    const std::string_view state = task_state(task, scheduler);
    stopped = stopped || state == "stopped";
    faulted = faulted || state == "faulted";
    runs = runs || state == "runs";
  }
  return stopped ? "stopped" : faulted ? "faulted" : runs ? "runs" : "starts";
}

}  // namespace plc::engineering
