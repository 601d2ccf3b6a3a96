// Small cycle listeners of plc-run: a cycle limit.
//
// In: the exchange points of the tasks. Out: a stop request. Threads: acts on one task only.
#pragma once

#include <cstdint>

#include "runtime/sched/cycle_listener.h"
#include "runtime/sched/realtime.h"

namespace plc::tools {

/// Asks the scheduler to stop after the task's N-th scan, or when the task faults for good.
class CycleLimit final : public runtime::CycleListener {
 public:
  CycleLimit(runtime::RealtimeScheduler& scheduler, std::uint32_t task, std::uint64_t cycles)
      : scheduler_(scheduler), task_(task), cycles_(cycles) {}
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext& context) noexcept override {
    if (context.task == task_ && context.cycle + 1 >= cycles_) scheduler_.request_stop();
  }
  void safe_state() noexcept override {}
  /// The scans that are missing will not come.
  void task_stopped(std::uint32_t task) noexcept override {
    if (task == task_) scheduler_.request_stop();
  }

 private:
  runtime::RealtimeScheduler& scheduler_;
  std::uint32_t task_;
  std::uint64_t cycles_;
};

}  // namespace plc::tools
