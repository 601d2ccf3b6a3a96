#include <algorithm>
#include <bit>

#include "tests/unit/frontend-st/fixture.h"

namespace plc::st::test {
namespace {

using core::Code;
using core::TypeId;
using ir::Role;
using ir::TypeKind;

const ir::Variable& var(const ir::Module& module, std::string_view pou_name, std::string_view name) {
  static const ir::Variable none;
  const auto it = module.pou_by_name.find(pou_name);
  const ir::Variable* v = it == module.pou_by_name.end() ? nullptr : module.pous[it->second].find(name);
  EXPECT_NE(v, nullptr) << name;
  return v == nullptr ? none : *v;
}
std::string items(const ir::Variable& v) {
  std::string out;
  for (const ir::InitItem& item : v.initial) {
    for (std::uint32_t step : item.path) out += std::to_string(step) + ".";
    out += "=" + (item.value.text.empty() ? std::to_string(item.value.bits) : item.value.text) + " ";
  }
  return out;
}

TEST(DeclareTypes, TextsInBracketsOfStringsByAnotherName) {
  World w;
  w.project.data_types = {data_type("Name", string_of("20"))};
  plcopen::InitialValue typed = list({simple("pump")});
  typed.text = "[pump]";
  w.program("P", {variable("n", named("Name"), Section::kLocal, typed),
                  variable("a", array_of(named("Name"), {{"0", "0"}}), Section::kLocal, list({simple("'x'")}))});
  ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(items(var(m, "P", "n")), "=[pump] ");
  EXPECT_EQ(items(var(m, "P", "a")), "0.=x ");
}

TEST(DeclareTypes, AnyOrderAndNested) {
  World w;
  w.project.data_types = {
      data_type("Outer", structure({variable("inner", named("Inner"), Section::kLocal), variable("c", named("Color")),
                                    variable("m", array_of(named("INT"), {{"1", "2"}, {"0", "N - 1"}}))})),
      data_type("Inner", structure({variable("v", named("Percent"), Section::kLocal),
                                    variable("k", named("INT"), Section::kLocal, simple("7"))})),
      data_type("Color", enumeration({{"Red", ""}, {"Green", "Red + 4"}, {"Blue", ""}}), simple("Green")),
      data_type("Percent", subrange("INT", "0", "100"), simple("50")),
      data_type("Speed", named("REAL"), simple("2.5"))};
  plcopen::Variable n = variable("N", named("INT"), Section::kGlobal, simple("3"));
  n.constant = true;
  w.configuration().globals = {n};
  w.program("P", {variable("o", named("outer")), variable("s", named("Speed")),
                  variable("os", array_of(named("Inner"), {{"0", "1"}})),
                  variable("k", structure({variable("z", named("BOOL"))}))});
  ir::Module& m = w.declare_cleanly();
  const auto outer = m.types.find("Outer");
  ASSERT_TRUE(outer);
  EXPECT_EQ(m.types[*outer].fields.size(), 3u);
  EXPECT_EQ(m.types.name_of(m.types[*outer].fields[2].type), "ARRAY [1..2, 0..2] OF INT");
  const auto color = m.types.find("color");
  ASSERT_TRUE(color);
  EXPECT_EQ(m.types[*color].members[1].value, 4);
  EXPECT_EQ(m.types[*color].members[2].value, 5);
  EXPECT_EQ(m.types[*color].initial, 4);
  EXPECT_EQ(m.types[*m.types.find("Percent")].initial, 50);
  EXPECT_EQ(items(var(m, "P", "o")), "0.1.=7 ") << "defaults of members reach the variable";
  EXPECT_EQ(items(var(m, "P", "s")), "=" + std::to_string(std::bit_cast<std::uint32_t>(2.5f)) + " ");
  EXPECT_EQ(items(var(m, "P", "os")), "0.1.=7 1.1.=7 ");
}

TEST(DeclareTypes, RecursionIsRefusedWithItsPath) {
  World w;
  w.project.data_types = {
      data_type("A", structure({variable("b", named("B"))})),
      data_type("B", structure({variable("a", array_of(named("A"), {{"0", "1"}}))})),
      data_type("Node", structure({variable("next", pointer_to(named("Node"))), variable("v", named("INT"))}))};
  w.declare_all();
  ASSERT_EQ(w.count(Code::P4016), 1u) << w.rendered();
  EXPECT_NE(w.first(Code::P4016)->message.find("A > B > A"), std::string::npos) << w.first(Code::P4016)->message;
  EXPECT_EQ(w.diagnostics.error_count(), 1u) << w.rendered();
}

TEST(DeclareTypes, WrongDeclarations) {
  World w;
  w.project.data_types = {data_type("E1", enumeration({{"X", ""}, {"x", ""}})),   // twice
                          data_type("E2", enumeration({})),                       // empty
                          data_type("S1", subrange("INT", "10", "5")),            // inverted
                          data_type("S2", subrange("SINT", "0", "1000")),         // too wide
                          data_type("R1", subrange("REAL", "0", "1")),            // not an integer
                          data_type("A1", array_of(named("INT"), {{"5", "1"}})),  // inverted
                          data_type("A2", array_of(named("INT"), {{"0", "999999999999"}})),
                          data_type("T1", string_of("0")),
                          data_type("T2", string_of("abc")),
                          data_type("S1", named("INT")),
                          data_type("INT", named("REAL"))};
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4018), 3u) << w.rendered();
  EXPECT_EQ(w.count(Code::P4017), 7u) << w.rendered();
  EXPECT_EQ(w.count(Code::P4034), 1u) << w.rendered();
}

