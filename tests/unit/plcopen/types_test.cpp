// Types, values, variables, interfaces.
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

const Variable& only_variable(const ReadResult& r) { return r.project->pous.at(0).variables.at(0); }

ReadResult variable_of(std::string_view content, std::string_view attributes = "") {
  return read_clean(program("<ST/>", "<localVars><variable name=\"v\" " + std::string(attributes) + ">" +
                                         std::string(content) + "</variable></localVars>"));
}

TEST(Types, ElementaryDerivedAndStrings) {
  EXPECT_EQ(only_variable(variable_of("<type><LTIME/></type>")).type.name, "LTIME");
  const auto derived = variable_of("<type><derived name=\"TON\"/></type>");
  EXPECT_EQ(only_variable(derived).type.kind, TypeSpec::Kind::kNamed);
  EXPECT_EQ(only_variable(derived).type.name, "TON");
  const auto text = variable_of("<type><wstring length=\"20\"/></type>");
  EXPECT_EQ(only_variable(text).type.kind, TypeSpec::Kind::kString);
  EXPECT_EQ(only_variable(text).type.name, "WSTRING");
  EXPECT_EQ(only_variable(text).type.length, "20");
}

TEST(Types, ArrayOfArrayOfStruct) {
  const auto r =
      variable_of(R"(<type><array><dimension lower="0" upper="MAX"/><dimension lower="-1" upper="1"/><baseType><array>
<dimension lower="1" upper="2"/><baseType><struct><variable name="x"><type><pointer><baseType><INT/></baseType></pointer></type></variable>
<variable name="y"><type><REAL/></type></variable></struct></baseType></array></baseType></array></type>)");
  const TypeSpec& outer = only_variable(r).type;
  ASSERT_EQ(outer.kind, TypeSpec::Kind::kArray);
  ASSERT_EQ(outer.dimensions.size(), 2u);
  EXPECT_EQ(outer.dimensions[0].upper, "MAX");
  EXPECT_EQ(outer.dimensions[1].lower, "-1");
  ASSERT_NE(outer.base, nullptr);
  ASSERT_EQ(outer.base->kind, TypeSpec::Kind::kArray);
  const TypeSpec& record = *outer.base->base;
  ASSERT_EQ(record.kind, TypeSpec::Kind::kStruct);
  ASSERT_EQ(record.members.size(), 2u);
  EXPECT_EQ(record.members[0].type.kind, TypeSpec::Kind::kPointer);
  EXPECT_EQ(record.members[0].type.base->name, "INT");
  EXPECT_EQ(record.members[1].name, "y");
}

/// Lists in brackets, members with their names, repetitions before `x`.
std::string shown(const InitialValue& value) {
  std::string text = value.member.empty() ? "" : value.member + "=";
  if (!value.repetition.empty()) text += value.repetition + "x";
  if (value.kind == InitialValue::Kind::kSimple) return text + value.text;
  if (value.kind == InitialValue::Kind::kNone) return text;
  text += value.kind == InitialValue::Kind::kArray ? "[" : "(";
  for (const InitialValue& one : value.values) text += (&one == value.values.data() ? "" : " ") + shown(one);
  return text + (value.kind == InitialValue::Kind::kArray ? "]" : ")");
}

TEST(Types, ListsInOneSimpleValueAreLists) {
  const auto value = [](const std::string& text, const std::string& type = "<derived name=\"T\"/>") {
    return shown(only_variable(variable_of("<type>" + type + "</type><initialValue><simpleValue value=\"" + text +
                                           "\"/></initialValue>"))
                     .initial);
  };
  EXPECT_EQ(value("[1, 2(4) ,-3]"), "[1 2x4 -3]");
  EXPECT_EQ(value("[[1,2],N([3])]"), "[[1 2] Nx[3]]");
  EXPECT_EQ(value("[]"), "[]");
  EXPECT_EQ(value("[2(), (1 + 2) * 3]"), "[2x (1 + 2) * 3]");
  EXPECT_EQ(value("(x := 1, s := '],$'', y := [(z:=2)])"), "(x=1 s='],$'' y=[(z=2)])");
  // No lists, or broken ones: what was typed is kept.
  EXPECT_EQ(value("(1 + 2)"), "(1 + 2)");
  EXPECT_EQ(value("(1) + (2)"), "(1) + (2)");
  EXPECT_EQ(value("[1, 2"), "[1, 2");
  EXPECT_EQ(value("[1,]"), "[1,]");
  EXPECT_EQ(value("[a]", "<string/>"), "[a]");
  EXPECT_EQ(value(std::string(100, '[') + std::string(100, ']')), std::string(100, '[') + std::string(100, ']'));
}

