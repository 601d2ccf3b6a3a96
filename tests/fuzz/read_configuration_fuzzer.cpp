// io::read_configuration on arbitrary bytes: it must end, report, and hand out only what it documents.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "io-drivers/config/configuration.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  core::Diagnostics diagnostics;
  const auto configuration =
      io::read_configuration({reinterpret_cast<const char*>(data), size}, "plc.toml", diagnostics);
  for (const core::Diagnostic& diagnostic : diagnostics.all()) static_cast<void>(diagnostics.render_one(diagnostic));
  require(configuration.has_value() != diagnostics.has_errors());
  if (!configuration) return 0;
  const auto check_channel = [&](const io::ChannelConfig& channel) {
    const io::DriverConfig* driver = configuration->driver(channel.driver.text);
    require(driver != nullptr && !channel.variable.text.empty() && channel.variable.at.line > 0);
    require(driver->kind != io::DriverKind::kGpio || (!channel.channel.text.empty() && !driver->chip.text.empty()));
    require(channel.bias <= io::Bias::kPullDown && channel.drive <= io::Drive::kOpenSource);
    require(channel.latch <= io::Latch::kFalling);
  };
  for (const io::ChannelConfig& channel : configuration->inputs) check_channel(channel);
  for (const io::ChannelConfig& channel : configuration->outputs) check_channel(channel);
  for (const io::DriverConfig& driver : configuration->drivers) require(!driver.name.empty() && driver.retry_ns > 0);
  const io::ModbusConfig& modbus = configuration->modbus;
  require(modbus.max_clients > 0 && modbus.max_clients_per_address <= modbus.max_clients);
  require(!modbus.enabled || !modbus.address.empty());
  for (const io::ModbusRange& range : modbus.ranges) {
    require(range.first <= range.last && range.table <= io::ModbusTable::kHoldingRegisters);
  }
  require(configuration->guardian.hang_timeout_ns >= 0);
  return 0;
}
