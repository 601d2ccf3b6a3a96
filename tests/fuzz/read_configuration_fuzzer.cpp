// io::read_configuration on arbitrary bytes: it must end, report, and hand out only what it documents.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "io-drivers/config/configuration.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/machine/driver_types.h"

namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace plc;
  core::Diagnostics diagnostics;
  const auto configuration =
      io::read_configuration({reinterpret_cast<const char*>(data), size}, "plc.toml", io::driver_types(), diagnostics);
  for (const core::Diagnostic& diagnostic : diagnostics.all()) static_cast<void>(diagnostics.render_one(diagnostic));
  require(configuration.has_value() != diagnostics.has_errors());
  if (!configuration) return 0;
  // The kinds read what they like, and find what they require.
  const auto check_values = [](const io::KeyValues& values, std::span<const io::KeyInfo> keys) {
    for (const io::KeyInfo& key : keys) {
      require(key.fallback.kind != io::KeyDefault::Kind::kRequired || !values.text(key.name).empty());
      if (key.type.kind == io::KeyKind::kInteger && values.has(key.name)) {
        require(values.number(key.name) >= key.type.low && values.number(key.name) <= key.type.high);
      }
      if (key.type.kind == io::KeyKind::kChoice) {
        require(io::choice_index(key.type, values.text(key.name)) == values.number(key.name));
      }
    }
  };
  const auto check_channel = [&](const io::ChannelConfig& channel) {
    const io::DriverConfig* driver = configuration->driver(channel.driver.text);
    require(driver != nullptr && !channel.variable.text.empty() && channel.variable.at.line > 0);
    check_values(channel.values, driver->type->channel_keys);
  };
  for (const io::ChannelConfig& channel : configuration->inputs) check_channel(channel);
  for (const io::ChannelConfig& channel : configuration->outputs) check_channel(channel);
  for (const io::DriverConfig& driver : configuration->drivers) {
    require(!driver.name.empty() && driver.retry_ns > 0 && driver.type != nullptr);
    check_values(driver.values, driver.type->driver_keys);
  }
  const io::ModbusConfig& modbus = configuration->modbus;
  require(modbus.max_clients > 0 && modbus.max_clients_per_address <= modbus.max_clients);
  require(!modbus.enabled || !modbus.address.empty());
  require(!modbus.serial || (!modbus.serial->path.text.empty() && modbus.serial->unit > 0));
  for (const io::ModbusRange& range : modbus.ranges) {
    require(range.first <= range.last && range.table <= io::ModbusTable::kHoldingRegisters);
  }
  require(configuration->guardian.hang_timeout_ns >= 0);
  return 0;
}
