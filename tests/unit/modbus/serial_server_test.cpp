// The server on a serial line: what it answers, what it leaves alone, lines that come and go, both servers at once.
#include "io-drivers/modbus/serial_server.h"

#include <filesystem>

#include "io-drivers/modbus-client/link.h"
#include "io-drivers/modbus-rtu/line.h"
#include "tests/support/serial_line.h"
#include "tests/unit/modbus/wire.h"

namespace plc::test {
namespace {

constexpr std::uint8_t kUnit = 5;

Pdu rtu(std::uint8_t unit, const Pdu& pdu) { return modbus_client::rtu_frame(unit, pdu); }
Pdu operator+(Pdu one, const Pdu& other) {
  one.insert(one.end(), other.begin(), other.end());
  return one;
}

io::ModbusSerialConfig serial_config(const std::string& path) {
  io::ModbusSerialConfig config;
  config.path.text = path;
  config.line.text = "115200 8E1";
  config.unit = kUnit;
  return config;
}

/// Everything said until `text` comes, at most fifteen seconds.
std::string said_until(modbus::SerialServer& server, const std::string& text) {
  std::string all;
  eventually([&] {
    for (const io::Sentence& sentence : server.take_said()) all += sentence.text + '\n';
    return all.find(text) != std::string::npos;
  });
  return all;
}

/// A plant on a line whose other end is the test.
struct SerialPlant {
  explicit SerialPlant(const std::string& path = {})
      : responder(*plant.resource, plant.map, plant.config),
        config(serial_config(path.empty() ? line.path() : path)),
        server(responder, config) {
    server.start();
    if (path.empty()) said_until("listening");
  }
  Pdu ask(const Pdu& bytes, std::chrono::milliseconds wait = 10'000ms) {
    line.put(bytes);
    return line.get(wait);
  }
  std::string said_until(const std::string& text) { return test::said_until(server, text); }

