// A Node-RED flow: reading nodes for runs of addresses, one function that takes them apart, one that writes by name.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "tools/plc/map_formats.h"

namespace plc::tools {
namespace {

using modbus::Point;
using modbus::Table;
using nlohmann::ordered_json;

/// Addresses that one request reads.
struct Run {
  Table table;
  std::uint32_t first;
  std::uint32_t end;
  std::vector<const Point*> points;
};

bool is_bit_table(Table table) { return table == Table::kCoils || table == Table::kDiscreteInputs; }

/// In one request. Texts may be longer.
constexpr std::uint32_t kMostRead = 125, kMostWritten = 123;

/// Short gaps are read as well, where the server answers them.
bool bridges(const modbus::AddressMap& map, const Run& run, const Point& next, std::uint32_t next_end) {
  const bool bits = is_bit_table(run.table);
  if (run.table != next.table || next_end - run.first > (bits ? 2000u : kMostRead)) return false;
  if (next.address > run.end + (bits ? 256u : 16u)) return false;
  for (std::uint32_t at = run.end; at < next.address; ++at) {
    if (!map.contains(run.table, static_cast<std::uint16_t>(at))) return false;
  }
  return true;
}

std::vector<Run> runs_of(const modbus::AddressMap& map) {
  std::vector<Run> runs;
  for (const Point& point : map.points()) {
    if (point.registers > kMostRead) continue;
    const std::uint32_t end = point.address + std::max<std::uint32_t>(point.registers, 1);
    if (runs.empty() || !bridges(map, runs.back(), point, end)) runs.push_back({point.table, point.address, end, {}});
    runs.back().end = std::max(runs.back().end, end);
    runs.back().points.push_back(&point);
  }
  return runs;
}

/// Of texts s or w, and how many characters they have at most.
std::string coding_name(const Point& point) {
  if (point.characters != 0) {
    return fmt::format("{}{}", point.elementary == core::TypeId::kWstring ? 'w' : 's', point.characters);
  }
  constexpr const char* kNames[] = {"bit", "i16", "u16", "i32", "u32", "f32", "i64", "u64", "f64"};
  return kNames[static_cast<std::size_t>(coding_of(point))];
}

const char* node_table(Table table) {
  constexpr const char* kTables[] = {"Coil", "Input", "InputRegister", "HoldingRegister"};
  return kTables[static_cast<std::size_t>(table)];
}

// msg.payload has the bits or words of one run. CDAB and DCBA send the low word first; BADC and DCBA swap bytes.
constexpr const char* kDecode = R"(const values = {};
for (const [name, at, coding, order] of runs[msg.topic] || []) {
  if (coding === "bit") { values[name] = !!msg.payload[at]; continue; }
  if (coding[0] === "s" || coding[0] === "w") {
    const wide = coding[0] === "w", most = Number(coding.slice(1));
    const words = msg.payload.slice(at, at + (wide ? most : Math.ceil(most / 2)));
    const codes = words.flatMap(word => wide ? [word] : [word >> 8 & 255, word & 255]).concat(0);
    values[name] = String.fromCharCode(...codes.slice(0, codes.indexOf(0)));
    continue;
  }
  const size = Number(coding.slice(1)) / 8;
  const words = msg.payload.slice(at, at + size / 2);
  if (order === "CDAB" || order === "DCBA") words.reverse();
  const bytes = Buffer.alloc(size);
  words.forEach((word, i) => bytes.writeUInt16BE(word & 0xffff, 2 * i));
  if (order === "BADC" || order === "DCBA") bytes.swap16();
  const read = {i16: "readInt16BE", u16: "readUInt16BE", i32: "readInt32BE", u32: "readUInt32BE", f32: "readFloatBE",
                i64: "readBigInt64BE", u64: "readBigUInt64BE", f64: "readDoubleBE"}[coding];
  values[name] = Number(bytes[read](0));
}
flow.set("plc", Object.assign(flow.get("plc") || {}, values));
msg.payload = values;
return msg;
)";

// In: topic is the variable, payload the value. Values of several registers go out in one request, as one value.
constexpr const char* kEncode = R"(const variable = variables[msg.topic];
if (!variable) { node.error("no variable that may be written: " + msg.topic, msg); return null; }
const [address, coding, order] = variable;
const request = {unitid: unit, address: address, quantity: 1};
if (coding === "bit") {
  request.fc = 5;
  request.value = msg.payload === true || msg.payload === 1 || msg.payload === "1" || msg.payload === "true";
} else if (coding[0] === "s" || coding[0] === "w") {
  const wide = coding[0] === "w", most = Number(coding.slice(1));
  const code = i => i < most && i < String(msg.payload).length ? String(msg.payload).charCodeAt(i) : 0;
  const words = [];
  for (let i = 0; i < most; i += wide ? 1 : 2) words.push(wide ? code(i) : (code(i) & 255) << 8 | code(i + 1) & 255);
  request.fc = 16;
  request.quantity = words.length;
  request.value = words;
} else {
  const size = Number(coding.slice(1)) / 8;
  const bytes = Buffer.alloc(size);
  const write = {i16: "writeInt16BE", u16: "writeUInt16BE", i32: "writeInt32BE", u32: "writeUInt32BE", f32: "writeFloatBE",
                 i64: "writeBigInt64BE", u64: "writeBigUInt64BE", f64: "writeDoubleBE"}[coding];
  bytes[write](coding.endsWith("64") && coding[0] !== "f" ? BigInt(Math.round(Number(msg.payload))) : Number(msg.payload));
  if (order === "BADC" || order === "DCBA") bytes.swap16();
  const words = [];
  for (let i = 0; i < size; i += 2) words.push(bytes.readUInt16BE(i));
  if (order === "CDAB" || order === "DCBA") words.reverse();
  request.fc = words.length === 1 ? 6 : 16;
  request.quantity = words.length;
  request.value = words.length === 1 ? words[0] : words;
}
msg.payload = request;
return msg;
)";

