// plc modbus scan, read and write against servers of our own, over TCP and a serial line, and against peers that are
// none: what is printed, exit codes.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "io-drivers/modbus/serial_server.h"
#include "tests/support/modbus_peers.h"
#include "tests/support/serial_line.h"
#include "tests/tools/fixture.h"
#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

struct Case {
  const char* name;
  std::vector<std::string> arguments;  ///< BUS is where the server is
  int code = 0;
  std::string out, err = {};
};

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
  return text;
}

/// Runs each in turn: what one writes, the next reads.
void run_all(std::span<const Case> cases, const std::string& bus, const std::vector<std::string>& more = {}) {
  for (const Case& one : cases) {
    std::vector<std::string> command = {PLC_TOOL, "modbus"};
    for (const std::string& argument : one.arguments) command.push_back(replaced(argument, "BUS", bus));
    command.insert(command.end(), more.begin(), more.end());
    const ToolResult result = run_tool(command);
    EXPECT_EQ(result.code, one.code) << one.name;
    EXPECT_EQ(replaced(result.out, bus, "BUS"), one.out) << one.name;
    EXPECT_EQ(replaced(result.err, bus, "BUS"), one.err) << one.name;
  }
}

const std::string kIdentity = "PICARD PICARD-PLC " PLC_VERSION_TEXT;

// What holds over TCP as on a line.
const Case kGood[] = {
    {"zeros", {"read", "BUS", "holding-registers", "1024", "--count", "2"}, 0, "1024 0\n1025 0\n"},
    {"write", {"write", "BUS", "holding-registers", "1024", "--type", "INT", "--value=-5", "--value=20"}, 0, ""},
    {"read INT",
     {"read", "BUS", "holding-registers", "1024", "--count", "2", "--type", "INT"},
     0,
     "1024 -5\n1025 20\n"},
    {"read UINT", {"read", "BUS", "holding-registers", "1024"}, 0, "1024 65531\n"},
    {"write REAL", {"write", "BUS", "holding-registers", "2056", "--type", "REAL", "--value=123.456"}, 0, ""},
    {"read REAL", {"read", "BUS", "holding-registers", "2056", "--type", "REAL"}, 0, "2056 123.456\n"},
    {"its words", {"read", "BUS", "holding-registers", "2056", "--count", "2"}, 0, "2056 17142\n2057 59769\n"},
    {"write REAL, low word first",
     {"write", "BUS", "holding-registers", "2056", "--type", "REAL", "--word-order", "CDAB", "--value=123.456"},
     0,
     ""},
    {"exchanged", {"read", "BUS", "holding-registers", "2056", "--count", "2"}, 0, "2056 59769\n2057 17142\n"},
    {"write LINT",
     {"write", "BUS", "holding-registers", "4096", "--type", "LINT", "--value=-9000000000", "--value=1"},
     0,
     ""},
    {"read LINT",
     {"read", "BUS", "holding-registers", "4096", "--type", "LINT", "--count", "2"},
     0,
     "4096 -9000000000\n4100 1\n"},
    {"write coils", {"write", "BUS", "coils", "3", "--value=TRUE", "--value=0", "--value=1"}, 0, ""},
    {"read coils", {"read", "BUS", "coils", "2", "--count", "5"}, 0, "2 0\n3 1\n4 0\n5 1\n6 0\n"},
    {"write a coil", {"write", "BUS", "coils", "3", "--value=FALSE"}, 0, ""},
    {"read a coil", {"read", "BUS", "coils", "3"}, 0, "3 0\n"},
    {"function 16 for one", {"write", "BUS", "holding-registers", "1030", "--value=7", "--multiple"}, 0, ""},
    {"input registers", {"read", "BUS", "input-registers", "0"}, 0, "0 0\n"},
    {"no such address",
     {"read", "BUS", "holding-registers", "60000"},
     1,
     "",
     "plc modbus: BUS, unit 1: exception 2: it has no such address\n"},
    {"may not be written",
     {"write", "BUS", "holding-registers", "1325", "--value=1"},
     1,
     "",
     "plc modbus: BUS, unit 1: exception 2: it has no such address\n"},
    {"no such value",
     {"write", "BUS", "holding-registers", "1324", "--value=101"},
     1,
     "",
     "plc modbus: BUS, unit 1: exception 3: it does not take this number of values, or this value\n"},
    {"another unit",
     {"read", "BUS", "holding-registers", "1024", "--unit", "2"},
     1,
     "",
     "plc modbus: BUS, unit 2: it does not answer in time\n"},
    {"scan", {"scan", "BUS", "--units", "1-2"}, 0, "unit 1: " + kIdentity + "\n"},
    {"scan of another unit",
     {"scan", "BUS", "--units", "2"},
     1,
     "",
     "plc modbus: BUS: no unit from 2 to 2 answers\n"
     "  help: --line sets speed and parity of a serial line, --timeout waits longer\n"},
};

