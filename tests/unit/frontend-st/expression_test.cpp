#include <bit>

#include "tests/unit/frontend-st/fixture.h"

namespace plc::st::test {
namespace {

using core::Code;
using ir::Operand;

/// Variables of every kind that expressions use.
struct ExpressionTest : ::testing::Test {
  World world;

  void SetUp() override {
    world.project.data_types = {
        data_type("Color", enumeration({{"Red", ""}, {"Green", "5"}, {"Blue", ""}})),
        data_type("Light", enumeration({{"Off", ""}, {"Red", ""}})),
        data_type("Point", structure({variable("x", named("INT")), variable("y", named("INT"))}))};
    plcopen::Variable in_list = variable("speed", named("INT"), Section::kGlobal);
    in_list.prefix = "GVL";
    world.configuration().globals = {in_list, variable("Running", named("BOOL"), Section::kGlobal)};
    plcopen::Variable limit = variable("Limit", named("INT"), Section::kLocal, simple("10"));
    limit.constant = true;
    world.project.pous.push_back(
        pou("Twice", plcopen::PouKind::kFunction, {variable("IN", named("INT"), Section::kInput)}));
    world.project.pous.back().return_type = named("INT");
    world.program("Main", {variable("A", named("BOOL")),
                           variable("B", named("BOOL")),
                           variable("C", named("BOOL")),
                           variable("i", named("INT")),
                           variable("j", named("INT")),
                           variable("d", named("DINT")),
                           variable("r", named("REAL")),
                           variable("w", named("WORD")),
                           variable("t", named("TIME")),
                           variable("state", named("Color")),
                           variable("p", named("Point")),
                           variable("arr", array_of(named("INT"), {{"1", "3"}})),
                           variable("grid", array_of(named("INT"), {{"0", "1"}, {"5", "6"}})),
                           variable("points", array_of(named("Point"), {{"0", "3"}})),
                           variable("TON1", named("TON")),
                           limit,
                           variable("In", named("INT"), Section::kInput),
                           variable("io", named("INT"), Section::kInOut),
                           variable("s", string_of("10")),
                           variable("Start_Button", named("BOOL"))});
    world.declare_cleanly();
  }
  ir::Builder builder() { return {*world.module, 1, world.diagnostics}; }

