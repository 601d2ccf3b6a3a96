#include <gtest/gtest.h>

#include <set>
#include <string>

#include "io-drivers/config/configuration.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/gpio/gpio_driver.h"
#include "io-drivers/machine/driver_types.h"

namespace plc::io {
namespace {

/// The configuration of a text that has no problems.
Configuration good(std::string_view text) {
  core::Diagnostics diagnostics;
  auto configuration = read_configuration(text, "plc.toml", driver_types(), diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
  return configuration.value_or(Configuration{});
}

TEST(ReadConfiguration, ACompleteFile) {
  const Configuration c = good(R"(
[drivers.panel]
kind = "gpio"
chip = "gpiochip0"
task = "Fast"
on_loss = "zero"
retry = "2.5s"
ok = "PanelOk"
[drivers.slow]
kind = "gpio"
chip = "expander"
poll = "5ms"
[drivers.bench]
kind = "simulated"
stimulus = "in.csv"
[inputs]
"%IX0.0" = { driver = "panel", channel = 17, bias = "pull-up", invert = true, latch = "falling", active_low = true }
StartButton = { driver = "panel", channel = "START" }
"Tank.Level" = { driver = "bench" }
[outputs]
"%QX0.0" = { driver = "panel", channel = 22, safe = true, initial = false, drive = "open-drain" }
Speed = { driver = "bench", safe = -12, initial = 0.5 }
Text = { driver = "bench", safe = "idle" }
[modbus]
listen = "[::1]:1502"
read_only = true
writable = ["Main.*", "Level"]
exported = []
word_order = "CDAB"
strict_gaps = true
unit_id = 7
unit_exception = true
max_clients = 5
max_clients_per_address = 2
frame_timeout = "100ms"
idle_timeout = "1h"
lock_file = "addresses.csv"
client_seen = "Seen"
client_timeout = "3s"
[[modbus.range]]
table = "input-registers"
first = 10
last = 20
word_order = "DCBA"
[[modbus.range]]
table = "coils"
writable = false
[guardian]
enabled = false
hang_timeout = "0s"
)");
  EXPECT_EQ(c.file, "plc.toml");
  ASSERT_EQ(c.drivers.size(), 3u);
  const DriverConfig& panel = c.drivers[0];
  EXPECT_EQ(panel.name, "panel");
  EXPECT_EQ(panel.type->name, "gpio");
  EXPECT_EQ(panel.values.text("chip"), "gpiochip0");
  EXPECT_EQ(panel.task.text, "Fast");
  EXPECT_EQ(panel.task.at.line, 5u);
  EXPECT_EQ(panel.task.at.column, 8u);
  EXPECT_EQ(panel.on_loss, OnLoss::kZero);
  EXPECT_EQ(panel.retry_ns, 2'500'000'000);
  EXPECT_EQ(panel.ok.text, "PanelOk");
  EXPECT_EQ(panel.values.has("poll"), false);
  EXPECT_EQ(c.drivers[1].values.number("poll"), 5'000'000);
  EXPECT_EQ(c.drivers[2].name, "bench");  // in the order of the file, not of the alphabet
  EXPECT_EQ(c.drivers[2].type->name, "simulated");
  EXPECT_EQ(c.drivers[2].values.text("stimulus"), "in.csv");
  EXPECT_EQ(c.driver("bench"), &c.drivers[2]);
  EXPECT_EQ(c.driver("Bench"), nullptr);

  ASSERT_EQ(c.inputs.size(), 3u);
  EXPECT_EQ(c.inputs[0].variable.text, "%IX0.0");
  EXPECT_EQ(c.inputs[0].variable.at.line, 17u);
  EXPECT_EQ(c.inputs[0].values.text("channel"), "17");
  EXPECT_EQ(c.inputs[0].values.choice<Bias>("bias"), Bias::kPullUp);
  EXPECT_EQ(c.inputs[0].values.choice<Latch>("latch"), Latch::kFalling);
  EXPECT_TRUE(c.inputs[0].invert);
  EXPECT_TRUE(c.inputs[0].values.flag("active_low"));
  EXPECT_EQ(c.inputs[1].values.text("channel"), "START");
  EXPECT_EQ(c.inputs[2].variable.text, "Tank.Level");
  EXPECT_EQ(c.inputs[2].driver.text, "bench");
  EXPECT_EQ(c.inputs[2].values.text("channel"), "");

  ASSERT_EQ(c.outputs.size(), 3u);
  EXPECT_EQ(c.outputs[0].safe.text, "TRUE");
  EXPECT_EQ(c.outputs[0].initial.text, "FALSE");
  EXPECT_EQ(c.outputs[0].values.choice<Drive>("drive"), Drive::kOpenDrain);
  EXPECT_EQ(c.outputs[1].safe.text, "-12");
  EXPECT_EQ(c.outputs[1].initial.text, "0.5");
  EXPECT_EQ(c.outputs[2].safe.text, "idle");
  EXPECT_EQ(c.outputs_at.line, 20u);

  EXPECT_TRUE(c.modbus.enabled);
  EXPECT_EQ(c.modbus.address, "::1");
  EXPECT_EQ(c.modbus.port, 1502);
  EXPECT_TRUE(c.modbus.read_only);
  ASSERT_EQ(c.modbus.writable.size(), 2u);
  EXPECT_EQ(c.modbus.writable[1].text, "Level");
  EXPECT_EQ(c.modbus.writable[1].at.line, 27u);
  EXPECT_EQ(c.modbus.writable[1].at.column, 23u);
  EXPECT_TRUE(c.modbus.exported.empty());
  EXPECT_EQ(c.modbus.word_order, WordOrder::kCdab);
  EXPECT_TRUE(c.modbus.strict_gaps);
  EXPECT_EQ(c.modbus.unit_id, 7);
  EXPECT_TRUE(c.modbus.unit_exception);
  EXPECT_EQ(c.modbus.max_clients, 5u);
  EXPECT_EQ(c.modbus.max_clients_per_address, 2u);
  EXPECT_EQ(c.modbus.frame_timeout_ns, 100'000'000);
  EXPECT_EQ(c.modbus.idle_timeout_ns, 3'600'000'000'000);
  EXPECT_EQ(c.modbus.lock_file.text, "addresses.csv");
  EXPECT_EQ(c.modbus.client_seen.text, "Seen");
  EXPECT_EQ(c.modbus.client_timeout_ns, 3'000'000'000);
  ASSERT_EQ(c.modbus.ranges.size(), 2u);
  EXPECT_EQ(c.modbus.ranges[0].table, ModbusTable::kInputRegisters);
  EXPECT_EQ(c.modbus.ranges[0].first, 10);
  EXPECT_EQ(c.modbus.ranges[0].last, 20);
  EXPECT_EQ(c.modbus.ranges[0].word_order, WordOrder::kDcba);
  EXPECT_EQ(c.modbus.ranges[0].writable, std::nullopt);
  EXPECT_EQ(c.modbus.ranges[1].table, ModbusTable::kCoils);
  EXPECT_EQ(c.modbus.ranges[1].last, 65535);
  EXPECT_EQ(c.modbus.ranges[1].writable, false);
  EXPECT_FALSE(c.guardian.enabled);
  EXPECT_EQ(c.guardian.hang_timeout_ns, 0);
}

TEST(ReadConfiguration, AnEmptyFileIsTheDefaults) {
  const Configuration c = good("");
  EXPECT_TRUE(c.drivers.empty());
  EXPECT_EQ(c.modbus.address, "127.0.0.1");
  EXPECT_EQ(c.modbus.exported.size(), 1u);
}

TEST(ReadConfiguration, ModbusOff) {
  const Configuration c = good("[modbus]\nlisten = \"off\"\n");
  EXPECT_FALSE(c.modbus.enabled);
}

TEST(ReadConfiguration, ModbusOnASerialLine) {
  const Configuration c =
      good("[modbus]\nlisten = \"off\"\n[modbus.serial]\npath = \"/dev/ttyUSB0\"\nline = \"9600 8N2\"\nunit = 17\n");
  ASSERT_TRUE(c.modbus.serial);
  EXPECT_EQ(c.modbus.serial->path.text, "/dev/ttyUSB0");
  EXPECT_EQ(c.modbus.serial->line.text, "9600 8N2");
  EXPECT_EQ(c.modbus.serial->unit, 17);
  EXPECT_TRUE(c.modbus.serves());
  EXPECT_FALSE(c.modbus.enabled);
  EXPECT_FALSE(good("[modbus]\nlisten = \"off\"\n").modbus.serves());
}

TEST(ReadConfiguration, HeadersInsteadOfInlineTables) {
  const Configuration c =
      good("[inputs.\"%IX0.0\"]\ndriver = \"a\"\nchannel = 3\n[drivers]\na = { kind = \"gpio\", chip = \"c\" }\n");
  ASSERT_EQ(c.inputs.size(), 1u);
  EXPECT_EQ(c.inputs[0].values.text("channel"), "3");
}

TEST(ReadConfiguration, WindowsLineEndsAndByteOrderMark) {
  EXPECT_EQ(good("\xef\xbb\xbf[modbus]\r\nmax_clients = 3\r\n").modbus.max_clients, 3u);
}

/// Every documented default, written out: it must change nothing. Also shows that the default has the key's type.
TEST(Keys, DefaultsAreThoseOfTheStructures) {
  std::string modbus = "[modbus]\n", guardian = "[guardian]\n", drivers, input, output, range;
  std::string scheduler = "[scheduler]\n", task = "[tasks.T]\n", taskblocks = "[taskblocks]\n", project = "[project]\n",
              retain = "[retain]\n", engineering = "[engineering]\n",
              serial = "[modbus.serial]\npath = \"/dev/ttyS0\"\n";
  const auto entry = [](std::string& line, const KeyInfo& key) {
    line += (line.empty() ? "" : ", ") + std::string(key.name) + " = " + std::string(key.fallback.toml);
  };
  const Keys keys(driver_types());
  // A driver of each kind, named like it.
  for (const DriverType* type : driver_types()) {
    const std::string name(type->name);
    drivers += "[drivers." + name + "]\nkind = \"" + name + "\"\n";
    for (const KeyInfo& key : keys.rows()) {
      const bool has = key.table == TableId::kDriver && (key.kind == nullptr || key.kind == type) && key.name != "kind";
      if (!has || key.fallback.kind == KeyDefault::Kind::kNothing) continue;
      drivers += std::string(key.name) + " = " + std::string(key.fallback.toml) + "\n";
    }
  }
  const DriverType* const gpio_type = &kGpioType;
  for (const KeyInfo& key : keys.rows()) {
    if (key.fallback.kind != KeyDefault::Kind::kValue) continue;
    const std::string line = std::string(key.name) + " = " + std::string(key.fallback.toml) + "\n";
    if (key.table == TableId::kModbus) modbus += line;
    if (key.table == TableId::kGuardian) guardian += line;
    if (key.table == TableId::kModbusRange) range += line;
    if (key.table == TableId::kModbusSerial) serial += line;
    if (key.table == TableId::kScheduler) scheduler += line;
    if (key.table == TableId::kTask) task += line;
    if (key.table == TableId::kTaskblocks) taskblocks += line;
    if (key.table == TableId::kProject) project += line;
    if (key.table == TableId::kRetain) retain += line;
    if (key.table == TableId::kEngineering) engineering += line;
    const bool of_gpio = key.kind == nullptr || key.kind == gpio_type;
    if (key.table == TableId::kChannel && of_gpio && (key.applies & kInputsOnly) != 0) entry(input, key);
    if (key.table == TableId::kChannel && of_gpio && (key.applies & kOutputsOnly) != 0) entry(output, key);
  }
  const Configuration c = good(drivers + "[inputs]\nX = { driver = \"gpio\", channel = 1, " + input +
                               " }\n[outputs]\nY = { driver = \"gpio\", channel = 2, " + output + " }\n" + modbus +
                               serial + "[[modbus.range]]\ntable = \"holding-registers\"\n" + range + guardian +
                               scheduler + taskblocks + project + retain + engineering + task);
  const EngineeringConfig server;
  EXPECT_EQ(c.engineering.enabled, server.enabled);
  EXPECT_EQ(c.engineering.address, server.address);
  EXPECT_EQ(c.engineering.port, server.port);
  EXPECT_EQ(c.engineering.tls, server.tls);
  EXPECT_EQ(c.engineering.certificate.text, server.certificate.text);
  EXPECT_EQ(c.engineering.key.text, server.key.text);
  EXPECT_TRUE(c.engineering.hosts.empty());
  EXPECT_EQ(c.engineering.max_clients, server.max_clients);
  EXPECT_TRUE(c.taskblocks.libraries.empty());
  EXPECT_TRUE(c.project.libraries.empty());
  const DriverConfig driver;
  ASSERT_EQ(c.drivers.size(), driver_types().size());
  for (const DriverConfig& d : c.drivers) {
    EXPECT_EQ(d.task.text, driver.task.text);
    EXPECT_EQ(d.on_loss, driver.on_loss);
    EXPECT_EQ(d.retry_ns, driver.retry_ns);
    EXPECT_EQ(d.ok.text, driver.ok.text);
  }
  const ChannelConfig channel;
  for (const ChannelConfig* one : {&c.inputs.at(0), &c.outputs.at(0)}) {
    EXPECT_EQ(one->invert, channel.invert);
    EXPECT_EQ(one->safe.text, channel.safe.text);
    EXPECT_EQ(one->initial.text, channel.initial.text);
  }
  // Kinds have no structures here: what they read is the same whether the file has a default or not.
  for (const KeyInfo& key : keys.rows()) {
    if (key.fallback.kind != KeyDefault::Kind::kValue || key.kind == nullptr) continue;
    const bool of_driver = key.table == TableId::kDriver;
    for (const DriverConfig& d : c.drivers) {
      if (!of_driver || d.type != key.kind) continue;
      EXPECT_TRUE(d.values.has(key.name)) << key.name;
      const KeyValues defaults(key.kind->driver_keys);
      if (key.type.kind == KeyKind::kBoolean) {
        EXPECT_EQ(d.values.flag(key.name), defaults.flag(key.name)) << key.name;
      } else {
        EXPECT_EQ(d.values.text(key.name), defaults.text(key.name)) << key.name;
      }
    }
    for (const ChannelConfig* one : {&c.inputs.at(0), &c.outputs.at(0)}) {
      if (of_driver || key.kind != gpio_type || !one->values.has(key.name)) continue;
      EXPECT_EQ(one->values.number(key.name), KeyValues(gpio_type->channel_keys).number(key.name)) << key.name;
    }
  }
  const ModbusConfig m;
  EXPECT_EQ(c.modbus.enabled, m.enabled);
  EXPECT_EQ(c.modbus.address, m.address);
  EXPECT_EQ(c.modbus.port, m.port);
  EXPECT_EQ(c.modbus.read_only, m.read_only);
  EXPECT_EQ(c.modbus.writable.size(), m.writable.size());
  ASSERT_EQ(c.modbus.exported.size(), m.exported.size());
  EXPECT_EQ(c.modbus.exported[0].text, m.exported[0].text);
  EXPECT_EQ(c.modbus.word_order, m.word_order);
  EXPECT_EQ(c.modbus.strict_gaps, m.strict_gaps);
  EXPECT_EQ(c.modbus.unit_id, m.unit_id);
  EXPECT_EQ(c.modbus.unit_exception, m.unit_exception);
  EXPECT_EQ(c.modbus.max_clients, m.max_clients);
  EXPECT_EQ(c.modbus.max_clients_per_address, m.max_clients_per_address);
  EXPECT_EQ(c.modbus.frame_timeout_ns, m.frame_timeout_ns);
  EXPECT_EQ(c.modbus.idle_timeout_ns, m.idle_timeout_ns);
  EXPECT_EQ(c.modbus.lock_file.text, m.lock_file.text);
  EXPECT_EQ(c.modbus.client_seen.text, m.client_seen.text);
  EXPECT_EQ(c.modbus.client_timeout_ns, m.client_timeout_ns);
  EXPECT_EQ(c.modbus.serial.value().line.text, ModbusSerialConfig{}.line.text);
  EXPECT_EQ(c.modbus.serial.value().unit, ModbusSerialConfig{}.unit);
  const ModbusRange r;
  EXPECT_EQ(c.modbus.ranges.at(0).first, r.first);
  EXPECT_EQ(c.modbus.ranges.at(0).last, r.last);
  EXPECT_EQ(c.modbus.ranges.at(0).writable, r.writable);
  EXPECT_EQ(c.modbus.ranges.at(0).word_order, r.word_order);
  EXPECT_EQ(c.retain.state.text, RetainConfig{}.state.text);
  EXPECT_EQ(c.retain.interval_ns, RetainConfig{}.interval_ns);
  EXPECT_EQ(c.guardian.enabled, GuardianConfig{}.enabled);
  EXPECT_EQ(c.guardian.hang_timeout_ns, GuardianConfig{}.hang_timeout_ns);
  const SchedulerConfig s;
  EXPECT_EQ(c.scheduler.priorities, s.priorities);
  EXPECT_EQ(c.scheduler.cpu, s.cpu);
  EXPECT_EQ(c.scheduler.calibration.text, s.calibration.text);
  EXPECT_EQ(c.scheduler.unfit, s.unfit);
  const TaskConfig t;
  EXPECT_EQ(c.tasks.at(0).priority, t.priority);
  EXPECT_EQ(c.tasks.at(0).cpu, t.cpu);
  EXPECT_EQ(c.tasks.at(0).offset_ns, t.offset_ns);
  EXPECT_EQ(c.tasks.at(0).deadline_ns, t.deadline_ns);
  EXPECT_EQ(c.tasks.at(0).execution_ns, t.execution_ns);
  EXPECT_EQ(c.tasks.at(0).watchdog_ns, t.watchdog_ns);
  EXPECT_EQ(c.tasks.at(0).overrun, t.overrun);
  EXPECT_EQ(c.tasks.at(0).on_fault, t.on_fault);
}

/// The choices are in the order of the enumerators.
TEST(Keys, ChoicesAreInOrder) {
  const Keys keys(driver_types());
  const KeyType& orders = keys.find(TableId::kModbus, "word_order")->type;
  for (const WordOrder order : {WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba}) {
    EXPECT_EQ(choice_index(orders, word_order_text(order)), static_cast<int>(order));
  }
  const KeyType& tables = keys.find(TableId::kModbusRange, "table")->type;
  for (const ModbusTable table : {ModbusTable::kCoils, ModbusTable::kDiscreteInputs, ModbusTable::kInputRegisters,
                                  ModbusTable::kHoldingRegisters}) {
    EXPECT_EQ(choice_index(tables, modbus_table_text(table)), static_cast<int>(table));
  }
}

TEST(Keys, AreDocumentedOnce) {
  std::set<std::string> seen;
  for (const Keys keys(driver_types()); const KeyInfo& key : keys.rows()) {
    const std::string owner = key.kind == nullptr ? "" : std::string(key.kind->name) + ' ';
    EXPECT_TRUE(seen.insert(owner + std::to_string(static_cast<int>(key.table)) + std::string(key.name)).second)
        << key.name;
    EXPECT_FALSE(key.documentation.empty()) << key.name;
    EXPECT_EQ(key.documentation.back(), '.') << key.name;
  }
}

TEST(Listen, Texts) {
  EXPECT_EQ(parse_listen("0.0.0.0:502")->address, "0.0.0.0");
  EXPECT_EQ(parse_listen("[::]:0")->address, "::");
  EXPECT_EQ(parse_listen("[::]:0")->port, 0);
  EXPECT_EQ(parse_listen("[::ffff:10.0.0.1]:65535")->port, 65535);
  EXPECT_EQ(parse_listen("off")->address, "");
  for (const char* wrong : {"", ":", ":502", "1.2.3.4", "1.2.3:502", "1.2.3.4:", "1.2.3.4:5x", "[1.2.3.4]:502",
                            "::1:502", "[::1]", "OFF", " 1.2.3.4:502", "256.0.0.1:502", "[::1%lo]:502"}) {
    EXPECT_FALSE(parse_listen(wrong).has_value()) << wrong;
  }
}

}  // namespace
}  // namespace plc::io
