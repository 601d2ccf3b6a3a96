// Driver: what moves values between a device and the global table.
//
// In: the channels a configuration binds to it, the exchange points of a task's cycle (runtime/sched/cycle_listener.h).
// Out: inputs published as one snapshot (runtime::GlobalInputs), device outputs. A bounded driver works on the thread
// of the task it is attached to: before_scan() reads the device, after_scan() writes it. A threaded one has a thread of
// its own and meets the tasks in the global table only. Life: make -> check() -> open() -> [fork: the guardian keeps a
// copy] -> start() -> exchange points and service() -> safe_state() -> close(). Does not belong here: the mapping of
// addresses to channels (config/), what a task is.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/result.h"
#include "runtime/sched/cycle_listener.h"

namespace plc::io {

/// How a driver keeps the cycle bounded.
enum class Timing : std::uint8_t {
  kBounded,   ///< works in the cycle, with a listed, bounded number of system calls
  kThreaded,  ///< works on a thread of its own (threaded.h); the exchange points do nothing
  kOffline,   ///< simulation and demonstration only: allocation in the cycle
};

/// What an input's present value is worth.
enum class Quality : std::uint8_t {
  kNever,  ///< not read yet: the initial value
  kGood,   ///< read at the last exchange
  kLost,   ///< the device is gone; the value is what `on_loss` says
};
/// "never", "good", "lost".
std::string_view quality_word(Quality quality);

/// What the operator is told while the plant runs.
struct Sentence {
  std::string text;
  core::Severity severity = core::Severity::kWarning;
  std::string source{};  ///< who says it: "modbus"; of a driver it is its name
};

struct InputStatus {
  std::string_view variable;
  Quality quality = Quality::kNever;
  core::TimeNs age_ns = 0;  ///< since the value was last read from the device; 0 when never
};

/// Of a variable that was read last at `read_at_ns`, negative = never, from a device that is there or not.
InputStatus input_status(std::string_view variable, core::TimeNs read_at_ns, bool connected, core::TimeNs now_ns);

struct DriverStatus {
  bool connected = false;
  std::uint64_t losses = 0;      ///< times the device went away since open()
  std::uint64_t recoveries = 0;  ///< times it came back
  std::uint64_t exchanges = 0;   ///< device reads and writes that succeeded
  std::string problem;           ///< why it is not connected, or empty
};

class Driver : public runtime::CycleListener {
 public:
  /// As in plc.toml: "panel".
  [[nodiscard]] virtual std::string_view name() const = 0;
  [[nodiscard]] virtual Timing timing() const = 0;
  /// The task whose cycle it serves, index into Image::tasks; bounded drivers ignore the calls of others.
  [[nodiscard]] virtual std::uint32_t task() const = 0;

  /// Everything open() can find out without touching the device: names, lines in use. All drivers are asked before the
  /// first is opened, so that a mistake in one leaves the outputs of the others alone.
  virtual std::optional<core::Problem> check() { return std::nullopt; }
  /// Takes the device: outputs to their initial values, first read of the inputs. On a problem (P74xx) nothing was
  /// touched, or what was is as before. Before any task runs; never twice.
  virtual std::optional<core::Problem> open() = 0;
  /// From here on the process is the one that runs the tasks: threads may be made. Before any task runs.
  virtual void start() {}
  /// What cannot be done in a cycle: notices loss, tries to come back. Called about every 100 ms from a thread that is
  /// not a task's. Returns sentences for the operator: what changed since the last call ("panel: gpiochip0 is gone:
  /// ...").
  virtual std::vector<Sentence> service(core::TimeNs now_ns) = 0;
  /// Any thread.
  [[nodiscard]] virtual DriverStatus status() const = 0;
  [[nodiscard]] virtual std::vector<InputStatus> inputs(core::TimeNs now_ns) const = 0;

  /// Drives the declared safe values, with whatever still works; also called by the guardian, in another process than
  /// the one that ran, when that one died (docs/adr/0014). True when every output is known to have its safe value. Not
  /// RT.
  virtual bool drive_safe() noexcept = 0;
  /// Guardian only, a few times a second: lets go of a handle whose device is gone. WHY: the kernel gives the name of a
  /// device to the next one only when the last process has let go (Linux 6.1 not even then).
  virtual void release_if_gone() noexcept {}
  /// True when it drives outputs that a guardian must outlive.
  [[nodiscard]] virtual bool has_outputs() const = 0;
  /// Gives the device back, outputs in their safe state.
  virtual void close() noexcept = 0;
};

/// For the end: calls `what` for each driver. Those that work in a cycle come first, one after the other; then all
/// others at once, since a device that is silent takes seconds, and the next one must not wait for it.
void for_all_at_once(std::span<Driver* const> drivers, const std::function<void(Driver&)>& what);

}  // namespace plc::io