ordered_json function_node(const char* id, const char* name, std::string code, int x, int y, const char* to) {
  return {{"id", id},
          {"type", "function"},
          {"z", "plc_tab"},
          {"name", name},
          {"func", std::move(code)},
          {"outputs", 1},
          {"x", x},
          {"y", y},
          {"wires", ordered_json::array({ordered_json::array({to})})}};
}

std::string table_code(const char* name, const ordered_json& table) {
  return fmt::format("const {} = {};\n", name, table.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

}  // namespace

// Nodes need x and y: one without counts as configuration, and Node-RED does not start.
MapText map_as_nodered(const MapSource& source) {
  ordered_json flow = ordered_json::array();
  flow.push_back({{"id", "plc_tab"}, {"type", "tab"}, {"label", source.name}});
  flow.push_back({{"id", "plc_server"},
                  {"type", "modbus-client"},
                  {"name", source.name},
                  {"clienttype", "tcp"},
                  {"bufferCommands", true},
                  {"stateLogEnabled", false},
                  {"queueLogEnabled", false},
                  {"failureLogEnabled", true},
                  {"tcpHost", source.host},
                  {"tcpPort", source.port},
                  {"tcpType", "DEFAULT"},
                  {"unit_id", source.unit_id},
                  {"commandDelay", 1},
                  {"clientTimeout", 1000},
                  {"reconnectOnTimeout", true},
                  {"reconnectTimeout", 2000},
                  {"parallelUnitIdsAllowed", true},
                  {"showErrors", true},
                  {"showWarnings", true},
                  {"showLogs", true}});
  ordered_json runs = ordered_json::object();
  ordered_json variables = ordered_json::object();
  int y = 60;
  for (const Run& run : runs_of(source.map)) {
    const std::string topic = fmt::format("{} {}-{}", io::modbus_table_text(run.table), run.first, run.end - 1);
    ordered_json parts = ordered_json::array();
    for (const Point* point : run.points) {
      const std::string coding = coding_name(*point);
      const auto order = io::word_order_text(point->word_order);
      parts.push_back({point->path, point->address - run.first, coding, order});
      if (point->writable && point->registers <= kMostWritten) variables[point->path] = {point->address, coding, order};
    }
    runs[topic] = std::move(parts);
    flow.push_back({{"id", fmt::format("plc_read_{}", flow.size())},
                    {"type", "modbus-read"},
                    {"z", "plc_tab"},
                    {"name", topic},
                    {"topic", topic},
                    {"showStatusActivities", false},
                    {"logIOActivities", false},
                    {"showErrors", true},
                    {"showWarnings", true},
                    {"unitid", source.unit_id},
                    {"dataType", node_table(run.table)},
                    {"adr", run.first},
                    {"quantity", run.end - run.first},
                    {"rate", 500},
                    {"rateUnit", "ms"},
                    {"delayOnStart", false},
                    {"startDelayTime", ""},
                    {"server", "plc_server"},
                    {"useIOFile", false},
                    {"ioFile", ""},
                    {"useIOForPayload", false},
                    {"emptyMsgOnFail", false},
                    {"x", 180},
                    {"y", y},
                    {"wires", ordered_json::array({ordered_json::array({"plc_values"}), ordered_json::array()})}});
    y += 60;
  }
  flow.push_back(function_node("plc_values", "values by name", table_code("runs", runs) + kDecode, 480, 60, "plc_out"));
  flow.push_back({{"id", "plc_out"},
                  {"type", "link out"},
                  {"z", "plc_tab"},
                  {"name", source.name + " values"},
                  {"mode", "link"},
                  {"links", ordered_json::array()},
                  {"x", 635},
                  {"y", 60},
                  {"wires", ordered_json::array()}});
  flow.push_back({{"id", "plc_in"},
                  {"type", "link in"},
                  {"z", "plc_tab"},
                  {"name", source.name + " write"},
                  {"links", ordered_json::array()},
                  {"x", 95},
                  {"y", y},
                  {"wires", ordered_json::array({ordered_json::array({"plc_request"})})}});
  flow.push_back(
      function_node("plc_request", "topic is the variable, payload the value",
                    fmt::format("const unit = {};\n", source.unit_id) + table_code("variables", variables) + kEncode,
                    300, y, "plc_write"));
  flow.push_back({{"id", "plc_write"},
                  {"type", "modbus-flex-write"},
                  {"z", "plc_tab"},
                  {"name", "write"},
                  {"showStatusActivities", false},
                  {"showErrors", true},
                  {"showWarnings", true},
                  {"server", "plc_server"},
                  {"emptyMsgOnFail", false},
                  {"keepMsgProperties", true},
                  {"delayOnStart", false},
                  {"startDelayTime", ""},
                  {"x", 560},
                  {"y", y},
                  {"wires", ordered_json::array({ordered_json::array(), ordered_json::array()})}});
  MapText out{flow.dump(1, ' ', false, ordered_json::error_handler_t::replace) + '\n', {}};
  for (const Point& point : source.map.points()) {
    if (point.registers > kMostRead) out.left_out.push_back(point.path);
  }
  return out;
}

}  // namespace plc::tools
