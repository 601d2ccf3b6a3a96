#include "runtime/sched/realtime.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <system_error>


namespace plc::runtime {
namespace {

/// Between start() and the first release, so that no thread is late for it.
constexpr core::TimeNs kStartDelayNs = 10'000'000;
/// How long a task may be deaf to request_stop() while it waits for its next release.
constexpr core::TimeNs kStopPollNs = 100'000'000;
/// More than the deepest nesting of calls and a library kernel take.
constexpr std::size_t kStackPrefault = 512 * 1024;

std::string error_text(int error) { return std::system_category().message(error); }

/// Touches the stack below here, so that no cycle meets a page for the first time.
[[gnu::noinline]] void prefault_stack() {
  volatile unsigned char pages[kStackPrefault];
  for (std::size_t i = 0; i < sizeof pages; i += 4096) pages[i] = 0;
}

}  // namespace

RealtimeScheduler::RealtimeScheduler(Resource& resource, RealtimeOptions options)
    : resource_(resource), options_(std::move(options)) {
  for (std::uint32_t i = 0; i < resource.task_count(); ++i) {
    runs_.push_back(std::make_unique<TaskRun>());
    runs_.back()->index = i;
  }
}

RealtimeScheduler::~RealtimeScheduler() {
  request_stop();
  join();
}

const RealtimeReport& RealtimeScheduler::start() {
  if (started_) return report_;
  started_ = true;
  if (options_.lock_memory) {
    report_.memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    if (!report_.memory_locked) {
      report_.refused.push_back("memory is not locked (" + error_text(errno) + "): a page fault may delay a cycle");
    }
  }
  report_.realtime_priority = options_.realtime_priority && !runs_.empty();
  const core::TimeNs start_ns = clock_.now_ns() + kStartDelayNs;
  for (auto& run_ptr : runs_) {
    TaskRun& task = *run_ptr;
    task.thread = std::thread([this, &task, start_ns] { run(task, start_ns); });
    set_cpu(task);
    set_priority(task);
  }
  return report_;
}

void RealtimeScheduler::set_priority(TaskRun& task) {
  if (!options_.realtime_priority) return;
  const std::int32_t iec = std::max(resource_.program(task.index).task().priority, 0);
  sched_param parameter{};
  parameter.sched_priority = std::max(kHighestPriority - std::min(iec, kHighestPriority), 1);
  const int error = pthread_setschedparam(task.thread.native_handle(), SCHED_FIFO, &parameter);
  if (error == 0) return;
  report_.realtime_priority = false;
  report_.refused.push_back("task \"" + resource_.program(task.index).task().name +
                            "\" runs without real-time priority (" + error_text(error) + "): other load may delay it");
}

void RealtimeScheduler::set_cpu(TaskRun& task) {
  if (task.index >= options_.cpus.size() || options_.cpus[task.index] < 0) return;
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET(static_cast<unsigned>(options_.cpus[task.index]), &set);
  const int error = pthread_setaffinity_np(task.thread.native_handle(), sizeof set, &set);
  if (error == 0) return;
  report_.refused.push_back("task \"" + resource_.program(task.index).task().name + "\" is not bound to CPU " +
                            std::to_string(options_.cpus[task.index]) + " (" + error_text(error) + ")");
}

// RT: everything from the first release on.
void RealtimeScheduler::run(TaskRun& task, core::TimeNs start_ns) noexcept {
  const bytecode::ImageTask& declared = resource_.program(task.index).task();
  const std::optional<std::uint32_t> trigger = trigger_of(resource_.image(), declared);
  const bool freewheeling = !trigger && declared.period_ns <= 0;
  ReleaseGrid grid(start_ns, grid_period(declared));
  bool trigger_was = false;
  std::uint64_t cycle = 0;
  prefault_stack();
  if (options_.on_thread_start != nullptr) options_.on_thread_start(task.index);
  for (;;) {
    const core::TimeNs release_ns = grid.next_ns();
    // Long periods are slept in parts, so that a stop does not have to wait for them.
    core::TimeNs now_ns = clock_.now_ns();
    while (!stop_requested() && now_ns < release_ns) {
      clock_.sleep_until_ns(std::min(release_ns, now_ns + kStopPollNs));
      now_ns = clock_.now_ns();
    }
    if (stop_requested()) return;
    bool released = true;
    if (trigger) {
      const bool level = resource_.program(task.index).read_global_bool(*trigger);
      released = level && !trigger_was;
      trigger_was = level;
    }
    bool go_on = true;
    if (released) {
      task.statistics.jitter.record(now_ns - release_ns);
      go_on = scan(task, {task.index, cycle++, now_ns, release_ns});
    }
    const core::TimeNs end_ns = clock_.now_ns();
    if (released) task.statistics.scan_time.record(end_ns - now_ns);
    // A freewheeling task has no instants to miss: it is as slow as it is.
    const std::uint64_t missed = grid.advance(end_ns);
    if (released && !freewheeling && !trigger && missed != 0) {
      task.statistics.overruns.fetch_add(1, std::memory_order_relaxed);
      task.statistics.missed.fetch_add(missed, std::memory_order_relaxed);
    }
    if (!go_on) return;
  }
}

// RT: false when the task must not be released again.
bool RealtimeScheduler::scan(TaskRun& task, const ReleaseContext& context) noexcept {
  for (CycleListener* const listener : listeners_) listener->before_scan(context);
  resource_.process_image().sync();
  const Fault fault = resource_.program(task.index).execute({context.now_ns});
  resource_.process_image().sync();
  for (CycleListener* const listener : listeners_) listener->after_scan(context);
  task.statistics.scans.fetch_add(1, std::memory_order_relaxed);
  if (!fault) return true;
  task.statistics.faults.fetch_add(1, std::memory_order_relaxed);
  const std::uint32_t kept = task.fault_count.load(std::memory_order_relaxed);
  if (kept < kMaxFaultsKept) {
    task.faults[kept] = {task.index, context.cycle, context.now_ns, fault};
    task.fault_count.store(kept + 1, std::memory_order_release);
  }
  if (options_.on_fault == FaultPolicy::kContinue) return true;
  if (options_.on_fault == FaultPolicy::kStop) request_stop();
  resource_.globals().task_stopped(context.task);
  for (CycleListener* const listener : listeners_) listener->task_stopped(context.task);
  return false;
}

void RealtimeScheduler::join() {
  if (!started_ || joined_) return;
  joined_ = true;
  for (auto& task : runs_) {
    if (task->thread.joinable()) task->thread.join();
  }
  for (CycleListener* const listener : listeners_) listener->safe_state();
}

std::vector<TaskFault> RealtimeScheduler::faults() const {
  std::vector<TaskFault> all;
  for (const auto& task : runs_) {
    const std::uint32_t count = task->fault_count.load(std::memory_order_acquire);
    all.insert(all.end(), task->faults, task->faults + count);
  }
  return all;
}

}  // namespace plc::runtime