TEST(Types, TextsOfListsAreKept) {
  const auto value = [](const std::string& text) {
    return only_variable(variable_of("<type><derived name=\"T\"/></type><initialValue><simpleValue value=\"" + text +
                                     "\"/></initialValue>"))
        .initial;
  };
  EXPECT_EQ(value("[pump]").kind, InitialValue::Kind::kArray);
  EXPECT_EQ(value("[pump]").text, "[pump]") << "T may be a string";
  std::string many = "[0";
  for (int i = 0; i < 1'000'000; ++i) many += ",0";
  EXPECT_EQ(value(many + "]").kind, InitialValue::Kind::kSimple) << "more values than are made of one text";
}

TEST(Types, EnumAndSubrangeDataTypes) {
  const auto r = read_clean(tc6(
      R"(<dataTypes><dataType name="Color"><baseType><enum><values><value name="Red"/><value name="Green" value="5"/></values>
<baseType><INT/></baseType></enum></baseType><initialValue><simpleValue value="Green"/></initialValue></dataType>
<dataType name="Percent"><baseType><subrangeSigned><range lower="0" upper="100"/><baseType><INT/></baseType></subrangeSigned></baseType></dataType></dataTypes><pous/>)"));
  ASSERT_EQ(r.project->data_types.size(), 2u);
  const DataType& color = r.project->data_types[0];
  EXPECT_EQ(color.type.kind, TypeSpec::Kind::kEnum);
  ASSERT_EQ(color.type.values.size(), 2u);
  EXPECT_EQ(color.type.values[1].name, "Green");
  EXPECT_EQ(color.type.values[1].value, "5");
  EXPECT_EQ(color.type.base->name, "INT");
  EXPECT_EQ(color.initial.text, "Green");
  EXPECT_EQ(r.project->data_types[1].type.kind, TypeSpec::Kind::kSubrange);
  EXPECT_EQ(r.project->data_types[1].type.dimensions.at(0).upper, "100");
}

TEST(Values, SimpleArrayAndStruct) {
  EXPECT_EQ(only_variable(variable_of("<initialValue><simpleValue value=\" -1 \"/></initialValue>")).initial.text,
            "-1");
  const auto r = variable_of(
      R"(<type><INT/></type><initialValue><arrayValue><value repetitionValue="3"><simpleValue value="7"/></value>
<value><structValue><value member="a"><simpleValue value="TRUE"/></value><value member="b"><arrayValue/></value></structValue></value></arrayValue></initialValue>)");
  const InitialValue& value = only_variable(r).initial;
  ASSERT_EQ(value.kind, InitialValue::Kind::kArray);
  ASSERT_EQ(value.values.size(), 2u);
  EXPECT_EQ(value.values[0].repetition, "3");
  EXPECT_EQ(value.values[0].text, "7");
  ASSERT_EQ(value.values[1].kind, InitialValue::Kind::kStruct);
  EXPECT_EQ(value.values[1].values.at(0).member, "a");
  EXPECT_EQ(value.values[1].values.at(1).kind, InitialValue::Kind::kArray);
}

TEST(Values, AmpersandAndEntitiesInAttributes) {
  EXPECT_EQ(only_variable(variable_of("<initialValue><simpleValue value=\"'a&amp;b&lt;&#38;&#x41;'\"/></initialValue>"))
                .initial.text,
            "'a&b<&A'");
}

TEST(Interface, SectionsAndFlags) {
  const auto r = read_text(program("<ST/>", R"(<returnType><INT/></returnType>
<inputVars retain="true"><variable name="i"><type><BOOL/></type></variable></inputVars><outputVars><variable name="o"/></outputVars>
<inOutVars><variable name="io"/></inOutVars><localVars constant="true" persistent="true"><variable name="l" address="%IX0.0"><documentation>
<xhtml:p>a note</xhtml:p></documentation></variable></localVars><tempVars><variable name="t"/></tempVars>
<externalVars nonretain="true"><variable name="e"/></externalVars><globalVars name="G"><variable name="g"/></globalVars>)"));
  EXPECT_NE(r.shown().find("warning P4068: localVars is constant and persistent"), std::string::npos) << r.shown();
  const std::vector<Variable>& v = r.project->pous.at(0).variables;
  ASSERT_EQ(v.size(), 7u);
  EXPECT_TRUE(v[0].section == Section::kInput && v[0].retain);
  EXPECT_EQ(v[1].section, Section::kOutput);
  EXPECT_EQ(v[1].type.kind, TypeSpec::Kind::kMissing);
  EXPECT_EQ(v[2].section, Section::kInOut);
  EXPECT_TRUE(v[3].section == Section::kLocal && v[3].constant && v[3].persistent);
  EXPECT_EQ(v[3].address, "%IX0.0");
  EXPECT_EQ(v[3].documentation, "a note");
  EXPECT_EQ(v[4].section, Section::kTemp);
  EXPECT_TRUE(v[5].section == Section::kExternal && v[5].nonretain);
  EXPECT_TRUE(v[6].section == Section::kGlobal && v[6].list == "G");
  EXPECT_EQ(r.project->pous[0].return_type.name, "INT");
  EXPECT_EQ(r.row("pou/interface/localVars/variable/documentation")->fate, Fate::kPreserved);
}

TEST(Configuration, GlobalsAccessConfigTasksAndInstances) {
  const auto r = read_clean(tc6("<pous/>", R"(<configuration name="C"><resource name="R">
<task name="Fast" interval="PT0.02S" priority="1"><pouInstance name="a" typeName="A"/></task><task name="Ev" single="Trig" priority="2"/>
<globalVars name="GVL"><variable name="x"/></globalVars><pouInstance name="b" typeName="B"/></resource>
<globalVars><variable name="y"/></globalVars><accessVars><accessVariable alias="al" instancePathAndName="R.a.v" direction="readWrite"><type><INT/></type></accessVariable></accessVars>
<configVars><configVariable instancePathAndName="R.a.w" address="%QX1.0"><type><BOOL/></type></configVariable></configVars></configuration>)"));
  ASSERT_EQ(r.project->configurations.size(), 1u);
  const Configuration& c = r.project->configurations[0];
  EXPECT_EQ(c.name, "C");
  ASSERT_EQ(c.resources.size(), 1u);
  ASSERT_EQ(c.resources[0].tasks.size(), 2u);
  EXPECT_EQ(c.resources[0].tasks[0].interval, "PT0.02S");
  EXPECT_EQ(c.resources[0].tasks[0].instances.at(0).type_name, "A");
  EXPECT_EQ(c.resources[0].tasks[1].single, "Trig");
  EXPECT_EQ(c.resources[0].instances.at(0).name, "b");
  EXPECT_EQ(c.resources[0].globals.at(0).list, "GVL");
  EXPECT_EQ(c.globals.at(0).name, "y");
  EXPECT_EQ(c.access.at(0).name, "al");
  EXPECT_EQ(c.access[0].address, "R.a.v");
  EXPECT_FALSE(c.access[0].constant);
  EXPECT_EQ(c.configs.at(0).name, "R.a.w");
  EXPECT_EQ(c.configs[0].address, "%QX1.0");
}

TEST(Project, HeadersKindsAndVersion) {
  const auto r = read_clean(tc6(
      R"(<pous><pou name="F" pouType="function"><interface/><body><ST/></body><documentation>text</documentation></pou>
<pou name="B" pouType="functionBlock"><interface/><body WorksheetName="w"><ST/></body></pou></pous>)"));
  EXPECT_EQ(r.project->name, "demo");
  EXPECT_EQ(r.project->product, "tool");
  EXPECT_EQ(r.project->version, Version::kTc6v201);
  EXPECT_EQ(r.project->pous.at(0).kind, PouKind::kFunction);
  EXPECT_EQ(r.project->pous[0].documentation, "text");
  EXPECT_EQ(r.project->pous.at(1).kind, PouKind::kFunctionBlock);
  EXPECT_EQ(r.project->pous[1].bodies.at(0).name, "w");
}

}  // namespace
}  // namespace plc::plcopen
