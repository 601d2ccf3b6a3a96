// The PDU handler on its own: bytes in, bytes out. Names begin with the attack they answer, where there is one.
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "tests/support/modbus_oracle.h"
#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

using Registers = std::vector<std::uint16_t>;

/// What runs of the registers that malformed requests aim at.
std::vector<Registers> contents(PlantPdu& pdu) {
  return {pdu.holding(kWords, 120), pdu.holding(kPercent, 2), pdu.holding(kDoubles, 12), pdu.holding(kLongs, 8)};
}

TEST(ModbusPdu, B1EveryFunctionWithEveryLength) {
  PlantPdu pdu;
  std::mt19937 random(1);
  for (unsigned function = 0; function < 256; ++function) {
    for (std::size_t length = 0; length <= 260; ++length) {
      Pdu request(length);
      for (std::uint8_t& byte : request) byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() : random() % 4);
      if (length != 0) request[0] = static_cast<std::uint8_t>(function);
      const Pdu response = pdu.ask(request);
      ASSERT_EQ(complaint(request, response), "") << "function " << function << ", " << length << " bytes";
    }
  }
}

TEST(ModbusPdu, B2Quantities) {
  PlantPdu pdu;
  for (const unsigned bits : {1u, 2u}) {
    for (const std::uint32_t count : {0u, 2001u, 2008u, 0xffffu}) EXPECT_EQ(pdu.exception(pdu_of(bits, {0, count})), 3);
    for (const std::uint32_t count : {1u, 2000u}) EXPECT_EQ(pdu.exception(pdu_of(bits, {0, count})), 0) << count;
  }
  for (const unsigned registers : {3u, 4u}) {
    for (const std::uint32_t count : {0u, 126u, 127u, 0xffffu}) {
      EXPECT_EQ(pdu.exception(pdu_of(registers, {0, count})), 3);
    }
    for (const std::uint32_t count : {1u, 125u}) EXPECT_EQ(pdu.exception(pdu_of(registers, {0, count})), 0) << count;
  }
  EXPECT_EQ(pdu.exception(write_registers(kWords, Registers(123))), 0);
  EXPECT_EQ(pdu.exception(write_registers(kWords, Registers(124))), 3);
  EXPECT_EQ(pdu.exception(write_registers(kWords, {})), 3);
  EXPECT_EQ(pdu.exception(write_coils(kCoils, 1968, Pdu(246))), 0);
  EXPECT_EQ(pdu.exception(write_coils(kCoils, 1969, Pdu(247))), 3);
  EXPECT_EQ(pdu.exception(write_coils(kCoils, 0, {})), 3);
  EXPECT_EQ(pdu.exception(read_write(kWords, 125, kWords, Registers(121))), 0);
  EXPECT_EQ(pdu.exception(read_write(kWords, 126, kWords, Registers(1))), 3);
  EXPECT_EQ(pdu.exception(read_write(kWords, 1, kWords, Registers(122))), 3);
  EXPECT_EQ(pdu.exception(read_write(kWords, 0, kWords, Registers(1))), 3);
  EXPECT_EQ(pdu.exception(read_write(kWords, 1, kWords, {})), 3);
}

TEST(ModbusPdu, B3AddressesDoNotWrap) {
  PlantPdu pdu;
  for (const unsigned function : {1u, 2u, 3u, 4u}) {
    EXPECT_EQ(pdu.exception(pdu_of(function, {65535, 2})), 2);
    EXPECT_EQ(pdu.exception(pdu_of(function, {65500, 100})), 2);
  }
  const auto before = contents(pdu);
  EXPECT_EQ(pdu.exception(write_registers(65535, {1, 2})), 2);
  EXPECT_EQ(pdu.exception(write_coils(65530, 16, {0xff, 0xff})), 2);
  EXPECT_EQ(pdu.exception(read_write(65535, 2, kWords, {1})), 2);
  EXPECT_EQ(pdu.exception(read_write(kWords, 1, 65535, {1, 2})), 2);
  EXPECT_EQ(contents(pdu), before);
}

