// Driver: what moves values between a device and the global table.
//
// In: the exchange points of a task's cycle (runtime/sched/cycle_listener.h). Out: global variables and device outputs.
// A driver declares how long its calls may take. Threads: exchange points run on the task's thread.
// Does not belong here: the mapping of addresses to devices (plc.toml, tools).
#pragma once

#include <string_view>

#include "runtime/sched/cycle_listener.h"

namespace plc::io {

/// How a driver keeps the cycle bounded.
enum class Timing : std::uint8_t {
  kBounded,   ///< works in the cycle, with a listed, bounded system call at most
  kThreaded,  ///< works on a thread of its own; the exchange points only copy
  kOffline,   ///< simulation only: files, allocation
};

class Driver : public runtime::CycleListener {
 public:
  [[nodiscard]] virtual std::string_view name() const = 0;
  [[nodiscard]] virtual Timing timing() const = 0;
};

}  // namespace plc::io