TEST(DeclareTypes, UnknownTypesNameEverything) {
  World w;
  w.program("P", {variable("log", named("LOGGER")), variable("t", named("TONN"))});
  w.declare_all();
  ASSERT_EQ(w.count(Code::P4014), 2u);
  const core::Diagnostic* d = w.first(Code::P4014);
  EXPECT_EQ(d->pou, "P");
  EXPECT_NE(d->message.find("LOGGER"), std::string::npos);
  EXPECT_NE(d->message.find("\"log\""), std::string::npos);
  EXPECT_NE(d->help.find("Beremiz"), std::string::npos);
  EXPECT_NE(w.diagnostics.all()[1].help.find("TON"), std::string::npos);
}

TEST(DeclareTypes, StubsForMissingTypes) {
  World w;
  w.options.stub_missing = true;
  w.program("P", {variable("log", named("LOGGER")), variable("x", named("BOOL"))});
  ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(w.count(Code::P4031), 1u);
  EXPECT_TRUE(m.types[var(m, "P", "log").type].stub);
  ir::Builder b(m, 0, w.diagnostics);
  EXPECT_TRUE(lower_expression("log.Q AND x", at_line(1), b, ir::kBoolType));
  EXPECT_TRUE(lower_expression("log.Q", at_line(2), b, ir::kBoolType));
  EXPECT_TRUE(lower_statements("log(IN := x); log.Q := TRUE;", at_line(3), b));
  EXPECT_EQ(w.count(Code::P4015), 1u) << w.rendered();
  EXPECT_EQ(w.diagnostics.error_count(), 0u) << w.rendered();
}

TEST(DeclareTypes, StubsThatGiveReferencesAreNotFollowed) {
  World w;
  plcopen::Pou old = pou("Old", plcopen::PouKind::kFunction, {});
  old.return_type.kind = TypeSpec::Kind::kReferenceTo;
  old.return_type.base = std::make_shared<TypeSpec>(named("INT"));
  w.project.pous = {old};
  w.program("P", {variable("a", named("INT"))});
  ir::Module& m = w.declare_cleanly();
  m.pous[0].stub = true;
  ir::Builder b(m, 1, w.diagnostics);
  EXPECT_TRUE(lower_statements("a := Old() + 1;", at_line(1), b)) << w.rendered();
  EXPECT_EQ(w.count(Code::P4015), 1u) << w.rendered();
  const auto& places = m.pous[1].body.places;
  EXPECT_TRUE(std::none_of(places.begin(), places.end(),
                           [](const ir::Place& place) { return place.kind == ir::Place::Kind::kDeref; }));
}

