// ModbusLoad: many clients that ask as fast as they are answered, one request under way each, on one thread with epoll.
//
// In: a port of 127.0.0.1, requests to take in turn. Out: how many were answered, and which of them wrongly. Cheap, so
// that what is measured is the server, and the same for every server. Does not belong here: what a right answer is.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"

namespace plc::bench {

struct LoadResult {
  std::uint64_t answers = 0;
  std::uint64_t errors = 0;      ///< connections lost, wrong frames, exceptions
  std::uint64_t mismatches = 0;  ///< answers whose registers the check refused
  double seconds = 0;
  std::string problem;  ///< the first error
  [[nodiscard]] double rate() const { return seconds > 0 ? static_cast<double>(answers) / seconds : 0; }
};

/// Function 3: `count` registers from `first` on.
struct RegisterRead {
  std::uint16_t first = 0;
  std::uint16_t count = 125;
};
/// Whether the registers of an answer (high byte first) are right for the request.
using RegisterCheck = std::function<bool(const RegisterRead&, std::span<const std::uint8_t>)>;

LoadResult modbus_load(std::uint16_t port, unsigned connections, double seconds, std::span<const RegisterRead> reads,
                       const RegisterCheck& check);

}  // namespace plc::bench
