#include "io-drivers/machine/driver_types.h"

#include <algorithm>
#include <span>

#include "io-drivers/external/external_types.h"
#include "io-drivers/gpio/gpio_driver.h"
#include "io-drivers/modbus-client/modbus_driver.h"
#include "io-drivers/simulated/simulated_device.h"

namespace plc::io {

DriverTypes driver_types() {
  static constexpr const DriverType* kTypes[] = {
      &kGpioType,
      &kSimulatedType,
      &modbus_client::kModbusType,
  };
  return kTypes;
}

bool is_about_devices(core::Code code) {
  const auto has = [code](std::span<const core::Code> codes) {
    return std::find(codes.begin(), codes.end(), code) != codes.end();
  };
  const DriverTypes types = driver_types();
  return code == core::Code::P7410 || has(kExternalDeviceProblems) ||
         std::any_of(types.begin(), types.end(), [&](const DriverType* type) { return has(type->device_problems); });
}

std::optional<Configuration> load_configuration(const std::string& path, core::Diagnostics& diagnostics) {
  return load_configuration(path, driver_types(), diagnostics,
                            [](const Configuration& configuration, Findings& findings) {
                              return load_external_types(configuration, driver_types(), findings);
                            });
}

}  // namespace plc::io
