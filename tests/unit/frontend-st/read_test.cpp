// Declarations as text: every form, the same structure as PLCopen XML gives, and recovery from errors.
#include "frontend-st/read.h"

#include <gtest/gtest.h>

#include <chrono>

#include "frontend-st/lexer.h"
#include "plcopen/reader.h"
#include "tests/unit/frontend-st/reading.h"

namespace plc::st {
namespace {

using plcopen::InitialValue;
using plcopen::Language;
using plcopen::Section;
using plcopen::TypeSpec;

std::string text_of(const TypeSpec& type);

std::string text_of(const InitialValue& value) {
  std::string out = value.member.empty() ? "" : value.member + ":=";
  if (!value.repetition.empty()) out += value.repetition + "x";
  switch (value.kind) {
    case InitialValue::Kind::kNone:
      return out;
    case InitialValue::Kind::kSimple:
      return out + value.text;
    default:
      out += value.kind == InitialValue::Kind::kArray ? "[" : "(";
      for (const InitialValue& one : value.values) out += text_of(one) + ";";
      return out + (value.kind == InitialValue::Kind::kArray ? "]" : ")");
  }
}

std::string text_of(const plcopen::Variable& v) {
  std::string out = std::to_string(static_cast<int>(v.section)) + (v.list.empty() ? "" : " " + v.list) + " " + v.name;
  if (!v.address.empty()) out += " AT " + v.address;
  out += " : " + text_of(v.type);
  if (v.constant) out += " constant";
  if (v.retain) out += " retain";
  if (v.nonretain) out += " nonretain";
  if (v.persistent) out += " persistent";
  if (v.edge != plcopen::Edge::kNone) out += v.edge == plcopen::Edge::kRising ? " rising" : " falling";
  const std::string initial = text_of(v.initial);
  return initial.empty() ? out : out + " := " + initial;
}

std::string text_of(const TypeSpec& type) {
  std::string out;
  switch (type.kind) {
    case TypeSpec::Kind::kNamed:
      return type.name;
    case TypeSpec::Kind::kString:
      return type.name + "[" + type.length + "]";
    case TypeSpec::Kind::kMissing:
      return "-";
    case TypeSpec::Kind::kPointer:
      return "POINTER TO " + text_of(*type.base);
    case TypeSpec::Kind::kReference:
      return "REF_TO " + text_of(*type.base);
    case TypeSpec::Kind::kReferenceTo:
      return "REFERENCE TO " + text_of(*type.base);
    case TypeSpec::Kind::kUnion:
      for (const plcopen::Variable& member : type.members) out += text_of(member) + "; ";
      return "union {" + out + "}";
    case TypeSpec::Kind::kArray:
    case TypeSpec::Kind::kSubrange:
      for (const plcopen::Dimension& d : type.dimensions) out += d.lower + ".." + d.upper + ",";
      return (type.kind == TypeSpec::Kind::kArray ? "array " : "range ") + out + " " + text_of(*type.base);
    case TypeSpec::Kind::kStruct:
      for (const plcopen::Variable& member : type.members) out += text_of(member) + "; ";
      return "{" + out + "}";
    case TypeSpec::Kind::kEnum:
      for (const plcopen::EnumValue& value : type.values) out += value.name + "=" + value.value + ",";
      return "enum " + out + (type.base ? text_of(*type.base) : "");
  }
  return out;
}

std::string text_of(const plcopen::Project& project) {
  std::string out;
  for (const plcopen::DataType& type : project.data_types) {
    out += "type " + type.name + " : " + text_of(type.type) + " := " + text_of(type.initial) + "\n";
  }
  for (const plcopen::Pou& pou : project.pous) {
    out += std::string(plcopen::pou_kind_name(pou.kind)) + " " + pou.name + " : " + text_of(pou.return_type) + "\n";
    for (const plcopen::Variable& v : pou.variables) out += "  " + text_of(v) + "\n";
    for (const plcopen::Body& body : pou.bodies) {
      out += "  " + std::string(plcopen::language_name(body.language)) + " <" + body.text + ">\n";
    }
  }
  for (const plcopen::Configuration& configuration : project.configurations) {
    out += "configuration " + configuration.name + "\n";
    for (const auto* list : {&configuration.globals, &configuration.access, &configuration.configs}) {
      for (const plcopen::Variable& v : *list) out += "  " + text_of(v) + "\n";
    }
    for (const plcopen::Resource& resource : configuration.resources) {
      out += "  resource " + resource.name + "\n";
      for (const plcopen::Variable& v : resource.globals) out += "    " + text_of(v) + "\n";
      for (const plcopen::Task& task : resource.tasks) {
        out += "    task " + task.name + " " + task.interval + " " + task.single + " " + task.priority;
        for (const plcopen::PouInstance& one : task.instances) out += " " + one.name + ":" + one.type_name;
        out += "\n";
      }
      for (const plcopen::PouInstance& one : resource.instances) out += "    " + one.name + ":" + one.type_name + "\n";
    }
  }
  return out;
}

std::string type_of(const std::string& text) {
  const Reading r("TYPE T : " + text + "; END_TYPE");
  EXPECT_EQ(r.diagnostics.error_count(), 0u) << text << "\n" << r.rendered();
  if (!r.project || r.project->data_types.size() != 1) return {};
  const plcopen::DataType& type = r.project->data_types[0];
  const std::string initial = text_of(type.initial);
  return text_of(type.type) + (initial.empty() ? "" : " := " + initial);
}

TEST(ReadTypes, EveryForm) {
  EXPECT_EQ(type_of("REAL"), "REAL");
  EXPECT_EQ(type_of("Lib.Point"), "Lib.Point");
  EXPECT_EQ(type_of("INT := 3 + 4"), "INT := 3 + 4");
  EXPECT_EQ(type_of("(Red, Green, Blue)"), "enum Red=,Green=,Blue=,");
  EXPECT_EQ(type_of("(Red, Green := 5) := Green"), "enum Red=,Green=5, := Green");
  EXPECT_EQ(type_of("INT (a := 1, b := a + 1) := b"), "enum a=1,b=a + 1,INT := b");
  EXPECT_EQ(type_of("DINT (a)"), "enum a=,DINT");
  EXPECT_EQ(type_of("(a, b) UINT"), "enum a=,b=,UINT");
  EXPECT_EQ(type_of("INT (-5..N*2) := 0"), "range -5..N*2, INT := 0");
  EXPECT_EQ(type_of("ARRAY [0..9] OF INT"), "array 0..9, INT");
  EXPECT_EQ(type_of("ARRAY[-1..N-1,1..2,0..0]OF ARRAY[1..2]OF BOOL"), "array -1..N-1,1..2,0..0, array 1..2, BOOL");
  EXPECT_EQ(type_of("STRING"), "STRING[]");
  EXPECT_EQ(type_of("string[20] := 'a;b'"), "STRING[20] := 'a;b'");
  EXPECT_EQ(type_of("WSTRING(N + 1)"), "WSTRING[N + 1]");
  EXPECT_EQ(type_of("REF_TO REF_TO INT := NULL"), "REF_TO REF_TO INT := NULL");
  EXPECT_EQ(type_of("POINTER TO INT"), "POINTER TO INT");
  EXPECT_EQ(type_of("REFERENCE TO INT"), "REFERENCE TO INT");
  EXPECT_EQ(type_of("STRUCT a, b : INT := 2; c : STRUCT d : BOOL; END_STRUCT; END_STRUCT"),
            "{3 a : INT := 2; 3 b : INT := 2; 3 c : {3 d : BOOL; }; }");
  EXPECT_EQ(type_of("STRUCT a : INT; END_STRUCT := (a := 1)"), "{3 a : INT; } := (a:=1;)");
}

TEST(ReadTypes, InitialValuesOfEveryForm) {
  EXPECT_EQ(type_of("ARRAY [1..5] OF INT := [3(0), 2(1)]"), "array 1..5, INT := [3x0;2x1;]");
  EXPECT_EQ(type_of("ARRAY [1..5] OF INT := [N(), 1]"), "array 1..5, INT := [Nx;1;]");
  EXPECT_EQ(type_of("ARRAY [1..5] OF INT := 1, 2, 3(4)"), "array 1..5, INT := [1;2;3x4;]");
  EXPECT_EQ(type_of("ARRAY [1..5] OF INT := 5(7)"), "array 1..5, INT := [5x7;]");
  EXPECT_EQ(type_of("ARRAY [1..2] OF P := [2((x := 1, y := [1, 2]))]"), "array 1..2, P := [2x(x:=1;y:=[1;2;];);]");
  EXPECT_EQ(type_of("P := (a := 1, b := [3(0), 2(1)], c := (d := (1 + 2) * 3))"),
            "P := (a:=1;b:=[3x0;2x1;];c:=(d:=(1 + 2) * 3;);)");
  EXPECT_EQ(type_of("TIME := T#1h2m"), "TIME := T#1h2m");
}

TEST(ReadTypes, StructWithoutSemicolonAfterIt) {
  const Reading r("TYPE\n A : STRUCT x : INT; END_STRUCT\n B : INT;\nEND_TYPE");
  EXPECT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  EXPECT_EQ(r.project->data_types.size(), 2u);
}

TEST(ReadVariables, SectionsAndQualifiers) {
  const Reading r(R"(FUNCTION_BLOCK F
VAR_INPUT a, b : INT := 3; r : BOOL R_EDGE; f : BOOL F_EDGE; END_VAR
VAR_OUTPUT RETAIN o : REAL; END_VAR
VAR_IN_OUT io : ARRAY [1..2] OF INT; END_VAR
VAR CONSTANT c : INT := 1; END_VAR
VAR RETAIN PERSISTENT p : INT; END_VAR
VAR NON_RETAIN n : INT; END_VAR
VAR_INST i : TON := (PT := T#1s); END_VAR
VAR_TEMP t : INT; END_VAR
VAR_EXTERNAL CONSTANT e : INT; END_VAR
VAR l AT %IX0.0 : BOOL; u AT %Q* : BOOL; AT %MW3 : WORD; retain : BOOL; END_VAR
END_FUNCTION_BLOCK)");
  ASSERT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  std::vector<std::string> found;
  for (const plcopen::Variable& v : r.project->pous.at(0).variables) found.push_back(text_of(v));
  const std::vector<std::string> expected = {"0 a : INT := 3",
                                             "0 b : INT := 3",
                                             "0 r : BOOL rising",
                                             "0 f : BOOL falling",
                                             "1 o : REAL retain",
                                             "2 io : array 1..2, INT",
                                             "3 c : INT constant := 1",
                                             "3 p : INT retain persistent",
                                             "3 n : INT nonretain",
                                             "9 i : TON := (PT:=T#1s;)",
                                             "4 t : INT",
                                             "5 e : INT constant",
                                             "3 l AT %IX0.0 : BOOL",
                                             "3 u AT %Q* : BOOL",
                                             "3 %MW3 AT %MW3 : WORD",
                                             "3 retain : BOOL"};
  EXPECT_EQ(found, expected);
  EXPECT_EQ(r.project->pous[0].variables[1].at.line, 2u);
  EXPECT_EQ(r.project->pous[0].variables[1].at.column, 14u);
}

TEST(ReadPous, KindsResultsAndBodies) {
  const Reading r(R"(FUNCTION Add : INT
VAR_INPUT a : INT; END_VAR
  (* END_FUNCTION *) Add := a + 1; // END_FUNCTION
  s := 'END_FUNCTION';
END_FUNCTION
FUNCTION None END_FUNCTION
PROGRAM Main x.program := 1; END_PROGRAM;
FUNCTION_BLOCK Seq INITIAL_STEP Start: END_STEP END_FUNCTION_BLOCK
FUNCTION_BLOCK List
  LD a
  ST b
END_FUNCTION_BLOCK
FUNCTION_BLOCK Labelled next: LD a END_FUNCTION_BLOCK
PROGRAM NotAList Step := 3; LD := 4; S(a := 1); END_PROGRAM)");
  EXPECT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  const std::vector<plcopen::Pou>& pous = r.project->pous;
  ASSERT_EQ(pous.size(), 7u);
  EXPECT_EQ(text_of(pous[0].return_type), "INT");
  EXPECT_EQ(pous[0].bodies.at(0).text, "Add := a + 1; // END_FUNCTION\n  s := 'END_FUNCTION';");
  EXPECT_EQ(pous[0].bodies[0].text_at.line, 3u);
  EXPECT_EQ(pous[0].bodies[0].text_at.column, 22u);
  EXPECT_EQ(pous[1].return_type.kind, TypeSpec::Kind::kMissing);
  EXPECT_EQ(pous[1].bodies.at(0).language, Language::kNone);
  EXPECT_EQ(pous[2].bodies.at(0).text, "x.program := 1;");
  EXPECT_EQ(pous[3].bodies.at(0).language, Language::kSfc);
  EXPECT_EQ(pous[4].bodies.at(0).language, Language::kIl);
  EXPECT_EQ(pous[5].bodies.at(0).language, Language::kIl);
  EXPECT_EQ(pous[6].bodies.at(0).language, Language::kSt);
}

TEST(ReadPous, ActionsInAfterAndBesideTheirPou) {
  const Reading r(R"(FUNCTION_BLOCK Pump
VAR n : INT; END_VAR
ACTION First: n := 1; END_ACTION
  n := 2;
ACTION Second
  n := 3;
END_ACTION;
  n := 4;
END_FUNCTION_BLOCK
ACTION Third: n := a.action; END_ACTION
PROGRAM Main END_PROGRAM
ACTIONS pump ACTION Fourth END_ACTION END_ACTIONS
ACTION Pump.Fifth: LD n END_ACTION
ACTIONS ACTION Own: END_ACTION END_ACTIONS
)");
  EXPECT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  ASSERT_EQ(r.project->pous.size(), 2u);
  const std::vector<plcopen::Pou>& actions = r.project->pous[0].actions;
  ASSERT_EQ(actions.size(), 5u);
  EXPECT_EQ(actions[0].name, "First");
  EXPECT_EQ(actions[0].bodies.at(0).text, "n := 1;");
  EXPECT_EQ(actions[1].bodies.at(0).text_at.line, 6u);
  EXPECT_EQ(actions[2].bodies.at(0).text, "n := a.action;");
  EXPECT_EQ(actions[3].bodies.at(0).language, Language::kNone);
  EXPECT_EQ(actions[4].bodies.at(0).language, Language::kIl);
  ASSERT_EQ(r.project->pous[1].actions.size(), 1u);
  const std::string& body = r.project->pous[0].bodies.at(0).text;
  EXPECT_EQ(body.find("ACTION"), std::string::npos) << body;
  EXPECT_EQ(r.project->pous[0].bodies[0].text_at.line, 4u);
  EXPECT_EQ(std::count(body.begin(), body.end(), '\n'), 4);
}

TEST(ReadErrors, ActionsThatDoNotEndOrBelongNowhere) {
  EXPECT_EQ(Reading("ACTION a: END_ACTION PROGRAM P END_PROGRAM").places(), Places{"1:8 P4050"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM ACTION Q.a: END_ACTION").places(), Places{"1:32 P4050"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM ACTION a: x := 1;").places(), Places{"1:23 P4042"});
  EXPECT_EQ(Reading("PROGRAM P ACTION a: x := 1; END_PROGRAM").places(), Places{"1:11 P4042"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM ACTIONS P ACTION a: END_ACTION").places(), Places{"1:23 P4042"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM ACTIONS P x := 1; END_ACTIONS").places(), Places{"1:33 P4040"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM ACTION a: VAR x : INT; END_VAR END_ACTION").places(), Places{"1:33 P4045"});
}

TEST(ReadConfiguration, ResourcesTasksInstancesAndPaths) {
  const Reading r(R"(CONFIGURATION Plant
  VAR_GLOBAL CONSTANT N : INT := 5; END_VAR
  RESOURCE Cell ON X86
    VAR_GLOBAL g AT %QX0.0 : BOOL; END_VAR
    TASK Fast (INTERVAL := T#10ms, PRIORITY := 1);
    TASK Event (SINGLE := g, PRIORITY := 0);
    PROGRAM RETAIN p WITH Fast : Main (Speed := 3, Level := g.x, Full => %QX0.1);
    PROGRAM q : Main;
  END_RESOURCE
  VAR_ACCESS Alias : Cell.p.x : INT READ_WRITE; Seen : Cell.%IX0.0 : BOOL; END_VAR
  VAR_CONFIG Cell.p.y AT %QX3.0 : BOOL := TRUE; END_VAR
END_CONFIGURATION
CONFIGURATION Small TASK t (INTERVAL := T#1s); PROGRAM p WITH t : Main; END_CONFIGURATION)");
  ASSERT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  EXPECT_EQ(text_of(*r.project),
            "configuration Plant\n"
            "  6 N : INT constant := 5\n"
            "  7 Alias AT Cell.p.x : INT\n"
            "  7 Seen AT Cell.%IX0.0 : BOOL constant\n"
            "  8 Cell.p.y AT %QX3.0 : BOOL := TRUE\n"
            "  resource Cell\n"
            "    6 g AT %QX0.0 : BOOL\n"
            "    task Fast T#10ms  1 p:Main\n"
            "    task Event  g 0\n"
            "    q:Main\n"
            "configuration Small\n"
            "  resource \n"
            "    task t T#1s   p:Main\n");
  const plcopen::PouInstance& p = r.project->configurations[0].resources[0].tasks[0].instances[0];
  EXPECT_TRUE(p.retain);
  ASSERT_EQ(p.connections.size(), 3u);
  EXPECT_EQ(p.connections[1].variable, "Level");
  EXPECT_EQ(p.connections[1].other, "g.x");
  EXPECT_TRUE(p.connections[2].output);
}

// What PLCopen XML says in elements, and the same as text.
TEST(Read, TextAndXmlGiveOneProject) {
  constexpr std::string_view kXml = R"(<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader productName="p"/><contentHeader name="test"/>
<types><dataTypes>
 <dataType name="Mode"><baseType><enum><values><value name="Off" value="1"/><value name="On"/></values>
   <baseType><INT/></baseType></enum></baseType><initialValue><simpleValue value="On"/></initialValue></dataType>
 <dataType name="Pct"><baseType><subrangeSigned><range lower="0" upper="100"/><baseType><INT/></baseType></subrangeSigned></baseType></dataType>
 <dataType name="Point"><baseType><struct>
   <variable name="x"><type><REAL/></type><initialValue><simpleValue value="1.5"/></initialValue></variable>
   <variable name="name"><type><string length="20"/></type></variable></struct></baseType></dataType>
 <dataType name="Grid"><baseType><array><dimension lower="0" upper="4"/><dimension lower="1" upper="2"/><baseType><INT/></baseType></array></baseType>
   <initialValue><arrayValue><value repetitionValue="3"><simpleValue value="0"/></value><value><simpleValue value="1"/></value></arrayValue></initialValue></dataType>
 <dataType name="Ref"><baseType><pointer><baseType><derived name="Point"/></baseType></pointer></baseType></dataType>
</dataTypes><pous>
 <pou name="Add" pouType="function"><interface><returnType><INT/></returnType>
   <inputVars><variable name="a"><type><INT/></type></variable></inputVars></interface>
   <body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">Add := a + 1;</xhtml></ST></body></pou>
 <pou name="Main" pouType="program"><interface>
   <localVars retain="true"><variable name="t"><type><derived name="TON"/></type>
     <initialValue><structValue><value member="PT"><simpleValue value="T#3s"/></value></structValue></initialValue></variable></localVars>
   <localVars><variable name="out" address="%QX0.0"><type><BOOL/></type></variable>
     <variable name="p"><type><derived name="Point"/></type>
     <initialValue><structValue><value member="x"><simpleValue value="3.0"/></value></structValue></initialValue></variable></localVars>
   <tempVars><variable name="i"><type><INT/></type></variable></tempVars></interface>
   <body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">out := t.Q;</xhtml></ST></body></pou>
</pous></types>
<instances><configurations><configuration name="Plant"><resource name="Cell">
  <task name="Fast" interval="T#10ms" priority="1"><pouInstance name="Line1" typeName="Main"/></task>
  <globalVars constant="true"><variable name="N"><type><INT/></type><initialValue><simpleValue value="5"/></initialValue></variable></globalVars>
</resource></configuration></configurations></instances></project>)";
  constexpr std::string_view kText = R"(TYPE
  Mode : INT (Off := 1, On) := On;
  Pct : INT (0..100);
  Point : STRUCT x : REAL := 1.5; name : STRING[20]; END_STRUCT;
  Grid : ARRAY [0..4, 1..2] OF INT := [3(0), 1];
  Ref : POINTER TO Point;
END_TYPE
FUNCTION Add : INT
VAR_INPUT a : INT; END_VAR
  Add := a + 1;
END_FUNCTION
PROGRAM Main
VAR RETAIN t : TON := (PT := T#3s); END_VAR
VAR out AT %QX0.0 : BOOL; p : Point := (x := 3.0); END_VAR
VAR_TEMP i : INT; END_VAR
  out := t.Q;
END_PROGRAM
CONFIGURATION Plant
  RESOURCE Cell ON PLC
    VAR_GLOBAL CONSTANT N : INT := 5; END_VAR
    TASK Fast (INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM Line1 WITH Fast : Main;
  END_RESOURCE
END_CONFIGURATION)";
  const Reading text(kText);
  core::Diagnostics diagnostics;
  const auto xml = plcopen::read_memory(kXml, "test.xml", diagnostics);
  ASSERT_TRUE(xml && text.project);
  ASSERT_EQ(diagnostics.error_count() + text.diagnostics.error_count(), 0u) << text.rendered();
  EXPECT_EQ(text_of(*xml), text_of(*text.project));
}

TEST(ReadErrors, EachOnceAndWhatFollowsIsRead) {
  const Reading r(
      "PROGRAM P\n"
      "VAR\n"
      "  a INT;\n"             // 3:5
      "  b : INT\n"            // missing ; found at 5:3
      "  c : INT := ;\n"       // 5:14
      "  d : ARRAY OF INT;\n"  // 6:13
      "  e : 'x;\n"            // 7:7, a text ends with its line
      "  f : INT;\n"
      "END_VAR\n"
      "END_PROGRAM\n"
      "nonsense;\n"  // 11:1
      "PROGRAM Q END_PROGRAM\n");
  EXPECT_EQ(r.places(), (Places{"3:5 P4040", "5:3 P4040", "5:14 P4040", "6:13 P4040", "7:7 P4040", "11:1 P4040"}))
      << r.rendered();
  ASSERT_EQ(r.project->pous.size(), 2u);
  std::string known;
  for (const plcopen::Variable& v : r.project->pous[0].variables) known += v.name + (v.refused ? "! " : " ");
  EXPECT_EQ(known, "a! b c! d! e! f ");
}

TEST(ReadErrors, MissingEndsNameWhatIsOpen) {
  EXPECT_EQ(Reading("PROGRAM P\n x := 1;\nFUNCTION F : INT END_FUNCTION").places(), Places{"1:1 P4042"});
  EXPECT_EQ(Reading("PROGRAM P\nVAR x : INT;\n x := 1;\nEND_PROGRAM").places(), Places{"2:1 P4042"});
  EXPECT_EQ(Reading("PROGRAM P\nEND_FUNCTION\nPROGRAM Q END_PROGRAM").places(), Places{"2:1 P4042"});
  EXPECT_EQ(Reading("TYPE A : INT;\nPROGRAM P END_PROGRAM").places(), Places{"1:1 P4042"});
  EXPECT_EQ(Reading("TYPE A : STRUCT x : INT; END_TYPE").places(), Places{"1:10 P4042"});
  EXPECT_EQ(Reading("CONFIGURATION C RESOURCE R ON X\nEND_CONFIGURATION").places(), Places{"1:17 P4042"});
  EXPECT_EQ(Reading("CONFIGURATION C\nPROGRAM P VAR END_VAR END_PROGRAM").places(), Places{"1:1 P4042"});
  EXPECT_EQ(Reading("PROGRAM P END_PROGRAM (* open").places(), Places{"1:23 P4040"});
}

TEST(ReadErrors, KeywordsInPlaceOfNamesDoNotStopTheReader) {
  for (const char* word : {"TYPE", "END_TYPE", "VAR", "END_VAR", "STRUCT", "END_STRUCT", "PROGRAM", "END_PROGRAM",
                           "CONFIGURATION", "TASK", "RESOURCE", "CLASS", "METHOD", "UNION", "END_UNION", "ACTION"}) {
    for (const char* following : {" : INT;", ", x : INT;", ";", " x", "", " := 1;", "(a)"}) {
      const std::string text = std::string(word) + following;
      static_cast<void>(Reading(text));
      static_cast<void>(Reading("TYPE " + text + " END_TYPE"));
      static_cast<void>(Reading("TYPE S : STRUCT " + text + " END_STRUCT; END_TYPE"));
      static_cast<void>(Reading("PROGRAM P VAR " + text + " END_VAR END_PROGRAM"));
      static_cast<void>(Reading("CONFIGURATION C " + text + " RESOURCE R ON X " + text + " END_RESOURCE"));
      static_cast<void>(Reading("VAR_CONFIG " + text + " END_VAR VAR_ACCESS " + text));
    }
  }
}

TEST(ReadErrors, ObjectOrientationIsRefusedOnceAConstruct) {
  const Reading r(
      "CLASS C METHOD m END_METHOD END_CLASS\n"
      "INTERFACE I END_INTERFACE\n"
      "NAMESPACE N FUNCTION F : INT END_FUNCTION NAMESPACE M END_NAMESPACE END_NAMESPACE\n"
      "FUNCTION_BLOCK B EXTENDS A IMPLEMENTS I, J\n"
      "VAR PRIVATE x : INT; END_VAR\n"
      "x := 1;\n"
      "METHOD PUBLIC m : INT m := 1; END_METHOD\n"
      "x := 2;\n"
      "END_FUNCTION_BLOCK\n"
      "PROGRAM P END_PROGRAM");
  EXPECT_EQ(r.places(), (Places{"1:1 P4041", "2:1 P4041", "3:1 P4041", "4:18 P4041", "5:5 P4041", "7:1 P4041"}))
      << r.rendered();
  ASSERT_EQ(r.project->pous.size(), 2u);
  const std::string& body = r.project->pous[0].bodies.at(0).text;
  EXPECT_EQ(body.find("METHOD"), std::string::npos) << body;
  EXPECT_EQ(std::count(body.begin(), body.end(), '\n'), 2);  // the lines following the method keep their numbers
}

TEST(ReadErrors, SectionsThatCannotStand) {
  EXPECT_EQ(Reading("FUNCTION F : INT VAR_INST x : INT; END_VAR END_FUNCTION").places(), Places{"1:18 P4045"});
  EXPECT_EQ(Reading("FUNCTION_BLOCK F VAR_GLOBAL x : INT; END_VAR END_FUNCTION_BLOCK").places(), Places{"1:18 P4045"});
  EXPECT_EQ(Reading("PROGRAM P x := 1; VAR y : INT; END_VAR y := 2; END_PROGRAM").places(), Places{"1:19 P4045"});
  EXPECT_EQ(Reading("PROGRAM P VAR x : BOOL R_EDGE; END_VAR END_PROGRAM").places(), Places{"1:24 P4046"});
  EXPECT_EQ(Reading("PROGRAM P VAR RETAIN NON_RETAIN x : BOOL; END_VAR END_PROGRAM").places(), Places{"1:11 P4045"});
}

TEST(ReadErrors, WhatIsNotSupportedIsNamed) {
  EXPECT_EQ(Reading("TYPE A : STRUCT OVERLAP a : INT; b : REAL; END_STRUCT; B : INT; END_TYPE").places(),
            Places{"1:17 P4043"});
  EXPECT_EQ(Reading("PROGRAM P VAR f : Fb(a := 1); END_VAR END_PROGRAM").places(), Places{"1:19 P4043"});
}

TEST(ReadLimits, DepthSizeAndLongLists) {
  std::string deep = "TYPE A : ";
  for (int i = 0; i < 5000; ++i) deep += "ARRAY [0..1] OF ";
  EXPECT_EQ(Reading(deep + "INT; END_TYPE").diagnostics.error_count(), 1u);
  std::string values = "TYPE A : P := ";
  for (int i = 0; i < 5000; ++i) values += "[";
  EXPECT_GE(Reading(values + "; END_TYPE").diagnostics.error_count(), 1u);
  // Many names with one large type: the copies are what costs.
  std::string names = "PROGRAM P VAR a0";
  for (int i = 1; i < 20000; ++i) names += ",a" + std::to_string(i);
  names += " : STRUCT ";
  for (int i = 0; i < 2000; ++i) names += "m" + std::to_string(i) + " : INT; ";
  const Reading r(names + "END_STRUCT; END_VAR END_PROGRAM");
  EXPECT_EQ(r.places().size(), 1u) << r.rendered();
  EXPECT_EQ(r.diagnostics.all().at(0).code, core::Code::P4044);
}

TEST(Read, ByteOrderMarksEncodingsAndLineEnds) {
  const auto program = [](const Reading& r) { return r.project ? text_of(*r.project) : std::string("unread"); };
  const std::string plain = program(Reading("PROGRAM P\nx := 1;\nEND_PROGRAM"));
  EXPECT_EQ(program(Reading("\xEF\xBB\xBFPROGRAM P\nx := 1;\nEND_PROGRAM")), plain);
  EXPECT_EQ(program(Reading("PROGRAM P\r\nx := 1;\r\nEND_PROGRAM\r\n")), plain);
  std::string wide = "\xFF\xFE";
  for (const char c : std::string("PROGRAM P x := 1; END_PROGRAM")) wide += std::string{c, '\0'};
  EXPECT_EQ(program(Reading(wide)), plain);
  const Reading latin("PROGRAM P (* \xFC *) x\xE4 := 1; ; ? END_PROGRAM");
  EXPECT_EQ(latin.project->pous.at(0).bodies.at(0).text, "x\xC3\xA4 := 1; ; ?");
  EXPECT_EQ(Reading(std::string_view("PROGRAM\0P", 9)).places(), Places{"0:0 P4047"});
  EXPECT_TRUE(looks_like_text("  PROGRAM"));
  EXPECT_FALSE(looks_like_text("\xEF\xBB\xBF <?xml"));
}

TEST(Read, PragmasAreKeptAndNameTheListOfAFile) {
  const Reading r("{attribute 'qualified_only'}\nVAR_GLOBAL x : INT; END_VAR PROGRAM P y := 1; {region} END_PROGRAM");
  EXPECT_EQ(r.diagnostics.error_count(), 0u) << r.rendered();
  ASSERT_EQ(r.project->pragmas.size(), 2u);
  EXPECT_EQ(r.project->pragmas[0].text, "{attribute 'qualified_only'}");
  EXPECT_EQ(r.project->configurations.at(0).globals.at(0).list, "test");
}

TEST(Read, PlainDeclarationsCountWhereTheTypedOnesAreMissing) {
  core::Diagnostics diagnostics;
  diagnostics.add_file("test.xml");
  plcopen::Project project;
  plcopen::Pou typed, plain;
  typed.name = "Typed";
  typed.variables.emplace_back().name = "a";
  plain.name = "Plain";
  plain.kind = plcopen::PouKind::kFunction;
  project.pous = {typed, plain};
  core::SourceRef at;
  at.line = 7;
  at.column = 5;
  project.declarations = {{"Typed", false, "PROGRAM Typed VAR b : INT; {x} END_VAR", at},
                          {"Plain", false, "FUNCTION Plain : INT\nVAR_INPUT c : INT; END_VAR", at},
                          {"GVL", true, "{attribute 'qualified_only'} VAR_GLOBAL g : INT := 3; END_VAR", at},
                          {"Plain", false, "VAR broken", at}};
  read_plain_declarations(project, diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 0u);
  EXPECT_EQ(project.pous[0].variables.size(), 1u);
  EXPECT_EQ(text_of(project.pous[1].return_type), "INT");
  ASSERT_EQ(project.pous[1].variables.size(), 1u);
  EXPECT_EQ(project.pous[1].variables[0].at.line, 8u);
  ASSERT_EQ(project.configurations.size(), 1u);
  EXPECT_EQ(text_of(project.configurations[0].globals.at(0)), "6 GVL g : INT := 3");
  EXPECT_EQ(project.pragmas.size(), 2u);
}

TEST(Read, CommentsBeforeABody) {
  const auto lead = [](const std::string& comments) {
    const Reading r("PROGRAM P VAR a : INT; END_VAR" + comments + "a := 1;\nEND_PROGRAM");
    return r.project->pous.at(0).bodies.at(0).lead;
  };
  EXPECT_EQ(lead("  // about the variables\n  // about the body\n  "), "  // about the body\n  ");
  EXPECT_EQ(lead(" (* about\n the variables *) // too\n"), "") << "no comment begins on a line of its own";
  EXPECT_EQ(lead(" (* about\n the variables *)\n(* the body *)\n"), "(* the body *)\n");
  EXPECT_EQ(lead("\n"), "");
}

TEST(Read, AHundredThousandLinesInLinearTime) {
  std::string text;
  for (int i = 0; i < 1000; ++i) {
    text += "FUNCTION_BLOCK F" + std::to_string(i) + "\nVAR_INPUT a : INT; END_VAR\n";
    for (int k = 0; k < 97; ++k) text += "  a := a + " + std::to_string(k) + "; (* comment *)\n";
    text += "END_FUNCTION_BLOCK\n";
  }
  const auto begin = std::chrono::steady_clock::now();
  const Reading r(text);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(r.diagnostics.error_count(), 0u);
  EXPECT_EQ(r.project->pous.size(), 1000u);
  // Measured 0.03 s; sanitizers and a busy machine take their share.
  EXPECT_LT(took.count(), 3.0);
}

}  // namespace
}  // namespace plc::st
