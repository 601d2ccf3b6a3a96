// Service: tells systemd that the plant runs, that its tasks do, and that it ends (sd_notify(3)); takes the socket that
// systemd opened for it (sd_listen_fds(3)).
//
// In: NOTIFY_SOCKET and WATCHDOG_USEC, which systemd sets for a service of Type=notify with WatchdogSec; LISTEN_FDS,
// for one with a socket unit. Without them nothing is told or taken. With a guardian, the runtime is not the service's
// main process: such a unit needs NotifyAccess=all. Thread: the owner's; nothing here waits for a task, or for long for
// a service manager that does not listen. Does not belong here: units (packaging/).
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bytecode/image.h"
#include "core/clock.h"
#include "io-drivers/machine/machine.h"
#include "runtime/sched/realtime.h"

namespace plc::tools {

/// What systemd opened for this process.
struct PassedSockets {
  std::optional<io::OpenSocket> modbus;  ///< the first one that listens for TCP
  std::vector<std::string> unused;       ///< what is left, a sentence each
  int count = 0;                         ///< all, from SD_LISTEN_FDS_START on
};
/// Before a process is started or split: it takes the sockets out of the environment, and no other program gets them.
PassedSockets take_passed_sockets();

class Service {
 public:
  /// `scheduler` must outlive it. `now_ns`: monotonic.
  Service(const bytecode::Image& image, const runtime::RealtimeScheduler& scheduler, core::TimeNs now_ns);

  /// The tasks run. `status` is what `systemctl status` shows, one line. Told again by service() until it is heard.
  void ready(const std::string& status);
  /// About every 20 ms. Feeds the watchdog four times in its time, for as long as no task hangs.
  void service(core::TimeNs now_ns);
  /// The same while no task is to run.
  void rests(core::TimeNs now_ns);
  /// An orderly stop begins.
  static void stopping();
  /// Feeds the watchdog, whatever the tasks do. Any thread.
  static void alive();
  /// How often that is to be done; 0: there is no watchdog.
  static std::chrono::milliseconds alive_every();

  /// Whether every task that has an interval and goes on after its faults has ended a scan lately: within the
  /// watchdog's time, or two of its intervals where that is longer.
  [[nodiscard]] bool tasks_run(core::TimeNs now_ns);

 private:
  struct Seen {
    std::uint32_t task = 0;
    core::TimeNs patience_ns = 0;
    std::uint64_t scans = 0;
    core::TimeNs at_ns = 0;  ///< when `scans` changed
  };

  const runtime::RealtimeScheduler& scheduler_;
  core::TimeNs watchdog_ns_ = 0;  ///< 0 = none
  core::TimeNs next_ns_ = 0;
  core::TimeNs tell_ns_ = 0;  ///< when `unheard_` is told again
  std::string unheard_;       ///< what ready() could not say
  std::vector<Seen> tasks_;
};

}  // namespace plc::tools