TEST(DeclareInitialValues, OperatorsThatComputeNoConstant) {
  World w;
  w.program("P", {variable("c", named("BOOL"), Section::kLocal, simple("TRUE AND_THEN FALSE"))});
  w.declare_all();
  EXPECT_EQ(w.diagnostics.error_count(), 1u) << w.rendered();
  EXPECT_NE(w.rendered().find("operator does not take these values"), std::string::npos) << w.rendered();
}

TEST(DeclareInitialValues, EveryForm) {
  World w;
  w.project.data_types = {data_type("P", structure({variable("x", named("INT")), variable("y", named("INT"))})),
                          data_type("Mode", enumeration({{"Idle", ""}, {"Run", "8"}}))};
  const auto init = [](std::string name, std::string type, std::string text) {
    return variable(std::move(name), named(std::move(type)), Section::kLocal, simple(std::move(text)));
  };
  w.program("Q", {init("a", "INT", "-5"),
                  init("b", "TIME", " T#2s"),
                  init("c", "BOOL", "False"),
                  init("d", "BOOL", "1"),
                  init("e", "WORD", "16#FF"),
                  init("f", "REAL", "3"),
                  init("g", "LREAL", "-1.0E-3"),
                  init("h", "Mode", "Mode#Run"),
                  init("i", "Mode", "Run"),
                  init("j", "DINT", "INT#7"),
                  init("k", "INT", "2 * (3 + 4)"),
                  init("l", "TIME", "0"),
                  init("m", "ULINT", "18446744073709551615"),
                  init("n", "UDINT", ""),
                  variable("s", string_of("5"), Section::kLocal, simple("'abc'")),
                  variable("arr", array_of(named("INT"), {{"1", "6"}}), Section::kLocal,
                           list({simple("1"), repeated("3", simple("2")), simple("9")})),
                  variable("flat", array_of(named("INT"), {{"0", "1"}, {"0", "1"}}), Section::kLocal,
                           list({simple("1"), simple("2"), simple("3")})),
                  variable("deep", array_of(named("INT"), {{"0", "1"}, {"0", "1"}}), Section::kLocal,
                           list({list({simple("1"), simple("2")}), repeated("1", list({repeated("2", simple("4"))}))})),
                  variable("p", named("P"), Section::kLocal, members({{"y", simple("3")}})),
                  variable("ps", array_of(named("P"), {{"0", "2"}}), Section::kLocal,
                           list({repeated("2", members({{"x", simple("1")}, {"y", simple("2")}}))}))});
  ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(items(var(m, "Q", "a")), "=65531 ");
  EXPECT_EQ(items(var(m, "Q", "b")), "=2000000000 ");
  EXPECT_EQ(items(var(m, "Q", "c")), "=0 ");
  EXPECT_EQ(items(var(m, "Q", "d")), "=1 ");
  EXPECT_EQ(items(var(m, "Q", "e")), "=255 ");
  EXPECT_EQ(items(var(m, "Q", "f")), "=" + std::to_string(std::bit_cast<std::uint32_t>(3.0f)) + " ");
  EXPECT_EQ(items(var(m, "Q", "g")), "=" + std::to_string(std::bit_cast<std::uint64_t>(-1.0e-3)) + " ");
  EXPECT_EQ(items(var(m, "Q", "h")), "=8 ");
  EXPECT_EQ(items(var(m, "Q", "i")), "=8 ");
  EXPECT_EQ(items(var(m, "Q", "j")), "=7 ");
  EXPECT_EQ(items(var(m, "Q", "k")), "=14 ");
  EXPECT_EQ(items(var(m, "Q", "l")), "=0 ");
  EXPECT_EQ(items(var(m, "Q", "m")), "=18446744073709551615 ");
  EXPECT_EQ(items(var(m, "Q", "n")), "");
  EXPECT_EQ(items(var(m, "Q", "s")), "=abc ");
  EXPECT_EQ(items(var(m, "Q", "arr")), "0.=1 1.=2 2.=2 3.=2 4.=9 ");
  EXPECT_EQ(items(var(m, "Q", "flat")), "0.0.=1 0.1.=2 1.0.=3 ");
  EXPECT_EQ(items(var(m, "Q", "deep")), "0.0.=1 0.1.=2 1.0.=4 1.1.=4 ");
  EXPECT_EQ(items(var(m, "Q", "p")), "1.=3 ");
  EXPECT_EQ(items(var(m, "Q", "ps")), "0.0.=1 0.1.=2 1.0.=1 1.1.=2 ");
}

