// Keeper: stores what a resource keeps while it runs, and brings it back before it runs again.
//
// In: a loaded resource, a state folder. Out: the file of retained values, what the operator should know. Life:
// restore() -> start() -> tasks run -> stop(). While they run, a thread of its own asks the tasks for their variables
// every interval and stores them when something has changed: what does not go well is said, tried again, and stops
// nothing. Threads: the owner's, but for that one. Does not belong here: command lines, the restart of tasks.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/diagnostics.h"
#include "core/result.h"
#include "retain/carry.h"
#include "retain/gather.h"
#include "retain/layout.h"
#include "retain/store.h"
#include "runtime/resource.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::retain {

struct KeeperOptions {
  std::string folder;                      ///< where the file lies; made when it is not there
  core::TimeNs interval_ns = 100'000'000;  ///< between two sets of values, at least
  What what = What::kMarked;
};

/// What restore() found.
struct Restored {
  bool found = false;                    ///< there is a file
  std::optional<core::Problem> problem;  ///< P7611, P7001: it cannot be used
  Carried carried;
  std::uint64_t sequence = 0;
  std::int64_t time_of_day_ns = 0;  ///< when it was stored
  /// What the clock of the programs is to show at the first release, so that timers go on where they were.
  std::optional<core::TimeNs> program_time_ns;
};

/// What the operator is told while the plant runs.
struct Message {
  std::string text;
  core::Severity severity = core::Severity::kNote;
};

class Keeper {
 public:
  Keeper(runtime::Resource& resource, KeeperOptions options);
  ~Keeper();
  Keeper(const Keeper&) = delete;
  Keeper& operator=(const Keeper&) = delete;

  /// Nothing is declared as retained: nothing will be stored.
  [[nodiscard]] bool empty() const { return kept_.layout.roots.empty(); }
  [[nodiscard]] const Layout& layout() const { return kept_.layout; }
  [[nodiscard]] std::string path() const { return store_.path(); }

  /// Stored values into the resource. Once, before its taskblocks start and anything runs.
  Restored restore(Start start);
  /// Starts the thread. After the process has split off others.
  void start();
  /// After the tasks have ended, but for `running`: stores what the last scans have left.
  void stop(std::span<const std::uint32_t> running = {});
  /// What went wrong, or well again, since the last call: sentences. Any thread.
  std::vector<Message> messages();

  // The steps of the thread, for who has none.
  void ask() noexcept { gatherer_.ask(); }
  [[nodiscard]] bool answered() const noexcept { return gatherer_.answered(); }
  /// Stores what was answered, if it differs from what is stored. `now_ns`: of a monotonic clock, for how often is said
  /// and tried what fails.
  void store(core::TimeNs now_ns);

 private:
  void run();
  void say(Message message);
  /// Waits; true when it is to end.
  bool wait(core::TimeNs ns);

  runtime::Resource& resource_;
  KeeperOptions options_;
  Kept kept_;
  Gatherer gatherer_;
  Store store_;
  std::vector<std::byte> values_;  ///< gathered
  std::vector<std::byte> stored_;  ///< on the disk
  bool any_stored_ = false;
  core::TimeNs program_time_ns_ = 0;
  bool failing_ = false;
  bool told_ = false;  ///< of the present trouble
  std::optional<core::TimeNs> said_ns_;
  core::TimeNs retry_ns_ = 0;

  std::mutex mutex_;  ///< of what follows; no task takes it
  std::condition_variable changed_;
  bool ending_ = false;
  std::vector<Message> messages_;
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::retain
