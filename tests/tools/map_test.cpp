#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "tests/support/golden.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

using nlohmann::json;

std::string belt() { return PLC_EXAMPLES "/hmi/hmi.xml"; }
std::string belt_configuration() { return PLC_EXAMPLES "/hmi/plc.toml"; }

/// plc map of the example as it is configured.
ToolResult map_as(const std::string& format) {
  return run_tool({PLC_TOOL, "map", belt(), "--config", belt_configuration(), "--format", format});
}

class MapFormats : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(MapFormats, OfTheExample) {
  const auto [format, file] = GetParam();
  const auto result = map_as(format);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_golden(std::string("tests/golden/map/") + file, result.out);
  EXPECT_EQ(map_as(format).out, result.out) << "equal inputs, equal output";
}

INSTANTIATE_TEST_SUITE_P(All, MapFormats,
                         testing::Values(std::pair{"table", "table.txt"}, std::pair{"csv", "variables.csv"},
                                         std::pair{"json", "variables.json"}, std::pair{"fuxa", "fuxa.json"},
                                         std::pair{"nodered", "nodered.json"}, std::pair{"scadalts", "scadalts.json"},
                                         std::pair{"ignition", "ignition.json"}),
                         [](const auto& format) { return std::string(format.param.first); });

/// The tag of a variable in FUXA's file.
json fuxa_tag(const json& devices, const std::string& name) {
  for (const json& tag : devices.at(0).at("tags")) {
    if (tag.at("name") == name) return tag;
  }
  return {};
}

/// Texts of one and two bytes a character, one longer than a request, and a number.
std::string texts() {
  return "VAR_GLOBAL\n  Recipe : STRING[5]; Title : WSTRING[3]; Letter : STRING[1]; Long : STRING[255]; Speed : DINT;\n"
         "END_VAR\nPROGRAM Main\n  Speed := Speed;\nEND_PROGRAM\nCONFIGURATION C\n  RESOURCE R ON PLC\n"
         "    TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n    PROGRAM main WITH T : Main;\n  END_RESOURCE\n"
         "END_CONFIGURATION\n";
}

TEST(Map, TextsAreInTheFilesOfHmisThatHaveThem) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("texts.st");
  write_text(project, texts());
  const auto mapped = [&](const char* format) { return run_tool({PLC_TOOL, "map", project, "--format", format}); };
  const json variables = json::parse(mapped("json").out).at("variables");
  const auto address = [&](const std::string& name) {
    for (const json& one : variables) {
      if (one.at("name") == name) return one.at("address1").get<int>();
    }
    return 0;
  };
  const auto ignition = mapped("ignition");
  EXPECT_NE(ignition.out.find("]HRS" + std::to_string(address("Recipe")) + ":6\""), std::string::npos) << ignition.out;
  EXPECT_NE(ignition.out.find("]HRS" + std::to_string(address("Letter")) + ":2\""), std::string::npos);
  EXPECT_NE(ignition.err.find("Title"), std::string::npos) << "left out, and said";
  EXPECT_NE(mapped("nodered").err.find("Long"), std::string::npos) << "no request reads it";
  EXPECT_NE(mapped("fuxa").err.find("Recipe"), std::string::npos);
}

