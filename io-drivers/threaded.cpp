#include "io-drivers/threaded.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <utility>

#include "core/clock.h"

namespace plc::io {
namespace {

constexpr std::uint32_t kLastBit = 63;

}  // namespace

ThreadedDriver::ThreadedDriver(std::unique_ptr<Driver> driver, core::TimeNs poll_ns)
    : driver_(std::move(driver)), poll_ns_(poll_ns) {}

ThreadedDriver::~ThreadedDriver() {
  tell_to_end();
  thread_.join();
}

void ThreadedDriver::start() {
  if (thread_.joinable()) return;
  thread_.start("plc-driver", [this] { run(); });
}

void ThreadedDriver::run() noexcept {
  core::MonotonicClock clock;
  runtime::ReleaseContext context;
  context.task = driver_->task();
  context.release_ns = clock.now_ns();
  std::uint64_t stopped = 0;
  do {
    for (const std::uint64_t now = stopped_tasks_.load(std::memory_order_relaxed); stopped != now;) {
      const auto task = static_cast<std::uint32_t>(std::countr_zero(now & ~stopped));
      stopped |= std::uint64_t{1} << task;
      // Which of many it was is not known: all outputs are safe then.
      driver_->task_stopped(task < kLastBit ? task : driver_->task());
    }
    context.now_ns = clock.now_ns();
    driver_->before_scan(context);
    driver_->after_scan(context);
    ++context.cycle;
    // A device that is slower than asked for is exchanged with as fast as it goes.
    context.release_ns = std::max(context.release_ns + poll_ns_, clock.now_ns());
  } while (rest_until(context.release_ns));
  driver_->safe_state();
}

bool ThreadedDriver::rest_until(core::TimeNs at_ns) {
  std::unique_lock lock(mutex_);
  const core::TimeNs left = std::max<core::TimeNs>(at_ns - core::MonotonicClock().now_ns(), 0);
  return !changed_.wait_for(lock, std::chrono::nanoseconds(left), [this] { return stop_; });
}

// RT:
void ThreadedDriver::task_stopped(std::uint32_t task) noexcept {
  stopped_tasks_.fetch_or(std::uint64_t{1} << std::min(task, kLastBit), std::memory_order_relaxed);
}

void ThreadedDriver::tell_to_end() noexcept {
  const std::scoped_lock lock(mutex_);
  stop_ = true;
  changed_.notify_all();
}

/// The thread does it when it ends: other drivers do not wait here for a device that takes its time.
void ThreadedDriver::safe_state() noexcept {
  if (!thread_.joinable()) return driver_->safe_state();
  tell_to_end();
}

bool ThreadedDriver::drive_safe() noexcept { return driver_->drive_safe(); }

void ThreadedDriver::close() noexcept {
  tell_to_end();
  thread_.join();
  driver_->close();
}

}  // namespace plc::io
