#include "io-drivers/machine/driver_types.h"

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

std::optional<Configuration> load_configuration(const std::string& path, core::Diagnostics& diagnostics) {
  return load_configuration(path, driver_types(), diagnostics,
                            [](const Configuration& configuration, Findings& findings) {
                              return load_external_types(configuration, driver_types(), findings);
                            });
}

}  // namespace plc::io
