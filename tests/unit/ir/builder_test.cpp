// Typed helpers of the builder: what they accept, what they make of it, how they name what they refuse.
#include "ir/builder.h"

#include <gtest/gtest.h>

#include <bit>
#include <string>
#include <vector>

#include "ir/check.h"
#include "tests/support/module_builder.h"

namespace plc {
namespace {

using core::TypeId;
using ir::Op;
using ir::Operand;
using test::literal;
using test::ModuleBuilder;
using test::real_literal;
using test::type;

struct BuilderTest : testing::Test {
  ModuleBuilder m;
  std::uint32_t main = m.pou("Main");
  ir::Builder b = m.body(main);

  ir::PlaceId var(const char* name, ir::TypeRef t, ir::Role role = ir::Role::kLocal) {
    return b.variable(m.variable(main, name, t, role));
  }
  Operand read(const char* name, ir::TypeRef t) { return Operand::of(b.load(var(name, t))); }
  const ir::Constant& constant(ir::ValueId v) {
    EXPECT_EQ(b.body().insts[v.index].op, Op::kConst);
    return b.body().constants[b.body().insts[v.index].a];
  }
  std::string only_message() {
    EXPECT_EQ(m.diagnostics.all().size(), 1u);
    return m.diagnostics.all().empty() ? "" : m.diagnostics.all().back().message;
  }
  std::string only_help() { return m.diagnostics.all().empty() ? "" : m.diagnostics.all().back().help; }
  core::Code only_code() { return m.diagnostics.all().empty() ? core::Code::P9001 : m.diagnostics.all().back().code; }
};

TEST_F(BuilderTest, PlacesAreInterned) {
  const auto a = m.variable(main, "a", m.module.types.array(type(TypeId::kInt), 1, 3));
  EXPECT_EQ(b.element(b.variable(a), 1), b.element(b.variable(a), 1));
  EXPECT_EQ(b.describe(b.element(b.variable(a), 1)), "a[2]");
}

TEST_F(BuilderTest, AnElementMayStandAtAComputedIndex) {
  ir::Type point;
  point.kind = ir::TypeKind::kStruct;
  point.fields = {{"Row", m.module.types.array(type(TypeId::kReal), 0, 9)}};
  m.module.types.declare("Point", point);
  const auto a = var("a", m.module.types.array(*m.module.types.find("Point"), 1, 3));
  const auto i = b.load(var("i", type(TypeId::kUsint)));
  const auto at = b.element_at(a, i);
  EXPECT_EQ(at, b.element_at(a, i));
  const auto j = b.call_overload(stdlib::overloads_named("ABS").front(), std::vector{i}, type(TypeId::kSint));
  const auto leaf = b.element_at(*b.member(at, "row"), j);
  EXPECT_EQ(b.type_of(leaf), type(TypeId::kReal));
  EXPECT_EQ(b.describe(leaf), "a[i].Row[..]");
  EXPECT_FALSE(at == b.element_at(a, j));
}

TEST_F(BuilderTest, PartsOfWordsHaveTheirOwnTypes) {
  const auto w = b.load(var("w", type(TypeId::kWord)));
  const auto bit = b.extract(w, ir::kBoolType, 15);
  EXPECT_EQ(b.type_of(bit), ir::kBoolType);
  const auto byte = b.extract(w, type(TypeId::kByte), 8);
  EXPECT_EQ(b.type_of(byte), type(TypeId::kByte));
  EXPECT_EQ(b.type_of(b.insert(w, byte, 0)), type(TypeId::kWord));
  EXPECT_EQ(b.type_of(b.insert(w, bit, 3)), type(TypeId::kWord));
}

TEST_F(BuilderTest, IntegerLiteralTakesTheTypeOfItsPlace) {
  EXPECT_EQ(constant(*b.convert(literal(1), ir::kBoolType, "x")).bits, 1u);
  EXPECT_EQ(constant(*b.convert(literal(-1), type(TypeId::kInt), "x")).bits, 0xffffu);
  EXPECT_EQ(constant(*b.convert(literal(255), type(TypeId::kByte), "x")).bits, 255u);
  EXPECT_EQ(constant(*b.convert(literal(3), type(TypeId::kReal), "x")).bits, std::bit_cast<std::uint32_t>(3.0f));
  EXPECT_TRUE(m.diagnostics.all().empty());
}

TEST_F(BuilderTest, LiteralsThatDoNotFitAreRefused) {
  EXPECT_FALSE(b.convert(literal(2), ir::kBoolType, "x"));
  EXPECT_FALSE(b.convert(literal(40000), type(TypeId::kInt), "x"));
  EXPECT_FALSE(b.convert(literal(5), type(TypeId::kTime), "x"));
  EXPECT_FALSE(b.convert(real_literal(1.5), type(TypeId::kDint), "x"));
  EXPECT_EQ(m.diagnostics.error_count(), 4u);
  for (const auto& d : m.diagnostics.all()) EXPECT_EQ(d.code, core::Code::P4107);
  EXPECT_EQ(m.diagnostics.all()[2].help, "write a duration: T#5ms");
}

TEST_F(BuilderTest, ValuesWidenAsTheThirdEditionAllows) {
  const auto wide = b.convert(read("i", type(TypeId::kInt)), type(TypeId::kLreal), "x");
  ASSERT_TRUE(wide);
  EXPECT_EQ(b.body().insts[wide->index].op, Op::kCall);
  EXPECT_EQ(b.type_of(*wide), type(TypeId::kLreal));
}

TEST_F(BuilderTest, NarrowingNamesReceiverAndConversion) {
  EXPECT_FALSE(b.convert(read("r", type(TypeId::kReal)), type(TypeId::kInt), "input \"PT\" of X"));
  EXPECT_EQ(only_code(), core::Code::P4101);
  EXPECT_EQ(only_message(), "input \"PT\" of X needs INT, a value is REAL");
  EXPECT_EQ(only_help(), "convert with REAL_TO_INT");
}

TEST_F(BuilderTest, TypedConstantsAreConvertedAtCompileTime) {
  ir::Constant c;
  c.type = type(TypeId::kInt);
  c.bits = 0xfffe;  // INT#-2
  const auto wide = b.convert(Operand::of(b.constant(c)), type(TypeId::kDint), "x");
  EXPECT_EQ(constant(*wide).bits, 0xfffffffeu);
}

TEST_F(BuilderTest, EnumerationsComeOnlyFromThemselves) {
  ir::Type e;
  e.kind = ir::TypeKind::kEnum;
  e.elementary = TypeId::kInt;
  e.members = {{"Red", 0}, {"Green", 1}};
  ASSERT_TRUE(m.module.types.declare("Colour", e));
  const auto colour = *m.module.types.find("COLOUR");
  EXPECT_FALSE(b.convert(literal(1), colour, "x"));
  EXPECT_FALSE(b.convert(read("i", type(TypeId::kInt)), colour, "x"));
  EXPECT_TRUE(b.convert(read("c", colour), colour, "x"));
  EXPECT_TRUE(b.convert(read("d", colour), type(TypeId::kInt), "x"));
  EXPECT_EQ(m.diagnostics.error_count(), 2u);
}

struct SubrangeTest : BuilderTest {
  ir::TypeRef percent;
  SubrangeTest() {
    ir::Type t;
    t.kind = ir::TypeKind::kSubrange;
    t.elementary = TypeId::kInt;
    t.lower = 0;
    t.upper = 100;
    m.module.types.declare("Percent", t);
    percent = *m.module.types.find("percent");
  }
};
TEST_F(SubrangeTest, ConstantsAreChecked) {
  EXPECT_TRUE(b.convert(literal(100), percent, "x"));
  EXPECT_FALSE(b.convert(literal(101), percent, "variable \"X\""));
  EXPECT_EQ(only_code(), core::Code::P4108);
  EXPECT_EQ(only_message(), "variable \"X\" takes 0..100, 101 is outside");
}
TEST_F(SubrangeTest, OtherValuesAreHeldInside) {
  const auto v = b.convert(read("i", type(TypeId::kInt)), percent, "x");
  ASSERT_TRUE(v);
  const ir::Inst& inst = b.body().insts[v->index];
  EXPECT_EQ(inst.op, Op::kRange);
  EXPECT_EQ(inst.type, percent);
}

TEST_F(BuilderTest, BooleanFunctionsBecomeLogic) {
  const std::vector<Operand> args{read("a", ir::kBoolType), read("b", ir::kBoolType), read("c", ir::kBoolType)};
  const auto v = b.call("and", args, {});
  ASSERT_TRUE(v);
  EXPECT_EQ(b.body().insts[v->index].op, Op::kAnd);
  EXPECT_TRUE(b.body().functions.empty());
}

TEST_F(BuilderTest, ConstantArgumentsAreFolded) {
  const std::vector<Operand> args{literal(20), literal(22)};
  EXPECT_EQ(constant(*b.call("ADD", args, {}, type(TypeId::kDint))).bits, 42u);
}

TEST_F(BuilderTest, FoldingLeavesEventsToTheProgram) {
  const std::vector<Operand> args{literal(20), literal(0)};
  const auto v = b.call("DIV", args, {}, type(TypeId::kDint));
  ASSERT_TRUE(v);
  EXPECT_EQ(b.body().insts[v->index].op, Op::kCall);
}

TEST_F(BuilderTest, MixedIntegerWidthsAreWidened) {
  const std::vector<Operand> args{read("i", type(TypeId::kInt)), read("d", type(TypeId::kDint))};
  const auto v = b.call("ADD", args, {});
  ASSERT_TRUE(v);
  EXPECT_EQ(b.type_of(*v), type(TypeId::kDint));
}

TEST_F(BuilderTest, MismatchNamesThePin) {
  const std::vector<Operand> args{read("a", type(TypeId::kDint)), read("b", type(TypeId::kString)),
                                  read("c", type(TypeId::kDint))};
  EXPECT_FALSE(b.call("LIMIT", args, {}));
  EXPECT_EQ(only_code(), core::Code::P4103);
  EXPECT_NE(only_message().find("input \"IN\" of LIMIT has type STRING[80], other inputs are DINT"), std::string::npos)
      << only_message();
}

TEST_F(BuilderTest, UnknownFunctionsAndCountsAreNamed) {
  EXPECT_FALSE(b.call("FROB", {}, {}));
  EXPECT_EQ(m.diagnostics.all().back().code, core::Code::P9001);
  const std::vector<Operand> one{read("a", ir::kBoolType)};
  EXPECT_FALSE(b.call("SEL", one, {}));
  EXPECT_EQ(m.diagnostics.all().back().code, core::Code::P4105);
  EXPECT_EQ(m.diagnostics.all().back().message, "SEL takes 3 inputs (G, IN0, IN1), 1 given");
  const std::vector<Operand> many(256, literal(1));
  EXPECT_FALSE(b.call("ADD", many, {}));
  EXPECT_EQ(m.diagnostics.all().back().message, "ADD takes at most 255 inputs, 256 given");
}

TEST_F(BuilderTest, UnconnectedPinsAreNamed) {
  const std::vector<Operand> args{Operand{}, literal(1)};
  const std::vector<std::string> pins{"In1", "In2"};
  EXPECT_FALSE(b.call("ADD", args, {}, std::nullopt, pins));
  EXPECT_EQ(only_message(), "input \"In1\" of ADD is not connected");
}

TEST_F(BuilderTest, LiteralsAloneSettle) {
  EXPECT_EQ(b.type_of(*b.settle(literal(1))), type(TypeId::kDint));
  EXPECT_EQ(b.type_of(*b.settle(literal(1ll << 40))), type(TypeId::kLint));
  EXPECT_EQ(b.type_of(*b.settle(real_literal(1.5))), type(TypeId::kLreal));
  EXPECT_EQ(b.type_of(*b.settle(real_literal(1.5), type(TypeId::kReal))), type(TypeId::kReal));
}

TEST_F(BuilderTest, InOutsAreReadThroughTheirHandle) {
  const auto place = var("io", type(TypeId::kInt), ir::Role::kInOut);
  EXPECT_EQ(b.type_of(place), type(TypeId::kInt));
  EXPECT_EQ(b.describe(place), "io");
}

TEST_F(BuilderTest, InstancesCannotBeAssigned) {
  const auto fb = m.pou("Fb", ir::PouKind::kFunctionBlock);
  ir::Builder inner = m.body(main);
  const auto t = m.module.pous[fb].instance_type;
  const auto x = inner.variable(m.variable(main, "x", t));
  const auto y = inner.variable(m.variable(main, "y", t));
  EXPECT_FALSE(inner.assign(x, Operand::of(inner.load(y)), "variable \"x\""));
  EXPECT_EQ(only_code(), core::Code::P4109);
}

TEST_F(BuilderTest, MembersAreFoundInAnyCase) {
  const auto* ton = stdlib::block_named("TON");
  ASSERT_NE(ton, nullptr);
  const auto t = b.variable(m.variable(main, "T1", m.module.types.block(*ton)));
  ASSERT_TRUE(b.member(t, "pt"));
  EXPECT_EQ(b.describe(*b.member(t, "q")), "T1.Q");
  EXPECT_FALSE(b.member(t, "nothing"));
}

TEST(TypeTable, FindsEverythingInAnyCase) {
  ir::TypeTable types;
  EXPECT_EQ(types.find("bool"), ir::kBoolType);
  EXPECT_EQ(types.find("tod"), ir::ref_of(TypeId::kTod));
  EXPECT_EQ(types.find("String"), types.string(TypeId::kString, 80));
  ASSERT_TRUE(types.find("ton"));
  EXPECT_EQ(types[*types.find("Ton")].kind, ir::TypeKind::kBlock);
  EXPECT_FALSE(types.find("Unheard"));
  EXPECT_FALSE(types.declare("INT", {}));
  EXPECT_TRUE(types.declare_alias("Speed", ir::ref_of(TypeId::kReal)));
  EXPECT_EQ(types.find("SPEED"), ir::ref_of(TypeId::kReal));
  EXPECT_FALSE(types.declare_alias("speed", ir::kBoolType));
}

TEST(TypeTable, EqualTypesAreOne) {
  ir::TypeTable types;
  EXPECT_EQ(types.array(ir::kBoolType, 0, 3), types.array(ir::kBoolType, 0, 3));
  EXPECT_NE(types.array(ir::kBoolType, 0, 3), types.array(ir::kBoolType, 1, 4));
  EXPECT_EQ(types.name_of(types.array(types.array(ir::kBoolType, 1, 2), 0, 3)), "ARRAY [0..3, 1..2] OF BOOL");
}

}  // namespace
}  // namespace plc
