#include "io-drivers/modbus-client/modbus_driver.h"

#include <utility>

namespace plc::modbus_client {

ModbusDriver::ModbusDriver(const io::BoundDriver& bound, const BusAddress& address, DeviceSettings settings,
                           Points points, std::optional<core::Problem> problem, runtime::Resource& resource)
    : task_(bound.task),
      problem_(std::move(problem)),
      device_(std::move(settings), bound.task, std::move(points.reads), std::move(points.status),
              std::move(points.writes), io::claimed_fields(bound), resource.globals()),
      bus_(Bus::of(&resource, address)) {
  bus_->add(device_);
}

ModbusDriver::~ModbusDriver() { bus_->leave(device_); }

std::optional<core::Problem> ModbusDriver::open() {
  opened_ = true;
  return std::nullopt;
}

bool ModbusDriver::drive_safe() noexcept try {
  device_.hold_all();
  if (!opened_ || !device_.has_outputs()) return true;
  if (bus_->runs()) {
    bus_->leave(device_);
    return true;
  }
  // The guardian: the thread and its connection ended with the other process.
  return bus_->write_safe(device_);
} catch (...) {
  return false;
}

void ModbusDriver::close() noexcept {
  device_.hold_all();
  bus_->leave(device_);
  opened_ = false;
}

}  // namespace plc::modbus_client