TEST(Map, NodeRedFunctionsReadAndWriteTexts) {
  if (run_tool({"/usr/bin/env", "node", "--version"}).code != 0) GTEST_SKIP() << "node is not installed";
  const ScratchFolder scratch;
  write_text(scratch.file("texts.st"), texts());
  ASSERT_EQ(
      run_tool({PLC_TOOL, "map", scratch.file("texts.st"), "--format", "nodered", "-o", scratch.file("flow.json")})
          .code,
      0);
  // Writes go into registers, which are then read.
  write_text(scratch.file("try.js"), R"(
const flow = JSON.parse(require("fs").readFileSync(process.argv[2]));
const code = name => new Function("msg", "node", "flow", flow.find(n => n.name === name).func);
const none = {get() {}, set() {}, error(text) { console.log(text); }};
const registers = {};
for (const [topic, payload] of [["Recipe", "abcdefg"], ["Title", "€u"], ["Letter", "x"], ["Speed", -70000], ["Long", "?"]]) {
  const request = code("topic is the variable, payload the value")({topic, payload}, none, none);
  if (request) [].concat(request.payload.value).forEach((word, i) => { registers[request.payload.address + i] = word; });
}
for (const reading of flow.filter(n => n.type === "modbus-read" && n.dataType === "HoldingRegister")) {
  const payload = Array.from({length: reading.quantity}, (_, i) => registers[reading.adr + i] || 0);
  console.log(JSON.stringify(code("values by name")({topic: reading.topic, payload}, none, none).payload));
}
)");
  const ToolResult result = run_tool({"/usr/bin/env", "node", scratch.file("try.js"), scratch.file("flow.json")});
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("no variable that may be written: Long"), std::string::npos) << result.out;
  for (const char* value : {"\"Recipe\":\"abcde\"", "\"Title\":\"\u20acu\"", "\"Letter\":\"x\"", "\"Speed\":-70000"}) {
    EXPECT_NE(result.out.find(value), std::string::npos) << value << result.out;
  }
}

TEST(Map, FuxaCountsAddressesFromOne) {
  const json devices = json::parse(map_as("fuxa").out);
  const json real = fuxa_tag(devices, "SetTemperature");
  EXPECT_EQ(real.at("type"), "Float32");
  EXPECT_EQ(real.at("memaddress"), "400000");
  EXPECT_EQ(real.at("address"), "2049");
  EXPECT_EQ(fuxa_tag(devices, "PriceOfMwh").at("type"), "Float64");
  EXPECT_EQ(fuxa_tag(devices, "LevelRaw").at("memaddress"), "300000");
  EXPECT_EQ(fuxa_tag(devices, "DoorOpen").at("memaddress"), "100000");
  EXPECT_EQ(fuxa_tag(devices, "Lamp").at("memaddress"), "000000");
  EXPECT_EQ(devices.at(0).at("property").at("address"), "127.0.0.1:1502");
}

TEST(Map, NodeRedReadsEverythingInFewRequests) {
  const json flow = json::parse(map_as("nodered").out);
  std::size_t requests = 0;
  for (const json& node : flow) {
    if (node.contains("z")) {
      EXPECT_TRUE(node.contains("x") && node.contains("y")) << node.at("id") << ": Node-RED takes it for configuration";
    }
    if (node.at("type") != "modbus-read") continue;
    ++requests;
    const bool bits = node.at("dataType") == "Coil" || node.at("dataType") == "Input";
    EXPECT_LE(node.at("quantity"), bits ? 2000 : 125);
  }
  EXPECT_LE(requests, 12u);
}

TEST(Map, HostAndPortForTheHmi) {
  const auto result = run_tool({PLC_TOOL, "map", belt(), "--config", belt_configuration(), "--format", "json", "--host",
                                "192.168.7.2", "--port", "5020"});
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("host"), "192.168.7.2");
  EXPECT_EQ(document.at("port"), 5020);
}

TEST(Map, WithoutAConfigurationTheDefaultsHold) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  const auto result = run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--format", "json"});
  EXPECT_EQ(result.code, 0) << result.err;
  const json document = json::parse(result.out);
  EXPECT_EQ(document.at("port"), 502);
  for (const json& variable : document.at("variables")) {
    if (variable.at("name") == "Fahrenheit") {
      EXPECT_EQ(variable.at("access"), "rw");
    }
  }
}

