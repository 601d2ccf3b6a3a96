// Link: one request and its answer over a TCP connection or a serial line, in bounded time.
//
// In: where the bus is, PDUs. Out: the answer's PDU, or what went wrong. Connects by itself; a connection on which
// something went wrong is closed, so that a late answer never meets the next request. Threads: one at a time. Not RT:
// waits. Does not belong here: retries, back-off (device.h), what PDUs say (frame.h).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "io-drivers/modbus-client/frame.h"
#include "io-drivers/modbus-rtu/line.h"

namespace plc::modbus_client {

using modbus_rtu::LineSettings;

struct BusAddress {
  bool serial = false;
  std::string host;  ///< IPv4 or IPv6 address, host name; or the path of the line
  std::uint16_t port = 502;
  LineSettings line;
};
/// "192.168.1.20", "192.168.1.20:1502", "[fd00::20]:502", "meter.plant:502", "/dev/ttyUSB0"; nothing when it is none of
/// these.
std::optional<BusAddress> parse_bus(std::string_view text);
/// The same for all texts that mean the same.
std::string bus_name(const BusAddress& bus);

class Link {
 public:
  virtual ~Link() = default;
  /// Asks `unit`, and waits for the answer at most `timeout_ns` from when the request is sent; for the connection as
  /// long again. `answer` is a PDU when there is no error: an exception is one.
  virtual Error exchange(std::uint8_t unit, std::span<const std::uint8_t> pdu, core::TimeNs timeout_ns,
                         Bytes& answer) = 0;
  /// Why the last exchange failed, in words of the system ("Connection refused"), or empty.
  [[nodiscard]] virtual std::string_view reason() const { return {}; }
  /// No exchange waits beyond this instant any more, one that has begun neither. Any thread.
  void end_by(core::TimeNs at_ns) { end_by_ns_.store(at_ns, std::memory_order_relaxed); }
  /// An exchange took so long and was answered, which puts off the end: many that answer do not run out of time.
  void answered_in(core::TimeNs took_ns) {
    core::TimeNs end = end_by_ns_.load(std::memory_order_relaxed);
    // One that was set meanwhile holds.
    if (end != kNoEnd) end_by_ns_.compare_exchange_strong(end, end + took_ns, std::memory_order_relaxed);
  }

 protected:
  /// The deadline, or the end where that is earlier.
  [[nodiscard]] core::TimeNs until(core::TimeNs deadline_ns) const {
    return std::min(deadline_ns, end_by_ns_.load(std::memory_order_relaxed));
  }

 private:
  static constexpr core::TimeNs kNoEnd = std::numeric_limits<core::TimeNs>::max();
  std::atomic<core::TimeNs> end_by_ns_{kNoEnd};
};

/// Touches nothing until the first exchange.
std::unique_ptr<Link> make_link(const BusAddress& bus);

/// exchange(), and what the answer says.
Error ask(Link& link, std::uint8_t unit, std::span<const std::uint8_t> pdu, core::TimeNs timeout_ns, Cells& cells);

}  // namespace plc::modbus_client
