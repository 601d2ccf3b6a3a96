#include "io-drivers/machine/driver_types.h"

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

}  // namespace plc::io
