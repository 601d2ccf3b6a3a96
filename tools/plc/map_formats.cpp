#include "tools/plc/map_formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/text.h"
#include "io-drivers/csv.h"

namespace plc::tools {
namespace {

using modbus::Point;
using modbus::Table;
using nlohmann::ordered_json;

std::string type_of(const MapSource& source, const Point& point) {
  const std::string& declared = source.image.types[point.type].name;
  if (!declared.empty()) return declared;
  std::string type(core::name_of(point.elementary));
  return point.characters == 0 ? type : fmt::format("{}[{}]", type, point.characters);
}

/// "0 = Off, 1 = Heat" for enumerations.
std::string members_of(const bytecode::ImageType& type) {
  std::string text;
  for (std::size_t i = 0; i < type.members.size(); ++i) {
    text += fmt::format("{}{} = {}", i == 0 ? "" : ", ", type.member_values[i], type.members[i]);
  }
  return text;
}

/// The port of a taskblock that a point is, or is part of; null for other variables.
const picard_port* port_of(const MapSource& source, const Point& point) {
  const bytecode::Image& image = source.image;
  std::uint32_t type = image.global_type;
  std::uint32_t offset = point.offset;
  for (;;) {
    const bytecode::ImageType& t = image.types[type];
    if (t.kind == bytecode::TypeKind::kArray) {
      type = t.element;
      offset %= image.types[type].size;
      continue;
    }
    if (t.kind != bytecode::TypeKind::kStruct) return nullptr;
    const auto next = std::upper_bound(t.fields.begin(), t.fields.end(), offset,
                                       [](std::uint32_t at, const auto& field) { return at < field.offset; });
    if (next == t.fields.begin()) return nullptr;
    const bytecode::ImageField& field = *(next - 1);
    for (const bytecode::ImageBlock& block : image.blocks) {
      const auto* const entry = block.type == type ? source.taskblocks.find(block.name) : nullptr;
      if (entry == nullptr) continue;
      const picard_port* const end = entry->block->ports + entry->block->port_count;
      const picard_port* const port = std::find_if(
          entry->block->ports, end, [&field](const picard_port& p) { return core::iequals(p.name, field.name); });
      return port != end ? port : nullptr;
    }
    type = field.type;
    offset -= field.offset;
  }
}

/// What HMIs show beside a value, as far as the program knows.
struct Meaning {
  std::string lowest, highest;  ///< numbers, or empty
  std::string unit;
  std::string comment;
};

Meaning meaning_of(const MapSource& source, const Point& point) {
  const bytecode::ImageType& type = source.image.types[point.type];
  Meaning meaning{{}, {}, {}, members_of(type)};
  if (type.limited) {
    meaning.lowest = fmt::format("{}", type.lower);
    meaning.highest = fmt::format("{}", type.upper);
  }
  if (const picard_port* const port = port_of(source, point)) {
    if (std::isfinite(port->lowest)) meaning.lowest = fmt::format("{}", port->lowest);
    if (std::isfinite(port->highest)) meaning.highest = fmt::format("{}", port->highest);
    meaning.unit = port->unit;
    meaning.comment = port->summary;
  }
  return meaning;
}

std::string order_of(const Point& point) {
  return point.registers > 1 && point.characters == 0 ? std::string(io::word_order_text(point.word_order))
                                                      : std::string{};
}

const char* functions_of(Table table) {
  switch (table) {
    case Table::kCoils:
      return "read with function 1, written with 5 and 15";
    case Table::kDiscreteInputs:
      return "read with function 2";
    case Table::kInputRegisters:
      return "read with function 4";
    case Table::kHoldingRegisters:
      return "read with function 3, written with 6, 16, 22 and 23";
  }
  return "";
}

}  // namespace

Coding coding_of(const Point& point) {
  switch (core::rep_of(point.elementary)) {
    case core::Rep::kBool:
      return Coding::kBit;
    case core::Rep::kI8:
    case core::Rep::kI16:
      return Coding::kI16;
    case core::Rep::kI32:
      return Coding::kI32;
    case core::Rep::kU32:
      return Coding::kU32;
    case core::Rep::kI64:
      return Coding::kI64;
    case core::Rep::kU64:
      return Coding::kU64;
    case core::Rep::kF32:
      return Coding::kF32;
    case core::Rep::kF64:
      return Coding::kF64;
    case core::Rep::kStr:
    case core::Rep::kWstr:
      return Coding::kText;
    default:
      return Coding::kU16;
  }
}

std::string PlainNames::operator()(std::string_view path) {
  std::string name;
  for (const char c : path) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (plain) {
      name += c;
    } else if (!name.empty() && name.back() != '_') {
      name += '_';
    }
  }
  while (name.ends_with('_')) name.pop_back();
  if (name.empty() || (name[0] >= '0' && name[0] <= '9')) name.insert(0, "v_");
  std::string unique = name;
  for (int n = 2; !used_.insert(unique).second; ++n) unique = fmt::format("{}_{}", name, n);
  return unique;
}

