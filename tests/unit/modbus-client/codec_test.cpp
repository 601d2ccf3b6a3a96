// How variables lie in registers: every type, order of words and conversion.
#include "io-drivers/modbus-client/codec.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace plc::modbus_client {
namespace {

using core::TypeId;
using io::WordOrder;
using Registers = std::vector<std::uint16_t>;

template <class T>
Registers encoded(const Coding& coding, T value) {
  Registers cells(coding.variable == TypeId::kBool ? 1 : registers_of(coding.raw));
  encode(coding, reinterpret_cast<const std::byte*>(&value), cells);
  return cells;
}
template <class T>
T decoded(const Coding& coding, const Registers& cells) {
  std::byte bytes[8] = {};
  decode(coding, cells, bytes);
  T value{};
  std::memcpy(&value, bytes, sizeof value);
  return value;
}

Coding plain(TypeId variable, Raw raw, WordOrder order = WordOrder::kAbcd) {
  Coding coding;
  coding.variable = variable;
  coding.raw = raw;
  coding.order = order;
  return coding;
}

TEST(Codec, OrdersAreThoseOfTheServer) {
  const float value = 123.456F;  // 42F6 E979
  const std::pair<WordOrder, Registers> rows[] = {{WordOrder::kAbcd, {0x42f6, 0xe979}},
                                                  {WordOrder::kCdab, {0xe979, 0x42f6}},
                                                  {WordOrder::kBadc, {0xf642, 0x79e9}},
                                                  {WordOrder::kDcba, {0x79e9, 0xf642}}};
  for (const auto& [order, cells] : rows) {
    const Coding coding = plain(TypeId::kReal, Raw::kReal, order);
    EXPECT_EQ(encoded(coding, value), cells) << io::word_order_text(order);
    EXPECT_EQ(decoded<float>(coding, cells), value) << io::word_order_text(order);
  }
  const std::pair<WordOrder, Registers> wide[] = {{WordOrder::kAbcd, {0x0123, 0x4567, 0x89ab, 0xcdef}},
                                                  {WordOrder::kCdab, {0xcdef, 0x89ab, 0x4567, 0x0123}},
                                                  {WordOrder::kBadc, {0x2301, 0x6745, 0xab89, 0xefcd}},
                                                  {WordOrder::kDcba, {0xefcd, 0xab89, 0x6745, 0x2301}}};
  for (const auto& [order, cells] : wide) {
    const Coding coding = plain(TypeId::kLword, Raw::kUlint, order);
    EXPECT_EQ(encoded(coding, std::uint64_t{0x0123456789abcdef}), cells);
    EXPECT_EQ(decoded<std::uint64_t>(coding, cells), 0x0123456789abcdefu);
  }
  for (const auto order : {WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba}) {
    EXPECT_EQ(encoded(plain(TypeId::kInt, Raw::kInt, order), std::int16_t{0x1234}), Registers{0x1234});
  }
}

/// Both ways, for the least, the greatest and some values in between that both types have.
template <class T>
void round_trips(TypeId variable) {
  const Raw raw = raw_of(variable);
  using Limits = std::numeric_limits<T>;
  for (const T value : {Limits::lowest(), Limits::max(), T{0}, T{1}, T{100}}) {
    for (const auto order : {WordOrder::kAbcd, WordOrder::kCdab, WordOrder::kBadc, WordOrder::kDcba}) {
      const Coding coding = plain(variable, raw, order);
      EXPECT_EQ(decoded<T>(coding, encoded(coding, value)), value) << core::name_of(variable);
    }
  }
}

TEST(Codec, EveryTypeComesBackAsItWas) {
  round_trips<std::int8_t>(TypeId::kSint);
  round_trips<std::int16_t>(TypeId::kInt);
  round_trips<std::int32_t>(TypeId::kDint);
  round_trips<std::int64_t>(TypeId::kLint);
  round_trips<std::uint8_t>(TypeId::kUsint);
  round_trips<std::uint16_t>(TypeId::kUint);
  round_trips<std::uint32_t>(TypeId::kUdint);
  round_trips<std::uint64_t>(TypeId::kUlint);
  round_trips<std::uint8_t>(TypeId::kByte);
  round_trips<std::uint16_t>(TypeId::kWord);
  round_trips<std::uint32_t>(TypeId::kDword);
  round_trips<std::uint64_t>(TypeId::kLword);
  round_trips<float>(TypeId::kReal);
  round_trips<double>(TypeId::kLreal);
}

TEST(Codec, ScaleAndOffsetTurnNumbersBothWays) {
  Coding tenths = plain(TypeId::kReal, Raw::kInt);
  tenths.scale = 0.1;
  tenths.offset = -40;
  EXPECT_FLOAT_EQ(decoded<float>(tenths, {605}), 20.5F);
  EXPECT_FLOAT_EQ(decoded<float>(tenths, {0xffff}), -40.1F);
  EXPECT_EQ(encoded(tenths, 20.5F), Registers{605});
  EXPECT_EQ(encoded(tenths, -40.1F), Registers{0xffff});
  Coding whole = plain(TypeId::kInt, Raw::kUint);
  whole.scale = 0.5;
  EXPECT_EQ(decoded<std::int16_t>(whole, {3}), 2) << "half away from zero";
  EXPECT_EQ(encoded(whole, std::int16_t{7}), Registers{14});
}

TEST(Codec, WhatDoesNotFitBecomesTheNearest) {
  EXPECT_EQ(decoded<std::int16_t>(plain(TypeId::kInt, Raw::kUint), {40000}), 32767);
  EXPECT_EQ(decoded<std::uint16_t>(plain(TypeId::kUint, Raw::kInt), {0xffff}), 0);
  EXPECT_EQ(decoded<std::uint8_t>(plain(TypeId::kUsint, Raw::kUint), {300}), 255);
  EXPECT_EQ(encoded(plain(TypeId::kDint, Raw::kInt), std::int32_t{-100000}), Registers{0x8000});
  EXPECT_EQ(encoded(plain(TypeId::kReal, Raw::kInt), 1e9F), Registers{0x7fff});
  EXPECT_EQ(encoded(plain(TypeId::kReal, Raw::kUint), -1.0F), Registers{0});
  EXPECT_EQ(encoded(plain(TypeId::kLreal, Raw::kLint), 1e300), (Registers{0x7fff, 0xffff, 0xffff, 0xffff}));
  EXPECT_EQ(encoded(plain(TypeId::kReal, Raw::kInt), std::nanf("")), Registers{0});
  const auto infinity = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::infinity());
  EXPECT_EQ(decoded<std::int32_t>(plain(TypeId::kDint, Raw::kReal), {std::uint16_t(infinity >> 16), 0}),
            std::numeric_limits<std::int32_t>::max());
}

