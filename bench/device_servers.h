// DeviceServers: Modbus devices for measurements: a process of its own with one thread, that answers each request for
// registers on each of its ports with registers that all have one value, which moves.
//
// In: how many. Out: ports on 127.0.0.1. Made before this process has threads. Does not belong here: clients.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <vector>

namespace plc::bench {

class DeviceServers {
 public:
  /// Throws when there are no ports or no process.
  explicit DeviceServers(unsigned count);
  ~DeviceServers();
  DeviceServers(const DeviceServers&) = delete;
  DeviceServers& operator=(const DeviceServers&) = delete;
  [[nodiscard]] const std::vector<std::uint16_t>& ports() const { return ports_; }

 private:
  std::vector<std::uint16_t> ports_;
  pid_t process_ = -1;
};

}  // namespace plc::bench
