// Devices: those of plc.toml, and what else the machine has.
#include <fmt/format.h>

#include <algorithm>

#include "core/text.h"
#include "doctor/check.h"
#include "io-drivers/config/driver_type.h"

namespace plc::doctor {
namespace {

struct Device {
  std::string_view user;  ///< name of the driver, or "[modbus.serial]"
  std::string node;       ///< "/dev/gpiochip0"
  bool named = false;     ///< by its path; else by a name that is also one of a node
};

/// Of drivers with a real device that is a node below /dev, and of the Modbus server.
std::vector<Device> nodes(const Context& c) {
  std::vector<Device> devices;
  for (const io::DriverConfig& driver : c.subject.configuration.drivers) {
    if (!driver.type->real || driver.type->device_key.empty()) continue;
    const std::string text(core::trimmed(driver.values.text(driver.type->device_key)));
    if (text.starts_with("/dev/")) {
      devices.push_back({driver.name, text, true});
    } else if (!text.empty() && text.find('/') == std::string::npos && c.system.facts("/dev/" + text)) {
      devices.push_back({driver.name, "/dev/" + text, false});
    }
  }
  if (const auto& serial = c.subject.configuration.modbus.serial) {
    devices.push_back({"[modbus.serial]", serial->path.text, true});
  }
  return devices;
}

/// "dialout", or the number where no name is known.
std::string group_name(const Context& c, std::uint32_t group) {
  const std::string text = c.system.read("/etc/group").value_or("");
  for (const std::string_view line : lines_of(text)) {
    const std::size_t name = line.find(':');
    const std::size_t password = name == std::string_view::npos ? name : line.find(':', name + 1);
    if (password == std::string_view::npos) continue;
    const std::string_view number = line.substr(password + 1, line.find(':', password + 1) - password - 1);
    if (to_number(number) == group) return std::string(line.substr(0, name));
  }
  return std::to_string(group);
}

/// What gives the process a file of `facts`.
std::string rights_help(const Context& c, const FileFacts& facts) {
  if ((facts.mode >> 3 & 6) == 6 && facts.group != 0) {
    const std::string group = group_name(c, facts.group);
    return fmt::format(
        "join its group: SupplementaryGroups={0} in the service, `usermod -aG {0} USER`, and log in again", group);
  }
  return "a rule of udev gives it to a group: GROUP=\"plc\", MODE=\"0660\" in /etc/udev/rules.d";
}

}  // namespace

Outcome check_device_nodes(const Context& c) {
  const auto devices = nodes(c);
  Outcome outcome = fine(devices.empty() ? "plc.toml names none" : "all there");
  for (const Device& device : devices) {
    if (c.system.facts(device.node)) continue;
    outcome.found.push_back(
        {fmt::format("{}: {} is not there", device.user, device.node),
         "is it connected, and its driver loaded (`dmesg`)? Names below /dev/serial/by-id do not change with "
         "the order of devices",
         {},
         {}});
  }
  return outcome;
}

Outcome check_device_rights(const Context& c) {
  const auto devices = nodes(c);
  Outcome outcome = fine(devices.empty() ? "plc.toml names none" : "all may be opened");
  for (const Device& device : devices) {
    const auto facts = c.system.facts(device.node);
    if (!facts || c.process.may(6, *facts)) continue;
    outcome.found.push_back(
        {fmt::format("{}: user {} may not open {}, which is for user {} and group {} (mode {:04o})", device.user,
                     c.process.user(), device.node, facts->owner, group_name(c, facts->group), facts->mode & 07777),
         rights_help(c, *facts),
         {},
         {}});
  }
  return outcome;
}

Outcome check_drivers(const Context& c) {
  if (!c.system.calls().devices) return unknown("needs the machine itself");
  const io::Configuration& configuration = c.subject.configuration;
  Outcome outcome = fine(configuration.drivers.empty() ? "plc.toml has none" : "");
  for (const io::DriverConfig& driver : configuration.drivers) {
    std::vector<const io::ChannelConfig*> sides[2];
    const std::vector<io::ChannelConfig>* const all[] = {&configuration.inputs, &configuration.outputs};
    for (std::size_t side = 0; side < 2; ++side) {
      for (const io::ChannelConfig& channel : *all[side]) {
        if (channel.driver.text == driver.name) sides[side].push_back(&channel);
      }
    }
    const auto problem =
        driver.type->check_device == nullptr ? std::nullopt : driver.type->check_device(driver, sides[0], sides[1]);
    if (problem) {
      outcome.found.push_back({driver.name + ": " + problem->message, problem->help, problem->code, {}});
    } else {
      outcome.seen += fmt::format("{}{}: {}", outcome.seen.empty() ? "" : ", ", driver.name,
                                  fmt::format("{} inputs, {} outputs", sides[0].size(), sides[1].size()));
    }
  }
  return outcome;
}

Outcome check_other_devices(const Context& c) {
  std::vector<std::string> closed, all;
  FileFacts first;
  const auto used = nodes(c);
  for (const std::string& name : c.system.list("/dev")) {
    const bool kind = name.starts_with("gpiochip") || name.starts_with("ttyUSB") || name.starts_with("ttyACM") ||
                      name.starts_with("ttyAMA");
    const std::string node = "/dev/" + name;
    const bool known = std::any_of(used.begin(), used.end(), [&](const Device& device) { return device.node == node; });
    const auto facts = kind && !known ? c.system.facts(node) : std::nullopt;
    if (!facts) continue;
    all.push_back(node);
    if (c.process.may(6, *facts)) continue;
    if (closed.empty()) first = *facts;
    closed.push_back(node);
  }
  if (closed.empty()) return fine(all.empty() ? "no GPIO chips, no serial devices" : joined(all));
  return wrong(fmt::format("user {} may not open {}", c.process.user(), joined(closed)), rights_help(c, first));
}

}  // namespace plc::doctor
