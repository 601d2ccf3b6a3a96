// Requests, answers and frames, from the examples of the specification and from hostile peers.
#include "io-drivers/modbus-client/frame.h"

#include <gtest/gtest.h>

#include <random>

namespace plc::modbus_client {
namespace {

TEST(Frame, RequestsAreThoseOfTheSpecification) {
  // V1.1b3, 6.1 to 6.12: the examples there.
  EXPECT_EQ(read_pdu(ModbusTable::kCoils, 19, 19), (Bytes{1, 0, 0x13, 0, 0x13}));
  EXPECT_EQ(read_pdu(ModbusTable::kDiscreteInputs, 196, 22), (Bytes{2, 0, 0xc4, 0, 0x16}));
  EXPECT_EQ(read_pdu(ModbusTable::kHoldingRegisters, 107, 3), (Bytes{3, 0, 0x6b, 0, 3}));
  EXPECT_EQ(read_pdu(ModbusTable::kInputRegisters, 8, 1), (Bytes{4, 0, 8, 0, 1}));
  const Cells on = {1}, three = {3}, two = {10, 0x102}, ten = {1, 0, 1, 1, 0, 0, 1, 1, 1, 0};
  EXPECT_EQ(write_pdu(ModbusTable::kCoils, 172, on, false), (Bytes{5, 0, 0xac, 0xff, 0}));
  EXPECT_EQ(write_pdu(ModbusTable::kHoldingRegisters, 1, three, false), (Bytes{6, 0, 1, 0, 3}));
  EXPECT_EQ(write_pdu(ModbusTable::kCoils, 19, ten, false), (Bytes{15, 0, 0x13, 0, 10, 2, 0xcd, 1}));
  EXPECT_EQ(write_pdu(ModbusTable::kHoldingRegisters, 1, two, false), (Bytes{16, 0, 1, 0, 2, 4, 0, 10, 1, 2}));
  EXPECT_EQ(write_pdu(ModbusTable::kHoldingRegisters, 1, three, true), (Bytes{16, 0, 1, 0, 1, 2, 0, 3}));
  EXPECT_EQ(write_pdu(ModbusTable::kCoils, 1, on, true), (Bytes{15, 0, 1, 0, 1, 1, 1}));
}

TEST(Frame, AnswersGiveCellsOrErrors) {
  struct Row {
    const char* what;
    Bytes request, answer;
    Error error;
    Cells cells;
  };
  const Bytes coils = read_pdu(ModbusTable::kCoils, 19, 10), words = read_pdu(ModbusTable::kHoldingRegisters, 0, 2);
  const Bytes write = write_pdu(ModbusTable::kHoldingRegisters, 1, Cells{3}, false);
  const Row rows[] = {
      {"bits, lowest first", coils, {1, 2, 0xcd, 2}, Error::kNone, {1, 0, 1, 1, 0, 0, 1, 1, 0, 1}},
      {"registers", words, {3, 4, 1, 2, 0xff, 0xfe}, Error::kNone, {0x102, 0xfffe}},
      {"written", write, {6, 0, 1, 0, 3}, Error::kNone, {}},
      {"exception", words, {0x83, 2}, Error::kIllegalAddress, {}},
      {"unknown exception", words, {0x83, 77}, static_cast<Error>(77), {}},
      {"exception 0", words, {0x83, 0}, Error::kWrongAnswer, {}},
      {"long exception", words, {0x83, 2, 0}, Error::kWrongAnswer, {}},
      {"other function", words, {4, 4, 1, 2, 3, 4}, Error::kWrongAnswer, {}},
      {"too few bytes", words, {3, 4, 1, 2, 3}, Error::kWrongAnswer, {}},
      {"too many bytes", words, {3, 4, 1, 2, 3, 4, 5}, Error::kWrongAnswer, {}},
      {"other count", words, {3, 2, 1, 2}, Error::kWrongAnswer, {}},
      {"other value written", write, {6, 0, 1, 0, 4}, Error::kWrongAnswer, {}},
      {"other address written", write, {6, 0, 2, 0, 3}, Error::kWrongAnswer, {}},
      {"nothing", words, {}, Error::kWrongAnswer, {}},
  };
  for (const Row& row : rows) {
    Cells cells = {99};
    EXPECT_EQ(parse_answer(row.request, row.answer, cells), row.error) << row.what;
    EXPECT_EQ(cells, row.cells) << row.what;
  }
}

TEST(Frame, WhatIsWrongWithATcpFrameShowsAtOnce) {
  const Bytes pdu = {3, 4, 1, 2, 3, 4};
  const Bytes good = tcp_frame(0x1234, 7, pdu);
  EXPECT_EQ(good, (Bytes{0x12, 0x34, 0, 0, 0, 7, 7, 3, 4, 1, 2, 3, 4}));
  std::span<const std::uint8_t> answer;
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(parse_tcp(std::span(good).first(size), 0x1234, 7, answer), Progress::kMore) << size;
  }
  ASSERT_EQ(parse_tcp(good, 0x1234, 7, answer), Progress::kComplete);
  EXPECT_EQ(Bytes(answer.begin(), answer.end()), pdu);
  for (const auto& [place, bytes] :
       std::initializer_list<std::pair<std::size_t, std::size_t>>{{1, 2}, {2, 4}, {3, 4}, {4, 6}, {6, 7}}) {
    Bytes wrong = good;
    wrong[place] ^= 0x40;
    EXPECT_EQ(parse_tcp(std::span(wrong).first(bytes), 0x1234, 7, answer), Progress::kWrong) << place;
  }
  for (const std::uint8_t length : Bytes{0, 1, 255}) {
    Bytes wrong = good;
    wrong[5] = length;
    EXPECT_EQ(parse_tcp(wrong, 0x1234, 7, answer), Progress::kWrong) << int(length);
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_EQ(parse_tcp(longer, 0x1234, 7, answer), Progress::kWrong);
}

TEST(Frame, RtuFramesHaveTheirCheckSum) {
  const Bytes request = read_pdu(ModbusTable::kHoldingRegisters, 0, 2);
  EXPECT_EQ(rtu_frame(1, request), (Bytes{1, 3, 0, 0, 0, 2, 0xc4, 0x0b}));
  const Bytes pdu = {3, 4, 1, 2, 3, 4}, exception = {0x83, 2};
  std::span<const std::uint8_t> answer;
  for (const Bytes& one : {pdu, exception}) {
    const Bytes good = rtu_frame(9, one);
    for (std::size_t size = 0; size < good.size(); ++size) {
      EXPECT_EQ(parse_rtu(std::span(good).first(size), 9, request, answer), Progress::kMore) << size;
    }
    ASSERT_EQ(parse_rtu(good, 9, request, answer), Progress::kComplete);
    EXPECT_EQ(Bytes(answer.begin(), answer.end()), one);
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
      Bytes wrong = good;
      wrong[bit / 8] ^= static_cast<std::uint8_t>(1u << bit % 8);
      EXPECT_NE(parse_rtu(wrong, 9, request, answer), Progress::kComplete) << bit;
    }
  }
}

TEST(Frame, IdentityIsReadFromWholeAnswersOnly) {
  const Bytes good = {0x2b, 0x0e, 1, 1, 0, 0, 2, 0, 4, 'A', 'C', 'M', 'E', 1, 2, 'X', 7};
  EXPECT_EQ(parse_identity(good), (std::vector<std::string>{"ACME", "X?"}));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_EQ(parse_identity(std::span(good).first(size)), std::nullopt) << size;
  }
  std::span<const std::uint8_t> answer;
  const Bytes frame = rtu_frame(3, good);
  for (std::size_t size = 0; size < frame.size(); ++size) {
    EXPECT_EQ(parse_rtu(std::span(frame).first(size), 3, identify_pdu(), answer), Progress::kMore) << size;
  }
  ASSERT_EQ(parse_rtu(frame, 3, identify_pdu(), answer), Progress::kComplete);
  EXPECT_EQ(Bytes(answer.begin(), answer.end()), good);
}

TEST(Frame, AnyBytesAreReadWithinTheirBounds) {
  std::mt19937 random(47);
  const Bytes requests[] = {read_pdu(ModbusTable::kCoils, 1, 2000), read_pdu(ModbusTable::kHoldingRegisters, 0, 125),
                            write_pdu(ModbusTable::kCoils, 1, Cells{1}, false), identify_pdu()};
  for (int i = 0; i < 200'000; ++i) {
    const Bytes& request = requests[random() % 4];
    Bytes bytes(random() % 300);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random() % 4 == 0 ? random() : random() % 4);
    if (bytes.size() > 7 && random() % 2 == 0) bytes[1] = bytes[7] = request[0];
    std::span<const std::uint8_t> answer;
    Cells cells;
    parse_tcp(bytes, 0, 0, answer);
    parse_rtu(bytes, bytes.empty() ? std::uint8_t{0} : bytes[0], request, answer);
    parse_answer(request, bytes, cells);
    EXPECT_LE(cells.size(), 2000u);
    parse_identity(bytes);
  }
}

}  // namespace
}  // namespace plc::modbus_client
