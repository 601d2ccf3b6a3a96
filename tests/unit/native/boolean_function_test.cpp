// Truth tables as expressions: the same function for every one of four inputs, and for a sample of five.
#include "native/boolean_function.h"

#include <gtest/gtest.h>

#include <random>

namespace plc::test {
namespace {

using native::BooleanExpression;
using Kind = BooleanExpression::Kind;

void expect_same(std::uint32_t truth, unsigned inputs) {
  const BooleanExpression e = native::expression_of(truth, inputs);
  const BooleanExpression opposite = native::negate(e);
  for (std::uint32_t row = 0; row < 1u << inputs; ++row) {
    const bool wanted = (truth >> row & 1u) != 0;
    ASSERT_EQ(e.value(row), wanted) << std::hex << truth << " row " << row;
    ASSERT_EQ(opposite.value(row), !wanted) << std::hex << truth << " row " << row;
  }
}

/// How often inputs are in it; tables are no expressions of them.
int inputs_in(const BooleanExpression& e) {
  if (e.kind == Kind::kTable) return 1000;
  int count = e.kind == Kind::kInput ? 1 : 0;
  for (const BooleanExpression& child : e.children) count += inputs_in(child);
  return count;
}

TEST(BooleanFunction, EveryFunctionOfUpToFourInputs) {
  for (unsigned inputs = 0; inputs <= 4; ++inputs) {
    for (std::uint32_t truth = 0; truth < 1u << (1u << inputs); ++truth) expect_same(truth, inputs);
  }
}

TEST(BooleanFunction, ASampleOfFiveInputs) {
  std::mt19937 random(1);
  for (int n = 0; n < 20'000; ++n) expect_same(static_cast<std::uint32_t>(random()), 5);
}

/// What rungs are: series and parallel contacts, some of them negated. A table of these is a rung read once.
std::uint32_t random_rung(std::mt19937& random, unsigned first, unsigned count, bool series) {
  static constexpr std::uint32_t kInputs[] = {0xaaaaaaaau, 0xccccccccu, 0xf0f0f0f0u, 0xff00ff00u, 0xffff0000u};
  if (count == 1) return random() % 3 == 0 ? ~kInputs[first] : kInputs[first];
  const unsigned left = 1 + static_cast<unsigned>(random()) % (count - 1);
  const std::uint32_t a = random_rung(random, first, left, !series);
  const std::uint32_t b = random_rung(random, first + left, count - left, !series);
  if (random() % 5 == 0) return a ^ b;
  return series ? a & b : a | b;
}

TEST(BooleanFunction, RungsReadEachContactOnce) {
  std::mt19937 random(2);
  for (int n = 0; n < 5'000; ++n) {
    const std::uint32_t truth = random_rung(random, 0, 5, n % 2 == 0);
    expect_same(truth, 5);
    EXPECT_EQ(inputs_in(native::expression_of(truth, 5)), 5) << std::hex << truth;
  }
}

TEST(BooleanFunction, WhatCannotBeReadOnceIsATable) {
  const BooleanExpression mux = native::expression_of(0xca, 3);
  EXPECT_EQ(mux.kind, Kind::kTable);
  // After a contact in series the table is of three inputs still.
  const BooleanExpression in_series = native::expression_of(0xca00, 4);
  EXPECT_EQ(in_series.kind, Kind::kAnd);
}

TEST(BooleanFunction, InputsThatDoNotMatterAreNotRead) {
  EXPECT_EQ(inputs_in(native::expression_of(0xaaaaaaaau, 5)), 1);
  EXPECT_EQ(native::expression_of(0, 5).kind, Kind::kConstant);
  EXPECT_TRUE(native::expression_of(0xffffffffu, 5).negated);
}

}  // namespace
}  // namespace plc::test
