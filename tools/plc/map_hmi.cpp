// Import files of FUXA, Scada-LTS and Ignition.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/plc/map_formats.h"

namespace plc::tools {
namespace {

using io::WordOrder;
using modbus::Point;
using modbus::Table;
using nlohmann::ordered_json;

std::string dump(const ordered_json& document) {
  return document.dump(1, ' ', false, ordered_json::error_handler_t::replace) + '\n';
}

/// FUXA: plain names are ABCD, MLE is CDAB, LE is DCBA. Nothing: FUXA cannot read it.
std::optional<std::string> fuxa_type(const Point& point) {
  const auto ordered = [&](std::string name, bool has_low_word_first) -> std::optional<std::string> {
    switch (point.word_order) {
      case WordOrder::kAbcd:
        return name;
      case WordOrder::kDcba:
        return name + "LE";
      case WordOrder::kCdab:
        if (has_low_word_first) return name + "MLE";
        return std::nullopt;
      case WordOrder::kBadc:
        return std::nullopt;
    }
    return std::nullopt;
  };
  switch (coding_of(point)) {
    case Coding::kBit:
      return "Bool";
    case Coding::kI16:
      return "Int16";
    case Coding::kU16:
      return "UInt16";
    case Coding::kI32:
      return ordered("Int32", true);
    case Coding::kU32:
      return ordered("UInt32", true);
    case Coding::kF32:
      return ordered("Float32", true);
    case Coding::kI64:
    case Coding::kU64:  // FUXA has no unsigned one; values from 2^63 on would show as negative
      return ordered("Int64", false);
    case Coding::kF64:
      return ordered("Float64", false);
    case Coding::kText:
      return std::nullopt;
  }
  return std::nullopt;
}

/// "127.0.0.1:502", "[::1]:502".
std::string endpoint(const MapSource& source) {
  const bool six = source.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", six ? "[" : "", source.host, six ? "]" : "", source.port);
}

const char* fuxa_memory(Table table) {
  constexpr const char* kMemory[] = {"000000", "100000", "300000", "400000"};
  return kMemory[static_cast<std::size_t>(table)];
}

/// Scada-LTS: _SWAPPED is CDAB, of a REAL _SWAPPED_INVERTED is DCBA.
std::optional<std::string> scadalts_type(const Point& point) {
  const auto ordered = [&](std::string name) -> std::optional<std::string> {
    if (point.word_order == WordOrder::kAbcd) return name;
    if (point.word_order == WordOrder::kCdab) return name + "_SWAPPED";
    if (point.word_order == WordOrder::kDcba && name == "FOUR_BYTE_FLOAT") return name + "_SWAPPED_INVERTED";
    return std::nullopt;
  };
  switch (coding_of(point)) {
    case Coding::kBit:
      return "BINARY";
    case Coding::kI16:
      return "TWO_BYTE_INT_SIGNED";
    case Coding::kU16:
      return "TWO_BYTE_INT_UNSIGNED";
    case Coding::kI32:
      return ordered("FOUR_BYTE_INT_SIGNED");
    case Coding::kU32:
      return ordered("FOUR_BYTE_INT_UNSIGNED");
    case Coding::kF32:
      return ordered("FOUR_BYTE_FLOAT");
    case Coding::kI64:
      return ordered("EIGHT_BYTE_INT_SIGNED");
    case Coding::kU64:
      return ordered("EIGHT_BYTE_INT_UNSIGNED");
    case Coding::kF64:
      return ordered("EIGHT_BYTE_FLOAT");
    case Coding::kText:
      return std::nullopt;
  }
  return std::nullopt;
}

const char* scadalts_range(Table table) {
  constexpr const char* kRanges[] = {"COIL_STATUS", "INPUT_STATUS", "INPUT_REGISTER", "HOLDING_REGISTER"};
  return kRanges[static_cast<std::size_t>(table)];
}

/// Designator in an OPC item path, after HR or IR, and the data type of the tag.
struct IgnitionType {
  const char* suffix;
  const char* data_type;
};
IgnitionType ignition_type(Coding coding) {
  switch (coding) {
    case Coding::kBit:
      return {"", "Boolean"};
    case Coding::kI16:
      return {"", "Int2"};
    case Coding::kU16:
      return {"US", "Int4"};
    case Coding::kI32:
      return {"I", "Int4"};
    case Coding::kU32:
      return {"UI", "Int8"};
    case Coding::kF32:
      return {"F", "Float4"};
    case Coding::kI64:
      return {"I_64", "Int8"};
    case Coding::kU64:
      return {"UI_64", "Int8"};
    case Coding::kF64:
      return {"D", "Float8"};
    case Coding::kText:
      return {"S", "String"};
  }
  return {"", ""};
}

}  // namespace

MapText map_as_fuxa(const MapSource& source) {
  MapText out;
  PlainNames plain;
  ordered_json tags = ordered_json::object();
  for (const Point& point : source.map.points()) {
    const auto type = fuxa_type(point);
    if (!type) {
      out.left_out.push_back(point.path);
      continue;
    }
    const std::string id = plain(point.path);
    tags[id] = {{"id", id},
                {"name", point.path},
                {"label", point.path},
                {"type", *type},
                {"memaddress", fuxa_memory(point.table)},
                {"address", std::to_string(point.address + 1)},
                {"divisor", ""},
                {"access", ""},
                {"options", ""},
                {"daq", {{"enabled", false}, {"interval", 60}, {"changed", false}, {"restored", false}}}};
  }
  const ordered_json device = {{"id", "d_" + PlainNames()(source.name)},
                               {"name", source.name},
                               {"type", "ModbusTCP"},
                               {"enabled", true},
                               {"polling", 500},
                               {"property",
                                {{"address", endpoint(source)},
                                 {"slaveid", std::to_string(source.unit_id)},
                                 {"connectionOption", "TcpPort"},
                                 {"options", false},
                                 {"delay", 10}}},
                               {"tags", std::move(tags)}};
  out.text = dump(ordered_json::array({device}));
  return out;
}

MapText map_as_scadalts(const MapSource& source) {
  MapText out;
  PlainNames plain;
  const std::string source_xid = "DS_" + PlainNames()(source.name);
  ordered_json points = ordered_json::array();
  for (const Point& point : source.map.points()) {
    const auto type = scadalts_type(point);
    if (!type) {
      out.left_out.push_back(point.path);
      continue;
    }
    points.push_back({{"xid", "DP_" + plain(point.path)},
                      {"dataSourceXid", source_xid},
                      {"name", point.path},
                      {"deviceName", source.name},
                      {"enabled", true},
                      {"loggingType", "ON_CHANGE"},
                      {"pointLocator",
                       {{"range", scadalts_range(point.table)},
                        {"modbusDataType", *type},
                        {"slaveId", source.unit_id},
                        {"offset", point.address},
                        {"bit", 0},
                        {"registerCount", 0},
                        {"settableOverride", point.writable},
                        {"multiplier", 1.0},
                        {"additive", 0.0}}}});
  }
  const ordered_json data_source = {{"xid", source_xid},
                                    {"type", "MODBUS_IP"},
                                    {"name", source.name},
                                    {"enabled", true},
                                    {"updatePeriods", 500},
                                    {"updatePeriodType", "MILLISECONDS"},
                                    {"timeout", 1000},
                                    {"retries", 2},
                                    {"contiguousBatches", false},
                                    {"maxReadBitCount", 2000},
                                    {"maxReadRegisterCount", 125},
                                    {"maxWriteRegisterCount", 120},
                                    {"transportType", "TCP_KEEP_ALIVE"},
                                    {"host", source.host},
                                    {"port", source.port},
                                    {"encapsulated", false}};
  out.text = dump({{"dataSources", ordered_json::array({data_source})}, {"dataPoints", std::move(points)}});
  return out;
}

MapText map_as_ignition(const MapSource& source) {
  MapText out;
  PlainNames plain;
  ordered_json tags = ordered_json::array();
  const std::string device = PlainNames()(source.name);
  const auto points = source.map.points();
  // The word order is an option of Ignition's device: all values have one.
  std::optional<WordOrder> order;
  for (const Point& point : points) {
    // Ignition has texts of one byte a character, in holding registers.
    const bool text = point.characters != 0;
    if (text && (point.table != Table::kHoldingRegisters || point.elementary == core::TypeId::kWstring)) {
      out.left_out.push_back(point.path);
      continue;
    }
    const bool swapped = point.word_order == WordOrder::kBadc || point.word_order == WordOrder::kDcba;
    if (point.registers > 1 && !text && !swapped && !order) order = point.word_order;
    if (point.registers > 1 && !text && (swapped || point.word_order != *order)) {
      out.left_out.push_back(point.path);
      continue;
    }
    const IgnitionType type = ignition_type(coding_of(point));
    constexpr const char* kDesignators[] = {"C", "DI", "IR", "HR"};
    const char* const designator = kDesignators[static_cast<std::size_t>(point.table)];
    tags.push_back(
        {{"name", plain(point.path)},
         {"tagType", "AtomicTag"},
         {"valueSource", "opc"},
         {"dataType", type.data_type},
         {"opcServer", "Ignition OPC UA Server"},
         {"opcItemPath", fmt::format("ns=1;s=[{}]{}{}{}{}", device, designator, type.suffix, point.address + 1,
                                     text ? fmt::format(":{}", 2 * point.registers) : "")},
         {"readOnly", !point.writable},
         {"documentation", point.path}});
  }
  out.text = dump({{"name", device}, {"tagType", "Folder"}, {"tags", std::move(tags)}});
  return out;
}

}  // namespace plc::tools
