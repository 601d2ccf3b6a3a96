// The row of kind = "gpio".
#include <fmt/format.h>

#include "core/text.h"
#include "io-drivers/config/findings.h"
#include "io-drivers/gpio/gpio_driver.h"
#include "io-drivers/threaded.h"

namespace plc::io {
namespace {

constexpr KeyInfo kDriverKeys[] = {
    {"chip", key::text(), key::required("\"gpiochip0\""),
     "GPIO chip: its name, its label, or its path below /dev (`gpiodetect` lists them)."},
    {"poll", key::duration("1ms", "10s"), key::nothing("\"5ms\""),
     "The device is exchanged with on a thread of its own, this often: for slow lines, such as expanders on I2C. "
     "Omitted: in the cycle of the task. Not together with latch."},
    {"errors", key::integer(0, 10000), key::otherwise("3"),
     "Cycles in a row whose exchange with the chip may fail, although each is tried twice, before the chip counts as "
     "lost. Until then inputs and lines keep their values. A chip that is unplugged is lost at once."},
    {"wait", key::boolean(), key::otherwise("false"),
     "true: a chip that cannot be opened at the start does not keep control from starting. It is tried again every "
     "`retry`; until it is there its inputs are as on_loss says (hold: their initial values), and `ok` is FALSE."},
};
constexpr core::Code kDeviceProblems[] = {core::Code::P7401, core::Code::P7404, core::Code::P7406};
constexpr KeyType kLine = key::channel();
// The choices are in the order of the enumerators.
constexpr KeyInfo kChannelKeys[] = {
    {"channel", kLine, key::required("17"), "Number or name of the line on its chip."},
    {"active_low", key::boolean(), key::otherwise("false"),
     "The kernel inverts the line. Together with invert they cancel out."},
    {"bias", key::choice("as-is|disabled|pull-up|pull-down"), key::otherwise("\"as-is\""), "Resistor of the line."},
    {"drive", key::choice("push-pull|open-drain|open-source"), key::otherwise("\"push-pull\""),
     "How the line is driven.", kOutputsOnly},
    {"latch", key::choice("none|rising|falling"), key::otherwise("\"none\""),
     "rising: a pulse between two cycles is seen as one cycle of TRUE. falling: a gap as one cycle of FALSE.",
     kInputsOnly},
};

void check(const DriverConfig& driver, std::span<const ChannelConfig* const> channels, Findings& findings) {
  if (!driver.values.has("poll")) return;
  for (const ChannelConfig* channel : channels) {
    if (channel->values.choice<Latch>("latch") == Latch::kNone) continue;
    findings.add(core::Code::P7311, channel->values.place("latch", channel->variable.at),
                 fmt::format("driver \"{}\" has \"poll\", which does not go with \"latch\"", driver.name));
  }
}

/// "gpiochip0" and "/dev/gpiochip0", 17 and "017" are the same line.
std::string channel_name(const DriverConfig& driver, const ChannelConfig& channel) {
  const std::string& chip_text = driver.values.text("chip");
  const std::string& line_text = channel.values.text("channel");
  if (chip_text.empty() || line_text.empty()) return {};
  std::string_view chip = core::trimmed(chip_text);
  if (chip.starts_with("/dev/")) chip.remove_prefix(5);
  std::string_view line = core::trimmed(line_text);
  if (line.find_first_not_of("0123456789") == std::string_view::npos) {
    while (line.size() > 1 && line.front() == '0') line.remove_prefix(1);
  }
  return fmt::format("line {} of {}", line, chip);
}

std::string_view refuses(const KeyValues&, const bytecode::ImageType& type) {
  return is_bool(type) ? "" : "a GPIO line is a BOOL";
}

std::optional<core::Problem> check_device(const DriverConfig& driver, std::span<const ChannelConfig* const> inputs,
                                          std::span<const ChannelConfig* const> outputs) {
  LinesRequest request{.chip = driver.values.text("chip"), .inputs = {}, .outputs = {}};
  for (const ChannelConfig* channel : inputs) {
    request.inputs.push_back({.line = channel->values.text("channel"), .variable = channel->variable.text});
  }
  for (const ChannelConfig* channel : outputs) {
    request.outputs.push_back({.line = channel->values.text("channel"), .variable = channel->variable.text});
  }
  return kernel_gpio().check(request);
}

std::optional<std::string> example_channel(const bytecode::ImageType&, std::uint32_t& next) {
  if (next > kLine.high) return std::nullopt;
  return fmt::format("channel = {}", next++);
}

std::unique_ptr<Driver> make(const BoundDriver& bound, const Configuration&, runtime::Resource& resource) {
  auto driver = std::make_unique<GpioDriver>(bound, resource, kernel_gpio());
  if (!bound.config->values.has("poll")) return driver;
  return std::make_unique<ThreadedDriver>(std::move(driver), bound.config->values.number("poll"));
}

}  // namespace

constexpr DriverType kGpioType = {
    .name = "gpio",
    .summary = "digital lines of a Linux GPIO chip.",
    .example = "panel",
    .driver_keys = kDriverKeys,
    .channel_keys = kChannelKeys,
    .device_key = "chip",
    .device_problems = kDeviceProblems,
    .check = check,
    .channel_name = channel_name,
    .refuses = refuses,
    .check_device = check_device,
    .example_channel = example_channel,
    .make = make,
};

}  // namespace plc::io
