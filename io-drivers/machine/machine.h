// Machine: what plc.toml makes of this computer for one project: drivers, Modbus server, guardian, in the order in
// which they must come and go.
//
// In: a loaded resource, a configuration (or none: Modbus on the loopback, no devices). Out: listeners for the
// scheduler, sentences for the operator. Life: configure() -> open() -> start(scheduler) -> service() .. -> stop()
// after the scheduler's join(). Threads: the owner's alone. Does not belong here: command lines, printing.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/bind.h"
#include "io-drivers/driver.h"
#include "io-drivers/guardian/guardian.h"
#include "io-drivers/modbus/address_map.h"
#include "io-drivers/modbus/serial_server.h"
#include "io-drivers/modbus/server.h"
#include "runtime/force_list.h"
#include "runtime/sched/realtime.h"

namespace plc::io {

/// A TCP socket that listens already. It stays open as long as the process.
struct OpenSocket {
  int descriptor = -1;
  ListenText at;  ///< what it is bound to
};

struct MachineOptions {
  std::string project;          ///< the project's file: the lock file of automatic addresses lies beside it
  Configuration configuration;  ///< as load_configuration() read it, or the defaults
  /// --modbus: replaces what the configuration says; an empty address is "off".
  std::optional<ListenText> modbus;
  /// A socket that somebody opened for the server, in place of what the configuration and --modbus say.
  std::optional<OpenSocket> socket = {};
  /// --simulate-io: no device is touched. Outputs go nowhere; inputs keep their initial values, and may be written by
  /// HMIs and scripts.
  bool simulate = false;
  /// False: drivers are not asked whether they could open. Another process has the devices.
  bool ask_drivers = true;
  std::function<int(int code, bool asked)> guardian_ended = {};  ///< GuardianOptions::ended
  std::string map_command = {};  ///< that lists the addresses, "plc map plant.st --lib drives.st"; empty = of `project`
};

class Machine {
 public:
  /// Binds the configuration, makes the address map and the drivers, and asks every driver whether it could
  /// open. Nothing is touched. Problems are in `diagnostics`; nothing after an error.
  static std::unique_ptr<Machine> configure(MachineOptions options, runtime::Resource& resource,
                                            core::Diagnostics& diagnostics);
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  /// A driver of the command line's own. Before open().
  std::optional<core::Problem> add(std::unique_ptr<Driver> driver);

  /// Takes the devices, then splits off the guardian when there are outputs: from here on this is the child. On a
  /// problem every device is given back as it was.
  std::optional<core::Problem> open();
  /// What is forced, to be told to clients; may be null. It must outlive the machine. Before start().
  void set_forces(const runtime::ForceList* forces) { forces_ = forces; }
  /// Adds the listeners and starts the server. An address that cannot be had is said, and tried again by service():
  /// what serves HMIs does not decide whether control starts.
  void start(runtime::RealtimeScheduler& scheduler, std::vector<Sentence>& notes);
  /// What changed at the devices and at the server since the last call. About every 100 ms.
  std::vector<Sentence> service(core::TimeNs now_ns);
  /// An orderly stop begins; before RealtimeScheduler::join().
  void stopping();
  /// Server down, devices given back in their safe state, guardian told. After join().
  void stop();

  /// What the outputs have when their task has stopped by a fault.
  [[nodiscard]] std::vector<runtime::SafeValue> safe_values() const;
  [[nodiscard]] const std::vector<std::unique_ptr<Driver>>& drivers() const { return drivers_; }
  [[nodiscard]] const modbus::AddressMap* address_map() const { return map_ ? &*map_ : nullptr; }
  /// Nothing while Modbus is off, over TCP or on the serial line.
  [[nodiscard]] std::optional<modbus::ServerStatistics> modbus_statistics() const;
  [[nodiscard]] std::optional<modbus::SerialStatistics> serial_statistics() const;
  [[nodiscard]] bool guarded() const { return pulse_ != nullptr; }

 private:
  explicit Machine(runtime::Resource& resource) : resource_(resource) {}
  void take_socket(const MachineOptions& options);
  bool make_map(const MachineOptions& options, core::Diagnostics& diagnostics);
  void listen(std::vector<Sentence>& said);
  void tell_map(std::vector<Sentence>& said) const;
  [[nodiscard]] modbus::SystemState system_state(const runtime::RealtimeScheduler& scheduler,
                                                 core::TimeNs ran_ns) const;

  runtime::Resource& resource_;
  const runtime::ForceList* forces_ = nullptr;
  std::function<int(int code, bool asked)> guardian_ended_;
  Configuration configuration_;
  Binding binding_;
  std::optional<runtime::GlobalInputs> client_seen_;
  std::optional<modbus::AddressMap> map_;
  std::vector<Sentence> notes_;  ///< of configure(), for start()
  std::string freeze_command_;   ///< empty when all automatic addresses are frozen
  std::vector<std::unique_ptr<Driver>> drivers_;
  std::optional<modbus::Responder> responder_;  ///< of both servers
  std::unique_ptr<modbus::Server> server_;
  std::unique_ptr<modbus::SerialServer> serial_server_;
  bool listening_ = false;
  std::string refusal_;  ///< why not, as it was said
  core::TimeNs next_listen_ns_ = 0;
  std::unique_ptr<Pulse> pulse_;
};

}  // namespace plc::io