TEST(DeclareInitialValues, Constants) {
  World w;
  const auto constant = [](std::string name, std::string text, Section section) {
    plcopen::Variable v = variable(std::move(name), named("INT"), section, simple(std::move(text)));
    v.constant = true;
    return v;
  };
  w.configuration().globals = {constant("N", "M + 1", Section::kGlobal), constant("M", "4", Section::kGlobal),
                               constant("Loop", "Loop + 1", Section::kGlobal)};
  w.program("P",
            {constant("K", "N * 2", Section::kLocal), variable("a", named("INT"), Section::kLocal, simple("K + N"))});
  ir::Module& m = w.declare_all();
  EXPECT_EQ(items(var(m, "P", "a")), "=15 ");
  EXPECT_EQ(w.count(Code::P4034), 1u) << w.rendered();
}

TEST(DeclareInitialValues, Errors) {
  World w;
  w.project.data_types = {data_type("P", structure({variable("x", named("INT"))})),
                          data_type("R", subrange("INT", "1", "5"))};
  const auto init = [](std::string name, TypeSpec type, InitialValue value) {
    return variable(std::move(name), std::move(type), Section::kLocal, std::move(value));
  };
  w.program("Q", {init("a", named("SINT"), simple("200")), init("b", named("BOOL"), simple("2")),
                  init("c", named("TIME"), simple("5")), init("d", named("INT"), simple("1.5")),
                  init("e", string_of("2"), simple("'abc'")), init("f", named("R"), simple("9")),
                  init("g", array_of(named("INT"), {{"0", "1"}}), list({simple("1"), simple("2"), simple("3")})),
                  init("h", named("P"), members({{"q", simple("1")}})), init("i", named("INT"), list({simple("1")})),
                  init("j", named("P"), simple("5")),
                  init("k", array_of(named("INT"), {{"0", "9"}}), list({repeated("5", simple("99999"))}))});
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4020), 11u) << w.rendered();
  EXPECT_EQ(w.diagnostics.error_count(), 11u) << w.rendered();
}

TEST(DeclarePous, RolesAndFrames) {
  World w;
  w.project.pous.push_back(pou("F", plcopen::PouKind::kFunction,
                               {variable("in", named("INT"), Section::kInput), variable("l", named("INT"))}));
  w.project.pous.back().return_type = named("REAL");
  w.project.pous.push_back(
      pou("B", plcopen::PouKind::kFunctionBlock,
          {variable("io", named("INT"), Section::kInOut), variable("t", named("INT"), Section::kTemp),
           variable("o", named("INT"), Section::kOutput)}));
  w.program("P", {variable("b", named("B"))});
  ir::Module& m = w.declare_cleanly();
  ASSERT_EQ(m.pous.size(), 3u);
  EXPECT_EQ(var(m, "F", "F").role, Role::kReturnValue);
  EXPECT_EQ(m.pous[0].return_type, ir::ref_of(TypeId::kReal));
  EXPECT_TRUE(var(m, "F", "l").in_frame);
  EXPECT_TRUE(var(m, "B", "t").in_frame);
  EXPECT_FALSE(var(m, "B", "o").in_frame);
  EXPECT_EQ(m.types[var(m, "B", "io").type].kind, TypeKind::kReference);
  EXPECT_EQ(m.types[var(m, "P", "b").type].kind, TypeKind::kPou);
  EXPECT_EQ(m.pous[1].instance_type, var(m, "P", "b").type);
}

