// FaultLog: faults of one task as one thread sees them.
//
// In: record() by its one writer. Out: the faults so far, for any thread. Keeps the first ones; a task that faults
// again and again is no news. Does not belong here: printing, policies.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <vector>

#include "runtime/sched/task.h"

namespace plc::runtime {

class FaultLog {
 public:
  static constexpr std::size_t kKept = 64;
  /// RT: one writer.
  void record(const TaskFault& fault) noexcept {
    const std::size_t count = count_.load(std::memory_order_relaxed);
    if (count == kKept) return;
    kept_[count] = fault;
    count_.store(count + 1, std::memory_order_release);
  }
  /// Appends those from number `from` on; returns how many there are by now.
  std::size_t append_to(std::vector<TaskFault>& all, std::size_t from = 0) const {
    const std::size_t count = count_.load(std::memory_order_acquire);
    all.insert(all.end(), kept_.begin() + static_cast<std::ptrdiff_t>(from),
               kept_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

 private:
  std::array<TaskFault, kKept> kept_;
  std::atomic<std::size_t> count_{0};
};

}  // namespace plc::runtime
