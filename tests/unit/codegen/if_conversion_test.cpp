// Which IFs become boolean logic: by what instructions their bodies have. What they compute: tests/cases/st/short-ifs*.
#include "bytecode/codegen/if_conversion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "ir/builder.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using ir::Op;
using test::ModuleBuilder;

struct IfConversion : testing::Test {
  ModuleBuilder m;
  std::uint32_t main = m.pou("Main");
  std::vector<std::uint32_t> bools;
  std::uint32_t number = m.variable(main, "n", test::type(core::TypeId::kInt));
  ir::Builder b = m.body(main);

  IfConversion() {
    for (int i = 0; i < 6; ++i) bools.push_back(m.variable(main, "b" + std::to_string(i), ir::kBoolType));
  }
  ir::PlaceId place(std::size_t i) { return b.variable(bools[i]); }
  ir::ValueId value(std::size_t i) { return b.load(place(i)); }
  void set(std::size_t i, bool to) { b.store(place(i), b.constant_bool(to)); }
  /// How many jumps are left.
  [[nodiscard]] std::ptrdiff_t jumps() const {
    const auto converted = bytecode::convert_ifs(m.module.pous[main].body);
    const ir::Body& body = converted ? *converted : m.module.pous[main].body;
    return std::count_if(body.insts.begin(), body.insts.end(), [](const ir::Inst& inst) {
      return inst.op == Op::kJump || inst.op == Op::kJumpIf || inst.op == Op::kJumpIfNot;
    });
  }
};

TEST_F(IfConversion, ABranchThatSetsIsLogic) {
  const ir::LabelId end = b.new_label();
  b.jump_if_not(value(0), end);
  set(1, true);
  set(2, false);
  b.bind(end);
  EXPECT_EQ(jumps(), 0);
}

TEST_F(IfConversion, SoAreBothBranches) {
  const ir::LabelId other = b.new_label(), end = b.new_label();
  b.jump_if_not(value(0), other);
  b.store(place(1), b.logic(Op::kAnd, value(2), value(3)));
  b.jump(end);
  b.bind(other);
  b.store(place(1), value(4));
  b.bind(end);
  EXPECT_EQ(jumps(), 0);
}

TEST_F(IfConversion, OneAfterTheOther) {
  for (std::size_t i = 0; i < 3; ++i) {
    const ir::LabelId end = b.new_label();
    b.jump_if(value(i), end);
    set(i + 1, i == 1);
    b.bind(end);
  }
  EXPECT_EQ(jumps(), 0);
}

TEST_F(IfConversion, OtherValuesStayJumps) {
  const ir::LabelId end = b.new_label();
  b.jump_if_not(value(0), end);
  set(1, true);
  b.assign(b.variable(number), test::literal(3), "n");
  b.bind(end);
  EXPECT_EQ(jumps(), 1);
}

TEST_F(IfConversion, LabelsThatOthersJumpToStayThere) {
  const ir::LabelId end = b.new_label();
  b.jump_if(value(5), end);
  b.jump_if_not(value(0), end);
  set(1, true);
  b.bind(end);
  EXPECT_EQ(jumps(), 2);
}

TEST_F(IfConversion, LoopsStay) {
  const ir::LabelId head = b.new_label();
  b.bind(head);
  set(1, true);
  b.jump_if(value(0), head);
  EXPECT_EQ(jumps(), 1);
}

TEST_F(IfConversion, AnEmptyBranchStays) {
  const ir::LabelId end = b.new_label();
  b.jump_if(value(0), end);
  b.bind(end);
  EXPECT_EQ(jumps(), 1);
}

TEST_F(IfConversion, LongBranchesStay) {
  const ir::LabelId end = b.new_label();
  b.jump_if_not(value(0), end);
  for (int i = 0; i < 9; ++i) set(1, true);  // two instructions each
  b.bind(end);
  EXPECT_EQ(jumps(), 1);
}

}  // namespace
}  // namespace plc
