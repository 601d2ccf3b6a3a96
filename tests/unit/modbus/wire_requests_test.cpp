// The server on a socket: requests, functions, units, what tears and what does not.
#include "tests/unit/modbus/wire.h"

namespace plc::test {
namespace {

TEST(ModbusWire, B1SampleOfFunctionsAndLengths) {
  PlantServer plant;
  std::mt19937 random(3);
  ModbusClient client = plant.client();
  for (unsigned step = 0; step < 3000; ++step) {
    Pdu request(1 + random() % 253);
    for (std::uint8_t& byte : request) byte = static_cast<std::uint8_t>(random() % 5);
    request[0] = static_cast<std::uint8_t>(random() % 2 == 0 ? random() : random() % 24);
    const Answer answer = client.ask(request, step);
    ASSERT_EQ(answer.kind, Answer::Kind::kFrame);
    ASSERT_EQ(answer.transaction, step & 0xffff);
    ASSERT_EQ(complaint(request, answer.pdu), "") << "function " << int{request[0]};
  }
  EXPECT_TRUE(client.ask(kRead).is_normal());
}

TEST(ModbusWire, B5FramesOfKnownAttacks) {
  PlantServer plant;
  // libmodbus #612 and #614 (A90AAAAN/xcBYgABAGoAAQLXEQ==, A90AAAAN/xcBYgABAIQAAQLXEQ==): in form, but they reached
  // outside a map that began at 354, and another that ended there.
  for (const std::uint8_t written : {std::uint8_t{0x6a}, std::uint8_t{0x84}}) {
    ModbusClient client = plant.client();
    client.send({0x03, 0xdd, 0x00, 0x00, 0x00, 0x0d, 0xff, 0x17, 0x01, 0x62, 0x00, 0x01, 0x00, written, 0x00, 0x01,
                 0x02, 0xd7, 0x11});
    const Answer answer = client.receive();
    ASSERT_EQ(answer.kind, Answer::Kind::kFrame);
    EXPECT_EQ(answer.transaction, 0x3ddu);
    EXPECT_EQ(answer.unit, 0xff);
    EXPECT_EQ(answer.pdu, (Pdu{0x17, 2, 0, 0})) << "both addresses are gaps of this map";
    EXPECT_TRUE(client.ask(kRead).is_normal());
  }
  EXPECT_EQ(plant.plant.value<std::uint16_t>("Words[0]"), 0);
}

TEST(ModbusWire, B7UnsupportedFunctionsKeepTheConnection) {
  PlantServer plant;
  ModbusClient client = plant.client();
  for (const unsigned function : {8u, 20u, 21u, 7u, 17u, 0u, 255u}) {
    EXPECT_EQ(client.ask(pdu_of(function, {0, 0})).exception(), 1) << function;
    EXPECT_TRUE(client.ask(kRead).is_normal()) << function;
  }
  EXPECT_EQ(client.ask({43, 13, 0}).exception(), 1);
  EXPECT_EQ(plant.server.statistics().exceptions, 8u);
}

TEST(ModbusWire, B8UnitIds) {
  PlantServer any;
  for (const unsigned unit : {0u, 1u, 17u, 247u, 255u}) {
    const Answer answer = any.client().ask(kRead, 9, static_cast<std::uint8_t>(unit));
    EXPECT_TRUE(answer.is_normal());
    EXPECT_EQ(answer.unit, unit);
  }
  io::ModbusConfig config;
  config.unit_id = std::uint8_t{17};
  PlantServer silent(config);
  ModbusClient client = silent.client();
  EXPECT_TRUE(client.ask(pdu_of(6, {kWords, 5}), 1, 1, 200).is_timeout());
  EXPECT_EQ(client.ask(kRead, 2, 17).pdu, (Pdu{3, 2, 0, 0})) << "the connection stays, and nothing was written";
  config.unit_exception = true;
  PlantServer excepting(config);
  ModbusClient other = excepting.client();
  const Answer refused = other.ask(kRead, 3, 18);
  EXPECT_EQ(refused.exception(), 11);
  EXPECT_EQ(refused.unit, 18);
  EXPECT_TRUE(other.ask(kRead, 4, 17).is_normal());
}

TEST(ModbusWire, B10NothingTearsWhileTheTaskRuns) {
  PlantServer plant;
  runtime::RealtimeOptions options;
  options.lock_memory = false;
  options.realtime_priority = false;
  runtime::RealtimeScheduler scheduler(*plant.plant.resource, options);
  scheduler.start();
  std::atomic<bool> stop{false};
  // The same word four times into a value that the task owns and copies; and into the high half of one it counts in.
  std::thread writer([&] {
    ModbusClient client = plant.client();
    for (std::uint16_t i = 1; !stop; ++i) {
      EXPECT_NE(client.ask(write_registers(kSetpoint, {i, i, i, i})).kind, Answer::Kind::kClosed);
      EXPECT_NE(client.ask(pdu_of(6, {kHalf, i})).kind, Answer::Kind::kClosed);
    }
  });
  ModbusClient client = plant.client();
  const auto end = Clock::now() + 3s;
  std::uint32_t reads = 0, changes = 0, last_low = 0;
  std::uint16_t last = 0;
  while (Clock::now() < end) {
    const Answer narrow = client.ask(pdu_of(3, {kCounter, 6}));
    ASSERT_TRUE(narrow.is_normal());
    const auto dint = [&](std::size_t at) { return word_at(narrow.pdu, at) << 16 | word_at(narrow.pdu, at + 2); };
    ASSERT_EQ(dint(2), ~dint(6)) << "two values of one scan";
    const std::uint32_t low = word_at(narrow.pdu, 12);
    ASSERT_GE(low, last_low) << "the task's half of a value went back";
    last_low = low;
    const Answer wide = client.ask(pdu_of(3, {kWide, 16}));
    ASSERT_TRUE(wide.is_normal());
    for (std::size_t i = 0; i < 8; ++i) ASSERT_EQ(wide.pdu[2 + i], wide.pdu[10 + i]) << "copies of one scan";
    for (std::size_t value : {2u, 18u, 26u}) {
      for (std::size_t word = 1; word < 4; ++word) {
        ASSERT_EQ(word_at(wide.pdu, value), word_at(wide.pdu, value + 2 * word)) << "words of one value";
      }
    }
    const auto setpoint = static_cast<std::uint16_t>(word_at(wide.pdu, 18));
    changes += setpoint != last;
    last = setpoint;
    ++reads;
  }
  stop = true;
  writer.join();
  scheduler.request_stop();
  scheduler.join();
  EXPECT_GT(reads, 1000u);
  EXPECT_GT(changes, 50u);
}

TEST(ModbusWire, B11OnlyProcessDataOnThisPort) {
  // No function beyond the served ones does anything: OpenPLC's debugger (65..69) and the like are not there.
  PlantServer plant;
  ModbusClient client = plant.client();
  for (unsigned function = 0; function < 256; ++function) {
    if (serves(function)) continue;
    for (const std::size_t length : {1u, 3u, 9u}) {
      Pdu request(length, 1);
      request[0] = static_cast<std::uint8_t>(function);
      ASSERT_EQ(client.ask(request).exception(), 1) << function;
    }
  }
}

TEST(ModbusWire, B12ReadOnlyAndAllowList) {
  io::ModbusConfig config;
  config.read_only = true;
  PlantServer read_only(config);
  ModbusClient client = read_only.client();
  EXPECT_EQ(client.ask(pdu_of(6, {kWords, 1})).exception(), 1);
  EXPECT_EQ(client.ask(read_write(kWords, 1, kWords, {1})).exception(), 1);
  EXPECT_EQ(client.ask(kRead).pdu, (Pdu{3, 2, 0, 0}));
  config.read_only = false;
  config.writable = {{"Coils*", {}}};
  PlantServer listed(config);
  ModbusClient writer = listed.client();
  EXPECT_EQ(writer.ask(pdu_of(6, {kWords, 1})).exception(), 2);
  EXPECT_TRUE(writer.ask(pdu_of(5, {kCoils, 0xff00})).is_normal());
  EXPECT_EQ(writer.ask(pdu_of(1, {kCoils, 1})).pdu, (Pdu{1, 1, 1}));
}

TEST(ModbusWire, ClientSeen) {
  io::ModbusConfig config;
  config.client_timeout_ns = 300'000'000;
  config.port = 0;
  Plant plant(config);
  runtime::GlobalTable& globals = plant.resource->globals();
  const runtime::Place place = *runtime::Access(*plant.resource).find_leaf("Seen");
  const std::uint32_t field = globals.field_of(place.offset);
  runtime::GlobalInputs owner(globals, std::span(&field, 1));
  modbus::Responder responder(*plant.resource, plant.map, plant.config,
                              modbus::SeenFlag{&owner, place.offset, place.type});
  modbus::Server server(responder, plant.config);
  ASSERT_FALSE(server.start().has_value());
  const auto seen = [&] { return plant.value<std::uint8_t>("Seen"); };
  ModbusClient client(server.port());
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(seen(), 0) << "a connection alone is nobody";
  EXPECT_EQ(client.ask(pdu_of(8, {0, 0})).exception(), 1);
  EXPECT_EQ(seen(), 0) << "nor is somebody who asks for what there is not";
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(client.ask(kRead).is_normal());
    EXPECT_EQ(seen(), 1);
    std::this_thread::sleep_for(60ms);
  }
  EXPECT_TRUE(eventually([&] { return seen() == 0; }, 1000ms));
  EXPECT_TRUE(client.ask(kRead).is_normal());
  EXPECT_EQ(seen(), 1);
  server.stop();
  EXPECT_EQ(seen(), 0);
}

}  // namespace
}  // namespace plc::test
