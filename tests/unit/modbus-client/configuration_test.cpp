// What plc.toml may say of kind = "modbus", and what is wrong with the rest.
#include <gtest/gtest.h>

#include "io-drivers/machine/driver_types.h"
#include "tests/unit/modbus-client/rig.h"

namespace plc::test {
namespace {

/// Problems of the file, of its variables, and of check_files().
std::string problems(const std::string& text) {
  core::Diagnostics diagnostics;
  const auto resource = copier();
  auto configuration = io::read_configuration(text, "plc.toml", io::driver_types(), diagnostics);
  std::optional<io::Binding> binding;
  if (configuration) binding = io::bind(*configuration, *resource, diagnostics);
  std::string all;
  for (const core::Diagnostic& d : diagnostics.all()) all += diagnostics.render_one(d) + '\n';
  if (!binding) return all;
  for (const io::BoundDriver& bound : binding->drivers) {
    const auto problem = bound.config->type->check_files(bound, *configuration, *resource);
    if (problem) all += std::string(core::info(problem->code).name) + ' ' + problem->message + '\n';
  }
  return all;
}

const std::string kDev = "[drivers.dev]\nkind = \"modbus\"\nbus = \"10.0.0.5\"\n";
std::string input(const std::string& name, const std::string& keys) {
  return kDev + "[inputs]\n" + name + " = { driver = \"dev\", " + keys + " }\n";
}
std::string outputs(const std::string& first, const std::string& second) {
  return kDev + "[outputs]\nOut0 = { driver = \"dev\", " + first + " }\nOut1 = { driver = \"dev\", " + second + " }\n";
}

TEST(Configuration, MistakesAreReportedAtTheirPlaces) {
  const std::string table = "table = \"holding-registers\", address = 1";
  const std::pair<std::string, std::string> rows[] = {
      {input("In0", table), ""},
      {input("Ok", "status = \"ok\""), ""},
      {input("Age", "status = \"age\"") + "Error = { driver = \"dev\", status = \"error\" }\n", ""},
      {"[drivers.dev]\nkind = \"modbus\"\nbus = \"ttyUSB0\"\n",
       "3:7: error P7305: \"ttyUSB0\" is neither an IP address, a host name nor the path of a serial line\n"},
      {"[drivers.dev]\nkind = \"modbus\"\nbus = \"/dev/ttyS0\"\nline = \"9600\"\n",
       "4:8: error P7305: \"9600\" is no setting of a serial line\n"},
      {"[drivers.dev]\nkind = \"modbus\"\nbus = \"/dev/ttyS0\"\nunit = 250\n",
       "4:8: error P7305: unit 250 is none on a serial line\n"},
      {kDev + "unit = 256\n", "4:8: error P7305: \"unit\" is \"256\"; it takes a whole number from 0 to 255\n"},
      {input("In0", "address = 1"), "5:1: error P7306: \"In0\" has no \"table\"\n"},
      {input("In0", "table = \"coils\""), "5:1: error P7306: \"In0\" has no \"address\"\n"},
      {input("In0", "table = \"coil\", address = 70000"), "5:51: error P7305: \"address\" is \"70000\""},
      {outputs("status = \"ok\"", table), "error P7307: \"status\" does not belong to output \"Out0\""},
      {kDev + "retry = \"10s\"\nretry_max = \"1s\"\n", "5:13: error P7311: \"retry_max\" is shorter than \"retry\"\n"},
      {kDev + "retry = \"1min\"\n", ""},
      {input("Flag", table + ", bit = 3, scale = 2"), "\"bit\" is of one register, without \"scale\" and \"offset\"\n"},
      {input("Flag", table + ", bit = 3, type = \"DINT\""), "\"bit\" is of one register"},
      {input("Flag", table + ", bit = 3, type = \"UINT\""), ""},
      {kDev + "max_registers = 1\n[inputs]\nReal = { driver = \"dev\", " + table + " }\n",
       "P7305 \"Real\" takes 2 registers, and \"max_registers\" is 1\n"},
      {input("In0", "status = \"ok\", address = 1"),
       "5:50: error P7311: \"address\" does not go with \"status\": it is not in the device\n"},
      {outputs("table = \"input-registers\", address = 1", table),
       "5:34: error P7311: no function of Modbus writes input-registers\n"},
      {input("Flag", "table = \"coils\", address = 1, scale = 2"), "5:64: error P7307: coils have no \"scale\"\n"},
      {input("In0", table + ", scale = 0"), "error P7305: \"scale\" is \"0\"; it takes a number other than 0\n"},
      {input("In0", table + ", offset = \"x\""), "error P7305: \"offset\" is \"x\"; it takes a number\n"},
      {input("In0", "table = \"coils\", address = 1"),
       "5:1: error P7322: \"In0\" has type INT, coils and discrete inputs are BOOLs\n"},
      {input("Flag", table), "5:1: error P7322: \"Flag\" has type BOOL, a BOOL in a register needs \"bit\"\n"},
      {input("In0", table + ", bit = 3"), "5:1: error P7322: \"In0\" has type INT, \"bit\" is for a BOOL\n"},
      {input("Text", table), ""},
      {input("Text", table + ", registers = 2, word_order = \"BADC\""), ""},
      {input("Text", "table = \"coils\", address = 1"), "has type STRING, coils and discrete inputs are BOOLs\n"},
      {input("Text", table + ", scale = 2"),
       "has type STRING, a text has neither \"type\" nor \"scale\" nor \"offset\"\n"},
      {input("In0", table + ", registers = 2"), "has type INT, \"registers\" is for a text\n"},
      {input("Text", "table = \"holding-registers\", address = 65532"),
       "P7305 \"Text\" ends after the last address, 65535\n"},
      {input("In0", "status = \"ok\""), "5:1: error P7322: \"In0\" has type INT, ok is a BOOL\n"},
      {input("In0", "status = \"age\""), "5:1: error P7322: \"In0\" has type INT, an age is a TIME\n"},
      {input("Ok", "status = \"error\""), "\"Ok\" has type BOOL, an error is a number of 16 bits or more\n"},
      {input("In0", table + ", substitute = 70000"),
       "5:1: error P7322: \"In0\" has type INT, of which its substitute is no value\n"},
      {input("Real", "table = \"holding-registers\", address = 65535"),
       "P7305 \"Real\" ends after the last address, 65535\n"},
      {outputs(table, table), "P7310 \"Out0\" and \"Out1\" are both written to address 1 of holding-registers\n"},
      {"[drivers.a]\nkind = \"modbus\"\nbus = \"/dev/ttyS0\"\n[drivers.b]\nkind = \"modbus\"\nbus = "
       "\"/dev/ttyS0\"\nline "
       "= \"9600 8N1\"\n",
       "P7311 drivers \"a\" and \"b\" set the line /dev/ttyS0 differently: \"19200 8E1\" and \"9600 8N1\"\n"},
      {"[drivers.a]\nkind = \"modbus\"\nbus = \"10.0.0.5\"\n[drivers.b]\nkind = \"modbus\"\nbus = \"10.0.0.5:502\"\n"
       "[outputs]\nOut0 = { driver = \"a\", " +
           table + " }\nOut1 = { driver = \"b\", " + table + " }\n",
       "P7310 \"Out1\" and \"Out0\" of driver \"a\" are both written to address 1 of holding-registers\n"},
      {"[drivers.a]\nkind = \"modbus\"\nbus = \"10.0.0.5\"\n[drivers.b]\nkind = \"modbus\"\nbus = \"10.0.0.5\"\nunit = "
       "2\n"
       "[outputs]\nOut0 = { driver = \"a\", " +
           table + " }\nOut1 = { driver = \"b\", " + table + " }\n",
       ""},
      {"[drivers.a]\nkind = \"modbus\"\nbus = \"/dev/ttyS0\"\n[modbus.serial]\npath = \"/dev/ttyS0\"\n",
       "P7311 driver \"a\" asks devices on the line /dev/ttyS0, and [modbus.serial] answers there\n"},
  };
  for (const auto& [text, problem] : rows) {
    const std::string found = problems(text);
    EXPECT_EQ(found.empty(), problem.empty()) << text << found;
    EXPECT_NE(found.find(problem), std::string::npos) << text << found;
  }
}

TEST(Configuration, AWrongValueIsNoMissingKey) {
  for (const char* const rest : {"table = \"coil\", address = 70000", "status = \"age?\""}) {
    const std::string found = problems(input("In0", rest));
    EXPECT_EQ(found.find("P7306"), std::string::npos) << found;
  }
  EXPECT_EQ(problems(outputs("status = \"ok\"", "table = \"coils\", address = 1")).find("P7306"), std::string::npos);
}

TEST(Configuration, TheDoctorLooksForTheWayToADevice) {
  const auto problem = [](const std::string& bus) {
    static constexpr const io::DriverType* types[] = {&modbus_client::kModbusType};
    core::Diagnostics diagnostics;
    const auto configuration = io::read_configuration("[drivers.dev]\nkind = \"modbus\"\nbus = \"" + bus + "\"\n",
                                                      "plc.toml", types, diagnostics);
    const auto found = modbus_client::kModbusType.check_device(configuration.value().drivers.at(0), {}, {});
    return found ? std::string(core::info(found->code).name) + ' ' + found->message : "";
  };
  EXPECT_EQ(problem("127.0.0.1:1"), "") << "it is not connected to";
  EXPECT_EQ(problem("localhost"), "");
  EXPECT_EQ(problem("/dev/no-such-line"), "") << "the doctor looks at nodes itself";
  EXPECT_EQ(problem("[fe80::1]:502").find("P7955 no way leads to fe80::1: "), 0u);
  EXPECT_EQ(problem("no-such-host.invalid").find("P7955 nobody knows the name no-such-host.invalid: "), 0u);
}

TEST(Configuration, EveryKeyIsRead) {
  const Rig rig(kDev +
                "unit = 9\npoll = \"20ms\"\nwrite = \"5ms\"\nrewrite = \"3s\"\ntimeout = \"70ms\"\nretries = 4\n"
                "retry = \"2s\"\nretry_max = \"9s\"\ngap = 3\nmax_registers = 124\nword_order = \"CDAB\"\n"
                "multiple = true\nline = \"9600 8N1\"\n[inputs]\n"
                "Real = { driver = \"dev\", table = \"input-registers\", address = 6, type = \"UDINT\", scale = 0.5, "
                "offset = -1, substitute = 2.5, poll = \"1s\", word_order = \"BADC\" }\n"
                "Flag = { driver = \"dev\", table = \"holding-registers\", address = 7, bit = 3, invert = true }\n");
  const modbus_client::DeviceSettings& settings = rig.device->settings();
  EXPECT_EQ(settings.where, "10.0.0.5:502, unit 9");
  EXPECT_EQ(settings.unit, 9);
  EXPECT_EQ(settings.write_ns, 5'000'000);
  EXPECT_EQ(settings.rewrite_ns, 3'000'000'000);
  EXPECT_EQ(settings.timeout_ns, 70'000'000);
  EXPECT_EQ(settings.retries, 4u);
  EXPECT_EQ(settings.retry_ns, 2'000'000'000);
  EXPECT_EQ(settings.retry_max_ns, 9'000'000'000);
  EXPECT_EQ(settings.read_limits.gap, 3);
  EXPECT_EQ(settings.read_limits.registers, 124);
  EXPECT_EQ(settings.read_limits.bits, 1984);
  EXPECT_EQ(settings.write_limits.registers, 123);
  EXPECT_EQ(settings.write_limits.bits, 1968);
  EXPECT_TRUE(settings.multiple);
  core::Diagnostics diagnostics;
  const auto binding = io::bind(*rig.configuration, *copier(), diagnostics);
  EXPECT_EQ(modbus_client::address_of(*binding.value().drivers[0].config).line,
            (modbus_client::LineSettings{9600, 8, modbus_rtu::Parity::kNone, 1}));
  const auto points = modbus_client::points_of(binding->drivers[0], *rig.resource);
  ASSERT_EQ(points.reads.size(), 2u);
  EXPECT_EQ(points.reads[0].want.count, 2);
  EXPECT_EQ(points.reads[0].want.period_ns, 1'000'000'000);
  EXPECT_EQ(points.reads[0].coding.raw, modbus_client::Raw::kUdint);
  EXPECT_EQ(points.reads[0].coding.order, io::WordOrder::kBadc);
  EXPECT_EQ(points.reads[0].coding.scale, 0.5);
  EXPECT_EQ(points.reads[0].coding.offset, -1);
  EXPECT_EQ(points.reads[0].substitute, bytes_of(2.5F));
  EXPECT_EQ(points.reads[1].want.period_ns, 20'000'000);
  EXPECT_EQ(points.reads[1].coding.bit, 3);
  EXPECT_TRUE(points.reads[1].coding.invert);
}

}  // namespace
}  // namespace plc::test
