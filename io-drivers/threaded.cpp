#include "io-drivers/threaded.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/clock.h"

namespace plc::io {
namespace {

constexpr std::uint32_t kLastBit = 63;

}  // namespace

ThreadedDriver::ThreadedDriver(std::unique_ptr<Driver> driver, core::TimeNs poll_ns)
    : driver_(std::move(driver)), poll_ns_(poll_ns) {}

ThreadedDriver::~ThreadedDriver() { stop(); }

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
  while (!stop_.load(std::memory_order_relaxed)) {
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
    clock.sleep_until_ns(context.release_ns);
  }
}

// RT:
void ThreadedDriver::task_stopped(std::uint32_t task) noexcept {
  stopped_tasks_.fetch_or(std::uint64_t{1} << std::min(task, kLastBit), std::memory_order_relaxed);
}

void ThreadedDriver::stop() noexcept {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void ThreadedDriver::safe_state() noexcept {
  stop();
  driver_->safe_state();
}

bool ThreadedDriver::drive_safe() noexcept { return driver_->drive_safe(); }

void ThreadedDriver::close() noexcept {
  stop();
  driver_->close();
}

}  // namespace plc::io