TEST(DeclarePous, NamesThatCollide) {
  World w;
  w.project.pous.push_back(pou("MAX", plcopen::PouKind::kFunction, {}));
  w.project.pous.push_back(
      pou("TON", plcopen::PouKind::kFunctionBlock, {variable("IN", named("BOOL"), Section::kInput)}));
  w.program("P", {variable("x", named("INT")), variable("X", named("BOOL")), variable("t", named("ton"))});
  w.program("p", {});
  ir::Module& m = w.declare_all();
  EXPECT_EQ(w.count(Code::P4019), 2u);
  EXPECT_EQ(w.count(Code::P4018), 2u) << w.rendered();
  EXPECT_EQ(m.pous.size(), 4u) << "one entry for each POU of the project";
  EXPECT_EQ(m.types[var(m, "P", "t").type].kind, TypeKind::kPou) << "the project's own TON wins";
}

TEST(DeclarePous, Externals) {
  World w;
  plcopen::Variable listed = variable("speed", named("INT"), Section::kGlobal);
  listed.prefix = "GVL";
  w.configuration().globals = {variable("G", named("INT"), Section::kGlobal)};
  w.resource().globals = {listed};
  w.program("P", {variable("g", named("INT"), Section::kExternal), variable("speed", named("INT"), Section::kExternal),
                  variable("missing", named("INT"), Section::kExternal)});
  w.program("Q", {variable("G", named("BOOL"), Section::kExternal)});
  ir::Module& m = w.declare_all();
  EXPECT_EQ(var(m, "P", "g").role, Role::kExternal);
  EXPECT_EQ(m.globals[var(m, "P", "g").global].variable.name, "G");
  EXPECT_EQ(m.global_by_name.at("GVL.speed"), var(m, "P", "speed").global);
  EXPECT_EQ(w.count(Code::P4021), 1u);
  EXPECT_NE(w.first(Code::P4021)->message.find("missing"), std::string::npos);
  EXPECT_EQ(w.count(Code::P4022), 1u);
  EXPECT_EQ(w.diagnostics.error_count(), 2u) << w.rendered();
}

TEST(DeclarePous, AnExternalOfARefusedGlobalIsNoErrorOfItsOwn) {
  World w;
  w.configuration().globals = {variable("G", named("NOBODY_KNOWS"), Section::kGlobal)};
  w.program("P", {variable("G", named("INT"), Section::kExternal)});
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4014), 1u);
  EXPECT_EQ(w.diagnostics.error_count(), 1u) << w.rendered();
}

TEST(DeclarePous, OneNameInTwoListsNeedsItsList) {
  World w;
  plcopen::Variable a = variable("x", named("INT"), Section::kGlobal);
  a.list = "A";
  plcopen::Variable b = a;
  b.list = "B";
  w.configuration().globals = {a, b};
  w.program("P", {});
  ir::Module& m = w.declare_cleanly();
  ir::Builder builder(m, 0, w.diagnostics);
  EXPECT_TRUE(lower_expression("A.x + B.x", at_line(1), builder));
  EXPECT_FALSE(lower_expression("x", at_line(1), builder));
  EXPECT_EQ(w.count(Code::P4011), 1u);
}