TEST(PlcModbus, ReadsWritesAndScansOverTcp) {
  io::ModbusConfig one_unit;
  one_unit.unit_id = 1;
  const PlantServer plant(one_unit);
  run_all(kGood, "127.0.0.1:" + std::to_string(plant.server.port()), {"--timeout", "300ms"});
}

TEST(PlcModbus, ReadsWritesAndScansOnALine) {
  Plant plant;
  modbus::Responder responder(*plant.resource, plant.map, plant.config);
  const SerialCable cable;
  io::ModbusSerialConfig config;
  config.path.text = cable.path(0);
  config.line.text = "115200 8N1";
  modbus::SerialServer server(responder, config);
  server.start();
  while (server.take_said().empty()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  run_all(kGood, cable.path(1), {"--timeout", "300ms", "--line", "115200 8N1"});
}

TEST(PlcModbus, BehindAGatewayUnitsThatAreNotThereAreNotListed) {
  io::ModbusConfig gateway;
  gateway.unit_id = 3;
  gateway.unit_exception = true;
  const PlantServer plant(gateway);
  const Case cases[] = {
      {"scan", {"scan", "BUS", "--units", "1-10"}, 0, "unit 3: " + kIdentity + "\n"},
      {"read",
       {"read", "BUS", "coils", "0"},
       1,
       "",
       "plc modbus: BUS, unit 1: exception 11: it does not answer the gateway\n"},
  };
  run_all(cases, "127.0.0.1:" + std::to_string(plant.server.port()));
}

TEST(PlcModbus, WhatIsNoModbusIsNamed) {
  const TcpPeer web([](const Bytes&) { return Reaction{{Bytes{'H', 'T', 'T', 'P', '/', '1', '.', '1', ' ', '4'}}}; });
  const Case cases[] = {
      {"scan",
       {"scan", "BUS", "--units", "1"},
       0,
       "unit 1: something that is no Modbus, or two devices with this unit, or another speed\n"},
      {"read", {"read", "BUS", "coils", "0"}, 1, "", "plc modbus: BUS, unit 1: its answer is not one to the request\n"},
  };
  run_all(cases, web.bus());
}

TEST(PlcModbus, AnIdentityIsPrintedWithoutWhatATerminalWouldObey) {
  const TcpPeer peer([](const Bytes& request) {
    Bytes answer = {0x83, 1};
    if (request[7] == 0x2b) answer = {0x2b, 14, 1, 1, 0, 0, 2, 0, 5, 'A', 'C', 0x1b, '[', 'm', 1, 1, 'X'};
    const auto transaction = static_cast<std::uint16_t>(request[0] << 8 | request[1]);
    return Reaction{{modbus_client::tcp_frame(transaction, request[6], answer)}};
  });
  const Case cases[] = {{"scan", {"scan", "BUS", "--units", "9"}, 0, "unit 9: AC?[m X\n"}};
  run_all(cases, peer.bus());
}

TEST(PlcModbus, NobodyThere) {
  std::string bus;
  {
    bus = TcpPeer([](const Bytes&) { return Reaction{}; }).bus();
  }
  const Case cases[] = {
      {"read",
       {"read", "BUS", "coils", "0"},
       1,
       "",
       "plc modbus: BUS, unit 1: it cannot be connected to (Connection refused)\n"},
      {"write",
       {"write", "BUS", "coils", "0", "--value=1"},
       1,
       "",
       "plc modbus: BUS, unit 1: it cannot be connected to (Connection refused)\n"},
      {"scan", {"scan", "BUS"}, 1, "", "plc modbus: BUS, unit 1: it cannot be connected to (Connection refused)\n"},
      {"no line",
       {"read", "/dev/no-such-line", "coils", "0"},
       1,
       "",
       "plc modbus: /dev/no-such-line, unit 1: it cannot be connected to (No such file or directory)\n"},
      {"no line at all",
       {"read", "/dev/null", "coils", "0"},
       1,
       "",
       "plc modbus: /dev/null, unit 1: it cannot be connected to (Inappropriate ioctl for device)\n"},
  };
  run_all(cases, bus);
}

TEST(PlcModbus, BadUseIsRefusedBeforeAnythingIsSent) {
  const TcpPeer peer([](const Bytes&) { return Reaction{}; });
  const struct {
    std::vector<std::string> arguments;
    const char* said;
  } rows[] = {
      {{"read"}, "BUS"},
      {{"frobnicate"}, "there is no command \"frobnicate\""},
      {{"read", "COM3", "coils", "0"}, "\"COM3\" is neither an IP address, a host name nor the path of a serial line"},
      {{"read", "BUS", "coil", "0"}, "coil"},
      {{"read", "BUS", "coils"}, "ADDRESS"},
      {{"read", "BUS", "coils", "65536"}, "65535"},
      {{"read", "BUS", "coils", "-1"}, ""},
      {{"read", "BUS", "coils", "0", "--count", "0"}, "--count"},
      {{"read", "BUS", "coils", "0", "--count", "2001"}, "--count"},
      {{"read", "BUS", "coils", "65535", "--count", "2"},
       "one request reads at most 2000 of coils, up to address 65535"},
      {{"read", "BUS", "holding-registers", "0", "--count", "63", "--type", "REAL"},
       "one request reads at most 125 of holding-registers, up to address 65535"},
      {{"read", "BUS", "holding-registers", "0", "--type", "BYTE"}, "BYTE"},
      {{"read", "BUS", "holding-registers", "0", "--unit", "256"}, "--unit"},
      {{"read", "BUS", "holding-registers", "0", "--timeout", "0s"}, "\"0s\" is no duration up to 1h"},
      {{"read", "BUS", "holding-registers", "0", "--line", "9600"}, "\"9600\" is not like \"19200 8E1\""},
      {{"read", "BUS", "coils", "0", "--type", "REAL"}, "coils have no type"},
      {{"write", "/dev/no-such-line", "coils", "0", "--value=1", "--unit", "0"}, "unit 0 is none on a serial line"},
      {{"read", "/dev/no-such-line", "coils", "0", "--unit", "248"}, "unit 248 is none on a serial line"},
      {{"write", "BUS", "coils", "0"}, "--value"},
      {{"write", "BUS", "input-registers", "0", "--value=1"}, "no function of Modbus writes input-registers"},
      {{"write", "BUS", "holding-registers", "0", "--value=x"}, "\"x\""},
      {{"write", "BUS", "holding-registers", "0", "--value=65536"}, "65536"},
      {{"write", "BUS", "holding-registers", "0", "--type", "INT", "--value=-32769"}, "-32769"},
      {{"write", "BUS", "coils", "0", "--value=2"}, "2"},
      {{"write", "BUS", "holding-registers", "65535", "--value=1", "--value=2"},
       "one request writes at most 123 of holding-registers, up to address 65535"},
      {{"scan", "BUS", "--units", "9-1"}, "from 0 to 255: 1-247"},
      {{"scan", "BUS", "--units", "1-256"}, "from 0 to 255: 1-247"},
  };
  for (const auto& row : rows) {
    std::vector<std::string> command = {PLC_TOOL, "modbus"};
    std::string shown;
    for (const std::string& argument : row.arguments) {
      command.push_back(argument == "BUS" ? peer.bus() : argument);
      shown += argument + ' ';
    }
    const ToolResult result = run_tool(command);
    EXPECT_EQ(result.code, 2) << shown;
    EXPECT_EQ(result.out, "") << shown;
    EXPECT_NE(result.err.find(row.said), std::string::npos) << shown << result.err;
  }
  EXPECT_EQ(peer.connections(), 0);
}

TEST(PlcModbus, TheFunctionIsTheOneThatDevicesExpect) {
  std::atomic<int> function = 0;
  const TcpPeer peer([&](const Bytes& request) {
    function = request[7];
    const auto transaction = static_cast<std::uint16_t>(request[0] << 8 | request[1]);
    return Reaction{{modbus_client::tcp_frame(transaction, request[6], std::span(request).subspan(7, 5))}};
  });
  const struct {
    std::vector<std::string> arguments;
    int function;
  } rows[] = {
      {{"coils", "0", "--value=1"}, 5},
      {{"coils", "0", "--value=1", "--multiple"}, 15},
      {{"coils", "0", "--value=1", "--value=0"}, 15},
      {{"holding-registers", "0", "--value=1"}, 6},
      {{"holding-registers", "0", "--value=1", "--multiple"}, 16},
      {{"holding-registers", "0", "--value=1.5", "--type", "REAL"}, 16},
  };
  for (const auto& row : rows) {
    std::vector<std::string> command = {PLC_TOOL, "modbus", "write", peer.bus()};
    command.insert(command.end(), row.arguments.begin(), row.arguments.end());
    EXPECT_EQ(run_tool(command).code, 0);
    EXPECT_EQ(function, row.function);
  }
}

std::uint16_t free_port() {
  return TcpPeer([](const Bytes&) { return Reaction{}; }).port();
}

TEST(PlcRunModbus, ServesTcpAndALineAtOnce) {
  const ScratchFolder scratch;
  const SerialCable cable;
  const std::string tcp = "127.0.0.1:" + std::to_string(free_port());
  write_text(
      scratch.file("plant.st"),
      "PROGRAM Main\nVAR Setpoint AT %MW0 : INT; Level AT %QW0 : INT; END_VAR\n  Level := Setpoint;\nEND_PROGRAM\n"
      "CONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
      "    PROGRAM main WITH T : Main;\n  END_RESOURCE\nEND_CONFIGURATION\n");
  write_text(scratch.file("plc.toml"), "[modbus]\nlisten = \"" + tcp + "\"\n[modbus.serial]\npath = \"" +
                                           cable.path(0) + "\"\nline = \"115200 8E1\"\nunit = 5\n");
  ToolResult plant;
  std::thread running([&] {
    plant = run_tool({PLC_RUN_TOOL, scratch.file("plant.st"), "--config", scratch.file("plc.toml"), "--engineering",
                      "off", "--duration", "6s", "--stats"});
  });
  const auto on_line = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {PLC_TOOL, "modbus"});
    arguments.insert(arguments.end(), {"--unit", "5", "--line", "115200 8E1"});
    return run_tool(arguments);
  };
  for (int i = 0; i < 100; ++i) {
    if (on_line({"write", cable.path(1), "holding-registers", "1024", "--value=77"}).code == 0) break;
  }
  const auto over_tcp = [&] { return run_tool({PLC_TOOL, "modbus", "read", tcp, "holding-registers", "0"}).out; };
  std::string level = over_tcp();
  for (int i = 0; i < 100 && level != "0 77\n"; ++i) level = over_tcp();
  EXPECT_EQ(level, "0 77\n") << "written on the line, moved by the program, read over TCP";
  EXPECT_EQ(on_line({"read", cable.path(1), "holding-registers", "0"}).out, level);
  running.join();
  EXPECT_EQ(plant.code, 0) << plant.err;
  EXPECT_NE(plant.all().find("modbus: listening on " + tcp), std::string::npos) << plant.all();
  EXPECT_NE(plant.all().find("modbus: listening on " + cable.path(0) + " (115200 8E1) as unit 5"), std::string::npos);
  EXPECT_NE(plant.out.find("modbus: on the serial line "), std::string::npos) << plant.out;
}

}  // namespace
}  // namespace plc::test
