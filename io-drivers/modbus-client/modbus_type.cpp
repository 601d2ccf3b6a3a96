// The row of kind = "modbus".
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <map>
#include <utility>

#include "core/text.h"
#include "io-drivers/config/findings.h"
#include "io-drivers/modbus-client/modbus_driver.h"
#include "io-drivers/modbus-client/resolver.h"
#include "runtime/value_text.h"

namespace plc::modbus_client {
namespace {

using core::Code;
using io::BoundChannel;
using io::BoundDriver;
using io::ChannelConfig;
using io::Configuration;
using io::DriverConfig;
using io::Findings;
using io::KeyInfo;
using io::KeyValues;
namespace key = io::key;

/// For a name, while somebody waits for the doctor.
constexpr core::TimeNs kResolveNs = 3'000'000'000;

constexpr std::string_view kOrders = "ABCD|CDAB|BADC|DCBA";
constexpr KeyInfo kDriverKeys[] = {
    {"bus", key::text(), key::required("\"192.168.1.20:502\""),
     "IP address or host name, and port, of the device or its gateway (without a port 502), or the path of a serial "
     "line: \"/dev/ttyUSB0\". Drivers with the same bus share it, and one thread."},
    {"line", key::text(), key::otherwise("\"19200 8E1\""),
     "Serial line: its speed, data bits (8), parity (N, E or O) and stop bits. The same for all drivers on the line."},
    {"unit", key::integer(0, 255), key::otherwise("1"), "Unit identifier; 1 to 247 on a serial line."},
    {"poll", key::duration("1ms", "1h"), key::otherwise("\"100ms\""),
     "How often inputs are read that say nothing else."},
    {"write", key::duration("1ms", "1h"), key::otherwise("\"10ms\""),
     "How often outputs are compared; those that changed are written at once."},
    {"rewrite", key::duration("0s", "1h"), key::otherwise("\"1s\""),
     "Outputs that did not change are written again after this time. 0s: never."},
    {"timeout", key::duration("1ms", "1min"), key::otherwise("\"500ms\""),
     "Time for the whole answer, from when the request is sent; for a connection as long again."},
    {"retries", key::integer(0, 10), key::otherwise("2"),
     "Times that a request without a good answer is repeated before the device counts as lost."},
    {"retry_max", key::duration("10ms", "1d"), key::otherwise("\"30s\""),
     "Longest time between attempts to get a lost device back: after each, the time (`retry`) is twice as long."},
    {"gap", key::integer(0, 124), key::otherwise("8"),
     "Registers between two values that are read along, to save a request; of bits 16 times as many. A device that "
     "refuses is asked without."},
    {"max_registers", key::integer(1, 125), key::otherwise("125"),
     "Registers in one request; of bits 16 times as many."},
    {"word_order", key::choice(kOrders), key::otherwise("\"ABCD\""),
     "Order of bytes in values of 32 and 64 bits, as in [modbus]; of channels that say nothing else."},
    {"multiple", key::boolean(), key::otherwise("false"),
     "One coil or register is written with function 15 or 16, too, instead of 5 or 6."},
};
constexpr KeyInfo kChannelKeys[] = {
    {"table", key::choice("coils|discrete-inputs|input-registers|holding-registers"),
     key::nothing("\"holding-registers\""), "Which of the device's four tables. Needed but for status."},
    {"address", key::integer(0, 65535), key::nothing("100"),
     "First address, as it is sent: from 0 on (a manual's 40101 is 100). Needed but for status."},
    {"type", key::choice("INT|UINT|DINT|UDINT|LINT|ULINT|REAL|LREAL"), key::nothing("\"UINT\""),
     "What the device has in its registers. Omitted: the type of the variable, of 8 bits as of 16."},
    {"word_order", key::choice(kOrders), key::nothing("\"CDAB\""), "Omitted: as the driver says."},
    {"bit", key::integer(0, 15), key::nothing("3"),
     "BOOL in a register: which bit, 0 is the lowest. Bits of an output register without a variable are written as 0."},
    {"registers", key::integer(1, 125), key::nothing("8"),
     "A text: how many registers the device has for it, two characters in each. Omitted: for all characters of the "
     "variable."},
    {"scale", key::value(), key::otherwise("1"), "Variable = number in the device * scale + offset."},
    {"offset", key::value(), key::otherwise("0"), "See scale."},
    {"poll", key::duration("1ms", "1h"), key::nothing("\"1s\""), "How often it is read. Omitted: as the driver says.",
     io::kInputsOnly},
    {"substitute", key::value(), key::nothing("0"),
     "Value until the first answer and while the device does not give one. Omitted: as on_loss says.", io::kInputsOnly},
    {"status", key::choice("ok|age|error"), key::nothing("\"ok\""),
     "Tells about the device instead: ok (BOOL), age of the oldest input (TIME), error as a number, 0 for none.",
     io::kInputsOnly},
};

Raw raw_of(const KeyValues& channel, core::TypeId variable) {
  return channel.has("type") ? static_cast<Raw>(channel.number("type") + 1) : modbus_client::raw_of(variable);
}
bool of_bits(const KeyValues& channel) { return is_bits(channel.choice<ModbusTable>("table")); }

std::optional<double> real_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

void check_bus(const DriverConfig& driver, Findings& findings) {
  const KeyValues& values = driver.values;
  const auto bus = parse_bus(values.text("bus"));
  if (!bus && values.has("bus")) {
    findings.add(
        Code::P7305, values.place("bus", driver.at),
        fmt::format("\"{}\" is neither an IP address, a host name nor the path of a serial line", values.text("bus")),
        "write \"192.168.1.20:502\", \"[fd00::20]:502\", \"meter.plant:502\" or \"/dev/ttyUSB0\"");
  }
  if (!modbus_rtu::parse_line(values.text("line"))) {
    findings.add(Code::P7305, values.place("line", driver.at),
                 fmt::format("\"{}\" is no setting of a serial line", values.text("line")),
                 "write speed, data bits, parity and stop bits: \"19200 8E1\", \"9600 8N1\"");
  }
  if (values.has("retry_max") && values.number("retry_max") < driver.retry_ns) {
    findings.add(Code::P7311, values.place("retry_max", driver.at), "\"retry_max\" is shorter than \"retry\"");
  }
  const std::int64_t unit = values.number("unit");
  if (bus && bus->serial && (unit < 1 || unit > 247)) {
    findings.add(Code::P7305, values.place("unit", driver.at), fmt::format("unit {} is none on a serial line", unit),
                 "they go from 1 to 247");
  }
}

void check_channel(const ChannelConfig& channel, Findings& findings) {
  const KeyValues& values = channel.values;
  const core::SourceRef& at = channel.variable.at;
  if (values.has("status")) {
    for (const KeyInfo& one : kChannelKeys) {
      if (one.name == "status" || !values.has(one.name)) continue;
      findings.add(Code::P7311, values.place(one.name, at),
                   fmt::format("\"{}\" does not go with \"status\": it is not in the device", one.name));
    }
    return;
  }
  for (const std::string_view name : {"table", "address"}) {
    if (values.mentions(name) || values.mentions("status")) continue;
    findings.add(Code::P7306, at, fmt::format("\"{}\" has no \"{}\"", channel.variable.text, name),
                 name == "table" ? "add table = \"holding-registers\"" : "add address = 100");
  }
  if (!values.has("table")) return;
  const auto table = values.choice<ModbusTable>("table");
  if (channel.direction == io::kOutputsOnly && !is_writable(table)) {
    findings.add(Code::P7311, values.place("table", at),
                 fmt::format("no function of Modbus writes {}", io::modbus_table_text(table)),
                 "coils and holding-registers can be written");
  }
  for (const std::string_view name : {"type", "word_order", "bit", "registers", "scale", "offset"}) {
    if (!is_bits(table) || !values.has(name)) continue;
    findings.add(Code::P7307, values.place(name, at),
                 fmt::format("{} have no \"{}\"", io::modbus_table_text(table), name), "only registers have one");
  }
  for (const std::string_view name : {"scale", "offset"}) {
    const auto number = real_of(values.text(name));
    if (number && (name == "offset" || *number != 0)) continue;
    findings.add(Code::P7305, values.place(name, at),
                 fmt::format("\"{}\" is \"{}\"; it takes a number{}", name, values.text(name),
                             name == "scale" ? " other than 0" : ""));
  }
}

void check(const DriverConfig& driver, std::span<const ChannelConfig* const> channels, Findings& findings) {
  check_bus(driver, findings);
  for (const ChannelConfig* channel : channels) check_channel(*channel, findings);
}

std::string_view refuses_status(Status what, const bytecode::ImageType& type) {
  const bool scalar = type.kind == bytecode::TypeKind::kScalar;
  const auto is = [&](std::uint16_t categories) { return scalar && core::in_category(type.elementary, categories); };
  switch (what) {
    case Status::kOk:
      return io::is_bool(type) ? "" : "ok is a BOOL";
    case Status::kAge:
      return is(core::kAnyDuration) ? "" : "an age is a TIME";
    case Status::kError:
      // 1004 is the greatest.
      return is(core::kAnyInt | core::kAnyBit) && core::rep_bytes(core::info(type.elementary).rep) >= 2
                 ? ""
                 : "an error is a number of 16 bits or more";
  }
  return "";
}

std::uint32_t registers_of_text(const KeyValues& channel, const bytecode::ImageType& type) {
  if (channel.has("registers")) return static_cast<std::uint32_t>(channel.number("registers"));
  return type.elementary == core::TypeId::kWstring ? type.capacity : (type.capacity + 1u) / 2;
}

std::string_view refuses(const KeyValues& channel, const bytecode::ImageType& type) {
  if (channel.has("status")) return refuses_status(channel.choice<Status>("status"), type);
  if (const std::string_view why = modbus_client::refuses(type); !why.empty()) return why;
  if (channel.has("table")) {
    const bool bit = channel.has("bit");
    if (of_bits(channel) && !io::is_bool(type)) return "coils and discrete inputs are BOOLs";
    if (!of_bits(channel) && io::is_bool(type) && !bit) return "a BOOL in a register needs \"bit\"";
    if (!of_bits(channel) && !io::is_bool(type) && bit) return "\"bit\" is for a BOOL";
    if (bit && (channel.has("scale") || channel.has("offset") || registers_of(raw_of(channel, type.elementary)) > 1)) {
      return "\"bit\" is of one register, without \"scale\" and \"offset\"";
    }
  }
  const bool text = type.kind == bytecode::TypeKind::kString;
  if (!text && channel.has("registers")) return "\"registers\" is for a text";
  if (text && (channel.has("type") || channel.has("scale") || channel.has("offset"))) {
    return "a text has neither \"type\" nor \"scale\" nor \"offset\"";
  }
  if (text && registers_of_text(channel, type) > kMaxReadRegisters)
    return "a text has 125 registers at most: give \"registers\"";
  std::vector<std::byte> bytes(type.size);
  if (channel.has("substitute") && runtime::parse_value(type, channel.text("substitute"), bytes)) {
    return "of which its substitute is no value";
  }
  return "";
}

Coding coding_of(const ChannelConfig& channel, const DriverConfig& driver, const bytecode::ImageType& type) {
  const KeyValues& values = channel.values;
  Coding coding;
  coding.variable = type.elementary;
  coding.raw = raw_of(values, type.elementary);
  if (type.kind == bytecode::TypeKind::kString) coding.characters = type.capacity;
  coding.order = (values.has("word_order") ? values : driver.values).choice<io::WordOrder>("word_order");
  coding.scale = real_of(values.text("scale")).value_or(1);
  coding.offset = real_of(values.text("offset")).value_or(0);
  if (values.has("bit")) coding.bit = static_cast<int>(values.number("bit"));
  coding.invert = channel.invert;
  return coding;
}

Want want_of(const BoundChannel& bound, const DriverConfig& driver, const bytecode::Image& image) {
  const KeyValues& values = bound.config->values;
  Want want;
  want.table = values.choice<ModbusTable>("table");
  want.first = static_cast<std::uint16_t>(values.number("address"));
  const bytecode::ImageType& type = image.types[bound.type];
  if (type.kind == bytecode::TypeKind::kString) {
    want.count = static_cast<std::uint16_t>(registers_of_text(values, type));
  } else if (!is_bits(want.table) && !io::is_bool(type)) {
    want.count = registers_of(raw_of(values, type.elementary));
  }
  want.period_ns = (values.has("poll") ? values : driver.values).number("poll");
  return want;
}

/// What is written: by table, address and bit.
using Places = std::map<std::uint32_t, const BoundChannel*>;

/// A register that another driver before this one writes to the same unit. Each writes the whole of it, and what the
/// other one wrote is gone: also where they have bits of it.
std::optional<core::Problem> written_by_both(const Places& used, const DriverConfig& driver, const DriverConfig& other,
                                             const Configuration& configuration) {
  if (&driver < &other || driver.values.number("unit") != other.values.number("unit")) return std::nullopt;
  for (const ChannelConfig& output : configuration.outputs) {
    const KeyValues& values = output.values;
    if (output.driver.text != other.name || !values.has("table") || !values.has("address")) continue;
    const auto table = values.choice<ModbusTable>("table");
    const auto address = static_cast<std::uint32_t>(values.number("address"));
    const std::uint32_t place = static_cast<std::uint32_t>(table) << 16 | address;
    const auto mine = used.lower_bound(place * 16);
    if (mine == used.end() || mine->first / 16 != place) continue;
    return core::Problem{Code::P7310,
                         fmt::format("\"{}\" and \"{}\" of driver \"{}\" are both written to address {} of {}",
                                     mine->second->config->variable.text, output.variable.text, other.name, address,
                                     io::modbus_table_text(table)),
                         "both drivers are the same unit of one bus"};
  }
  return std::nullopt;
}

/// What shows when the types of the variables are known, and in what other drivers say.
std::optional<core::Problem> check_bound(const BoundDriver& bound, const Configuration& configuration,
                                         const bytecode::Image& image) {
  const DriverConfig& driver = *bound.config;
  for (const auto* channels : {&bound.inputs, &bound.outputs}) {
    for (const BoundChannel& channel : *channels) {
      const Want want = want_of(channel, driver, image);
      if (channels == &bound.outputs && want.count > kMaxWriteRegisters) {
        return core::Problem{Code::P7305,
                             fmt::format("\"{}\" takes {} registers, and a request writes 123 at most",
                                         channel.config->variable.text, want.count),
                             "give a smaller \"registers\""};
      }
      if (!is_bits(want.table) && want.count > driver.values.number("max_registers")) {
        return core::Problem{
            Code::P7305,
            fmt::format("\"{}\" takes {} registers, and \"max_registers\" is {}", channel.config->variable.text,
                        want.count, driver.values.number("max_registers")),
            "a value is read and written whole"};
      }
      if (want.first + want.count <= 65536) continue;
      return core::Problem{Code::P7305,
                           fmt::format("\"{}\" ends after the last address, 65535", channel.config->variable.text),
                           "its value takes " + std::to_string(want.count) + " registers"};
    }
  }
  Places used;
  for (const BoundChannel& output : bound.outputs) {
    const Want want = want_of(output, driver, image);
    const bool one_bit = output.config->values.has("bit");
    const auto bit = static_cast<std::uint32_t>(one_bit ? output.config->values.number("bit") : 0);
    for (std::uint32_t i = 0; i < want.count; ++i) {
      for (std::uint32_t b = bit; b < (one_bit ? bit + 1 : 16); ++b) {
        const std::uint32_t place = (static_cast<std::uint32_t>(want.table) << 16 | (want.first + i)) * 16 + b;
        const auto [other, free] = used.emplace(place, &output);
        if (free) continue;
        return core::Problem{
            Code::P7310,
            fmt::format("\"{}\" and \"{}\" are both written to address {} of {}", other->second->config->variable.text,
                        output.config->variable.text, want.first + i, io::modbus_table_text(want.table)),
            ""};
      }
    }
  }
  const auto bus = parse_bus(driver.values.text("bus"));
  const auto& server = configuration.modbus.serial;
  if (bus && bus->serial && server && server->path.text == bus->host) {
    return core::Problem{Code::P7311,
                         fmt::format("driver \"{}\" asks devices on the line {}, and [modbus.serial] answers there",
                                     driver.name, bus->host),
                         "a line has one that asks: give one of them another line"};
  }
  for (const DriverConfig& other : configuration.drivers) {
    if (other.type != driver.type || &other == &driver) continue;
    const auto its = parse_bus(other.values.text("bus"));
    if (!bus || !its || bus_name(*bus) != bus_name(*its)) continue;
    if (auto problem = written_by_both(used, driver, other, configuration)) return problem;
    if (!bus->serial) continue;
    if (modbus_rtu::parse_line(driver.values.text("line")) == modbus_rtu::parse_line(other.values.text("line")))
      continue;
    return core::Problem{
        Code::P7311,
        fmt::format("drivers \"{}\" and \"{}\" set the line {} differently: \"{}\" and \"{}\"", driver.name, other.name,
                    bus->host, driver.values.text("line"), other.values.text("line")),
        "all drivers on a line have the same \"line\""};
  }
  return std::nullopt;
}

std::optional<core::Problem> check_files(const BoundDriver& bound, const Configuration& configuration,
                                         runtime::Resource& resource) {
  return check_bound(bound, configuration, resource.image());
}

/// Of a serial line the doctor looks at the node. Of a device on the network: whether its name is known, and whether a
/// way leads to it. It is not connected to: many serve one client alone, which may be a plc-run that works.
std::optional<core::Problem> check_device(const DriverConfig& driver, std::span<const ChannelConfig* const>,
                                          std::span<const ChannelConfig* const>) {
  const auto bus = parse_bus(driver.values.text("bus"));
  if (!bus || bus->serial) return std::nullopt;
  Resolver resolver(bus->host, bus->port);
  const auto& addresses = resolver.resolve(core::MonotonicClock().now_ns() + kResolveNs);
  if (addresses.empty()) {
    return core::Problem{Code::P7955, fmt::format("nobody knows the name {}: {}", bus->host, resolver.reason()),
                         "mend /etc/hosts or the name server, or give the IP address in `bus`"};
  }
  std::string why;
  for (const SocketAddress& address : addresses) {
    if (why = why_no_way(address); why.empty()) return std::nullopt;
  }
  return core::Problem{
      Code::P7955, fmt::format("no way leads to {}: {}", bus->host, why),
      "is the network interface up, with an address of the device's network or a gateway (`ip route`)?"};
}

std::optional<std::string> example_channel(const bytecode::ImageType& type, std::uint32_t& next) {
  const bool bit = io::is_bool(type);
  const bool text = type.kind == bytecode::TypeKind::kString;
  const std::uint32_t size = bit    ? 1u
                             : text ? registers_of_text(KeyValues(kChannelKeys), type)
                                    : registers_of(modbus_client::raw_of(type.elementary));
  const std::uint32_t first = std::exchange(next, next + size);
  if (next > 65536) return std::nullopt;
  return fmt::format("table = \"{}\", address = {}", bit ? "coils" : "holding-registers", first);
}

std::unique_ptr<io::Driver> make(const BoundDriver& bound, const Configuration& configuration,
                                 runtime::Resource& resource) {
  return std::make_unique<ModbusDriver>(bound, address_of(*bound.config), settings_of(*bound.config),
                                        points_of(bound, resource), check_bound(bound, configuration, resource.image()),
                                        resource);
}

}  // namespace

BusAddress address_of(const DriverConfig& driver) {
  BusAddress bus = parse_bus(driver.values.text("bus")).value();
  bus.line = modbus_rtu::parse_line(driver.values.text("line")).value();
  return bus;
}

DeviceSettings settings_of(const DriverConfig& driver) {
  const KeyValues& values = driver.values;
  DeviceSettings settings;
  settings.name = driver.name;
  settings.where = fmt::format("{}, unit {}", bus_name(address_of(driver)), values.number("unit"));
  settings.unit = static_cast<std::uint8_t>(values.number("unit"));
  settings.timeout_ns = values.number("timeout");
  settings.retries = static_cast<std::uint32_t>(values.number("retries"));
  settings.retry_ns = driver.retry_ns;
  settings.retry_max_ns = values.number("retry_max");
  settings.write_ns = values.number("write");
  settings.rewrite_ns = values.number("rewrite");
  settings.multiple = values.flag("multiple");
  const auto registers = static_cast<std::uint16_t>(values.number("max_registers"));
  settings.read_limits = {registers, static_cast<std::uint16_t>(registers * 16),
                          static_cast<std::uint16_t>(values.number("gap"))};
  settings.write_limits.registers = std::min(registers, kMaxWriteRegisters);
  settings.write_limits.bits = static_cast<std::uint16_t>(settings.write_limits.registers * 16);
  return settings;
}

Points points_of(const BoundDriver& bound, runtime::Resource& resource) {
  const DriverConfig& driver = *bound.config;
  const bytecode::Image& image = resource.image();
  Points points;
  for (const BoundChannel& input : bound.inputs) {
    const KeyValues& values = input.config->values;
    const bytecode::ImageType& type = image.types[input.type];
    if (values.has("status")) {
      points.status.push_back({values.choice<Status>("status"), type.elementary, input.offset, input.type});
      continue;
    }
    ReadPoint point = {input.config->variable.text,
                       want_of(input, driver, image),
                       coding_of(*input.config, driver, type),
                       input.offset,
                       input.type,
                       {},
                       type.size};
    if (values.has("substitute") || driver.on_loss == io::OnLoss::kZero) point.substitute.resize(type.size);
    if (values.has("substitute")) {
      static_cast<void>(runtime::parse_value(type, values.text("substitute"), point.substitute));
    }
    points.reads.push_back(std::move(point));
  }
  if (bound.ok) points.status.push_back({Status::kOk, core::TypeId::kBool, bound.ok->offset, bound.ok->type});
  for (const BoundChannel& output : bound.outputs) {
    const bytecode::ImageType& type = image.types[output.type];
    Want want = want_of(output, driver, image);
    want.period_ns = 0;
    points.writes.push_back({want, coding_of(*output.config, driver, type), output.offset, type.size, output.safe,
                             output.initial, resource.globals().exporters(output.field)});
  }
  return points;
}

constexpr io::DriverType kModbusType = {
    .name = "modbus",
    .summary = "a Modbus device, over TCP or a serial line.",
    .example = "meter",
    .driver_keys = kDriverKeys,
    .channel_keys = kChannelKeys,
    .device_key = "bus",
    .check = check,
    .refuses = refuses,
    .check_files = check_files,
    .check_device = check_device,
    .example_channel = example_channel,
    .make = make,
};

}  // namespace plc::modbus_client
