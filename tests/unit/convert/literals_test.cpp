// Constants as literals that read back as the same.
#include "convert/literals.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <string>

namespace plc::convert {
namespace {

using core::TypeId;

std::string text(TypeId type, std::uint64_t bits) {
  const ir::TypeTable types;
  ir::Constant constant;
  constant.type = ir::ref_of(type);
  constant.bits = bits;
  return literal_text(types, constant).value_or("none");
}

TEST(Literals, NumbersHaveTheirType) {
  EXPECT_EQ(text(TypeId::kBool, 1), "TRUE");
  EXPECT_EQ(text(TypeId::kInt, 0xFFFF), "INT#-1");
  EXPECT_EQ(text(TypeId::kUint, 0xFFFF), "UINT#65535");
  EXPECT_EQ(text(TypeId::kWord, 0xABC), "WORD#16#ABC");
  EXPECT_EQ(text(TypeId::kLint, 0x8000000000000000u), "LINT#-9223372036854775808");
  EXPECT_EQ(text(TypeId::kReal, std::bit_cast<std::uint32_t>(1.0f)), "REAL#1.0");
  EXPECT_EQ(text(TypeId::kReal, std::bit_cast<std::uint32_t>(0.1f)), "REAL#0.1");
  EXPECT_EQ(text(TypeId::kLreal, std::bit_cast<std::uint64_t>(1e300)), "LREAL#1.0e+300");
  EXPECT_EQ(text(TypeId::kReal, std::bit_cast<std::uint32_t>(std::nanf(""))), "none");
}

TEST(Literals, TimesAndDates) {
  EXPECT_EQ(text(TypeId::kTime, 0), "T#0s");
  EXPECT_EQ(text(TypeId::kTime, 20'000'000), "T#20ms");
  EXPECT_EQ(text(TypeId::kTime, 90'000'000'000), "T#90s");
  EXPECT_EQ(text(TypeId::kLtime, 1), "LT#1ns");
  EXPECT_EQ(text(TypeId::kTime, static_cast<std::uint64_t>(-5'000'000)), "T#-5ms");
  EXPECT_EQ(text(TypeId::kDate, 951'782'400'000'000'000), "D#2000-02-29");
  EXPECT_EQ(text(TypeId::kDt, 951'782'400'000'000'000 + 3'661'500'000'000), "DT#2000-02-29-01:01:01.5");
  EXPECT_EQ(text(TypeId::kTod, 3'661'000'000'000), "TOD#01:01:01");
}

TEST(Literals, TextsEscapeWhatEndsThem) {
  ir::TypeTable types;
  ir::Constant constant;
  constant.type = types.string(TypeId::kString, 20);
  constant.text = "it's $5\n\x80";
  EXPECT_EQ(literal_text(types, constant), "'it$'s $$5$0A$80'");
  constant.type = types.string(TypeId::kWstring, 20);
  constant.text = std::string("a\0\"\0\xAC\x20", 6);
  EXPECT_EQ(literal_text(types, constant), "\"a$\"$20AC\"");
}

}  // namespace
}  // namespace plc::convert