TEST(Map, FreezingKeepsAddressesWhenTheProjectChanges) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("belt.xml"), lock = scratch.file("belt.modbus.csv");
  write_text(project, read_text(belt()));
  const auto loose = run_tool({PLC_TOOL, "map", project, "--format", "csv"});
  EXPECT_NE(loose.err.find("9 automatic addresses are not frozen"), std::string::npos) << loose.err;
  EXPECT_NE(loose.err.find("LampTest, "), std::string::npos) << loose.err;
  EXPECT_NE(loose.err.find("plc map " + project + " --freeze keeps them"), std::string::npos) << loose.err;
  write_text(scratch.file("plc.toml"), "");
  const auto configured = run_tool({PLC_TOOL, "map", project, "--config", scratch.file("plc.toml")});
  EXPECT_NE(configured.err.find("plc map " + project + " --config " + scratch.file("plc.toml") + " --freeze"),
            std::string::npos)
      << configured.err;

  const auto frozen = run_tool({PLC_TOOL, "map", project, "--format", "csv", "--freeze"});
  EXPECT_EQ(frozen.code, 0) << frozen.err;
  EXPECT_EQ(frozen.err.find(lock + ": 9 variables, 9 new: LampTest, "), 0u) << frozen.err;
  EXPECT_EQ(frozen.out, loose.out);
  const std::string kept = read_text(lock);
  EXPECT_NE(kept.find("\nLampTest,coils,16384,BOOL\n"), std::string::npos) << kept;

  std::string text = read_text(project);
  const std::string before = "<variable name=\"LampTest\">";
  const std::size_t declaration = text.rfind(before);
  ASSERT_NE(declaration, std::string::npos);
  text.insert(declaration, "<variable name=\"Newcomer\"><type><BOOL/></type></variable>");
  write_text(project, text);
  const auto changed = run_tool({PLC_TOOL, "map", project, "--format", "csv"});
  EXPECT_NE(changed.out.find("LampTest,BOOL,,coils,16384,"), std::string::npos) << changed.out;
  EXPECT_NE(changed.out.find("Newcomer,BOOL,,coils,16385,"), std::string::npos) << changed.out;
  EXPECT_NE(changed.err.find("1 automatic addresses are not frozen and may move when the project changes: Newcomer\n"),
            std::string::npos)
      << changed.err;
  EXPECT_EQ(read_text(lock), kept) << "only --freeze writes it";
}

TEST(Map, FreezingSaysWhatIsNewGoneOrUnchanged) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("belt.xml"), lock = scratch.file("belt.modbus.csv");
  write_text(project, read_text(belt()));
  ASSERT_EQ(run_tool({PLC_TOOL, "map", project, "--freeze"}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "map", project, "--freeze"}).err, lock + ": unchanged, 9 variables\n");

  write_text(lock, read_text(lock) + "Before,coils,16400,BOOL\n");
  const auto gone = run_tool({PLC_TOOL, "map", project});
  EXPECT_EQ(gone.code, 0);
  EXPECT_NE(gone.err.find("has 1 variable that the map does not have: Before\n"), std::string::npos) << gone.err;

  std::filesystem::remove(lock);
  std::string text = read_text(project);
  const std::size_t declaration = text.rfind("<variable name=\"LampTest\">");
  ASSERT_NE(declaration, std::string::npos);
  for (const char* name : {"ZetaA", "ZetaB"}) {
    text.insert(declaration, std::string("<variable name=\"") + name + "\"><type><BOOL/></type></variable>");
  }
  write_text(project, text);
  const auto many = run_tool({PLC_TOOL, "map", project});
  EXPECT_NE(many.err.find(", ZetaA and 1 more\n"), std::string::npos) << many.err;
}

TEST(Map, FreezingNothingWritesNothing) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  write_text(scratch.file("plc.toml"), "[modbus]\nexported = []\n");
  const auto result =
      run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--config", scratch.file("plc.toml"), "--freeze"});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "nothing to freeze: no variable has an automatic address\n");
  EXPECT_FALSE(std::filesystem::exists(scratch.file("belt.modbus.csv")));
}

TEST(Map, NothingIsFrozenWhenTheOutputCannotBeWritten) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  for (const char* output : {"no/such/map.txt", "belt.modbus.csv"}) {
    const auto result = run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--freeze", "-o", scratch.file(output)});
    EXPECT_EQ(result.code, 2) << output;
    EXPECT_FALSE(std::filesystem::exists(scratch.file("belt.modbus.csv"))) << output;
  }
}