TEST(ModbusPdu, B4ByteCountsThatDiffer) {
  PlantPdu pdu;
  const auto before = contents(pdu);
  const auto with_count = [](Pdu request, std::size_t at, unsigned count) {
    request[at] = static_cast<std::uint8_t>(count);
    return request;
  };
  for (const unsigned count : {0u, 1u, 2u, 3u, 5u, 6u, 255u}) {
    EXPECT_EQ(pdu.exception(with_count(write_registers(kWords, {1, 2}), 5, count)), 3) << count;
    EXPECT_EQ(pdu.exception(with_count(read_write(kWords, 1, kWords, {1, 2}), 9, count)), 3) << count;
  }
  for (const unsigned count : {0u, 1u, 3u, 255u}) {
    EXPECT_EQ(pdu.exception(with_count(write_coils(kCoils, 16, {0xff, 0xff}), 5, count)), 3) << count;
  }
  EXPECT_EQ(pdu.exception(write_coils(kCoils, 10, {0xff})), 3);
  EXPECT_EQ(pdu.exception(write_coils(kCoils, 8, {0xff, 0xff})), 3);
  EXPECT_EQ(contents(pdu), before);
  EXPECT_EQ(pdu.ask(pdu_of(1, {kCoils, 16})), (Pdu{1, 2, 0, 0}));
}

TEST(ModbusPdu, B5WritesOutsideTheMapByFunction23) {
  PlantPdu pdu;
  const auto before = contents(pdu);
  // The PDUs of libmodbus #612 and #614: read 1 register from 354, write 1 to 106 and to 132.
  const Pdu below = {0x17, 0x01, 0x62, 0x00, 0x01, 0x00, 0x6a, 0x00, 0x01, 0x02, 0xd7, 0x11};
  const Pdu above = {0x17, 0x01, 0x62, 0x00, 0x01, 0x00, 0x84, 0x00, 0x01, 0x02, 0xd7, 0x11};
  EXPECT_EQ(pdu.exception(below), 0);  // both addresses are gaps in our map: swallowed
  EXPECT_EQ(pdu.exception(above), 0);
  for (const std::uint32_t outside : {8192u, 16383u, 20000u, 65535u}) {
    EXPECT_EQ(pdu.exception(read_write(kWords, 1, outside, {1})), 2) << outside;
    EXPECT_EQ(pdu.exception(read_write(outside, 1, kWords, {1})), 2) << outside;
  }
  EXPECT_EQ(pdu.exception(read_write(kWords, 1, 8191, {1, 1})), 2);  // the last of the area, and one beyond
  EXPECT_EQ(contents(pdu), before);
}

TEST(ModbusPdu, B6CoilsTakeTwoValues) {
  PlantPdu pdu;
  for (const std::uint32_t value : {0x0001u, 0x00ffu, 0x1234u, 0xff01u, 0xffffu}) {
    EXPECT_EQ(pdu.exception(pdu_of(5, {kCoils, value})), 3) << value;
    EXPECT_EQ(pdu.plant.value<std::uint8_t>("Coils[0]"), 0);
  }
  EXPECT_EQ(pdu.ask(pdu_of(5, {kCoils, 0xff00})), pdu_of(5, {kCoils, 0xff00}));
  EXPECT_EQ(pdu.plant.value<std::uint8_t>("Coils[0]"), 1);
  EXPECT_EQ(pdu.ask(pdu_of(5, {kCoils, 0})), pdu_of(5, {kCoils, 0}));
  EXPECT_EQ(pdu.plant.value<std::uint8_t>("Coils[0]"), 0);
}

