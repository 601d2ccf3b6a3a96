#include "io-drivers/config/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <unordered_map>

#include "core/text.h"
#include "io-drivers/config/driver_type.h"

namespace plc::io {

bool before(const core::SourceRef& a, const core::SourceRef& b) {
  return a.line != b.line ? a.line < b.line : a.column < b.column;
}

void Findings::add(core::Code code, const core::SourceRef& at, std::string message, std::string help) {
  // A file of nothing but mistakes has some 10^6 of them.
  constexpr std::size_t kMost = 10'000;
  // Helps repeat what the file says, and a terminal would obey it.
  std::ranges::replace_if(
      help, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  if (found_.size() < kMost) found_.push_back({code, at, std::move(message), std::move(help)});
}

void Findings::report(core::Diagnostics& diagnostics) {
  std::ranges::stable_sort(found_, before, &Finding::at);
  for (Finding& one : found_) diagnostics.report(one.code, one.at, {}, std::move(one.message), std::move(one.help));
}

void check_channels(const Configuration& configuration, Findings& findings) {
  std::vector<const ChannelConfig*> channels;
  for (const ChannelConfig& channel : configuration.inputs) channels.push_back(&channel);
  for (const ChannelConfig& channel : configuration.outputs) channels.push_back(&channel);
  std::ranges::sort(channels, before, [](const ChannelConfig* channel) { return channel->variable.at; });
  struct Used {
    const DriverConfig* driver = nullptr;
    std::vector<const ChannelConfig*> channels;
  };
  std::map<std::string_view, Used> drivers;
  for (const DriverConfig& driver : configuration.drivers) {
    if (driver.type != nullptr) drivers[driver.name].driver = &driver;
  }
  std::unordered_map<std::string_view, const ChannelConfig*, core::NameHash, core::NameEqual> variables;
  std::map<std::string, const ChannelConfig*> names;
  for (const ChannelConfig* channel : channels) {
    const auto [first, fresh] = variables.emplace(channel->variable.text, channel);
    if (!fresh) {
      findings.add(core::Code::P7309, channel->variable.at,
                   fmt::format("\"{}\" is configured twice, first at line {}", channel->variable.text,
                               first->second->variable.at.line));
    }
    const auto used = drivers.find(channel->driver.text);
    if (used == drivers.end()) continue;
    used->second.channels.push_back(channel);
    const DriverConfig& driver = *used->second.driver;
    const std::string name = driver.type->channel_name == nullptr ? "" : driver.type->channel_name(driver, *channel);
    if (name.empty()) continue;
    const auto [other, free] = names.emplace(name, channel);
    if (!free) {
      findings.add(core::Code::P7310, channel->values.place("channel", channel->variable.at),
                   fmt::format("{} is used already, by \"{}\" in line {}", name, other->second->variable.text,
                               other->second->variable.at.line));
    }
  }
  for (const auto& [name, used] : drivers) {
    if (used.driver->type->check != nullptr) used.driver->type->check(*used.driver, used.channels, findings);
  }
}

}  // namespace plc::io
