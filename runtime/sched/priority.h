// Priorities of IEC tasks as priorities of Linux threads.
//
// In: 0 (the most urgent), 1, 2, ... Out: SCHED_FIFO priorities. Does not belong here: who gets which (task_plan.h).
#pragma once

#include <cstdint>

namespace plc::runtime {

/// SCHED_FIFO priority of IEC priority 0. Above the kernel's threads that serve interrupts (50 by default), so that
/// devices that no task needs delay no task; below its timers and migration (99).
inline constexpr int kHighestPriority = 80;
/// That of the watchdog, above every task.
inline constexpr int kWatchdogPriority = kHighestPriority + 1;

/// One less for each step down, never below 1: IEC priorities from 79 on are equally urgent.
constexpr int fifo_priority(std::int32_t priority) {
  if (priority < 0) return kHighestPriority;
  return priority < kHighestPriority - 1 ? kHighestPriority - priority : 1;
}

}  // namespace plc::runtime
