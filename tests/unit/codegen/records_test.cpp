// How many look-up records drawings take, and that they come in long runs: the figure the scan time hangs on.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "bytecode/codegen/generate.h"
#include "bytecode/image.h"
#include "frontend-fbd/power_flow.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using bytecode::Opcode;
using ir::Op;
using test::ModuleBuilder;

struct Counts {
  std::size_t runs = 0, records = 0, others = 0;
};

/// Instructions of a body that holds only boolean runs, moves and RETURN.
Counts count(const std::vector<std::uint32_t>& code) {
  Counts c;
  for (std::size_t at = 0; at < code.size();) {
    const auto opcode = static_cast<Opcode>(code[at] & 0xffffu);
    const std::uint32_t items = code[at] >> 16;
    at += bytecode::words_of(bytecode::info(opcode).operands, items);
    if (opcode == Opcode::kBoolRun) {
      ++c.runs;
      c.records += items;
    } else if (opcode != Opcode::kReturn) {
      ++c.others;
    }
  }
  return c;
}

struct Records : testing::Test {
  ModuleBuilder m;
  std::uint32_t main = m.pou("Main");
  std::vector<std::uint32_t> in, out;
  ir::Builder b = m.body(main);

  Records() {
    m.task("T", main, "Main");
    for (int i = 0; i < 24; ++i) in.push_back(m.variable(main, "i" + std::to_string(i), ir::kBoolType));
    for (int i = 0; i < 8; ++i) out.push_back(m.variable(main, "q" + std::to_string(i), ir::kBoolType));
  }
  ir::ValueId contact(int i) { return b.load(b.variable(in[static_cast<std::size_t>(i)])); }
  void coil(int i, ir::ValueId v) { b.store(b.variable(out[static_cast<std::size_t>(i)]), v); }
  ir::ValueId series(int first, int last) {
    ir::ValueId v = contact(first);
    for (int i = first + 1; i <= last; ++i) v = b.logic(Op::kAnd, v, contact(i));
    return v;
  }
  Counts counts() {
    const auto image = bytecode::generate(m.module, m.diagnostics);
    EXPECT_TRUE(image.has_value());
    core::Diagnostics verdict;
    EXPECT_TRUE(bytecode::verify(*image, verdict).has_value())
        << (verdict.all().empty() ? "" : verdict.all().front().message);
    return count(image->pous[0].code);
  }
};

TEST_F(Records, FourContactRungIsOneRecord) {
  // (i0 OR i1) AND i2 AND NOT i3
  coil(0,
       b.logic(Op::kAnd, b.logic(Op::kAnd, b.logic(Op::kOr, contact(0), contact(1)), contact(2)), b.not_(contact(3))));
  const Counts c = counts();
  EXPECT_EQ(c.records, 1u);
  EXPECT_EQ(c.runs, 1u);
  EXPECT_EQ(c.others, 0u);
}

TEST_F(Records, NestedRungOfTwelveIsThreeRecords) {
  // ((i0 i1 | i2 i3) i4 | i5 i6 i7) i8 (i9 | i10 | NOT i11)
  const auto inner = b.logic(Op::kAnd, b.logic(Op::kOr, series(0, 1), series(2, 3)), contact(4));
  const auto left = b.logic(Op::kOr, inner, series(5, 7));
  const auto right = b.logic(Op::kOr, b.logic(Op::kOr, contact(9), contact(10)), b.not_(contact(11)));
  coil(0, b.logic(Op::kAnd, b.logic(Op::kAnd, left, contact(8)), right));
  EXPECT_EQ(counts().records, 3u);
}

TEST_F(Records, WideSeriesFillsRecords) {
  coil(0, series(0, 20));  // 21 leaves: 5 records of 5 take 1 + 5 * 4
  EXPECT_EQ(counts().records, 5u);
}

TEST_F(Records, ConsecutiveRungsAreOneRun) {
  for (int i = 0; i < 8; ++i) coil(i, series(i, i + 3));
  const Counts c = counts();
  EXPECT_EQ(c.records, 8u);
  EXPECT_EQ(c.runs, 1u);
}