TEST(Codec, BitsAreTakenFromRegistersAndPutThere) {
  Coding bit = plain(TypeId::kBool, Raw::kUint);
  bit.bit = 9;
  EXPECT_EQ(decoded<std::uint8_t>(bit, {0x0200}), 1);
  EXPECT_EQ(decoded<std::uint8_t>(bit, {0xfdff}), 0);
  Registers cells = {0x8001};
  const std::byte on{1}, off{0};
  encode(bit, &on, cells);
  EXPECT_EQ(cells, Registers{0x8201});
  encode(bit, &off, cells);
  EXPECT_EQ(cells, Registers{0x8001});
  bit.invert = true;
  encode(bit, &off, cells);
  EXPECT_EQ(cells, Registers{0x8201});
  EXPECT_EQ(decoded<std::uint8_t>(bit, cells), 0);
  Coding coil = plain(TypeId::kBool, Raw::kUint);
  EXPECT_EQ(decoded<std::uint8_t>(coil, {1}), 1);
  EXPECT_EQ(encoded(coil, std::uint8_t{1}), Registers{1});
}

TEST(Codec, TextsEndWhereTheyEnd) {
  const struct {
    core::TypeId type;
    std::uint16_t characters;
    io::WordOrder order;
    std::vector<std::uint16_t> cells;
    std::string text;  ///< bytes
    std::vector<std::uint16_t> back;
  } rows[] = {
      {core::TypeId::kString, 5, io::WordOrder::kAbcd, {0x4142, 0x4344, 0x4500}, "ABCDE", {0x4142, 0x4344, 0x4500}},
      {core::TypeId::kString, 5, io::WordOrder::kAbcd, {0x4142, 0x4344, 0x4546}, "ABCDE", {0x4142, 0x4344, 0x4500}},
      {core::TypeId::kString, 9, io::WordOrder::kCdab, {0x4142, 0x4344}, "ABCD", {0x4142, 0x4344}},
      {core::TypeId::kString, 9, io::WordOrder::kBadc, {0x4142, 0x0043}, "BAC", {0x4142, 0x0043}},
      {core::TypeId::kString, 9, io::WordOrder::kAbcd, {0x4100, 0x4344}, "A", {0x4100, 0}},
      {core::TypeId::kString, 9, io::WordOrder::kAbcd, {0, 0x4344}, "", {0, 0}},
      {core::TypeId::kWstring,
       3,
       io::WordOrder::kAbcd,
       {0x20ac, 0x41},
       "\xac\x20"
       "A" +
           std::string(1, 0),
       {0x20ac, 0x41}},
      {core::TypeId::kWstring, 1, io::WordOrder::kDcba, {0xac20, 0x41}, "\xac\x20", {0xac20, 0}},
  };
  for (const auto& row : rows) {
    Coding coding;
    coding.variable = row.type;
    coding.characters = row.characters;
    coding.order = row.order;
    const std::size_t width = row.type == core::TypeId::kWstring ? 2 : 1;
    std::vector<std::byte> value(sizeof(core::StringHeader) + row.characters * width, std::byte{0x7e});
    decode(coding, row.cells, value.data());
    core::StringHeader header;
    std::memcpy(&header, value.data(), sizeof header);
    EXPECT_EQ(header.capacity, row.characters);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(value.data()) + sizeof header, header.length * width),
              row.text);
    std::vector<std::uint16_t> back(row.cells.size(), 0xffff);
    encode(coding, value.data(), back);
    EXPECT_EQ(back, row.back) << row.text;
  }
}

}  // namespace
}  // namespace plc::modbus_client
