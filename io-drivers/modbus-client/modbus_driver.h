// ModbusDriver: a Modbus device as io::Driver: kind = "modbus" in plc.toml.
//
// In: a BoundDriver, whose channels become points. Out: a device on its bus, which other drivers share when they name
// the same address. Threaded: the bus has a thread, tasks meet it in the global table only; in the cycle one flag is
// set. Does not belong here: requests (device.h), the thread (bus.h), keys (modbus_type.cpp).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/driver_type.h"
#include "io-drivers/modbus-client/bus.h"

namespace plc::modbus_client {

/// What the channels of a bound driver are.
struct Points {
  std::vector<ReadPoint> reads;
  std::vector<StatusPoint> status;
  std::vector<WritePoint> writes;
};

/// What plc.toml says of a driver whose keys were found good.
BusAddress address_of(const io::DriverConfig& driver);
DeviceSettings settings_of(const io::DriverConfig& driver);
Points points_of(const io::BoundDriver& bound, runtime::Resource& resource);

class ModbusDriver final : public io::Driver {
 public:
  /// Claims its inputs in the resource's global table: before any task runs. `problem`: what check() says.
  ModbusDriver(const io::BoundDriver& bound, const BusAddress& address, DeviceSettings settings, Points points,
               std::optional<core::Problem> problem, runtime::Resource& resource);
  ~ModbusDriver() override;

  [[nodiscard]] std::string_view name() const override { return device_.settings().name; }
  [[nodiscard]] io::Timing timing() const override { return io::Timing::kThreaded; }
  [[nodiscard]] std::uint32_t task() const override { return task_; }
  [[nodiscard]] bool has_outputs() const override { return device_.has_outputs(); }
  std::optional<core::Problem> check() override { return problem_; }
  /// Touches nothing: a device that does not answer yet stops no plant, and is tried for from start() on.
  std::optional<core::Problem> open() override;
  void start() override { bus_->start(); }
  std::vector<io::Sentence> service(core::TimeNs now_ns) override { return device_.take_said(now_ns); }
  [[nodiscard]] io::DriverStatus status() const override { return device_.status(); }
  [[nodiscard]] std::vector<io::InputStatus> inputs(core::TimeNs now_ns) const override {
    return device_.inputs(now_ns);
  }
  bool drive_safe() noexcept override;
  void close() noexcept override;

  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext& context) noexcept override { device_.scanned(context.task); }
  void safe_state() noexcept override { device_.hold_all(); }
  void task_stopped(std::uint32_t task) noexcept override { device_.task_stopped(task); }

 private:
  std::uint32_t task_;
  std::optional<core::Problem> problem_;
  Device device_;
  std::shared_ptr<Bus> bus_;
  bool opened_ = false;
};

/// kind = "modbus" (modbus_type.cpp).
extern const io::DriverType kModbusType;

}  // namespace plc::modbus_client
