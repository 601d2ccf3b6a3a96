#include "runtime/sched/realtime.h"

#include <pthread.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>

#include "core/floating_point.h"
#include "runtime/sched/priority.h"
#include "runtime/sched/thread_settings.h"
#include "runtime/sched/watchdog.h"

namespace plc::runtime {
namespace {

/// From the moment at which every thread is ready to the first release.
constexpr core::TimeNs kStartDelayNs = 10'000'000;
/// How often the threads and their owner look for each other until then.
constexpr core::TimeNs kStartPollNs = 1'000'000;
/// How long a task may be deaf to request_stop() while it waits for its next release.
constexpr core::TimeNs kStopPollNs = 100'000'000;
/// After a request to stop, until scans are cut short.
constexpr core::TimeNs kCutAfterNs = 300'000'000;
constexpr core::TimeNs kJoinPollNs = 1'000'000;
/// More than the deepest nesting of calls and a library kernel take.
constexpr std::size_t kStackPrefault = 512 * 1024;

/// What a processor copies at least, of bytes that another one has just written: no more is copied ahead than fits into
/// the time that is left.
constexpr std::size_t kBytesPerNs = 1;

std::string error_text(int error) { return std::system_category().message(error); }

/// Tells the processor that this thread waits awake, so that it saves power and leaves more to its sibling.
void relax_cpu() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Touches the stack below here, so that no cycle meets a page for the first time.
[[gnu::noinline]] void prefault_stack() {
  volatile unsigned char pages[kStackPrefault];
  for (std::size_t i = 0; i < sizeof pages; i += 4096) pages[i] = 0;
}

}  // namespace

RealtimeScheduler::RealtimeScheduler(Resource& resource, RealtimeOptions options)
    : resource_(resource),
      options_(std::move(options)),
      calendar_(options_.calendar != nullptr ? *options_.calendar : machine_calendar_) {
  if (options_.plan.empty()) options_.plan = default_plan(resource.image());
  for (std::uint32_t i = 0; i < resource.task_count(); ++i) {
    runs_.push_back(std::make_unique<TaskRun>());
    runs_.back()->index = i;
    runs_.back()->plan = options_.plan[i];
  }
  for (const SafeValue& safe : options_.safe_values) {
    for (const std::uint32_t task : resource.globals().exporters(resource.globals().field_of(safe.offset))) {
      runs_[task]->safe.push_back({safe.offset, safe.type, safe.value.data(), nullptr});
    }
  }
}

RealtimeScheduler::~RealtimeScheduler() {
  request_stop();
  // WHY: a task that still runs uses this object and the resource, and threads cannot be killed.
  if (!join().empty()) std::_Exit(EXIT_FAILURE);
}

std::optional<core::Problem> RealtimeScheduler::cannot_raise() const {
  if (resource_.image().options.coherence != core::Coherence::kPriorityCeiling || !options_.realtime_priority)
    return {};
  int error = 0;
  std::thread([&error] { error = set_fifo(pthread_self(), kHighestPriority); }).join();
  if (error == 0) return {};
  return core::Problem{
      core::Code::P7604,
      "--coherence=priority-ceiling keeps tasks apart by their priorities, and the system gives none (" +
          error_text(error) + ")",
      "run as root or with LimitRTPRIO=99, or compile with --coherence=wait-free"};
}

const RealtimeReport& RealtimeScheduler::start() {
  if (started_) return report_;
  report_.problem = cannot_raise();
  if (report_.problem) return report_;
  started_ = true;
  if (options_.lock_memory) {
    report_.memory_locked = mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    if (!report_.memory_locked) {
      report_.refused.push_back("memory is not locked (" + error_text(errno) + "): a page fault may delay a cycle");
    }
  }
  report_.realtime_priority = options_.realtime_priority && !runs_.empty();
  if (const int error = report_.realtime_priority ? awake_.request() : 0; error != 0) {
    report_.refused.push_back("idle processors may sleep deeply (" + error_text(error) +
                              "): waking up may delay a cycle");
  }
  for (const auto& run : runs_) {
    if (options_.realtime_priority) resource_.program(run->index).set_priority_change(set_own_priority);
  }
  for (auto& run_ptr : runs_) {
    TaskRun& task = *run_ptr;
    task.thread = std::thread([this, &task] {
      run(task);
      task.ended.store(true, std::memory_order_release);
    });
    set_cpu(task);
    set_priority(task);
  }
  // WHY wait: mapping and locking a stack may take longer than any fixed delay, and the first cycle would be late.
  while (ready_.load(std::memory_order_acquire) < runs_.size() && !stop_requested()) {
    clock_.sleep_until_ns(clock_.now_ns() + kStartPollNs);
  }
  // After the threads, whose handles it uses.
  std::vector<TaskRun*> watched;
  for (const auto& run : runs_) {
    if (run->plan.watchdog_ns > 0) watched.push_back(run.get());
  }
  if (!watched.empty()) {
    // Publishing safe values under priority ceilings is a copy among those of the tasks' processor.
    const bool ceilings = resource_.image().options.coherence == core::Coherence::kPriorityCeiling;
    watchdog_ = std::make_unique<Watchdog>(std::move(watched), ceilings ? runs_.front()->plan.cpu : -1,
                                           [this](TaskRun& run) { on_timeout(run); });
    std::string refused = watchdog_->start(options_.realtime_priority);
    if (!refused.empty()) report_.refused.push_back(std::move(refused));
  }
  start_ns_.store(clock_.now_ns() + kStartDelayNs, std::memory_order_release);
  return report_;
}

void RealtimeScheduler::set_priority(TaskRun& task) {
  if (!options_.realtime_priority) return;
  const int error = set_fifo(task.thread.native_handle(), fifo_priority(task.plan.priority));
  task.realtime = error == 0;
  if (task.realtime) return;
  report_.realtime_priority = false;
  report_.refused.push_back("task \"" + resource_.program(task.index).task().name +
                            "\" runs without real-time priority (" + error_text(error) + "): other load may delay it");
}

void RealtimeScheduler::set_cpu(TaskRun& task) {
  if (task.plan.cpu < 0) return;
  const int error = bind_to_cpu(task.thread.native_handle(), task.plan.cpu);
  if (error == 0) return;
  report_.refused.push_back("task \"" + resource_.program(task.index).task().name + "\" is not bound to CPU " +
                            std::to_string(task.plan.cpu) + " (" + error_text(error) + ")");
}

// RT: everything from the first release on.
void RealtimeScheduler::run(TaskRun& task) noexcept {
  const bytecode::ImageTask& declared = resource_.program(task.index).task();
  const std::optional<std::uint32_t> trigger = trigger_of(resource_.image(), declared);
  const bool freewheeling = !trigger && declared.period_ns <= 0;
  bool trigger_was = false;
  std::uint64_t cycle = 0;
  prefault_stack();
  core::set_floating_point_mode();
  if (options_.on_thread_start != nullptr) options_.on_thread_start(task.index);
  ready_.fetch_add(1, std::memory_order_release);
  while (start_ns_.load(std::memory_order_acquire) == 0) {
    if (stop_requested()) return;
    clock_.sleep_until_ns(clock_.now_ns() + kStartPollNs);
  }
  ReleaseGrid grid(start_ns_.load(std::memory_order_relaxed) + task.plan.offset_ns, grid_period(declared));
  // Who runs at an ordinary priority would only be in the way of others while it waits awake.
  const core::TimeNs lead_ns = task.realtime ? lead_of(declared, task.plan) : 0;
  for (;;) {
    const core::TimeNs release_ns = grid.next_ns();
    core::TimeNs now_ns = sleep_until_ns(release_ns - lead_ns);
    if (now_ns < release_ns && !stop_requested()) now_ns = expect(task, now_ns, release_ns);
    if (stop_requested()) return;
    bool released = true;
    if (trigger) {
      const bool level = resource_.program(task.index).read_global_bool(*trigger);
      released = level && !trigger_was;
      trigger_was = level;
    }
    const ReleaseContext context{task.index, cycle, now_ns, release_ns, calendar_.utc_ns()};
    bool go_on = true;
    if (released) {
      ++cycle;
      task.statistics.latency.record(now_ns - release_ns);
      go_on = scan(task, context);
    }
    core::TimeNs end_ns = clock_.now_ns();
    if (released) {
      task.statistics.scan_time.record(end_ns - now_ns);
      task.statistics.response.record(end_ns - release_ns);
      // After all that the scan is for.
      if (resource_.program(task.index).offer_kept()) end_ns = clock_.now_ns();
    }
    // A freewheeling task has no instants to miss: it is as slow as it is.
    const std::uint64_t missed = grid.advance(end_ns);
    if (released && !freewheeling && !trigger && missed != 0) {
      task.statistics.overruns.fetch_add(1, std::memory_order_relaxed);
      task.statistics.missed.fetch_add(missed, std::memory_order_relaxed);
      if (go_on && task.plan.overrun == OverrunPolicy::kFault) {
        go_on = fault(task, context, resource_.program(task.index).place(FaultKind::kOverrun));
      }
    }
    if (!go_on) return;
  }
}

// RT: sleeps in parts, so that a stop does not have to wait for long intervals. Returns the time.
core::TimeNs RealtimeScheduler::sleep_until_ns(core::TimeNs at_ns) noexcept {
  core::TimeNs now_ns = clock_.now_ns();
  while (!stop_requested() && now_ns < at_ns) {
    clock_.sleep_until_ns(std::min(at_ns, now_ns + kStopPollNs));
    now_ns = clock_.now_ns();
  }
  return now_ns;
}

// RT: waits awake for the release, with all in the caches that can be had ahead. Returns the time.
core::TimeNs RealtimeScheduler::expect(TaskRun& task, core::TimeNs now_ns, core::TimeNs release_ns) noexcept {
  regain_priority(task);
  resource_.program(task.index).expect(static_cast<std::size_t>(release_ns - now_ns) * kBytesPerNs);
  now_ns = clock_.now_ns();
  while (!stop_requested() && now_ns < release_ns) {
    relax_cpu();
    now_ns = clock_.now_ns();
  }
  return now_ns;
}

// RT: what the watchdog took from a scan that has ended since.
void RealtimeScheduler::regain_priority(TaskRun& task) noexcept {
  if (!task.demoted.load(std::memory_order_acquire)) return;
  task.demoted.store(false, std::memory_order_relaxed);
  if (options_.realtime_priority) static_cast<void>(set_fifo(pthread_self(), fifo_priority(task.plan.priority)));
}

// RT:
core::TimeNs RealtimeScheduler::program_ns(core::TimeNs now_ns) const noexcept {
  if (!options_.program_time_ns) return now_ns;
  const core::TimeNs start_ns = start_ns_.load(std::memory_order_relaxed);
  // 0: it stands until the common start.
  return *options_.program_time_ns + (start_ns == 0 ? 0 : now_ns - start_ns);
}

// RT:
CycleContext RealtimeScheduler::program_time(const ReleaseContext& context) const noexcept {
  const core::TimeNs start_ns = start_ns_.load(std::memory_order_relaxed);
  return {program_ns(context.now_ns), program_ns(start_ns), context.utc_ns};
}

// RT: false when the task must not be released again.
bool RealtimeScheduler::scan(TaskRun& task, const ReleaseContext& context) noexcept {
  Program& program = resource_.program(task.index);
  regain_priority(task);
  task.cycle.store(context.cycle, std::memory_order_relaxed);
  task.busy_since.store(context.now_ns, std::memory_order_relaxed);
  for (CycleListener* const listener : listeners_) listener->before_scan(context);
  resource_.process_image().sync();
  const Fault found = program.execute(program_time(context));
  task.statistics.scans.fetch_add(1, std::memory_order_relaxed);
  // Revoked: the watchdog has done all that is to do, and the outputs are no longer this thread's.
  if (found.kind == FaultKind::kWatchdog) return false;
  resource_.process_image().sync();
  for (CycleListener* const listener : listeners_) listener->after_scan(context);
  const bool timed_out = task.busy_since.exchange(TaskRun::kIdle, std::memory_order_relaxed) == TaskRun::kTimedOut;
  if (found && task.cut.load(std::memory_order_relaxed)) return false;
  if (found && !fault(task, context, found)) return false;
  // The watchdog was too late to take the outputs: this scan was about to be over.
  if (!timed_out || task.plan.on_fault == FaultPolicy::kContinue) return true;
  stop_task(task);
  return false;
}

// RT: false when the task must not be released again.
bool RealtimeScheduler::fault(TaskRun& task, const ReleaseContext& context, const Fault& fault) noexcept {
  task.statistics.faults.fetch_add(1, std::memory_order_relaxed);
  task.faults.record({task.index, context.cycle, context.now_ns, fault});
  if (task.plan.on_fault == FaultPolicy::kContinue) return true;
  stop_task(task);
  return false;
}

// RT: by the task's thread between scans, or by the watchdog that revoked it.
void RealtimeScheduler::stop_task(TaskRun& task) noexcept {
  resource_.program(task.index).publish_safe(task.safe);
  resource_.globals().task_stopped(task.index);
  for (CycleListener* const listener : listeners_) listener->task_stopped(task.index);
  if (task.plan.on_fault == FaultPolicy::kStop) request_stop();
}

// RT: on the watchdog's thread. The task is in the scan that was too long until it sees kTimedOut.
void RealtimeScheduler::on_timeout(TaskRun& task) noexcept {
  Program& program = resource_.program(task.index);
  task.statistics.faults.fetch_add(1, std::memory_order_relaxed);
  task.timeouts.record(
      {task.index, task.cycle.load(std::memory_order_relaxed), clock_.now_ns(), program.place(FaultKind::kWatchdog)});
  static_cast<void>(set_ordinary(task.thread.native_handle()));
  // After the demotion: the task takes its priority back when it sees this.
  task.demoted.store(true, std::memory_order_release);
  if (task.plan.on_fault == FaultPolicy::kContinue || !program.revoke()) return;
  stop_task(task);
  program.cut_loops();
  if (resource_.image().options.coherence == core::Coherence::kPriorityCeiling && options_.realtime_priority) {
    // publish_safe() took a task's.
    static_cast<void>(set_fifo(pthread_self(), kWatchdogPriority));
  }
}

std::vector<std::uint32_t> RealtimeScheduler::join() {
  if (!started_ || joined_) return stuck_;
  joined_ = true;
  const core::TimeNs begin_ns = clock_.now_ns();
  for (const auto& task : runs_) {
    for (core::TimeNs now_ns = begin_ns; !task->ended.load(std::memory_order_acquire); now_ns = clock_.now_ns()) {
      if (stop_requested() && now_ns - begin_ns > kCutAfterNs) {
        task->cut.store(true, std::memory_order_relaxed);
        resource_.program(task->index).cut_loops();
      }
      if (stop_requested() && now_ns - begin_ns > kStopPatienceNs) break;
      clock_.sleep_until_ns(now_ns + kJoinPollNs);
    }
  }
  // Before the threads, whose handles it uses.
  watchdog_.reset();
  for (const auto& task : runs_) {
    if (task->ended.load(std::memory_order_acquire)) {
      task->thread.join();
      continue;
    }
    stuck_.push_back(task->index);
    // Whatever it does from now on has no effect on the table.
    static_cast<void>(resource_.program(task->index).revoke());
    task->thread.detach();
  }
  for (CycleListener* const listener : listeners_) listener->safe_state();
  return stuck_;
}

std::vector<TaskFault> RealtimeScheduler::faults() const {
  std::vector<TaskFault> all;
  for (const auto& task : runs_) {
    task->faults.append_to(all);
    task->timeouts.append_to(all);
  }
  return all;
}

std::vector<TaskFault> RealtimeScheduler::new_faults() {
  std::vector<TaskFault> all;
  for (const auto& task : runs_) {
    task->faults_taken = task->faults.append_to(all, task->faults_taken);
    task->timeouts_taken = task->timeouts.append_to(all, task->timeouts_taken);
  }
  return all;
}

}  // namespace plc::runtime