MapText map_as_table(const MapSource& source) {
  std::size_t widest = 8;
  for (const Point& point : source.map.points()) widest = std::max(widest, point.path.size());
  widest = std::min<std::size_t>(widest, 60);
  std::string text;
  std::optional<Table> table;
  for (const Point& point : source.map.points()) {
    if (table != point.table) {
      table = point.table;
      text += fmt::format("{}{}: {}\n{:>7}  {:<{}}  {:<14} {:<14} {:<6} {}\n", text.empty() ? "" : "\n",
                          io::modbus_table_text(*table), functions_of(*table), "address", "variable", widest, "type",
                          "at", "access", "order");
    }
    std::string row =
        fmt::format("{:>7}  {:<{}}  {:<14} {:<14} {:<6} {}", point.address, point.path, widest, type_of(source, point),
                    point.automatic ? "automatic" : point.iec_address, point.writable ? "rw" : "r", order_of(point));
    text += row.substr(0, row.find_last_not_of(' ') + 1) + '\n';
  }
  if (text.empty()) text = "no variable has a Modbus address\n";
  text += fmt::format("\nof the plant itself, input-registers: {}\n", functions_of(Table::kInputRegisters));
  for (const modbus::SystemPoint& point : modbus::system_points()) {
    text += fmt::format("{:>7}  {:<{}}  {:<14} {}\n", point.address, point.name, widest, core::name_of(point.type),
                        point.documentation);
  }
  return {std::move(text), {}};
}

MapText map_as_csv(const MapSource& source) {
  std::string text =
      "name,type,iec_address,modbus_table,address0,address1,registers,bit,word_order,access,min,max,comment\n";
  for (const Point& point : source.map.points()) {
    const Meaning meaning = meaning_of(source, point);
    io::append_csv(text, point.path);
    text += ',';
    io::append_csv(text, type_of(source, point));
    text += fmt::format(",{},{},{},{},{},{},{},{},", point.iec_address, io::modbus_table_text(point.table),
                        point.address, point.address + 1, point.registers, point.registers == 0 ? "0" : "",
                        order_of(point), point.writable ? "rw" : "r");
    text += fmt::format("{},{},", meaning.lowest, meaning.highest);
    io::append_csv(text, meaning.comment + (meaning.unit.empty() ? "" : ", " + meaning.unit));
    text += '\n';
  }
  return {std::move(text), {}};
}

MapText map_as_json(const MapSource& source) {
  ordered_json variables = ordered_json::array();
  for (const Point& point : source.map.points()) {
    const Meaning meaning = meaning_of(source, point);
    ordered_json row;
    row["name"] = point.path;
    row["type"] = type_of(source, point);
    row["iec_address"] = point.iec_address;
    row["modbus_table"] = io::modbus_table_text(point.table);
    row["address0"] = point.address;
    row["address1"] = point.address + 1;
    row["registers"] = point.registers;
    if (point.registers == 0) row["bit"] = 0;
    if (point.registers > 1 && point.characters == 0) row["word_order"] = io::word_order_text(point.word_order);
    row["access"] = point.writable ? "rw" : "r";
    if (!meaning.lowest.empty()) row["min"] = ordered_json::parse(meaning.lowest);
    if (!meaning.highest.empty()) row["max"] = ordered_json::parse(meaning.highest);
    if (!meaning.unit.empty()) row["unit"] = meaning.unit;
    if (!meaning.comment.empty()) row["comment"] = meaning.comment;
    variables.push_back(std::move(row));
  }
  ordered_json system = ordered_json::array();
  for (const modbus::SystemPoint& point : modbus::system_points()) {
    ordered_json row;
    row["name"] = point.name;
    row["type"] = core::name_of(point.type);
    row["modbus_table"] = io::modbus_table_text(Table::kInputRegisters);
    row["address0"] = point.address;
    row["address1"] = point.address + 1;
    row["registers"] = point.registers;
    if (point.registers > 1) row["word_order"] = io::word_order_text(source.map.system_order());
    row["comment"] = point.documentation;
    system.push_back(std::move(row));
  }
  ordered_json document;
  document["project"] = source.name;
  document["host"] = source.host;
  document["port"] = source.port;
  document["unit_id"] = source.unit_id;
  document["variables"] = std::move(variables);
  document["system"] = std::move(system);
  return {document.dump(1, ' ', false, ordered_json::error_handler_t::replace) + '\n', {}};
}

}  // namespace plc::tools
