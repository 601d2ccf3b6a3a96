#include "io-drivers/config/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <unordered_map>

#include "core/text.h"

namespace plc::io {
namespace {

/// "gpiochip0" and "/dev/gpiochip0", 17 and "017" are the same line.
std::string line_of(const DriverConfig& driver, const ChannelConfig& channel) {
  std::string_view chip = core::trimmed(driver.chip.text);
  if (chip.starts_with("/dev/")) chip.remove_prefix(5);
  std::string_view line = core::trimmed(channel.channel.text);
  if (line.find_first_not_of("0123456789") == std::string_view::npos) {
    while (line.size() > 1 && line.front() == '0') line.remove_prefix(1);
  }
  return fmt::format("line {} of {}", line, chip);
}

}  // namespace

bool before(const core::SourceRef& a, const core::SourceRef& b) {
  return a.line != b.line ? a.line < b.line : a.column < b.column;
}

void Findings::add(core::Code code, const core::SourceRef& at, std::string message, std::string help) {
  // A file of nothing but mistakes has some 10^6 of them.
  constexpr std::size_t kMost = 10'000;
  if (found_.size() < kMost) found_.push_back({code, at, std::move(message), std::move(help)});
}

void Findings::report(core::Diagnostics& diagnostics) {
  std::stable_sort(found_.begin(), found_.end(), [](const Finding& a, const Finding& b) { return before(a.at, b.at); });
  for (Finding& one : found_) diagnostics.report(one.code, one.at, {}, std::move(one.message), std::move(one.help));
}

void check_double_use(const Configuration& configuration, Findings& findings) {
  std::vector<const ChannelConfig*> channels;
  for (const ChannelConfig& channel : configuration.inputs) channels.push_back(&channel);
  for (const ChannelConfig& channel : configuration.outputs) channels.push_back(&channel);
  std::sort(channels.begin(), channels.end(),
            [](const auto* a, const auto* b) { return before(a->variable.at, b->variable.at); });
  std::map<std::string_view, const DriverConfig*> drivers;
  for (const DriverConfig& driver : configuration.drivers) drivers[driver.name] = &driver;
  std::unordered_map<std::string_view, const ChannelConfig*, core::NameHash, core::NameEqual> variables;
  std::map<std::string, const ChannelConfig*> lines;
  for (const ChannelConfig* channel : channels) {
    const auto [first, fresh] = variables.emplace(channel->variable.text, channel);
    if (!fresh) {
      findings.add(core::Code::P7309, channel->variable.at,
                   fmt::format("\"{}\" is configured twice, first at line {}", channel->variable.text,
                               first->second->variable.at.line));
    }
    const auto driver = drivers.find(channel->driver.text);
    if (driver == drivers.end() || driver->second->kind != DriverKind::kGpio) continue;
    if (channel->channel.text.empty() || driver->second->chip.text.empty()) continue;
    const std::string line = line_of(*driver->second, *channel);
    const auto [other, free] = lines.emplace(line, channel);
    if (!free) {
      findings.add(core::Code::P7310, channel->channel.at,
                   fmt::format("{} is used already, by \"{}\" in line {}", line, other->second->variable.text,
                               other->second->variable.at.line));
    }
  }
}

}  // namespace plc::io