TEST_F(Records, ShortRungWithThreeCoilsIsRepeated) {
  const auto v = series(0, 3);
  for (int i = 0; i < 3; ++i) coil(i, v);
  EXPECT_EQ(counts().records, 3u);
}

TEST_F(Records, LongRungWithThreeCoilsIsEvaluatedOnce) {
  const auto v = series(0, 8);  // two records, then two coils read the first one
  for (int i = 0; i < 3; ++i) coil(i, v);
  EXPECT_EQ(counts().records, 4u);
}

TEST_F(Records, ConstantsVanish) {
  const auto rail = b.constant_bool(true);
  coil(0, b.logic(Op::kAnd, rail, contact(0)));
  coil(1, b.logic(Op::kOr, b.logic(Op::kAnd, contact(1), b.constant_bool(false)), contact(2)));
  coil(2, b.logic(Op::kXor, contact(3), b.not_(contact(3))));
  EXPECT_EQ(counts().records, 3u);
}

TEST_F(Records, SetAndResetCoilsTakeOneEach) {
  const auto q = b.variable(out[0]);
  b.store(q, b.logic(Op::kOr, b.load(q), series(0, 3)));
  b.store(q, b.logic(Op::kAnd, b.load(q), b.not_(series(4, 7))));
  EXPECT_EQ(counts().records, 2u);
}

TEST_F(Records, FlowComputedBeforeACoilKeepsItsValue) {
  // A coil that writes the contact's own variable does not change the flow to the second coil.
  const auto x = b.variable(in[0]);
  const auto flow = b.logic(Op::kAnd, b.load(x), contact(1));
  b.store(x, b.not_(flow));
  coil(0, flow);
  EXPECT_EQ(counts().records, 3u);  // flow, x, q0
}

TEST_F(Records, RunsAreSplitOnlyAtTheFormatsLimit) {
  for (int i = 0; i < 70000; ++i) coil(i % 8, series(i % 16, i % 16 + 3));
  const Counts c = counts();
  EXPECT_EQ(c.records, 70000u);
  EXPECT_EQ(c.runs, 2u);
}

TEST_F(Records, BranchesShareTheContactsInFrontOfThem) {
  // i0..i3 in series, then (i4, or NOT i5), then (i6, or i7 and NOT i8): ten contacts, as drawn.
  fbd::PowerFlows flows;
  ir::ValueId flow = b.constant_bool(true);
  for (int i = 0; i < 4; ++i) flow = flows.series(b, flow, contact(i));
  flow = flows.parallel(b, flows.series(b, flow, contact(4)), flows.series(b, flow, b.not_(contact(5))));
  const ir::ValueId lower = flows.series(b, flows.series(b, flow, contact(7)), b.not_(contact(8)));
  coil(0, flows.parallel(b, flows.series(b, flow, contact(6)), lower));
  EXPECT_EQ(counts().records, 2u);  // as ORs of whole ways it would be four
}

TEST_F(Records, AWirePastAContactTakesItOut) {
  fbd::PowerFlows flows;
  const ir::ValueId flow = flows.series(b, contact(0), contact(1));
  coil(0, flows.parallel(b, flows.series(b, flow, contact(2)), flow));
  coil(1, flows.parallel(b, contact(3), contact(4)));  // nothing in common
  const auto image = bytecode::generate(m.module, m.diagnostics);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(count(image->pous[0].code).records, 2u);
}

TEST_F(Records, BranchesOfAnyLengthAreLoweredInLinearTime) {
  fbd::PowerFlows flows;
  const ir::ValueId rail = b.constant_bool(true);
  ir::ValueId flow = flows.series(b, rail, contact(0));
  for (int i = 0; i < 20000; ++i) flow = flows.parallel(b, flows.series(b, flow, contact(i % 24)), rail);
  EXPECT_LT(m.module.pous[main].body.insts.size(), 20000u * 5);
}

}  // namespace
}  // namespace plc