  std::optional<Operand> lower(ir::Builder& b, std::string_view text,
                               std::optional<ir::TypeRef> expected = std::nullopt) {
    return lower_expression(text, at_line(7, 20), b, expected);
  }
  /// The value of `text` with the given cells, as the bits of its type.
  std::uint64_t value(std::string_view text, std::map<std::string, std::uint64_t> cells = {}) {
    ir::Builder b = builder();
    b.body() = {};
    b.body().sources.emplace_back();
    ir::Builder fresh = builder();
    const auto operand = lower(fresh, text);
    EXPECT_TRUE(operand) << text << "\n" << world.rendered();
    if (!operand) return 0;
    const auto settled = fresh.settle(*operand);
    EXPECT_TRUE(settled) << text << "\n" << world.rendered();
    if (!settled) return 0;
    Machine machine(*world.module, world.module->pous[1]);
    machine.cells = std::move(cells);
    machine.run();
    EXPECT_EQ(world.diagnostics.error_count(), 0u) << text << "\n" << world.rendered();
    return machine.bits_of(*settled);
  }
  std::int64_t number(std::string_view text, std::map<std::string, std::uint64_t> cells = {}) {
    return static_cast<std::int32_t>(value(text, std::move(cells)));
  }
  /// The one error `text` has.
  core::Diagnostic error(std::string_view text, std::optional<ir::TypeRef> expected = std::nullopt) {
    ir::Builder b = builder();
    const std::size_t before = world.diagnostics.all().size();
    EXPECT_FALSE(lower(b, text, expected)) << text;
    EXPECT_EQ(world.diagnostics.all().size(), before + 1) << text << "\n" << world.rendered();
    return world.diagnostics.all().empty() ? core::Diagnostic{} : world.diagnostics.all().back();
  }
};

TEST_F(ExpressionTest, PlainNameIsOneLoad) {
  ir::Builder b = builder();
  const auto operand = lower(b, " a ");
  ASSERT_TRUE(operand);
  ASSERT_EQ(b.body().insts.size(), 1u);
  EXPECT_EQ(b.body().insts[0].op, ir::Op::kLoad);
  EXPECT_EQ(b.type_of(operand->value), ir::kBoolType);
}

TEST_F(ExpressionTest, Precedence) {
  EXPECT_EQ(number("1 + 2 * 3"), 7);
  EXPECT_EQ(number("(1 + 2) * 3"), 9);
  EXPECT_EQ(number("10 - 4 - 3"), 3);
  EXPECT_EQ(number("100 / 10 / 2"), 5);
  EXPECT_EQ(number("17 MOD 5 * 2"), 4);
  EXPECT_EQ(number("-2 + 5"), 3);
  EXPECT_EQ(number("2 - -3"), 5);
  EXPECT_EQ(value("1 + 2 < 4 AND 2 * 2 = 4"), 1u);
  EXPECT_EQ(value("1 < 2 = TRUE"), 1u) << "relations bind tighter than equality";
}

TEST_F(ExpressionTest, BooleanPrecedenceByTruthTable) {
  for (std::uint64_t row = 0; row < 8; ++row) {
    const bool a = row & 1u, b = row & 2u, c = row & 4u;
    const std::map<std::string, std::uint64_t> cells = {{"A", a}, {"B", b}, {"C", c}};
    EXPECT_EQ(value("A OR B AND C", cells), static_cast<std::uint64_t>(a || (b && c)));
    EXPECT_EQ(value("A XOR B AND C", cells), static_cast<std::uint64_t>(a != (b && c)));
    EXPECT_EQ(value("A OR B XOR C", cells), static_cast<std::uint64_t>(a || (b != c)));
    EXPECT_EQ(value("NOT A & B", cells), static_cast<std::uint64_t>(!a && b));
    EXPECT_EQ(value("NOT (A and b)", cells), static_cast<std::uint64_t>(!(a && b)));
    EXPECT_EQ(value("not A = B", cells), static_cast<std::uint64_t>(!a == b));
  }
}

TEST_F(ExpressionTest, LiteralsStayUntypedUntilTheirPlaceIsKnown) {
  ir::Builder b = builder();
  const auto folded = lower(b, "-(2 * 3) + 1");
  ASSERT_TRUE(folded);
  EXPECT_EQ(folded->kind, Operand::Kind::kIntLiteral);
  EXPECT_EQ(folded->int_value, -5);
  const auto real = lower(b, "-1.0E-3");
  ASSERT_TRUE(real);
  EXPECT_EQ(real->kind, Operand::Kind::kRealLiteral);
  EXPECT_DOUBLE_EQ(real->real_value, -1e-3);
  const auto smallest = lower(b, "-9223372036854775808");
  ASSERT_TRUE(smallest);
  EXPECT_EQ(smallest->int_value, INT64_MIN);
  EXPECT_FALSE(smallest->int_is_unsigned);
}

TEST_F(ExpressionTest, TypedLiterals) {
  EXPECT_EQ(value("T#1h2m3s4.5ms"), 3'723'004'500'000u);
  EXPECT_EQ(static_cast<std::int64_t>(value("-T#5s")), -5'000'000'000);
  EXPECT_EQ(value("16#1234_5678"), 0x12345678u);
  EXPECT_EQ(value("-INT#5"), 0xfffbu);
  EXPECT_EQ(value("REAL#1.5"), std::bit_cast<std::uint32_t>(1.5f));
  EXPECT_EQ(value("BOOL#1"), 1u);
}

TEST_F(ExpressionTest, VariablesAndArithmetic) {
  EXPECT_EQ(number("i + j * 2", {{"i", 5}, {"j", 7}}), 19);
  EXPECT_EQ(value("i > 3 AND i < 10", {{"i", 5}}), 1u);
  EXPECT_EQ(number("d + i", {{"d", 100'000}, {"i", 5}}), 100'005) << "INT widens to DINT";
  EXPECT_EQ(static_cast<std::int16_t>(value("-i", {{"i", 5}})), -5);
  EXPECT_EQ(value("t < T#5s", {{"t", 1}}), 1u);
}

TEST_F(ExpressionTest, MembersAndElements) {
  EXPECT_EQ(value("p.y", {{"p.1", 42}}), 42u);
  EXPECT_EQ(value("arr[1]", {{"arr[0]", 11}}), 11u);
  EXPECT_EQ(value("arr[i + 1]", {{"i", 2}, {"arr[2]", 33}}), 33u);
  EXPECT_EQ(value("grid[1, 5]", {{"grid[1][0]", 7}}), 7u);
  EXPECT_EQ(value("grid[1][6]", {{"grid[1][1]", 8}}), 8u);
  EXPECT_EQ(value("points[3].x", {{"points[3].0", 9}}), 9u);
  EXPECT_EQ(value("points[j].y", {{"j", 2}, {"points[2].1", 4}}), 4u);
  EXPECT_EQ(value("arr[arr[1]]", {{"arr[0]", 3}, {"arr[2]", 6}}), 6u);
}

TEST_F(ExpressionTest, GlobalsNeedNoExternal) {
  EXPECT_EQ(value("GVL.speed", {{"global:speed", 12}}), 12u);
  EXPECT_EQ(value("speed + 0", {{"global:speed", 12}}), 12u);
  EXPECT_EQ(value("running AND A", {{"global:Running", 1}, {"A", 1}}), 1u);
  EXPECT_EQ(world.diagnostics.all().size(), world.count(Code::P4028));
}

TEST_F(ExpressionTest, BitsOfWords) {
  EXPECT_EQ(value("w.3", {{"w", 8}}), 1u);
  EXPECT_EQ(value("w.%X2", {{"w", 8}}), 0u);
  EXPECT_EQ(error("w.16").code, Code::P4008);
  EXPECT_EQ(error("r.3").code, Code::P4005);
}

TEST_F(ExpressionTest, BlockOutputs) {
  ir::Builder b = builder();
  const auto q = lower(b, "TON1.Q AND A");
  ASSERT_TRUE(q) << world.rendered();
  EXPECT_EQ(b.type_of(q->value), ir::kBoolType);
  EXPECT_EQ(error("TON1.QQ").code, Code::P4005);
}

TEST_F(ExpressionTest, EnumerationValues) {
  EXPECT_EQ(value("state = Color#Green", {{"state", 5}}), 1u);
  EXPECT_EQ(value("state = Blue", {{"state", 6}}), 1u);
  EXPECT_EQ(value("Red = state", {{"state", 0}}), 1u) << "the other side decides which Red";
  EXPECT_EQ(value("Color.Blue"), 6u);
  EXPECT_EQ(value("Green"), 5u);
  EXPECT_EQ(error("Red").code, Code::P4011);
  EXPECT_EQ(error("Color#Pink").code, Code::P4005);
  EXPECT_EQ(error("Colour#Red").code, Code::P4004);
}

TEST_F(ExpressionTest, DirectAddressesAreOnePlace) {
  EXPECT_EQ(value("%IX0.0 AND %I0.0", {{"global:%IX0.0", 1}}), 1u);
  ir::Builder b = builder();
  const auto word = lower(b, "%MW3");
  ASSERT_TRUE(word);
  EXPECT_EQ(b.type_of(word->value), ir::ref_of(core::TypeId::kWord));
  EXPECT_EQ(error("%IX0.9").code, Code::P4023);
}

TEST_F(ExpressionTest, StandardFunctions) {
  EXPECT_EQ(number("MAX(i, 3)", {{"i", 2}}), 3);
  EXPECT_EQ(static_cast<std::int16_t>(value("LIMIT(MN := INT#0, MX := INT#10, IN := i)", {{"i", 50}})), 10);
  EXPECT_EQ(value("ABS(-5) = 5"), 1u);
  EXPECT_EQ(error("MAXX(i, 3)").code, Code::P4009);
  EXPECT_NE(world.diagnostics.all().back().help.find("MAX"), std::string::npos);
  EXPECT_EQ(error("LIMIT(MN := 0, MX := 10, INN := i)").code, Code::P4010);
  EXPECT_EQ(error("LIMIT(MN := 0, MN := 10, IN := i)").code, Code::P4010);
}

TEST_F(ExpressionTest, EnBracketsACall) {
  const std::string_view text = "DIV(EN := A, IN1 := i, IN2 := j)";
  EXPECT_EQ(value(text, {{"A", 1}, {"i", 8}, {"j", 2}}), 4u);
  EXPECT_EQ(value(text, {{"A", 0}, {"i", 8}, {"j", 2}}), 0u) << "skipped";
}

TEST_F(ExpressionTest, FunctionPous) {
  ir::Builder b = builder();
  const auto result = lower(b, "Twice(i) + Twice(IN := 5)");
  ASSERT_TRUE(result) << world.rendered();
  std::size_t calls = 0;
  for (const ir::Inst& inst : b.body().insts) calls += inst.op == ir::Op::kCallPou ? 1u : 0u;
  EXPECT_EQ(calls, 2u);
  EXPECT_EQ(error("Twice(XX := 1)").code, Code::P4010);
  EXPECT_EQ(error("Twice(1, 2)").code, Code::P4010);
  EXPECT_EQ(error("Main(1)").code, Code::P4009);
}

TEST_F(ExpressionTest, ErrorsStandWhereTheyAre) {
  const core::Diagnostic unknown = error("A AND Start_Buton");
  EXPECT_EQ(unknown.code, Code::P4004);
  EXPECT_EQ(unknown.at.line, 7u);
  EXPECT_EQ(unknown.at.column, 26u);
  EXPECT_EQ(unknown.pou, "Main");
  EXPECT_EQ(unknown.help, "did you mean \"Start_Button\"?");
  const core::Diagnostic second_line = error("A AND\n  nothing");
  EXPECT_EQ(second_line.at.line, 8u);
  EXPECT_EQ(second_line.at.column, 3u);
  const core::Diagnostic member = error("p.z");
  EXPECT_EQ(member.code, Code::P4005);
  EXPECT_EQ(member.at.column, 22u);
}

TEST_F(ExpressionTest, EveryIndependentErrorIsReported) {
  ir::Builder b = builder();
  EXPECT_FALSE(lower(b, "unknown1 AND unknown2"));
  EXPECT_EQ(world.count(Code::P4004), 2u);
}

TEST_F(ExpressionTest, SyntaxErrors) {
  for (const char* text : {"A AND", "A B", "(A", "A)", "", "   ", "AND A", "A := B", "f(", "arr[", "arr[]", "p.",
                           "A = = B", "@", "(* x", "A;"}) {
    EXPECT_EQ(error(text).code, Code::P4001) << text;
  }
  EXPECT_EQ(error("'abc").code, Code::P4003);
  EXPECT_EQ(error("12ab").code, Code::P4003);
  EXPECT_EQ(error("T#5x").code, Code::P4003);
}

TEST_F(ExpressionTest, IndexErrors) {
  EXPECT_EQ(error("arr[0]").code, Code::P4008);
  EXPECT_EQ(error("arr[4]").code, Code::P4008);
  EXPECT_EQ(error("arr[-1]").code, Code::P4008);
  EXPECT_EQ(error("arr[r]").code, Code::P4008);
  EXPECT_EQ(error("arr[1, 2]").code, Code::P4008);
  EXPECT_EQ(error("i[1]").code, Code::P4008);
  EXPECT_EQ(error("arr[1.5]").code, Code::P4008);
}

TEST_F(ExpressionTest, DeepNestingIsAnErrorNotACrash) {
  const std::string deep = std::string(100'000, '(') + "A" + std::string(100'000, ')');
  EXPECT_EQ(error(deep).code, Code::P4002);
  std::string nots;
  for (int i = 0; i < 100'000; ++i) nots += "NOT ";
  EXPECT_EQ(error(nots + "A").code, Code::P4002);
  std::string indices;
  for (int i = 0; i < 50'000; ++i) indices += "arr[";
  EXPECT_EQ(error(indices).code, Code::P4002);
}

TEST_F(ExpressionTest, LongChainsAreFine) {
  std::string chain = "A";
  for (int i = 0; i < 50'000; ++i) chain += " AND B";
  EXPECT_EQ(value(chain, {{"A", 1}, {"B", 1}}), 1u);
}

TEST_F(ExpressionTest, CommentsAreBlanks) {
  EXPECT_EQ(value("A (* and (* nested *) *) AND // rest\n B", {{"A", 1}, {"B", 1}}), 1u);
}

TEST_F(ExpressionTest, Places) {
  ir::Builder b = builder();
  const auto where = [&](std::string_view text, bool writing) { return lower_place(text, at_line(3, 5), b, writing); };
  EXPECT_TRUE(where("i", true));
  EXPECT_TRUE(where("points[2].x", true));
  EXPECT_TRUE(where("arr[j]", true));
  EXPECT_TRUE(where("%QX0.1", true));
  EXPECT_TRUE(where("io", true)) << "in-outs are written through";
  EXPECT_TRUE(where("TON1.IN", true));
  EXPECT_TRUE(where("Limit", false));
  EXPECT_EQ(world.diagnostics.error_count(), 0u) << world.rendered();
  EXPECT_FALSE(where("Limit", true));
  EXPECT_EQ(world.diagnostics.all().back().code, Code::P4007);
  EXPECT_TRUE(where("In", true)) << "with a warning";
  EXPECT_EQ(world.diagnostics.all().back().code, Code::P4073);
  EXPECT_FALSE(where("TON1.Q", true));
  EXPECT_EQ(world.diagnostics.all().back().code, Code::P4007);
  EXPECT_FALSE(where("A AND B", false));
  EXPECT_EQ(world.diagnostics.all().back().code, Code::P4006);
  EXPECT_FALSE(where("NOT A", true));
  EXPECT_EQ(world.diagnostics.all().back().help,
            "a value goes to a variable, or to an element, a member or a bit of one");
  EXPECT_FALSE(where("5", false));
  EXPECT_EQ(world.diagnostics.all().back().code, Code::P4006);
}

TEST_F(ExpressionTest, InOutIsDereferenced) {
  ir::Builder b = builder();
  const auto where = lower_place("io", at_line(1), b, true);
  ASSERT_TRUE(where);
  EXPECT_EQ(b.body().places[where->index].kind, ir::Place::Kind::kDeref);
  EXPECT_EQ(b.type_of(*where), ir::ref_of(core::TypeId::kInt));
}

TEST(VariableTexts, WhatMayBeWritten) {
  for (const char* text : {"a", " a ", "a.b[1].c", "GVL.x", "%QX0.0", "a[i+1]", "p^", "p^.x"})
    EXPECT_TRUE(is_variable_text(text)) << text;
  for (const char* text : {"", "5", "a + b", "TRUE", "NOT a", "f(x)", "(a)", "T#5s", "a AND", "Color#Red", "'a'"}) {
    EXPECT_FALSE(is_variable_text(text)) << text;
  }
}

}  // namespace
}  // namespace plc::st::test
