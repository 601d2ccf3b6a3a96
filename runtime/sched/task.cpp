#include "runtime/sched/task.h"

#include <algorithm>
#include <numeric>

#include "bytecode/paths.h"

namespace plc::runtime {

// RT:
std::uint64_t ReleaseGrid::advance(core::TimeNs now_ns) noexcept {
  next_ += period_;
  if (next_ > now_ns) return 0;
  const std::int64_t left_out = (now_ns - next_) / period_ + 1;
  next_ += left_out * period_;
  return static_cast<std::uint64_t>(left_out);
}

core::TimeNs grid_period(const bytecode::ImageTask& task) {
  return task.single.empty() && task.period_ns > 0 ? task.period_ns : kFreewheelNs;
}

std::vector<std::uint32_t> priority_order(const bytecode::Image& image) {
  std::vector<std::uint32_t> order(image.tasks.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&image](std::uint32_t a, std::uint32_t b) {
    return image.tasks[a].priority < image.tasks[b].priority;
  });
  return order;
}

std::optional<std::uint32_t> trigger_of(const bytecode::Image& image, const bytecode::ImageTask& task) {
  if (task.single.empty()) return std::nullopt;
  return bytecode::find_global(image, task.single)->offset;
}

}  // namespace plc::runtime