  Plant plant;
  SerialEnd line;
  modbus::Responder responder;
  io::ModbusSerialConfig config;
  modbus::SerialServer server;
};

const Pdu kWrite = write_registers(kWords, {0x1234, 0x5678});
const Pdu kReadTwo = pdu_of(3, {kWords, 2});
const Pdu kTwo = rtu(kUnit, {3, 4, 0x12, 0x34, 0x56, 0x78});

TEST(SerialServer, AnswersItsUnitAndNoOther) {
  SerialPlant plant;
  EXPECT_EQ(plant.ask(rtu(kUnit, kWrite)), rtu(kUnit, pdu_of(16, {kWords, 2})));
  EXPECT_EQ(plant.ask(rtu(kUnit, kReadTwo)), kTwo);
  EXPECT_EQ(plant.ask(rtu(kUnit, pdu_of(5, {kCoils, 0xff00}))), rtu(kUnit, pdu_of(5, {kCoils, 0xff00})));
  EXPECT_EQ(plant.ask(rtu(kUnit, pdu_of(1, {kCoils, 8}))), rtu(kUnit, {1, 1, 1}));
  EXPECT_EQ(plant.ask(rtu(kUnit, pdu_of(3, {60'000, 1}))), rtu(kUnit, {0x83, 2}));
  EXPECT_EQ(plant.ask(rtu(kUnit, {0x41, 1, 2, 3})), rtu(kUnit, {0xc1, 1}));
  EXPECT_EQ(plant.ask(rtu(kUnit + 1, write_registers(kWords, {9, 9})), 100ms), Pdu{});
  EXPECT_EQ(plant.ask(rtu(kUnit, kReadTwo)), kTwo);
  const modbus::SerialStatistics statistics = plant.server.statistics();
  EXPECT_EQ(statistics.requests, 7u);
  EXPECT_EQ(statistics.exceptions, 2u);
  EXPECT_EQ(statistics.others, 1u);
  EXPECT_EQ(statistics.damaged, 0u);
}

TEST(SerialServer, TheLargestFramesFit) {
  SerialPlant plant;
  const Pdu registers = plant.ask(rtu(kUnit, pdu_of(3, {kWords, 125})));
  EXPECT_EQ(registers.size(), 255u);
  EXPECT_EQ(plant.ask(rtu(kUnit, write_registers(kWords, std::vector<std::uint16_t>(123, 7)))),
            rtu(kUnit, pdu_of(16, {kWords, 123})));
  EXPECT_EQ(plant.plant.value<std::uint16_t>("Words[122]"), 7);
}

TEST(SerialServer, WritesToAllUnitsHaveEffectAndNoAnswer) {
  SerialPlant plant;
  EXPECT_EQ(plant.ask(rtu(0, kWrite), 100ms), Pdu{});
  EXPECT_EQ(plant.ask(rtu(kUnit, kReadTwo)), kTwo);
  EXPECT_EQ(plant.ask(rtu(0, pdu_of(3, {kWords, 1})), 100ms), Pdu{});
}

TEST(SerialServer, AnswersAfterASilence) {
  SerialPlant plant;
  const auto silence = std::chrono::nanoseconds(modbus_rtu::silence_ns({115200, 8, modbus_rtu::Parity::kEven, 1}));
  const Pdu request = rtu(kUnit, kReadTwo);
  for (int i = 0; i < 20; ++i) {
    const auto begin = Clock::now();
    plant.line.put(request);
    ASSERT_FALSE(plant.line.get(10'000ms, 0ms).empty());
    EXPECT_GE(Clock::now() - begin, silence);
    ASSERT_LT(plant.line.get(20ms).size(), request.size());  // the rest of the answer
  }
}

TEST(SerialServer, NoiseHalfFramesAndOthersAreLeftBehind) {
  const Pdu good = rtu(kUnit, kReadTwo);
  Pdu damaged = rtu(kUnit, write_registers(kWords, {9, 9}));
  damaged[8] ^= 1;
  const struct {
    const char* what;
    Pdu bytes;
  } rows[] = {
      {"noise", Pdu(100, 0xaa)},
      {"zeros", Pdu(700, 0)},
      {"half a frame", {good.begin(), good.begin() + 5}},
      {"a damaged write", damaged},
      {"another unit, its answer and its next request",
       rtu(9, kReadTwo) + rtu(9, {3, 4, 1, 2, 3, 4}) + rtu(9, kReadTwo)},
      {"text", {'A', 'T', 'Z', '\r', '\n'}},
  };
  SerialPlant plant;
  ASSERT_EQ(plant.ask(rtu(kUnit, kWrite)).size(), 8u);
  for (const auto& row : rows) {
    EXPECT_EQ(plant.ask(row.bytes, 60ms), Pdu{}) << row.what;
    EXPECT_EQ(plant.ask(good), kTwo) << "after " << row.what;
  }
  EXPECT_EQ(plant.server.statistics().damaged, 5u);
  // A byte at a time, 3 ms apart: longer than the silence between frames, as adapters hand them on.
  for (const std::uint8_t byte : good) {
    plant.line.put({byte});
    std::this_thread::sleep_for(3ms);
  }
  EXPECT_EQ(plant.line.get(10'000ms), kTwo);
}

TEST(SerialServer, ARequestThatNobodyWaitsForIsNotAnswered) {
  SerialPlant plant;
  EXPECT_EQ(plant.ask(rtu(kUnit, kReadTwo) + rtu(kUnit, pdu_of(1, {kCoils, 8}))), rtu(kUnit, {1, 1, 0}));
}

TEST(SerialServer, AnotherSpeedIsSaid) {
  SerialPlant plant;
  for (int i = 0; i < 25; ++i) plant.ask({0xf8, 0x80, 0x78, 0xff, 0x9e, 0x00, 0xe6}, 30ms);
  EXPECT_NE(plant.said_until("nothing that comes in is a frame").find("is 115200 8E1 what the others on the line have"),
            std::string::npos);
}

TEST(SerialServer, ALineThatIsNotThereIsTriedAgainAndSaid) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "serial_server_test";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const std::string path = folder / "line";
  SerialPlant plant(path);
  EXPECT_EQ(plant.said_until("again"),
            "modbus: P7510: cannot listen for Modbus clients on " + path +
                ": No such file or directory; it is tried again (see path under [modbus.serial] in plc.toml; "
                "/dev/serial/by-id has names that stay)\n");
  std::this_thread::sleep_for(1200ms);
  EXPECT_TRUE(plant.server.take_said().empty()) << "said once";
  std::filesystem::create_symlink(plant.line.path(), path);
  EXPECT_EQ(plant.said_until("unit 5"), "modbus: listening on " + path + " (115200 8E1) as unit 5\n");
  EXPECT_EQ(plant.ask(rtu(kUnit, pdu_of(1, {kCoils, 8}))), rtu(kUnit, {1, 1, 0}));
  // Pulled out, and plugged in as another one.
  std::filesystem::remove(path);
  plant.line.pull_out();
  const std::string said = plant.said_until("No such file");
  EXPECT_EQ(said.find("modbus: " + path + " is gone: "), 0u) << said;
  SerialEnd other;
  std::filesystem::create_symlink(other.path(), path);
  plant.said_until("unit 5");
  other.put(rtu(kUnit, pdu_of(1, {kCoils, 8})));
  EXPECT_EQ(other.get(10'000ms), rtu(kUnit, {1, 1, 0}));
  // What is no line at all.
  std::filesystem::remove(path);
  std::filesystem::create_symlink("/dev/null", path);
  other.pull_out();
  EXPECT_NE(plant.said_until("Inappropriate").find("this is no serial line"), std::string::npos);
  const auto begin = Clock::now();
  plant.server.stop();
  EXPECT_LT(Clock::now() - begin, 900ms) << "not at the next attempt";
}

TEST(SerialServer, WhatIsNoLineIsSaidOnce) {
  SerialPlant plant("/dev/null");
  std::size_t lines = 0;
  for (int i = 0; i < 25; ++i) {
    std::this_thread::sleep_for(100ms);
    lines += plant.server.take_said().size();
  }
  EXPECT_EQ(lines, 1u);
}

TEST(SerialServer, OurOwnClientReadsAndWritesThroughIt) {
  Plant plant;
  modbus::Responder responder(*plant.resource, plant.map, plant.config);
  SerialCable cable;
  const io::ModbusSerialConfig config = serial_config(cable.path(0));
  modbus::SerialServer server(responder, config);
  server.start();
  said_until(server, "listening");
  modbus_client::BusAddress bus = modbus_client::parse_bus(cable.path(1)).value();
  bus.line.baud = 115200;
  const auto link = modbus_client::make_link(bus);
  modbus_client::Cells cells;
  for (std::uint16_t i = 1; i <= 300; ++i) {
    const modbus_client::Cells wanted = {i, static_cast<std::uint16_t>(~i)};
    ASSERT_EQ(modbus_client::ask(*link, kUnit,
                                 modbus_client::write_pdu(io::ModbusTable::kHoldingRegisters, kWords, wanted, false),
                                 20'000'000'000, cells),
              modbus_client::Error::kNone);
    ASSERT_EQ(modbus_client::ask(*link, kUnit, modbus_client::read_pdu(io::ModbusTable::kHoldingRegisters, kWords, 2),
                                 20'000'000'000, cells),
              modbus_client::Error::kNone);
    ASSERT_EQ(cells, wanted);
  }
  EXPECT_EQ(modbus_client::ask(*link, kUnit + 1, modbus_client::read_pdu(io::ModbusTable::kHoldingRegisters, kWords, 2),
                               100'000'000, cells),
            modbus_client::Error::kNoAnswer);
  EXPECT_EQ(server.statistics().damaged, 0u);
}

TEST(SerialServer, BothServersHaveOneMap) {
  io::ModbusConfig any_port;
  any_port.port = 0;
  SerialEnd line;
  Plant plant(any_port);
  modbus::Responder responder(*plant.resource, plant.map, plant.config);
  modbus::Server tcp(responder, plant.config);
  ASSERT_FALSE(tcp.start());
  const io::ModbusSerialConfig config = serial_config(line.path());
  modbus::SerialServer serial(responder, config);
  serial.start();
  said_until(serial, "listening");
  ModbusClient client(tcp.port());

  line.put(rtu(kUnit, kWrite));
  EXPECT_EQ(line.get(10'000ms).size(), 8u);
  EXPECT_EQ(client.ask(kReadTwo).pdu, (Pdu{3, 4, 0x12, 0x34, 0x56, 0x78}));
  // Both, as fast as they can.
  std::atomic<bool> stop = false;
  std::atomic<int> bad = 0;
  std::thread other([&] {
    ModbusClient fast(tcp.port());
    while (!stop) {
      if (!fast.ask(kReadTwo).is_normal()) ++bad;
    }
  });
  for (int i = 0; i < 100; ++i) {
    line.put(rtu(kUnit, kReadTwo));
    EXPECT_EQ(line.get(10'000ms, 3ms), kTwo);
  }
  stop = true;
  other.join();
  EXPECT_EQ(bad, 0);
}

}  // namespace
}  // namespace plc::test
