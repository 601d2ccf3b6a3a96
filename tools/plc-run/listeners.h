// Small cycle listeners of plc-run: a cycle limit and a scripted stimulus in real time.
//
// In: the exchange points of the tasks. Out: a stop request, or variables written. Threads: each acts on one task only.
#pragma once

#include <cstdint>

#include "io-drivers/simulated.h"
#include "runtime/sched/cycle_listener.h"
#include "runtime/sched/realtime.h"

namespace plc::tools {

/// Asks the scheduler to stop after the task's N-th scan.
class CycleLimit final : public runtime::CycleListener {
 public:
  CycleLimit(runtime::RealtimeScheduler& scheduler, std::uint32_t task, std::uint64_t cycles)
      : scheduler_(scheduler), task_(task), cycles_(cycles) {}
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext& context) noexcept override {
    if (context.task == task_ && context.cycle + 1 >= cycles_) scheduler_.request_stop();
  }
  void safe_state() noexcept override {}

 private:
  runtime::RealtimeScheduler& scheduler_;
  std::uint32_t task_;
  std::uint64_t cycles_;
};

/// Applies a stimulus at the start of the scans of one task; time 0 is that task's first release.
class RealtimeStimulus final : public runtime::CycleListener {
 public:
  RealtimeStimulus(io::SimulatedDriver& driver, std::uint32_t task) : driver_(driver), task_(task) {}
  void before_scan(const runtime::ReleaseContext& context) noexcept override {
    if (context.task != task_) return;
    if (context.cycle == 0) first_release_ns_ = context.release_ns;
    driver_.apply(context.release_ns - first_release_ns_);
  }
  void after_scan(const runtime::ReleaseContext&) noexcept override {}
  void safe_state() noexcept override {}

 private:
  io::SimulatedDriver& driver_;
  std::uint32_t task_;
  core::TimeNs first_release_ns_ = 0;
};

}  // namespace plc::tools