TEST(ModbusPdu, B7UnsupportedFunctions) {
  PlantPdu pdu;
  for (unsigned function = 0; function < 256; ++function) {
    if (serves(function)) continue;
    for (const std::size_t length : {1u, 5u, 253u}) {
      Pdu request(length);
      request[0] = static_cast<std::uint8_t>(function);
      EXPECT_EQ(pdu.ask(request), (Pdu{static_cast<std::uint8_t>(function | 0x80), 1})) << function;
    }
  }
  EXPECT_EQ(pdu.exception({43}), 1);
  EXPECT_EQ(pdu.exception({43, 13, 0, 0}), 1);
  EXPECT_EQ(pdu.exception({43, 14, 1}), 3);
  EXPECT_EQ(pdu.exception({43, 14, 0, 0}), 3);
  EXPECT_EQ(pdu.exception({43, 14, 5, 0}), 3);
  EXPECT_EQ(pdu.exception({43, 14, 4, 7}), 2);
}

TEST(ModbusPdu, B9WhatMustNotBeWritten) {
  PlantPdu pdu;
  EXPECT_EQ(pdu.exception(pdu_of(6, {kFixed, 1})), 2);
  EXPECT_EQ(pdu.exception(pdu_of(22, {kFixed, 0, 1})), 2);
  // All or nothing: the variables before and after the constant keep their values as well.
  EXPECT_EQ(pdu.exception(write_registers(kPercent, {5, 5, 5})), 2);
  EXPECT_EQ(pdu.holding(kPercent, 2), (Registers{0, 77}));
}

TEST(ModbusPdu, B12ReadOnly) {
  io::ModbusConfig config;
  config.read_only = true;
  PlantPdu pdu(config);
  for (const Pdu& request :
       {pdu_of(5, {kCoils, 0xff00}), pdu_of(6, {kWords, 1}), write_coils(kCoils, 8, {0xff}),
        write_registers(kWords, {1}), pdu_of(22, {kWords, 0, 1}), read_write(kWords, 1, kWords, {1})}) {
    EXPECT_EQ(pdu.exception(request), 1) << int{request[0]};
  }
  EXPECT_EQ(pdu.holding(kWords, 1), (Registers{0}));
  EXPECT_EQ(pdu.exception(pdu_of(1, {kCoils, 8})), 0);
}

TEST(ModbusPdu, B12AllowList) {
  io::ModbusConfig config;
  config.writable = {{"Words*", {}}};
  PlantPdu pdu(config);
  EXPECT_EQ(pdu.exception(pdu_of(6, {kWords, 1})), 0);
  EXPECT_EQ(pdu.exception(pdu_of(5, {kCoils, 0xff00})), 2);
  EXPECT_EQ(pdu.exception(write_registers(kDoubles, {1, 2})), 2);
  EXPECT_EQ(pdu.holding(kDoubles, 2), (Registers{0, 0}));
}

TEST(ModbusPdu, ValuesOutsideTheirLimits) {
  PlantPdu pdu;
  EXPECT_EQ(pdu.exception(pdu_of(6, {kPercent, 100})), 0);
  EXPECT_EQ(pdu.exception(pdu_of(6, {kPercent, 101})), 3);
  EXPECT_EQ(pdu.exception(pdu_of(6, {kPercent, 0xffff})), 3);
  EXPECT_EQ(pdu.holding(kPercent, 1), (Registers{100}));
  EXPECT_EQ(pdu.exception(write_registers(kPercentWide, {0, 99})), 0);
  EXPECT_EQ(pdu.exception(write_registers(kPercentWide, {1, 0})), 3);
  // Half a value cannot be judged alone: its owner leaves a result outside the limits out.
  EXPECT_EQ(pdu.exception(pdu_of(6, {kPercentWide, 1})), 0);
  EXPECT_EQ(pdu.holding(kPercentWide, 2), (Registers{0, 99}));
}