TEST(Map, WhereAnHmiFindsTheServer) {
  struct Row {
    const char* listen;
    const char* address;  ///< in FUXA's file
    const char* said;     ///< part of it
  };
  const Row rows[] = {{"[::1]:1502", "[::1]:1502", ""},
                      {"192.168.7.2:502", "192.168.7.2:502", ""},
                      {"0.0.0.0:1502", "127.0.0.1:1502", "--host NAME for HMIs on other machines"},
                      {"[::]:1502", "127.0.0.1:1502", "--host NAME for HMIs on other machines"},
                      {"127.0.0.1:0", "127.0.0.1:502", "port 0"},
                      {"off", "127.0.0.1:502", "listen is \"off\""}};
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  ASSERT_EQ(run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--freeze"}).code, 0);
  for (const Row& row : rows) {
    write_text(scratch.file("plc.toml"), std::string("[modbus]\nlisten = \"") + row.listen + "\"\n");
    const auto with = [&](const std::string& format) {
      return run_tool(
          {PLC_TOOL, "map", scratch.file("belt.xml"), "--config", scratch.file("plc.toml"), "--format", format});
    };
    const auto fuxa = with("fuxa");
    EXPECT_EQ(json::parse(fuxa.out).at(0).at("property").at("address"), row.address) << row.listen;
    EXPECT_EQ(fuxa.err.empty(), row.said[0] == '\0') << row.listen << ": " << fuxa.err;
    EXPECT_NE(fuxa.err.find(row.said), std::string::npos) << row.listen << ": " << fuxa.err;
    EXPECT_EQ(with("table").err, "") << "names no server";
  }
  const auto six = run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--format", "json", "--host", "[fe80::1]"});
  EXPECT_EQ(json::parse(six.out).at("host"), "fe80::1");
}

TEST(Map, AnImageHasTheLockFileOfItsProject) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  ASSERT_EQ(run_tool({PLC_TOOL, "compile", scratch.file("belt.xml"), "-o", scratch.file("belt.pbc")}).code, 0);
  ASSERT_EQ(run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--freeze"}).code, 0);
  const auto image = run_tool({PLC_TOOL, "map", scratch.file("belt.pbc")});
  EXPECT_EQ(image.code, 0);
  EXPECT_EQ(image.err, "");
  EXPECT_EQ(image.out, run_tool({PLC_TOOL, "map", scratch.file("belt.xml")}).out);
}

TEST(Map, ADamagedLockFileIsNamedWithItsLine) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  const std::string damaged = "path,table,address,type\nA,coils,16384,BOOL\nB,coils,16384,BOOL\n";
  write_text(scratch.file("belt.modbus.csv"), damaged);
  const auto result = run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--freeze"});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_NE(result.err.find("P7502: " + scratch.file("belt.modbus.csv") + ":3:"), std::string::npos) << result.err;
  EXPECT_EQ(read_text(scratch.file("belt.modbus.csv")), damaged);
}

