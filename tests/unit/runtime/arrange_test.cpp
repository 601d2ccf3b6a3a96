// Straight code that the interpreter arranges: how much of it, and that nobody sees it. Random programs: tests/engines.
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using bytecode::Opcode;

struct Numbers : OneProgram {
  std::uint32_t dint = b.type(core::TypeId::kDint);
  Word number(const std::string& name, std::int32_t initial = 0) {
    return main.variable(name, dint, bytecode::FieldRole::kLocal, bytes_of(initial));
  }
  /// What linking reports.
  static runtime::Program::LinkReport report(runtime::Resource& r) { return r.program(0).link_report(); }
};

std::string numbered(const char* name, int n) { return name + std::to_string(n); }

TEST(Arrange, NetworksThatShareATemporaryRunSideBySide) {
  Numbers p;
  const Word temporary = p.number("temporary");
  const Word three = p.number("three", 3);
  for (int n = 0; n < 20; ++n) {
    const Word in = p.number(numbered("in", n), n);
    p.main.op(Opcode::kAdd32, {temporary, in, three});
    p.main.op(Opcode::kMul32, {p.number(numbered("out", n)), temporary, temporary});
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Numbers::report(*r).arranged, 40u);
  EXPECT_EQ(Numbers::report(*r).runs, 2u);
  ASSERT_FALSE(r->program(0).execute({}));
  for (int n = 0; n < 20; ++n) {
    EXPECT_EQ(value_of(*r, "Main0." + numbered("out", n)), std::to_string((n + 3) * (n + 3)));
  }
  EXPECT_EQ(value_of(*r, "Main0.temporary"), "22") << "the last value";
}

TEST(Arrange, AValueIsReadBeforeItIsOverwritten) {
  // Values move down by one place, and grow by one.
  Numbers p;
  std::vector<Word> places;
  for (int n = 0; n < 30; ++n) places.push_back(p.number(numbered("v", n), 100 * n));
  const Word one = p.number("one", 1);
  for (int n = 0; n < 29; ++n) {
    const auto place = static_cast<std::size_t>(n);
    p.main.op(Opcode::kAdd32, {places[place], places[place + 1], one});
    p.main.op(Opcode::kMul32, {p.number(numbered("other", n)), one, one});
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_GT(Numbers::report(*r).arranged, 0u);
  for (int scan = 1; scan <= 2; ++scan) ASSERT_FALSE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "Main0.v0"), "202");
  EXPECT_EQ(value_of(*r, "Main0.v9"), "1102");
  EXPECT_EQ(value_of(*r, "Main0.v28"), "2901") << "its neighbour is nobody's result: 2900 + 1";
}

TEST(Arrange, AValueMayBeReadBetweenTwoWrites) {
  OneProgram p;
  const std::uint32_t type = p.b.type(core::TypeId::kWord);
  const auto word = [&](const std::string& name, std::uint16_t initial) {
    return p.main.variable(name, type, bytecode::FieldRole::kLocal, bytes_of(initial));
  };
  const Word value = word("value", 0);
  const Word in = word("in", 0x1234);
  const Word other = word("other", 0x00ff);
  for (int n = 0; n < 8; ++n) {
    p.main.op(Opcode::kXor16, {value, in, other});
    p.main.op(Opcode::kAnd16, {word(numbered("first", n), 0), value, other});
    p.main.op(Opcode::kOr16, {value, in, other});
    p.main.op(Opcode::kAnd16, {word(numbered("second", n), 0), value, other});
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(r->program(0).link_report().arranged, 32u);
  ASSERT_FALSE(r->program(0).execute({}));
  for (int n = 0; n < 8; ++n) {
    EXPECT_EQ(value_of(*r, "Main0." + numbered("first", n)), "203");
    EXPECT_EQ(value_of(*r, "Main0." + numbered("second", n)), "255");
  }
  EXPECT_EQ(value_of(*r, "Main0.value"), "4863");
}

TEST(Arrange, BlocksWaitForTheirInputsAndTheirReadersForThem) {
  // Every coil counts, and the next one is set by the counter before it.
  OneProgram p;
  const std::uint32_t block = p.b.block("CTU");
  Word enabled = p.main.variable("start", p.b.boolean());
  for (int n = 0; n < 16; ++n) {
    const Word counter = p.main.variable(numbered("c", n), p.b.block_type("CTU"));
    p.main.record(0xaaaaaaaa, counter, {enabled});  // CU
    p.main.op(Opcode::kRunTb, {block, counter});
    enabled = p.main.variable(numbered("q", n), p.b.boolean());
    p.main.record(0xaaaaaaaa, enabled, {counter + 2});  // Q
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  ASSERT_FALSE(r->program(0).execute({}));
  // PV is 0: CV has reached it from the start.
  EXPECT_EQ(value_of(*r, "Main0.c0.CV"), "0");
  EXPECT_EQ(value_of(*r, "Main0.c1.CV"), "1") << "its input rose in the same scan";
  EXPECT_EQ(value_of(*r, "Main0.c15.CV"), "1");
}

TEST(Arrange, MoreThanIsArrangedAtOnce) {
  Numbers p;
  const Word sum = p.number("sum");
  const Word one = p.number("one", 1);
  constexpr int kNetworks = 3000;
  for (int n = 0; n < kNetworks; ++n) {
    p.main.op(Opcode::kAdd32, {sum, sum, one});
    p.main.op(Opcode::kSub32, {p.number(numbered("out", n)), one, one});
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Numbers::report(*r).arranged, 2u * kNetworks);
  ASSERT_FALSE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "Main0.sum"), std::to_string(kNetworks));
}

TEST(Arrange, OrderThatGainsNothingStays) {
  // Each instruction needs the one before it.
  Numbers p;
  const Word sum = p.number("sum", 1);
  const Word two = p.number("two", 2);
  for (int n = 0; n < 8; ++n) {
    p.main.op(Opcode::kAdd32, {sum, sum, two});
    p.main.op(Opcode::kMul32, {sum, sum, two});
  }
  auto r = p.load();
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Numbers::report(*r).arranged, 0u);
  ASSERT_FALSE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "Main0.sum"), "1276");
}

TEST(Arrange, OnlyOnRequestNot) {
  Numbers p;
  const Word one = p.number("one", 1);
  for (int n = 0; n < 20; ++n) {
    p.main.op(n % 2 == 0 ? Opcode::kAdd32 : Opcode::kSub32, {p.number(numbered("out", n)), one, one});
  }
  auto r = p.load({.arrange = false});
  ASSERT_NE(r, nullptr);
  EXPECT_EQ(Numbers::report(*r).arranged, 0u);
  ASSERT_FALSE(r->program(0).execute({}));
  EXPECT_EQ(value_of(*r, "Main0.out18"), "2");
}

}  // namespace
}  // namespace plc::test