TEST(DeclarePous, AListThatMustBeNamedTakesNoNames) {
  World w;
  plcopen::Variable a = variable("x", named("INT"), Section::kGlobal);
  a.list = "A";
  plcopen::Variable b = variable("x", named("BOOL"), Section::kGlobal);
  b.prefix = "B";
  plcopen::Variable y = variable("y", named("INT"), Section::kGlobal);
  y.list = "A";
  w.configuration().globals = {a, b, y};
  w.program("P", {});
  ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(m.global_by_name.at("x"), m.global_by_name.at("B.x"));
  EXPECT_NE(m.global_by_name.at("x"), m.global_by_name.at("A.x"));
  ir::Builder builder(m, 0, w.diagnostics);
  EXPECT_FALSE(lower_expression("y", at_line(1), builder));
  ASSERT_EQ(w.count(Code::P4011), 1u);
  EXPECT_NE(w.first(Code::P4011)->message.find("in the list A"), std::string::npos);
}

TEST(DeclarePous, StepsOfAChartHidePrograms) {
  const std::string chart = "INITIAL_STEP Idle: END_STEP STEP Filling: END_STEP TRANSITION FROM Idle TO Filling := ";
  for (const auto& [condition, programs] :
       {std::pair("Filling.X OR Filling.T > T#1s;", 0u), std::pair("Filling.n > 3;", 1u)}) {
    SCOPED_TRACE(condition);
    World w;
    w.program("Filling", {variable("n", named("INT"))});
    w.program("Main", {});
    plcopen::Body body;
    body.language = plcopen::Language::kSfc;
    body.text = chart + condition + " END_TRANSITION";
    w.project.pous.back().bodies.push_back(std::move(body));
    EXPECT_EQ(w.declare_cleanly().globals.size(), programs);
  }
}

TEST(DeclarePous, TwoListsHaveNamesForOneAddress) {
  World w;
  plcopen::Variable a = variable("a", named("INT"), Section::kGlobal);
  a.prefix = "A";
  a.address = "%MW0";
  plcopen::Variable b = variable("b", named("INT"), Section::kGlobal);
  b.prefix = "B";
  b.address = "%MW0";
  w.configuration().globals = {a, b};
  w.program("P", {});
  ir::Module& m = w.declare_cleanly();
  for (const char* const name : {"a", "A.a", "b", "B.b"}) EXPECT_EQ(m.global_by_name.at(name), 0u) << name;
  EXPECT_EQ(m.global_aliases.size(), 2u) << "b and B.b from outside";
}

TEST(DeclarePous, ExternalsOfAListThatMustBeNamed) {
  for (const bool stubs : {false, true}) {
    SCOPED_TRACE(stubs);
    World w;
    w.options.stub_missing = stubs;
    plcopen::Variable speed = variable("speed", named("INT"), Section::kGlobal);
    speed.list = "GVL";
    plcopen::Variable with_list = variable("speed", named("INT"), Section::kExternal);
    with_list.list = "GVL";
    w.configuration().globals = {speed};
    w.program("Good", {with_list});
    w.program("Bad", {variable("speed", named("INT"), Section::kExternal)});
    const ir::Module& m = w.declare_all();
    EXPECT_EQ(w.diagnostics.error_count(), 1u) << w.rendered();
    ASSERT_EQ(w.count(Code::P4021), 1u);
    EXPECT_NE(w.first(Code::P4021)->help.find("GVL.speed"), std::string::npos);
    EXPECT_EQ(m.globals.size(), 1u) << "none is made";
  }
}

TEST(DeclarePous, ConstantsOfListsThatMustBeNamedHaveNoBareNames) {
  World w;
  plcopen::Variable a = variable("n", named("INT"), Section::kGlobal);
  a.list = "A";
  a.constant = true;
  a.initial = simple("5");
  plcopen::Variable b = variable("n", named("INT"), Section::kGlobal);
  b.prefix = "B";
  b.constant = true;
  b.initial = simple("7");
  plcopen::Variable c = variable("c", named("INT"), Section::kGlobal);
  c.initial = simple("n");
  w.configuration().globals = {a, b, c};
  w.program("P", {});
  const ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(m.globals[m.global_by_name.at("c")].variable.initial.at(0).value.bits, 7u);
}

