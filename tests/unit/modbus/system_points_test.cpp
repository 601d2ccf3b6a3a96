// Registers of the plant itself, and coils that latch.
#include "io-drivers/modbus/system_points.h"

#include <gtest/gtest.h>

#include "tests/unit/modbus/plant.h"

namespace plc::test {
namespace {

using modbus::SystemState;

std::vector<std::uint16_t> inputs(PlantPdu& pdu, std::uint32_t first, std::uint32_t count) {
  const Pdu answer = pdu.ask(pdu_of(4, {first, count}));
  std::vector<std::uint16_t> values;
  for (std::size_t i = 2; i + 1 < answer.size(); i += 2) {
    values.push_back(static_cast<std::uint16_t>(answer[i] << 8 | answer[i + 1]));
  }
  return values;
}
using Words = std::vector<std::uint16_t>;

TEST(SystemPoints, AreRowsWithoutGaps) {
  std::uint32_t next = modbus::kSystemFirst;
  for (const modbus::SystemPoint& point : modbus::system_points()) {
    EXPECT_EQ(point.address, next) << point.name;
    next += point.registers;
  }
  EXPECT_EQ(next, modbus::system_end());
  EXPECT_EQ(modbus::system_end(), 8201u) << "docs/guides/modbus.md names them";
}

TEST(SystemPoints, TellHowThePlantRuns) {
  PlantPdu pdu;
  EXPECT_EQ(inputs(pdu, 8192, 8), Words(8)) << "nobody tells";
  pdu.data.set_system(
      [] { return SystemState{modbus::PlantState::kTaskStopped, 1002, 0x00010002, 0x12345678, 86400, 3}; });
  EXPECT_EQ(inputs(pdu, 8192, 8), (Words{3, 1002, 1, 2, 0x1234, 0x5678, 1, 20864}));
  EXPECT_EQ(inputs(pdu, 8200, 1), Words{3});
  EXPECT_EQ(inputs(pdu, 8196, 2), (Words{0x1234, 0x5678}));
  EXPECT_EQ(inputs(pdu, 8193, 1), Words{1002});
  EXPECT_EQ(pdu.exception(pdu_of(4, {8192, 10})), 2) << "the map ends there";
  EXPECT_EQ(pdu.exception(pdu_of(4, {8191, 2})), 2);
  EXPECT_EQ(pdu.exception(pdu_of(3, {8192, 1})), 2) << "input registers alone";
}

TEST(SystemPoints, FollowTheWordOrder) {
  const auto words = [](io::WordOrder order) {
    io::ModbusConfig config;
    config.word_order = order;
    config.strict_gaps = true;
    PlantPdu pdu(config);
    pdu.data.set_system([] { return SystemState{modbus::PlantState::kRuns, 0, 0, 0x12345678, 0, 0}; });
    const Words all = inputs(pdu, 8192, 8);
    EXPECT_EQ(all.at(0), 1) << "one register has no order";
    return Words{all.at(4), all.at(5)};
  };
  EXPECT_EQ(words(io::WordOrder::kAbcd), (Words{0x1234, 0x5678}));
  EXPECT_EQ(words(io::WordOrder::kCdab), (Words{0x5678, 0x1234}));
  EXPECT_EQ(words(io::WordOrder::kBadc), (Words{0x3412, 0x7856}));
  EXPECT_EQ(words(io::WordOrder::kDcba), (Words{0x7856, 0x3412}));
}

/// A task that uses the coils, latched from 0 to 7, and how many scans it made.
struct LatchedPdu : PlantPdu {
  LatchedPdu() : PlantPdu(config(), image()) {
    data.set_scans([this](std::uint32_t) { return scans; });
  }
  static io::ModbusConfig config() {
    io::ModbusConfig config;
    io::ModbusRange& range = config.ranges.emplace_back();
    range.table = io::ModbusTable::kCoils;
    range.last = 7;
    range.latch = true;
    return config;
  }
  static Image image() {
    ImageBuilder b;
    const Word coils = b.global("Coils", b.array(b.boolean(), 16), {}, {.input = true, .address = "%QX0.0"});
    const Word seen = b.global("Seen", b.boolean());
    PouBuilder main = b.pou("Main", PouKind::kProgram);
    main.op(Opcode::kMoveBool, {seen, coils});
    b.task("Fast", 10'000'000, {main.finish()});
    return b.build();
  }
  void set(std::uint32_t coil, bool value) { EXPECT_EQ(exception(pdu_of(5, {coil, value ? 0xff00u : 0u})), 0); }
  bool is_set(std::uint32_t coil) { return (ask(pdu_of(1, {coil, 1})).at(2) & 1) != 0; }
  std::uint64_t scans = 100;
};

TEST(CoilLatch, AShortPressStaysUntilAWholeScanHasSeenIt) {
  LatchedPdu pdu;
  pdu.set(3, true);
  pdu.set(3, false);
  EXPECT_TRUE(pdu.is_set(3));
  EXPECT_TRUE(pdu.data.has_waiting_coils());
  pdu.data.release_coils();
  EXPECT_TRUE(pdu.is_set(3));
  ++pdu.scans;  // may have begun before the press
  pdu.data.release_coils();
  EXPECT_TRUE(pdu.is_set(3));
  ++pdu.scans;
  pdu.data.release_coils();
  EXPECT_FALSE(pdu.is_set(3));
  EXPECT_FALSE(pdu.data.has_waiting_coils());
}

TEST(CoilLatch, WhatWasSeenIsResetAtOnce) {
  LatchedPdu pdu;
  pdu.set(3, true);
  pdu.scans += 2;
  pdu.set(3, false);
  EXPECT_FALSE(pdu.is_set(3));
  pdu.set(3, false);
  EXPECT_FALSE(pdu.data.has_waiting_coils()) << "nothing was pressed";
}

TEST(CoilLatch, ANewPressTakesTheOldResetBack) {
  LatchedPdu pdu;
  pdu.set(3, true);
  pdu.set(3, false);
  pdu.set(3, true);
  EXPECT_FALSE(pdu.data.has_waiting_coils());
  pdu.scans += 5;
  pdu.data.release_coils();
  EXPECT_TRUE(pdu.is_set(3));
}

TEST(CoilLatch, HoldsForItsRangeAndForWholeRequests) {
  LatchedPdu pdu;
  EXPECT_EQ(pdu.exception(write_coils(0, 16, {0xff, 0xff})), 0);
  EXPECT_EQ(pdu.exception(write_coils(0, 16, {0x0f, 0x0f})), 0);
  EXPECT_EQ(pdu.ask(pdu_of(1, {0, 16})), (Pdu{1, 2, 0xff, 0x0f})) << "coils from 8 on are not latched";
  pdu.scans += 2;
  pdu.data.release_coils();
  EXPECT_EQ(pdu.ask(pdu_of(1, {0, 16})), (Pdu{1, 2, 0x0f, 0x0f}));
}

TEST(CoilLatch, NobodyWaitsForATaskThatHasStopped) {
  LatchedPdu pdu;
  pdu.set(3, true);
  pdu.scans = modbus::kNoMoreScans;
  pdu.set(3, false);
  EXPECT_FALSE(pdu.is_set(3));
}

}  // namespace
}  // namespace plc::test