TEST(Map, InputsOfDevicesAreReadOnly) {
  const ScratchFolder scratch;
  write_text(scratch.file("plc.toml"),
             "[drivers.panel]\nkind = \"gpio\"\nchip = \"gpiochip0\"\n[inputs]\nLampTest = { driver = \"panel\", "
             "channel = 3 }\n");
  const auto result = run_tool({PLC_TOOL, "map", belt(), "--config", scratch.file("plc.toml"), "--format", "csv"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("LampTest,BOOL,,coils,16384,16385,0,0,,r,"), std::string::npos)
      << "the lock file beside the project has its address: " << result.out;
}

TEST(Map, WhatAnHmiHasNoTypeForIsLeftOutAndSaid) {
  const ScratchFolder scratch;
  write_text(scratch.file("plc.toml"), "[modbus]\nword_order = \"BADC\"\n");
  for (const char* format : {"fuxa", "scadalts", "ignition"}) {
    const auto result = run_tool({PLC_TOOL, "map", belt(), "--config", scratch.file("plc.toml"), "--format", format});
    EXPECT_EQ(result.code, 0) << result.err;
    EXPECT_NE(result.err.find("8 variables left out, the first is \"SetTemperature\""), std::string::npos)
        << result.err;
    EXPECT_EQ(result.out.find("SetTemperature"), std::string::npos) << format;
    EXPECT_NE(result.out.find("SetSpeed"), std::string::npos) << format;
  }
}

TEST(Map, LowWordFirst) {
  const ScratchFolder scratch;
  write_text(scratch.file("plc.toml"), "[modbus]\nword_order = \"CDAB\"\n");
  const auto with = [&](const char* format) {
    return run_tool({PLC_TOOL, "map", belt(), "--config", scratch.file("plc.toml"), "--format", format});
  };
  const json devices = json::parse(with("fuxa").out);
  EXPECT_EQ(fuxa_tag(devices, "SetTemperature").at("type"), "Float32MLE");
  EXPECT_EQ(fuxa_tag(devices, "SetPieces").at("type"), "Int32MLE");
  EXPECT_EQ(fuxa_tag(devices, "SetPrice"), json()) << "FUXA has no 64-bit type of that order";
  EXPECT_NE(with("scadalts").out.find("EIGHT_BYTE_FLOAT_SWAPPED"), std::string::npos);
}

TEST(Map, WritesAFileButNeverWhatItIsMadeFrom) {
  const ScratchFolder scratch;
  write_text(scratch.file("belt.xml"), read_text(belt()));
  ASSERT_EQ(run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "--freeze", "-o", scratch.file("map.txt")}).code, 0);
  EXPECT_NE(read_text(scratch.file("map.txt")).find("SetSpeed"), std::string::npos);
  for (const char* name : {"belt.xml", "belt.modbus.csv"}) {
    const std::string before = read_text(scratch.file(name));
    EXPECT_EQ(run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "-o", scratch.file(name)}).code, 2) << name;
    EXPECT_EQ(read_text(scratch.file(name)), before) << name;
  }
  EXPECT_EQ(run_tool({PLC_TOOL, "map", scratch.file("belt.xml"), "-o", scratch.file("no/such/map.txt")}).code, 2);
}

TEST(Map, WrongFlagsAndFiles) {
  EXPECT_EQ(run_tool({PLC_TOOL, "map", belt(), "--format", "excel"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "map", belt(), "--port", "0"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "map", belt(), "--config", "no-such.toml"}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "map", "no-such.xml"}).code, 2);
}

TEST(Map, PortsOfATaskblockTellUnitRangeAndMeaning) {
  const ScratchFolder scratch;
  const std::string project = scratch.file("gear.st");
  write_text(project,
             "PROGRAM Main\nVAR_EXTERNAL Gears : ARRAY [1..2] OF GEAR; END_VAR VAR x : LREAL; END_VAR\n"
             "  Gears[2](MASTER := x);\n  x := Gears[2].SLAVE + 1.0;\nEND_PROGRAM\n"
             "CONFIGURATION C VAR_GLOBAL Gears : ARRAY [1..2] OF GEAR; END_VAR\n"
             "TASK T(INTERVAL := T#20ms); PROGRAM main WITH T : Main; END_CONFIGURATION\n");
  const json document = json::parse(run_tool({PLC_TOOL, "map", project, "--format", "json"}).out);
  std::map<std::string, json> by_name;
  for (const json& row : document.at("variables")) by_name[row.at("name")] = row;
  ASSERT_EQ(by_name.size(), 22u) << "ports, and no hidden fields: " << document;
  const json& modulo = by_name["Gears[2].MODULO"];
  EXPECT_EQ(modulo.at("unit"), "u");
  EXPECT_EQ(modulo.at("min"), 0.0);
  EXPECT_FALSE(modulo.contains("max"));
  EXPECT_EQ(modulo.at("comment"), "range of a rotary MASTER, or 0");
  EXPECT_EQ(modulo.at("access"), "r") << "a constant of the project";
  const json& ratio = by_name["Gears[1].RATIO"];
  EXPECT_EQ(ratio.at("comment"), "at this moment");
  EXPECT_FALSE(ratio.contains("unit"));
  const std::string csv = run_tool({PLC_TOOL, "map", project, "--format", "csv"}).out;
  EXPECT_NE(csv.find(",0,,\"range of a rotary MASTER, or 0, u\"\n"), std::string::npos) << csv;
}

}  // namespace
}  // namespace plc::test
