// Integers in bytes, whatever their size, sign and place.
#include "core/integer_at.h"

#include <gtest/gtest.h>

#include <array>

namespace plc::core {
namespace {

TEST(IntegerAt, HasTheSizeAndTheSignOfTheType) {
  std::array<std::byte, 9> bytes{};
  bytes.fill(std::byte{0xff});
  for (const std::size_t begin : {std::size_t{0}, std::size_t{1}}) {
    const std::byte* const from = bytes.data() + begin;
    EXPECT_EQ(integer_at(Rep::kBool, from), 1);
    for (const Rep rep : {Rep::kI8, Rep::kI16, Rep::kI32, Rep::kI64}) EXPECT_EQ(integer_at(rep, from), -1);
    EXPECT_EQ(integer_at(Rep::kU8, from), 0xff);
    EXPECT_EQ(integer_at(Rep::kU16, from), 0xffff);
    EXPECT_EQ(integer_at(Rep::kU32, from), 0xffff'ffff);
    EXPECT_EQ(integer_at(Rep::kU64, from), -1) << "the same bits";
    for (const Rep rep : {Rep::kF32, Rep::kF64, Rep::kStr, Rep::kWstr, Rep::kRef}) EXPECT_FALSE(integer_at(rep, from));
  }
  bytes.fill(std::byte{0});
  EXPECT_EQ(integer_at(Rep::kBool, bytes.data()), 0);
  EXPECT_EQ(integer_at(Rep::kI64, bytes.data()), 0);
}

}  // namespace
}  // namespace plc::core
