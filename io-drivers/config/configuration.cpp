#include "io-drivers/config/configuration.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "core/toml_limits.h"

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
  const auto found =
      std::find_if(drivers.begin(), drivers.end(), [&](const DriverConfig& d) { return d.name == name; });
  return found == drivers.end() ? nullptr : &*found;
}

std::string Configuration::beside(const std::string& name) const {
  return name.empty() ? name : (std::filesystem::path(file).parent_path() / name).string();
}

std::optional<ListenText> parse_listen(std::string_view text) {
  if (text == "off") return ListenText{};
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return std::nullopt;
  ListenText listen;
  const std::string_view port = text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), listen.port);
  if (error != std::errc{} || end != port.data() + port.size()) return std::nullopt;
  std::string_view address = text.substr(0, colon);
  const bool six = address.starts_with('[') && address.ends_with(']');
  if (six) address = address.substr(1, address.size() - 2);
  // inet_pton() stops at a zero byte.
  if (address.find('\0') != std::string_view::npos) return std::nullopt;
  listen.address = address;
  unsigned char bytes[sizeof(in6_addr)];
  if (::inet_pton(six ? AF_INET6 : AF_INET, listen.address.c_str(), bytes) != 1) return std::nullopt;
  return listen;
}

std::string listen_text(const ListenText& listen) {
  const bool six = listen.address.find(':') != std::string::npos;
  return (six ? "[" + listen.address + "]" : listen.address) + ":" + std::to_string(listen.port);
}

std::optional<Configuration> load_configuration(const std::string& path, DriverTypes types,
                                                core::Diagnostics& diagnostics, const LoadKinds& load_kinds) {
  // A pipe or a device is not opened: that may block, or never come to an end.
  struct stat status {};
  std::ifstream in;
  if (::stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode)) in.open(path, std::ios::binary);
  if (!in.is_open()) {
    core::SourceRef at;
    at.file = diagnostics.add_file(path);
    diagnostics.report(core::Code::P7001, at, {}, "file cannot be opened for reading",
                       "plc config init writes one for a project");
    return std::nullopt;
  }
  // One byte more than may be there: read_configuration() says so.
  std::string text(std::min<std::size_t>(static_cast<std::size_t>(status.st_size), core::kMaxTomlBytes + 1), '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  return read_configuration(text, path, types, diagnostics, load_kinds);
}

}  // namespace plc::io
