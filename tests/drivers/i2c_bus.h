// What an I2C bus of a test has on it: a file that the test and the simulated bus share.
#pragma once

#include <cstdint>

namespace plc::test {

inline constexpr const char* kBusVariable = "PLC_TEST_I2C_BUS";  ///< environment: the file
inline constexpr const char* kBusDevice = "/dev/i2c-77";

/// An ADS1115 at 16#49.
struct I2cBus {
  std::int32_t there = 1;      ///< 0: nobody acknowledges
  std::int16_t volts[4] = {};  ///< AIN0..3 against ground, as the chip converts them at 4.096 V
  std::uint16_t config = 0x8583;
  std::uint16_t conversion = 0;
  std::int32_t transfers = 0;
};

}  // namespace plc::test
