// Resolver: the addresses of a host name. The resolver of the C library waits for as long as it likes, so it is asked
// on a thread of its own, which nobody waits for longer than they want.
//
// In: a name. Out: addresses, or why there are none. Threads: one at a time. Does not belong here: connections.
#pragma once

#include <sys/socket.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"

namespace plc::modbus_client {

struct SocketAddress {
  sockaddr_storage bytes = {};
  socklen_t size = 0;
};
/// "192.168.1.20", "fd00::20".
std::string text_of(const SocketAddress& address);
/// Why this machine cannot send anything there ("Network is unreachable"); empty when it can. Sends nothing.
std::string why_no_way(const SocketAddress& address);

class Resolver {
 public:
  Resolver(std::string host, std::uint16_t port);

  /// Asks, and waits at most until `deadline_ns`. When there is no answer, or none in time, what the last good one
  /// said; an answer that comes late is that of the next call. Empty: reason() says why.
  const std::vector<SocketAddress>& resolve(core::TimeNs deadline_ns);
  /// What resolve() gave last.
  [[nodiscard]] const std::vector<SocketAddress>& known() const { return known_; }
  /// The last resolve() had no answer in time: the next one may have it.
  [[nodiscard]] bool waits() const { return waits_; }
  /// In words of the system: "Name or service not known".
  [[nodiscard]] std::string_view reason() const { return reason_; }

 private:
  struct State;
  static std::vector<SocketAddress> ask(const State& state, int flags, std::string& reason);

  std::shared_ptr<State> state_;  ///< the thread's, too
  bool is_address_ = false;       ///< nobody has to be asked
  bool waits_ = false;
  std::vector<SocketAddress> known_;
  std::string reason_;
};

}  // namespace plc::modbus_client