TEST(DeclarePous, LocatedVariablesShareOnePlace) {
  World w;
  w.program("P", {located("start", named("BOOL"), "%I0.0"), located("lamp", named("BOOL"), "%QX0.0"),
                  located("any", named("INT"), "%I*"), located("deep", named("INT"), "%IW0.0.1.0")});
  w.program("Q", {located("go", named("BOOL"), "%IX0.0")});
  ir::Module& m = w.declare_cleanly();
  EXPECT_EQ(var(m, "P", "start").role, Role::kExternal);
  EXPECT_EQ(var(m, "P", "start").global, var(m, "Q", "go").global);
  EXPECT_EQ(m.globals[var(m, "P", "start").global].variable.name, "%IX0.0");
  EXPECT_EQ(m.globals[var(m, "P", "start").global].variable.address, "%IX0.0");
  EXPECT_EQ(m.globals[var(m, "P", "lamp").global].variable.name, "P.lamp");
  EXPECT_EQ(var(m, "P", "any").role, Role::kLocal);  // one for each instance
  EXPECT_EQ(var(m, "P", "any").address, "%I*");
  EXPECT_EQ(m.globals[var(m, "P", "deep").global].variable.address, "%IW0.0.1.0");
  ir::Builder b(m, 1, w.diagnostics);
  const auto direct = lower_place("%QX0.0", at_line(1), b, true);
  ASSERT_TRUE(direct);
  EXPECT_EQ(b.body().places[direct->index].index, var(m, "P", "lamp").global);
}

TEST(DeclarePous, WrongAddresses) {
  World w;
  w.program("P", {located("a", named("INT"), "%IX0.0"), located("b", named("BOOL"), "%QW0"),
                  located("c", named("INT"), "%Z0"), located("d", named("WORD"), "%QW5"),
                  located("e", named("INT"), "%QW5")});
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4024), 2u);
  EXPECT_EQ(w.count(Code::P4023), 1u);
  EXPECT_EQ(w.count(Code::P4032), 1u);
}

TEST(DeclarePous, InstancesNeedMemory) {
  World w;
  w.project.pous.push_back(pou("F", plcopen::PouKind::kFunction,
                               {variable("t", named("TON")), variable("u", named("TON"), Section::kInOut)}));
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4033), 1u);
  EXPECT_EQ(w.diagnostics.error_count(), 1u) << w.rendered();
}

// ---- tasks ----

plcopen::Task task(std::string name, std::string interval,
                   std::vector<std::pair<std::string, std::string>> instances = {}) {
  plcopen::Task t;
  t.name = std::move(name);
  t.interval = std::move(interval);
  for (auto& [instance, type] : instances) t.instances.push_back({instance, type, {}});
  return t;
}

TEST(DeclareConfiguration, TasksAndInstances) {
  World w;
  w.configuration().globals = {variable("Go", named("BOOL"), Section::kGlobal)};
  w.program("Main", {}).program("Slow", {});
  w.resource().tasks = {task("fast", "T#10ms", {{"m1", "main"}, {"Main", ""}}), task("event", "")};
  w.resource().tasks[0].priority = "3";
  w.resource().tasks[1].single = "go";
  w.resource().tasks[1].instances.push_back({"s", "Slow", {}});
  ir::Module& m = w.declare_cleanly();
  ASSERT_EQ(m.tasks.size(), 2u);
  EXPECT_EQ(m.tasks[0].period_ns, 10'000'000);
  EXPECT_EQ(m.tasks[0].priority, 3);
  ASSERT_EQ(m.tasks[0].programs.size(), 2u);
  EXPECT_EQ(m.tasks[0].programs[1].name, "Main");
  EXPECT_EQ(m.tasks[0].programs[1].pou, 0u);
  EXPECT_EQ(m.tasks[1].period_ns, 0);
  EXPECT_EQ(m.tasks[1].single, "go");
  EXPECT_EQ(w.diagnostics.all().size(), 0u) << w.rendered();
}

