// Server: Modbus/TCP on one I/O thread (Boost.Asio), away from the tasks.
//
// In: Responder, [modbus]. Out: answers to any number of clients up to the limit. A read request sees one snapshot per
// owner; a write request goes in as one batch. Rules of the wire: see docs/guides/modbus.md. Threads: start() and
// stop() belong to one owner thread; counters any thread.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/result.h"
#include "io-drivers/modbus/responder.h"

namespace plc::modbus {

struct ServerStatistics {
  std::uint64_t accepted = 0;
  std::uint64_t refused = 0;  ///< connections over the limit
  std::uint64_t requests = 0;
  std::uint64_t exceptions = 0;  ///< requests answered with one
  std::uint64_t dropped = 0;     ///< connections closed for bad framing or a time-out
  std::uint32_t clients = 0;     ///< connected now
};

class Server {
 public:
  /// Both must outlive it.
  Server(Responder& responder, const io::ModbusConfig& config);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

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
