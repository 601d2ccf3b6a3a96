#include "io-drivers/config/configuration.h"

#include <algorithm>

namespace plc::io {

std::string_view word_order_text(WordOrder order) {
  constexpr std::string_view kTexts[] = {"ABCD", "CDAB", "BADC", "DCBA"};
  return kTexts[static_cast<std::size_t>(order)];
}

std::string_view modbus_table_text(ModbusTable table) {
  constexpr std::string_view kTexts[] = {"coils", "discrete-inputs", "input-registers", "holding-registers"};
  return kTexts[static_cast<std::size_t>(table)];
}

const DriverConfig* Configuration::driver(std::string_view name) const {
  const auto found = std::find_if(drivers.begin(), drivers.end(), [&](const DriverConfig& d) { return d.name == name; });
  return found == drivers.end() ? nullptr : &*found;
}

}  // namespace plc::io
