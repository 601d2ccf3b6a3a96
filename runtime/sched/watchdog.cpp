#include "runtime/sched/watchdog.h"

#include <pthread.h>

#include <algorithm>
#include <future>
#include <system_error>
#include <utility>

#include "runtime/sched/priority.h"
#include "runtime/sched/thread_settings.h"

namespace plc::runtime {
namespace {

/// How long it may be deaf to its end.
constexpr core::TimeNs kStopPollNs = 50'000'000;

}  // namespace

Watchdog::Watchdog(std::vector<TaskRun*> watched, int cpu, OnTimeout on_timeout)
    : watched_(std::move(watched)), cpu_(cpu), on_timeout_(std::move(on_timeout)) {}

Watchdog::~Watchdog() {
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) thread_.join();
}

std::string Watchdog::start(bool realtime) {
  // WHY by the thread itself, before it sleeps: with PREEMPT_RT the timer of a sleep that began at an ordinary priority
  // is left to a thread of low priority, which a task that spins on the same processor keeps from running.
  std::promise<int> settled;
  std::future<int> settling = settled.get_future();
  thread_ = std::thread([this, realtime, settled = std::move(settled)]() mutable {
    if (cpu_ >= 0) static_cast<void>(bind_to_cpu(pthread_self(), cpu_));
    settled.set_value(realtime ? set_fifo(pthread_self(), kWatchdogPriority) : 0);
    run();
  });
  const int error = settling.get();
  if (error == 0) return {};
  return "the watchdog runs without real-time priority (" + std::system_category().message(error) +
         "): tasks that keep a processor busy may keep it from acting";
}

// RT:
void Watchdog::run() noexcept {
  pthread_setname_np(pthread_self(), "plc-watchdog");
  while (!stop_.load(std::memory_order_relaxed)) {
    const core::TimeNs now_ns = clock_.now_ns();
    core::TimeNs wake_ns = now_ns + kStopPollNs;
    for (TaskRun* const run : watched_) {
      core::TimeNs since = run->busy_since.load(std::memory_order_relaxed);
      const core::TimeNs limit = run->plan.watchdog_ns;
      // A scan that begins after this look cannot be too long before the whole time has passed.
      core::TimeNs due = now_ns + limit;
      if (since > TaskRun::kIdle && now_ns - since < limit) {
        due = since + limit;
      } else if (since > TaskRun::kIdle &&
                 run->busy_since.compare_exchange_strong(since, TaskRun::kTimedOut, std::memory_order_relaxed)) {
        on_timeout_(*run);
      }
      wake_ns = std::min(wake_ns, due);
    }
    clock_.sleep_until_ns(wake_ns);
  }
}

}  // namespace plc::runtime