TEST(DeclareConfiguration, InstancesBesideTasks) {
  World w;
  w.program("Main", {});
  w.resource().tasks = {task("only", "T#10ms")};
  w.resource().instances = {{"m", "Main", {}}};
  EXPECT_EQ(w.declare_cleanly().tasks[0].programs.size(), 1u);
  EXPECT_EQ(w.diagnostics.warning_count(), 0u);
  World two;
  two.program("Main", {});
  two.resource().tasks = {task("a", "T#10ms"), task("b", "T#10ms")};
  two.resource().instances = {{"m", "Main", {}}};
  EXPECT_EQ(two.declare_cleanly().tasks[0].programs.size(), 1u);
  EXPECT_EQ(two.count(Code::P4030), 1u);
}

TEST(DeclareConfiguration, UnknownProgramNamesTheOthers) {
  World w;
  w.program("PLC_PRG", {});
  w.project.pous.push_back(pou("Helper", plcopen::PouKind::kFunctionBlock, {}));
  w.resource().tasks = {task("t", "T#10ms", {{"MAIN", ""}, {"h", "Helper"}})};
  w.declare_all();
  ASSERT_EQ(w.count(Code::P4027), 2u);
  EXPECT_NE(w.first(Code::P4027)->help.find("PLC_PRG"), std::string::npos);
  EXPECT_NE(w.first(Code::P4027)->help.find("--pou NAME"), std::string::npos);
  EXPECT_EQ(w.count(Code::P4028), 0u);
}

TEST(DeclareConfiguration, LibrariesOnlyWarn) {
  World w;
  w.project.pous.push_back(pou("Helper", plcopen::PouKind::kFunctionBlock, {}));
  w.declare_cleanly();
  ASSERT_EQ(w.count(Code::P4028), 1u);
  EXPECT_NE(w.first(Code::P4028)->help.find("Helper"), std::string::npos);
}

TEST(DeclareConfiguration, OnePouAlone) {
  World w;
  w.options.pou = "helper";
  w.project.pous.push_back(
      pou("Helper", plcopen::PouKind::kFunctionBlock, {variable("in", named("BOOL"), Section::kInput)}));
  w.program("Main", {});
  w.resource().tasks = {task("t", "T#10ms", {{"m", "Main"}})};
  ir::Module& m = w.declare_cleanly();
  ASSERT_EQ(m.tasks.size(), 1u);
  EXPECT_EQ(m.tasks[0].name, "main");
  EXPECT_EQ(m.tasks[0].period_ns, 20'000'000);
  ASSERT_EQ(m.tasks[0].programs.size(), 1u);
  EXPECT_EQ(m.tasks[0].programs[0].name, "Helper");
  EXPECT_EQ(m.tasks[0].programs[0].pou, 0u);
  World wrong;
  wrong.options.pou = "Mian";
  wrong.program("Main", {});
  wrong.declare_all();
  ASSERT_EQ(wrong.count(Code::P4029), 1u);
  EXPECT_NE(wrong.first(Code::P4029)->help.find("Main"), std::string::npos);
}

TEST(DeclareConfiguration, WrongTasks) {
  World w;
  w.program("Main", {});
  w.resource().tasks = {task("a", "soon", {{"m", "Main"}}), task("b", "T#10ms"), task("c", "T#10ms")};
  w.resource().tasks[1].priority = "high";
  w.resource().tasks[2].single = "nobody";
  w.declare_all();
  EXPECT_EQ(w.count(Code::P4025), 1u);
  EXPECT_EQ(w.count(Code::P4026), 2u) << w.rendered();
}

}  // namespace
}  // namespace plc::st::test
