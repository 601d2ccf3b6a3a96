// Source files of TwinCAT as texts with places, and as projects.
#include "sources/object_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "sources/object_project.h"
#include "sources/plcproj.h"

namespace plc::sources {
namespace {

struct Reading {
  explicit Reading(const std::string& bytes, const std::string& name = "A.TcPOU")
      : file(read_object_memory(bytes, name, diagnostics)) {
    if (file) project = to_project(*file, {"Tc2_Standard"}, diagnostics);
  }
  [[nodiscard]] bool has(core::Code code) const {
    return std::any_of(diagnostics.all().begin(), diagnostics.all().end(),
                       [&](const core::Diagnostic& one) { return one.code == code; });
  }
  core::Diagnostics diagnostics;
  std::optional<ObjectFile> file;
  plcopen::Project project;
};

std::string pou(const std::string& declaration, const std::string& rest) {
  return "\xEF\xBB\xBF<?xml version=\"1.0\" encoding=\"utf-8\"?>\r\n<TcPlcObject Version=\"1.1.0.1\">\r\n"
         "  <POU Name=\"A\" Id=\"{1}\" SpecialFunc=\"None\">\r\n    <Declaration><![CDATA[" +
         declaration + "]]></Declaration>\r\n" + rest + "  </POU>\r\n</TcPlcObject>";
}
std::string st(const std::string& body) {
  return "    <Implementation>\r\n      <ST><![CDATA[" + body + "]]></ST>\r\n    </Implementation>\r\n";
}

TEST(ObjectFile, PlacesAreThoseOfTheFile) {
  // Lines end in all ways; the second line of the declaration is line 5 of the file, the body begins in line 8.
  const Reading r(pou("FUNCTION_BLOCK A\nVAR x : INT; END_VAR\r\n", st("x := x + 1;\r\n  y := 2;")));
  ASSERT_TRUE(r.file);
  EXPECT_FALSE(r.diagnostics.has_errors());
  ASSERT_EQ(r.project.pous.size(), 1u);
  const plcopen::Pou& a = r.project.pous[0];
  EXPECT_EQ(a.kind, plcopen::PouKind::kFunctionBlock);
  EXPECT_EQ(a.at.line, 4u);
  EXPECT_EQ(a.at.column, 42u);
  ASSERT_EQ(a.variables.size(), 1u);
  EXPECT_EQ(a.variables[0].at.line, 5u);
  EXPECT_EQ(a.variables[0].at.column, 5u);
  ASSERT_EQ(a.bodies.size(), 1u);
  EXPECT_EQ(a.bodies[0].language, plcopen::Language::kSt);
  EXPECT_EQ(a.bodies[0].text_at.line, 8u);
  EXPECT_EQ(a.bodies[0].text_at.column, 20u);
  EXPECT_EQ(a.bodies[0].text, "x := x + 1;\n  y := 2;");
}

TEST(ObjectFile, SplitSectionsAreOneText) {
  const Reading r(pou("PROGRAM A\nVAR x : INT; END_VAR", st("x := 1; // ]]]]><![CDATA[> end\nx := 2;")));
  ASSERT_EQ(r.project.pous.size(), 1u);
  EXPECT_EQ(r.project.pous[0].bodies[0].text, "x := 1; // ]]> end\nx := 2;");
}

TEST(ObjectFile, ObjectsAreNamedOnceAndKeepTheirVariables) {
  const Reading r(pou("FUNCTION_BLOCK PUBLIC A EXTENDS B IMPLEMENTS C, D\nVAR_INPUT x : INT; END_VAR",
                      st("x := 1;") + "<Method Name=\"M\"><Declaration><![CDATA[METHOD M]]></Declaration></Method>"
                                      "<Property Name=\"P\"><Get Name=\"Get\"><Declaration/></Get></Property>"));
  EXPECT_FALSE(r.diagnostics.has_errors());  // reported when it is compiled
  ASSERT_EQ(r.project.pous.size(), 1u);
  const plcopen::Pou& a = r.project.pous[0];
  EXPECT_EQ(a.unread,
            "is object-oriented, which is not supported: PUBLIC, EXTENDS B, IMPLEMENTS C, D, METHOD M, PROPERTY P");
  EXPECT_EQ(a.unread_members, (std::vector<std::string>{"M", "P"}));
  EXPECT_EQ(a.variables.size(), 1u);
}

TEST(ObjectFile, DrawingsAreNamed) {
  for (const std::string format : {"NWL", "SFC", "CFC"}) {
    const Reading r(
        pou("PROGRAM A", "<Implementation><" + format + "><XmlArchive/></" + format + "></Implementation>"));
    ASSERT_EQ(r.project.pous.size(), 1u);
    EXPECT_NE(r.project.pous[0].unread.find(format), std::string::npos);
  }
}

TEST(ObjectFile, ActionsAndTasks) {
  const Reading actions(
      pou("PROGRAM A\nVAR x : INT; END_VAR",
          st("B();") + "<Action Name=\"B\"><Implementation><ST><![CDATA[x := 1;]]></ST></Implementation></Action>"));
  ASSERT_EQ(actions.project.pous.size(), 1u);
  ASSERT_EQ(actions.project.pous[0].actions.size(), 1u);
  EXPECT_EQ(actions.project.pous[0].actions[0].bodies[0].text, "x := 1;");

  const Reading task(
      "<TcPlcObject><Task Name=\"T\"><CycleTime>1500</CycleTime><Priority>3</Priority><PouCall><Name>B</Name></PouCall>"
      "<PouCall><Name>A</Name></PouCall></Task></TcPlcObject>",
      "T.TcTTO");
  ASSERT_EQ(task.project.configurations.size(), 1u);
  const plcopen::Task& t = task.project.configurations[0].resources[0].tasks[0];
  EXPECT_EQ(t.interval, "T#1500us");
  EXPECT_EQ(t.priority, "3");
  ASSERT_EQ(t.instances.size(), 2u);
  EXPECT_EQ(t.instances[0].name, "B");
  EXPECT_TRUE(Reading("<TcPlcObject><Task Name=\"T\"><CycleTime>0</CycleTime></Task></TcPlcObject>", "T.TcTTO")
                  .has(core::Code::P1208));
}

TEST(ObjectFile, NamespacesBecomeBlanks) {
  EXPECT_EQ(without_namespaces("a : Tc2_Standard.TON; x := tc2_standard . MAX(b.Tc2_Standard.c, 'Tc2_Standard.d');",
                               {"Tc2_Standard"}),
            "a :              TON; x :=                MAX(b.Tc2_Standard.c, 'Tc2_Standard.d');");
}

TEST(ObjectFile, HostileFilesAreErrors) {
  EXPECT_TRUE(Reading("<POU Name=\"A\"/>").has(core::Code::P1207));
  EXPECT_TRUE(Reading("").diagnostics.has_errors());
  EXPECT_TRUE(Reading("<TcPlcObject><POU Name=\"A\">").has(core::Code::P1002));
  EXPECT_TRUE(Reading("<!DOCTYPE a [<!ENTITY b \"c\">]><TcPlcObject>&b;</TcPlcObject>").has(core::Code::P1005));
  EXPECT_TRUE(Reading("<TcPlcObject><POU Name=\"A\"><Declaration/></POU></TcPlcObject>").has(core::Code::P4040));
  std::string deep = "<TcPlcObject>";
  for (int i = 0; i < 1000; ++i) deep += "<POU>";
  EXPECT_TRUE(Reading(deep).has(core::Code::P1006));
}

TEST(PlcProject, EntriesLibrariesAndExclusions) {
  core::Diagnostics diagnostics;
  const auto project = read_plcproj_memory(
      "<Project xmlns=\"http://schemas.microsoft.com/developer/msbuild/2003\"><PropertyGroup><Name>Plant</Name>"
      "</PropertyGroup><ItemGroup>\n<Compile Include=\"POUs\\A%20b.TcPOU\"><SubType>Code</SubType></Compile>"
      "<Compile Include=\"Old.TcPOU\"><ExcludeFromBuild>true</ExcludeFromBuild></Compile><Folder Include=\"POUs\"/>"
      "<PlaceholderReference Include=\"Tc2_Standard\"><Namespace>Std</Namespace></PlaceholderReference>"
      "<LibraryReference Include=\"Lib,newest,Company\"/></ItemGroup></Project>",
      "P.plcproj", diagnostics);
  ASSERT_TRUE(project);
  EXPECT_EQ(project->name, "Plant");
  ASSERT_EQ(project->entries.size(), 2u);
  EXPECT_EQ(project->entries[0].path, "POUs\\A b.TcPOU");
  EXPECT_FALSE(project->entries[0].excluded);
  EXPECT_TRUE(project->entries[1].excluded);
  EXPECT_EQ(project->entries[0].at.line, 2u);
  EXPECT_EQ(project->entries[0].at.column, 19u);
  EXPECT_EQ(project->namespaces, (std::vector<std::string>{"Std", "Lib"}));
}

}  // namespace
}  // namespace plc::sources
