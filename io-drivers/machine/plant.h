// Plant: the life of a project that runs, from devices that are taken to devices that are given back.
//
// In: a loaded resource, its machine (machine.h), what its threads are to do. Out: tasks that run between start() and
// stop(). Life: prepare() -> start() -> run() -> stop(); after a problem only the destructor. Threads: the owner's, but
// for request_stop(). Does not belong here: what is printed on the way, signals.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/machine/machine.h"
#include "runtime/sched/realtime.h"

namespace plc::io {

class Plant {
 public:
  /// `resource` must outlive the plant; its taskblocks are not started. Safe values are those of the machine.
  Plant(runtime::Resource& resource, std::unique_ptr<Machine> machine, runtime::RealtimeOptions realtime);
  ~Plant();
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  /// Takes the devices, makes the taskblocks and starts the server. `in_child` is called in the process that goes on,
  /// which may be another one than before (Machine::open()), ahead of any thread. Listeners may be added after this.
  std::optional<core::Problem> prepare(const std::function<void()>& in_child, std::vector<Sentence>& notes);
  /// Starts the tasks. A problem: the devices are given back.
  std::optional<core::Problem> start();
  /// Until a stop is requested or `duration_ns` has passed (0 = for ever). Calls `often` every 20 ms and `say`
  /// with what changed at devices.
  void run(core::TimeNs duration_ns, const std::function<void(core::TimeNs now_ns)>& often,
           const std::function<void(const Sentence&)>& say);
  /// Tasks end, outputs go into their safe state, devices are given back. The tasks that do not end: the process must
  /// end without destroying what they use.
  std::vector<std::uint32_t> stop();
  /// Async-signal-safe.
  void request_stop() noexcept { scheduler_->request_stop(); }

  /// From prepare() on.
  [[nodiscard]] runtime::RealtimeScheduler& scheduler() { return *scheduler_; }
  [[nodiscard]] const runtime::RealtimeScheduler& scheduler() const { return *scheduler_; }
  [[nodiscard]] Machine& machine() { return *machine_; }
  /// When start() was called.
  [[nodiscard]] core::TimeNs begin_ns() const { return begin_ns_; }

 private:
  runtime::Resource& resource_;
  std::unique_ptr<Machine> machine_;
  runtime::RealtimeOptions options_;
  std::optional<runtime::RealtimeScheduler> scheduler_;
  core::MonotonicClock clock_;
  core::TimeNs begin_ns_ = 0;
};

}  // namespace plc::io
