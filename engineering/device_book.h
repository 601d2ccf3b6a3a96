// DeviceBook: how the devices of a plant are, as its main thread noted it last.
//
// In: what the drivers and servers say. Out: copies of it for calls. Threads: any. Does not belong here: drivers.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace plc::engineering {

struct DeviceState {
  std::string name;
  std::string state;    ///< "good", "lost", "simulated"
  std::string problem;  ///< why it is lost, or empty
  std::uint64_t inputs = 0, inputs_good = 0;
  bool outputs = false;
  std::uint64_t losses = 0, recoveries = 0, exchanges = 0;
  std::int64_t oldest_ns = 0;  ///< age of the input that was read the longest time ago
};

struct ModbusState {
  std::string line;  ///< "TCP", "serial"
  std::uint32_t clients = 0;
  std::uint64_t requests = 0, exceptions = 0, refused = 0, dropped = 0;
};

struct Devices {
  std::vector<DeviceState> drivers;
  std::vector<ModbusState> modbus;
};

class DeviceBook {
 public:
  void put(Devices devices) {
    const std::lock_guard lock(mutex_);
    devices_ = std::move(devices);
  }
  [[nodiscard]] Devices get() const {
    const std::lock_guard lock(mutex_);
    return devices_;
  }

 private:
  mutable std::mutex mutex_;
  Devices devices_;
};

}  // namespace plc::engineering
