// Server: HTTP/1.1 and WebSockets for the dispatcher, on one I/O thread (Boost.Beast), away from the tasks.
//
// In: an address, a dispatcher, limits. Out: answers to any number of clients up to the limit. What takes long runs on
// further threads: one for passwords, one for files, one for the past, one for images that are looked at. Loopback
// alone is served without TLS. Slow, half-open and silent clients lose their connection; where all places are taken,
// one that has not logged in gives way, and where all have, one of the user who has most. Threads: start() and stop()
// belong to one owner; statistics any. Does not belong here: what calls do, who may call.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.h"
#include "engineering/certificate.h"
#include "engineering/dispatch.h"

namespace plc::engineering {

struct ServerOptions {
  std::string address = "127.0.0.1";  ///< IPv4 or IPv6 literal
  std::uint16_t port = 8061;          ///< 0 = any free one
  std::uint32_t max_clients = 128;
  std::int64_t request_timeout_ms = 10'000;  ///< for the rest of a request that has begun, and for handshakes
  std::int64_t idle_timeout_ms = 75'000;     ///< between two requests
  std::optional<Certificate> certificate;    ///< with it: TLS
};

struct ServerStatistics {
  std::uint64_t accepted = 0;
  std::uint64_t refused = 0;  ///< connections for which there was no place
  std::uint64_t requests = 0;
  std::uint64_t dropped = 0;  ///< connections closed for a time-out or because they gave way
  std::uint64_t frames = 0;   ///< sent by streams
  std::uint32_t clients = 0;  ///< connected now
};

class Server {
 public:
  /// The dispatcher must outlive it.
  Server(Dispatcher& dispatcher, ServerOptions options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Binds, listens and starts the threads. P7700 when the address cannot be had: it may be tried again. P7703 when
  /// OpenSSL refuses the certificate.
  std::optional<core::Problem> start();
  /// Closes all connections and joins. start() may follow.
  void stop();
  /// The port listened on, also when 0 was asked for.
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] ServerStatistics statistics() const;
  /// Runs on the thread for files, which start() has made. False when too much waits.
  bool post_file_work(std::function<void()> work);
  /// The same on the thread for the past.
  bool post_past_work(std::function<void()> work);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether the address is this machine alone.
bool is_loopback(const std::string& address);

}  // namespace plc::engineering