TEST(ModbusPdu, EightBitValuesTakeARegister) {
  PlantPdu pdu;
  const std::uint32_t small = pdu.plant.address("Small");
  for (const int value : {0, 5, 127, -1, -128}) {
    const auto wire = static_cast<std::uint16_t>(value);
    EXPECT_EQ(pdu.exception(pdu_of(6, {small, wire})), 0) << value;
    EXPECT_EQ(pdu.plant.value<std::int8_t>("Small"), value);
    EXPECT_EQ(pdu.holding(small, 1), (Registers{wire}));
  }
  for (const std::uint32_t wire : {128u, 255u, 256u, 0xff7fu, 0x8000u}) {
    EXPECT_EQ(pdu.exception(pdu_of(6, {small, wire})), 3) << wire;
  }
  EXPECT_EQ(pdu.plant.value<std::int8_t>("Small"), -128);
}

TEST(ModbusPdu, SingleBitsOfARegisterByFunction22) {
  PlantPdu pdu;
  ASSERT_EQ(pdu.exception(pdu_of(6, {kWords, 0x12})), 0);
  EXPECT_EQ(pdu.ask(pdu_of(22, {kWords, 0xf2, 0x25})), pdu_of(22, {kWords, 0xf2, 0x25}));
  EXPECT_EQ(pdu.holding(kWords, 1), (Registers{0x17}));
  // Into one word of a 64-bit value: the others keep what they have.
  ASSERT_EQ(pdu.exception(write_registers(kLongs, {0x1111, 0x2222, 0x3333, 0x4444})), 0);
  ASSERT_EQ(pdu.exception(pdu_of(22, {kLongs + 1, 0xff00, 0x00ab})), 0);
  EXPECT_EQ(pdu.plant.value<std::uint64_t>("Longs[0]"), 0x1111'22ab'3333'4444u);
}

TEST(ModbusPdu, AMaskIsAppliedWhereTheTaskWrites) {
  PlantPdu pdu;
  pdu.plant.scan(3);
  ASSERT_EQ(pdu.holding(kHalf, 2), (Registers{0, 3}));
  ASSERT_EQ(pdu.exception(pdu_of(6, {kHalf, 0x1234})), 0);  // the high word, before scans that change the low one
  EXPECT_EQ(pdu.holding(kHalf, 2), (Registers{0, 3}));      // not applied yet
  pdu.plant.scan(2);
  EXPECT_EQ(pdu.holding(kHalf, 2), (Registers{0x1234, 5}));
}

TEST(ModbusPdu, AJournalThatIsFullIsBusy) {
  PlantPdu pdu;
  int last = 0;
  for (int i = 0; i < 100'000 && last == 0; ++i) last = pdu.exception(write_registers(kSetpoint, {1, 2, 3, 4}));
  EXPECT_EQ(last, 6);
  pdu.plant.scan();
  EXPECT_EQ(pdu.exception(write_registers(kSetpoint, {4, 3, 2, 1})), 0);
  pdu.plant.scan();
  EXPECT_EQ(pdu.holding(kEcho, 4), (Registers{4, 3, 2, 1}));
}

TEST(ModbusPdu, Function23WritesBeforeItReads) {
  PlantPdu pdu;
  EXPECT_EQ(pdu.ask(read_write(kWords, 2, kWords, {7, 8})), (Pdu{23, 4, 0, 7, 0, 8}));
}

TEST(ModbusPdu, CoilsAreWrittenOneByOne) {
  PlantPdu pdu;
  ASSERT_EQ(pdu.exception(write_coils(kCoils + 3, 12, {0xff, 0xff})), 0);
  EXPECT_EQ(pdu.ask(pdu_of(1, {kCoils, 19})), (Pdu{1, 3, 0xf8, 0x7f, 0x00}));
  ASSERT_EQ(pdu.exception(write_coils(kCoils + 4, 3, {0x00})), 0);  // three, not the eight of their byte
  EXPECT_EQ(pdu.ask(pdu_of(1, {kCoils, 16})), (Pdu{1, 2, 0x88, 0x7f}));
  EXPECT_EQ(pdu.ask(pdu_of(1, {8191, 1})), (Pdu{1, 1, 0x00}));
}

TEST(ModbusPdu, GapsReadZeroAndSwallowWrites) {
  PlantPdu pdu;
  EXPECT_EQ(pdu.exception(write_registers(kWords - 2, {1, 2, 3, 4})), 0);
  EXPECT_EQ(pdu.holding(kWords - 2, 4), (Registers{0, 0, 3, 4}));
}

TEST(ModbusPdu, StrictGapsHaveNoAddress) {
  io::ModbusConfig config;
  config.strict_gaps = true;
  PlantPdu pdu(config);
  EXPECT_EQ(pdu.exception(pdu_of(3, {kWords - 1, 1})), 2);
  EXPECT_EQ(pdu.exception(write_registers(kWords - 1, {1, 2})), 2);
  EXPECT_EQ(pdu.exception(pdu_of(3, {kWords, 100})), 0);
}

TEST(ModbusPdu, InAnOverlayCoilsAreBitsOfWords) {
  ImageBuilder b;
  b.image.options.profile = core::AddressProfile::kOverlay;
  b.global("Level", b.type(TypeId::kDint), {}, {false, true, {}, "%QD1"});  // coils 32..63, holding registers 2 and 3
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  b.task("Task", 1'000'000, {main.finish()});
  PlantPdu pdu({}, b.build());
  ASSERT_EQ(pdu.exception(pdu_of(5, {32 + 3, 0xff00})), 0);
  ASSERT_EQ(pdu.exception(write_coils(32 + 14, 4, {0x0f})), 0);
  EXPECT_EQ(pdu.plant.value<std::uint32_t>("Level"), 0x0003'c008u);
  ASSERT_EQ(pdu.exception(pdu_of(5, {32 + 3, 0})), 0);
  EXPECT_EQ(pdu.ask(pdu_of(1, {32, 32})), (Pdu{1, 4, 0x00, 0xc0, 0x03, 0x00}));
  Registers shown = pdu.holding(2, 2);
  EXPECT_EQ(shown, (Registers{0xc000, 0x0003}));
  ASSERT_EQ(pdu.exception(pdu_of(6, {3, 0x1234})), 0);
  EXPECT_EQ(pdu.plant.value<std::uint32_t>("Level"), 0x1234'c000u);
}

TEST(ModbusPdu, DeviceIdentification) {
  PlantPdu pdu;
  const Pdu basic = pdu.ask({43, 14, 1, 0});
  EXPECT_EQ(basic, (Pdu{43,  14,  1, 0x82, 0,   0,   3,   0, 6, 'P', 'I', 'C', 'A',
                        'R', 'D', 1, 3,    'P', 'L', 'C', 2, 3, '1', '.', '2'}));
  EXPECT_EQ(pdu.ask({43, 14, 2, 0})[6], 7);
  EXPECT_EQ(pdu.ask({43, 14, 4, 6}), (Pdu{43, 14, 4, 0x82, 0, 0, 1, 6, 7, 'P', 'r', 'o', 'j', 'e', 'c', 't'}));
  EXPECT_EQ(pdu.ask({43, 14, 1, 9}), basic);  // a stream that begins at an object that is none starts anew
}

TEST(ModbusPdu, LongIdentificationsFollowInFurtherAnswers) {
  PlantPdu plant;
  modbus::PduHandler handler(plant.data, {std::string(300, 'a'), "b", "c", "d", "e", "f", "g"}, false);
  std::array<std::uint8_t, modbus::kMaxPdu> response{};
  ASSERT_EQ(handler.handle(Pdu{43, 14, 1, 0}, response), 253u);
  EXPECT_EQ(response[4], 0xff);  // more follows
  EXPECT_EQ(response[5], 1);     // from object 1 on
  EXPECT_EQ(response[6], 1);
  ASSERT_EQ(handler.handle(Pdu{43, 14, 1, 1}, response), 13u);
  EXPECT_EQ(response[4], 0);
  EXPECT_EQ(response[6], 2);
}

}  // namespace
}  // namespace plc::test
