// plc modbus: asks Modbus devices while a plant is put into service: which units answer, what is at an address.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "io-drivers/modbus-client/codec.h"
#include "io-drivers/modbus-client/link.h"
#include "runtime/value_text.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"

namespace plc::tools {
namespace {

namespace mb = modbus_client;

struct Modbus {
  std::string bus, line = "19200 8E1", timeout = "500ms";
  std::string units = "1-247";
  std::uint32_t unit = 1, address = 0, count = 1;
  mb::ModbusTable table = mb::ModbusTable::kHoldingRegisters;
  mb::Raw raw = mb::Raw::kVariable;
  io::WordOrder order = io::WordOrder::kAbcd;
  std::vector<std::string> values;
  bool multiple = false;
};

/// What a value of the flag --type is to the project's types.
core::TypeId type_of(const Modbus& modbus) {
  constexpr core::TypeId kTypes[] = {core::TypeId::kUint,  core::TypeId::kInt,   core::TypeId::kUint,
                                     core::TypeId::kDint,  core::TypeId::kUdint, core::TypeId::kLint,
                                     core::TypeId::kUlint, core::TypeId::kReal,  core::TypeId::kLreal};
  return mb::is_bits(modbus.table) ? core::TypeId::kBool : kTypes[static_cast<std::size_t>(modbus.raw)];
}
mb::Coding coding_of(const Modbus& modbus) {
  mb::Coding coding;
  coding.variable = type_of(modbus);
  coding.raw = modbus.raw == mb::Raw::kVariable ? mb::Raw::kUint : modbus.raw;
  coding.order = modbus.order;
  return coding;
}
bytecode::ImageType image_type(core::TypeId elementary) {
  bytecode::ImageType type;
  type.kind = bytecode::TypeKind::kScalar;
  type.elementary = elementary;
  type.size = core::rep_bytes(core::info(elementary).rep);
  return type;
}

std::unique_ptr<mb::Link> link_of(const Modbus& modbus) {
  mb::BusAddress bus = mb::parse_bus(modbus.bus).value();
  bus.line = modbus_rtu::parse_line(modbus.line).value();
  return mb::make_link(bus);
}
core::TimeNs timeout_of(const Modbus& modbus) { return parse_duration_ns(modbus.timeout).value(); }

int complain_of(const Modbus& modbus, const mb::Link& link, mb::Error error) {
  std::string why = mb::error_text(error);
  if (!link.reason().empty()) why += fmt::format(" ({})", link.reason());
  complain("plc modbus", fmt::format("{}, unit {}: {}", modbus.bus, modbus.unit, why));
  return kExitErrors;
}

/// First and last of "3", "1-247"; nothing when it is neither.
std::optional<std::pair<unsigned, unsigned>> range_of(std::string_view text) {
  const auto number = [](std::string_view part) -> std::optional<unsigned> {
    unsigned value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || value > 255) return std::nullopt;
    return value;
  };
  const std::size_t dash = text.find('-');
  const auto first = number(text.substr(0, dash));
  const auto last = dash == std::string_view::npos ? first : number(text.substr(dash + 1));
  if (!first || !last || *first > *last) return std::nullopt;
  return std::pair(*first, *last);
}

std::string joined(const std::vector<std::string>& texts) {
  std::string all;
  for (const std::string& text : texts) all += (all.empty() ? "" : " ") + text;
  return all;
}

int scan(const Modbus& modbus) {
  const auto link = link_of(modbus);
  const auto [first, last] = range_of(modbus.units).value();
  std::size_t found = 0;
  for (unsigned unit = first; unit <= last; ++unit) {
    const auto id = static_cast<std::uint8_t>(unit);
    mb::Cells cells;
    const mb::Error error =
        mb::ask(*link, id, mb::read_pdu(mb::ModbusTable::kHoldingRegisters, 0, 1), timeout_of(modbus), cells);
    if (error == mb::Error::kNotConnected) return complain_of(modbus, *link, error);
    // A gateway answers for units that are not there, too.
    const bool there = error == mb::Error::kNone ||
                       (mb::is_exception(error) && error != mb::Error::kNoPath && error != mb::Error::kNoTarget);
    const bool noise = error == mb::Error::kWrongAnswer;
    if (!there && !noise) continue;
    ++found;
    mb::Bytes answer;
    std::optional<std::vector<std::string>> identity;
    if (there && link->exchange(id, mb::identify_pdu(), timeout_of(modbus), answer) == mb::Error::kNone) {
      identity = mb::parse_identity(answer);
    }
    const std::string what = identity && !identity->empty() ? joined(*identity)
                             : noise ? "something that is no Modbus, or two devices with this unit, or another speed"
                                     : "answers";
    std::cout << fmt::format("unit {}: {}", unit, what) << std::endl;
  }
  if (found != 0) return kExitOk;
  complain("plc modbus", fmt::format("{}: no unit from {} to {} answers", modbus.bus, first, last),
           "--line sets speed and parity of a serial line, --timeout waits longer");
  return kExitErrors;
}

/// What does not go together, said; nothing is sent then.
bool is_wrong(const Modbus& modbus) {
  if (mb::is_bits(modbus.table) && modbus.raw != mb::Raw::kVariable) {
    complain("plc modbus", fmt::format("{} have no type", io::modbus_table_text(modbus.table)), "leave out --type");
    return true;
  }
  // Unit 0 of a line is every device: they carry out what is written, and none of them answers.
  if (!mb::parse_bus(modbus.bus).value().serial || (modbus.unit >= 1 && modbus.unit <= 247)) return false;
  complain("plc modbus", fmt::format("unit {} is none on a serial line", modbus.unit), "they go from 1 to 247");
  return true;
}

int read(const Modbus& modbus) {
  if (is_wrong(modbus)) return kExitUsage;
  const mb::Coding coding = coding_of(modbus);
  const std::uint32_t width = mb::is_bits(modbus.table) ? 1 : mb::registers_of(coding.raw);
  const std::uint32_t cells_wanted = modbus.count * width;
  const std::uint32_t most = mb::is_bits(modbus.table) ? mb::kMaxReadBits : mb::kMaxReadRegisters;
  if (cells_wanted > most || modbus.address + cells_wanted > 65536) {
    complain("plc modbus", fmt::format("one request reads at most {} of {}, up to address 65535", most,
                                       io::modbus_table_text(modbus.table)));
    return kExitUsage;
  }
  const auto link = link_of(modbus);
  mb::Cells cells;
  const mb::Error error = mb::ask(
      *link, static_cast<std::uint8_t>(modbus.unit),
      mb::read_pdu(modbus.table, static_cast<std::uint16_t>(modbus.address), static_cast<std::uint16_t>(cells_wanted)),
      timeout_of(modbus), cells);
  if (error != mb::Error::kNone) return complain_of(modbus, *link, error);
  const bytecode::ImageType type = image_type(coding.variable);
  for (std::uint32_t i = 0; i < modbus.count; ++i) {
    std::byte value[8] = {};
    mb::decode(coding, std::span(cells).subspan(std::size_t{i} * width, width), value);
    std::string text;
    runtime::append_value(type, value, text);
    std::cout << fmt::format("{} {}\n", modbus.address + i * width, text);
  }
  return kExitOk;
}

int write(const Modbus& modbus) {
  if (is_wrong(modbus)) return kExitUsage;
  if (!mb::is_writable(modbus.table)) {
    complain("plc modbus", fmt::format("no function of Modbus writes {}", io::modbus_table_text(modbus.table)));
    return kExitUsage;
  }
  const mb::Coding coding = coding_of(modbus);
  const bytecode::ImageType type = image_type(coding.variable);
  const std::size_t width = mb::is_bits(modbus.table) ? 1 : mb::registers_of(coding.raw);
  const std::size_t most = mb::is_bits(modbus.table) ? mb::kMaxWriteBits : mb::kMaxWriteRegisters;
  mb::Cells cells(modbus.values.size() * width);
  if (cells.size() > most || modbus.address + cells.size() > 65536) {
    complain("plc modbus", fmt::format("one request writes at most {} of {}, up to address 65535", most,
                                       io::modbus_table_text(modbus.table)));
    return kExitUsage;
  }
  for (std::size_t i = 0; i < modbus.values.size(); ++i) {
    std::byte value[8] = {};
    if (const auto problem = runtime::parse_value(type, modbus.values[i], std::span(value).first(type.size))) {
      complain(*problem);
      return kExitUsage;
    }
    mb::encode(coding, value, std::span(cells).subspan(i * width, width));
  }
  const auto link = link_of(modbus);
  mb::Cells none;
  const mb::Error error =
      mb::ask(*link, static_cast<std::uint8_t>(modbus.unit),
              mb::write_pdu(modbus.table, static_cast<std::uint16_t>(modbus.address), cells, modbus.multiple),
              timeout_of(modbus), none);
  return error == mb::Error::kNone ? kExitOk : complain_of(modbus, *link, error);
}

void add_bus(Command command, Modbus& modbus) {
  command.option("BUS", modbus.bus, "IP address or host name with a port (else 502), or the path of a serial line")
      .required()
      .check([](const std::string& text) {
        return mb::parse_bus(text)
                   ? ""
                   : '"' + text + "\" is neither an IP address, a host name nor the path of a serial line";
      });
  command.option("--line=LINE", modbus.line, "speed, data bits, parity and stop bits of a serial line")
      .shows_default()
      .check([](const std::string& text) {
        return modbus_rtu::parse_line(text) ? "" : '"' + text + "\" is not like \"19200 8E1\"";
      });
  command.option("--timeout=TIME", modbus.timeout, "time for an answer")
      .shows_default()
      .check([](const std::string& text) {
        const auto ns = parse_duration_ns(text);
        return ns && *ns > 0 && *ns <= 3'600'000'000'000 ? "" : '"' + text + "\" is no duration up to 1h";
      });
}

void add_cells(Command command, Modbus& modbus) {
  using Table = mb::ModbusTable;
  add_bus(command, modbus);
  command
      .choice("TABLE", modbus.table,
              {{"coils", Table::kCoils},
               {"discrete-inputs", Table::kDiscreteInputs},
               {"input-registers", Table::kInputRegisters},
               {"holding-registers", Table::kHoldingRegisters}},
              "which of the four tables")
      .required();
  command.option("ADDRESS", modbus.address, "first address, as it is sent: from 0 on").required().range(0u, 65535u);
  command.option("--unit=N", modbus.unit, "unit identifier").shows_default().range(0u, 255u);
  using mb::Raw;
  command.choice("--type=TYPE", modbus.raw,
                 {{"INT", Raw::kInt},
                  {"UINT", Raw::kUint},
                  {"DINT", Raw::kDint},
                  {"UDINT", Raw::kUdint},
                  {"LINT", Raw::kLint},
                  {"ULINT", Raw::kUlint},
                  {"REAL", Raw::kReal},
                  {"LREAL", Raw::kLreal}},
                 "what is in registers; without it UINT");
  using io::WordOrder;
  command.choice(
      "--word-order=ORDER", modbus.order,
      {{"ABCD", WordOrder::kAbcd}, {"CDAB", WordOrder::kCdab}, {"BADC", WordOrder::kBadc}, {"DCBA", WordOrder::kDcba}},
      "order of bytes in values of 32 and 64 bits");
}

}  // namespace

