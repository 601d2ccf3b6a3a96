// Server: Modbus/TCP on one I/O thread (Boost.Asio), away from the tasks.
//
// In: AddressMap, the global table, [modbus]. Out: functions 1-6, 15, 16, 22, 23, 43/14 for any number of clients up to
// the limit. A read request sees one snapshot per owner; a write request goes in as one batch. Rules of the wire: see
// docs/guides/modbus.md. Threads: start() and stop() belong to one owner thread; counters any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "io-drivers/modbus/address_map.h"
#include "io-drivers/modbus/coil_latch.h"
#include "runtime/memory/global_ports.h"
#include "runtime/resource.h"

namespace plc::modbus {

struct ServerStatistics {
  std::uint64_t accepted = 0;
  std::uint64_t refused = 0;  ///< connections over the limit
  std::uint64_t requests = 0;
  std::uint64_t exceptions = 0;  ///< requests answered with one
  std::uint64_t dropped = 0;     ///< connections closed for bad framing or a time-out
  std::uint32_t clients = 0;     ///< connected now
};

/// A BOOL that the server sets while clients are answered ([modbus] client_seen); claimed before the map is built, so
/// that clients cannot write it.
struct SeenFlag {
  runtime::GlobalInputs* owner = nullptr;
  std::uint32_t offset = 0;  ///< in the global table
  std::uint32_t type = 0;
};

class Server {
 public:
  /// Set-up only (it registers as a reader of the table). Map, resource, config and the owner of `seen` must outlive
  /// it.
  Server(runtime::Resource& resource, const AddressMap& map, const io::ModbusConfig& config,
         const std::optional<SeenFlag>& seen = std::nullopt);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// What the system's registers tell (system_points.h). Before start().
  void set_system(SystemSource source);
  /// How many scans tasks have made, for coils that are latched. Before start().
  void set_scans(ScanSource source);
  /// Binds, listens and starts the thread. P7510 when the address cannot be had: it may be tried again.
  std::optional<core::Problem> start();
  /// Closes all connections and joins. start() may follow.
  void stop();
  /// Connections at a time since start(): `max_clients`, or as many as the limit of descriptors allows, raised as far
  /// as this process may. Silent clients give way at this number.
  [[nodiscard]] std::uint32_t places() const;
  /// The port listened on, also when 0 was asked for.
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] ServerStatistics statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace plc::modbus