void add_modbus(Command program) {
  static Modbus modbus;
  const Command group =
      program.sub("modbus",
                  "Asks Modbus devices, over TCP or a serial line: for putting a plant into service.\n"
                  "Not while plc-run uses the same serial line.");
  const Command units = group.sub("scan",
                                  "Lists the units that answer, and who they are where they tell.\n"
                                  "\n"
                                  "Examples:\n"
                                  "  plc modbus scan /dev/ttyUSB0 --line '9600 8N1' --timeout 100ms\n"
                                  "  plc modbus scan 192.168.1.20 --units 1-10");
  add_bus(units, modbus);
  units.option("--units=RANGE", modbus.units, "\"1-247\", or one number")
      .shows_default()
      .check([](const std::string& text) { return range_of(text) ? "" : "from 0 to 255: 1-247"; });
  units.on_run([] { return scan(modbus); });

  const Command reading = group.sub("read",
                                    "Prints values of a device, an address and a value on each line.\n"
                                    "\n"
                                    "Examples:\n"
                                    "  plc modbus read 192.168.1.20 holding-registers 100 --count 8\n"
                                    "  plc modbus read /dev/ttyUSB0 input-registers 0 --unit 3 --type REAL "
                                    "--word-order CDAB");
  add_cells(reading, modbus);
  reading.option("--count=N", modbus.count, "values").shows_default().range(1u, 2000u);
  reading.on_run([] { return read(modbus); });

  const Command writing =
      group.sub("write",
                "Writes values to a device, in one request.\n"
                "\n"
                "Examples:\n"
                "  plc modbus write 192.168.1.20 coils 7 --value=TRUE\n"
                "  plc modbus write 192.168.1.20 holding-registers 100 --type INT --value=-5 --value=20");
  add_cells(writing, modbus);
  writing.option("--value=VALUE", modbus.values, "a value; several go to one address after the other")
      .required()
      .repeated();
  writing.flag("--multiple", modbus.multiple, "function 15 or 16 for one value, too");
  writing.on_run([] { return write(modbus); });
}

}  // namespace plc::tools
