// What decides about places: sizes, covers, grids, networks of the file, and that texts have the places of the file.
#include <gtest/gtest.h>

#include <cstdio>
#include <set>
#include <string>

#include "bytecode/drawn_lines.h"
#include "compiler/compile.h"
#include "drawings/make.h"
#include "frontend-sfc/macro_steps.h"
#include "plcopen/reader.h"
#include "tests/support/golden.h"
#include "tests/unit/drawings/properties.h"

namespace plc::test {
namespace {

/// The drawing of one POU with this body in LD.
DrawnBody ladder(const std::string& elements) {
  const std::string text =
      R"(<project xmlns="http://www.plcopen.org/xml/tc6_0201"><fileHeader companyName="" productName="" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="p"><coordinateInfo><fbd><scaling x="1" y="1"/></fbd><ld><scaling x="1" y="1"/></ld><sfc><scaling x="1" y="1"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="Main" pouType="program"><interface/><body><LD>)" +
      elements + "</LD></body></pou></pous></types><instances><configurations/></instances></project>";
  core::Diagnostics diagnostics;
  const auto project = plcopen::read_memory(text, "plant.xml", diagnostics);
  EXPECT_TRUE(project) << text;
  return project ? drawings::make(*project, diagnostics).bodies.at(0) : DrawnBody{};
}

std::string contact(int id, int from, int x, int y, int width, int height) {
  return fmt::format(R"(<contact localId="{}" width="{}" height="{}"><position x="{}" y="{}"/><connectionPointIn>)", id,
                     width, height, x, y) +
         (from == 0 ? "" : fmt::format(R"(<connection refLocalId="{}"/>)", from)) +
         "</connectionPointIn><connectionPointOut/><variable>A</variable></contact>";
}

const DrawnElement& element(const DrawnBody& body, std::int64_t id) {
  for (const DrawnElement& e : body.elements) {
    if (e.local_id == id) return e;
  }
  ADD_FAILURE() << "no element " << id;
  static const DrawnElement kNone;
  return kNone;
}

TEST(Places, OfTheFileStayWhereTheyCanBeUsed) {
  const DrawnBody body = ladder(contact(1, 0, 500, 300, 30, 20) + contact(2, 1, 900, 380, 30, 20));
  EXPECT_EQ(element(body, 2).x - element(body, 1).x, 400);
  EXPECT_EQ(element(body, 2).y - element(body, 1).y, 80);
  EXPECT_EQ(wrong_with(body), "");
}

TEST(Places, OfTheFileGoWhereElementsCoverEachOtherOrHaveNoSize) {
  for (const std::string& second : {contact(2, 1, 520, 310, 30, 20), contact(2, 1, 900, 380, 0, 0)}) {
    const DrawnBody body = ladder(contact(1, 0, 500, 300, 30, 20) + second);
    EXPECT_EQ(element(body, 2).y, element(body, 1).y) << "in a row";
    EXPECT_LT(element(body, 1).x + 30, element(body, 2).x);
    EXPECT_EQ(wrong_with(body), "");
    EXPECT_EQ(wrong_with_lines(body), "");
  }
  // Elements that touch do not cover each other.
  const DrawnBody touching = ladder(contact(1, 0, 500, 300, 30, 20) + contact(2, 1, 530, 320, 30, 20));
  EXPECT_EQ(element(touching, 2).y - element(touching, 1).y, 20);
}

TEST(Places, InCellsOfAGridBecomePixels) {
  const DrawnBody body = ladder(contact(1, 0, 10, 3, 4, 2) + contact(2, 1, 20, 3, 4, 2));
  EXPECT_EQ(element(body, 1).height, 18);
  EXPECT_EQ(element(body, 2).x - element(body, 1).x, 90);
  EXPECT_EQ(wrong_with(body), "");
}

TEST(Places, OfTenThousandRungsStay) {
  const DrawnBody body = ladder(contact(1, 0, 500, 0, 30, 20) + contact(2, 0, 500, 600'000, 30, 20));
  EXPECT_EQ(element(body, 2).y - element(body, 1).y, 600'000);
}

TEST(Places, FarOutsideOfAnyPaperAreNone) {
  const DrawnBody body = ladder(contact(1, 0, 0, 0, 30, 20) + contact(2, 1, -2147483648, 999999999, 30, 20));
  EXPECT_LT(element(body, 2).x, 1000);
  EXPECT_EQ(wrong_with(body), "");
}

TEST(Networks, OfTheFileAreBelowEachOtherWithTheirComments) {
  const auto title = [](int id) {
    return fmt::format(
        R"(<comment localId="{0}9" height="0" width="0"><position x="-99999" y="0"/><content><xhtml xmlns="http://www.w3.org/1999/xhtml">about {0}</xhtml></content></comment>
<vendorElement localId="{0}8"><position x="0" y="0"/><alternativeText><xhtml xmlns="http://www.w3.org/1999/xhtml"/></alternativeText>
<addData><data name="http://www.3s-software.com/plcopenxml/fbdelementtype" handleUnknown="implementation"><ElementType xmlns="">networktitle</ElementType></data></addData></vendorElement>)",
        id);
  };
  const DrawnBody body =
      ladder(title(1) + contact(1, 0, 0, 0, 0, 0) + title(2) + title(3) + contact(3, 0, 0, 0, 0, 0) + title(4));
  ASSERT_EQ(body.comments.size(), 4u);
  EXPECT_EQ(element(body, 1).network, 1u);
  EXPECT_EQ(element(body, 3).network, 2u) << "the one between is empty";
  EXPECT_LT(body.comments[0].y, element(body, 1).y);
  EXPECT_LT(element(body, 1).y, body.comments[1].y);
  EXPECT_LT(body.comments[1].y, body.comments[2].y) << "both stand above the next network that has something";
  EXPECT_LT(body.comments[2].y, element(body, 3).y);
  EXPECT_LT(element(body, 3).y, body.comments[3].y);
  for (const DrawnComment& comment : body.comments) EXPECT_LT(comment.x, 200);
}

TEST(Pins, ThatTheFileLeavesOutAreDrawnWhereAWireNamesThem) {
  const DrawnBody body = ladder(
      R"(<block localId="1" typeName="TON" instanceName="T1"><position x="0" y="0"/><inputVariables/><inOutVariables/><outputVariables/></block>
<outVariable localId="2"><position x="0" y="0"/><connectionPointIn><connection refLocalId="1" formalParameter="ET"/></connectionPointIn><expression>x</expression></outVariable>)");
  const DrawnElement& block = element(body, 1);
  ASSERT_EQ(block.pins.size(), 1u);
  EXPECT_EQ(block.pins[0].name, "ET");
  EXPECT_EQ(block.pins[0].pin, 0xffff) << "its number is not known";
  EXPECT_EQ(wrong_with(body), "");
}

TEST(MacroSteps, HaveTheLocalIdsOfTheWholeChart) {
  core::Diagnostics diagnostics;
  const std::string path = (source_root() / "tests/cases/sfc/macro-steps-in-macro-steps/project.xml").string();
  const auto project = compiler::read_project(path, diagnostics);
  ASSERT_TRUE(project);
  const Drawings drawings = drawings::make(*project, diagnostics);
  const DrawnBody& body = drawings.bodies.at(0);
  ASSERT_GE(body.sheets.size(), 3u);
  std::set<std::int64_t> ids;
  for (const DrawnElement& e : body.elements) {
    const bool stands_for_others = e.kind == core::ElementKind::kMacroStep;
    EXPECT_TRUE(stands_for_others || ids.insert(e.local_id).second) << e.local_id << " is there twice";
  }
  // They are those that the compiled chart has.
  core::Diagnostics quiet;
  std::set<std::int64_t> compiled;
  for (const plcopen::Element& e : sfc::expand_macro_steps(project->pous.at(0).bodies.at(0), {}, quiet).elements) {
    compiled.insert(e.at.local_id);
  }
  for (const DrawnElement& e : body.elements) {
    if (e.kind == core::ElementKind::kMacroStep) continue;
    EXPECT_TRUE(compiled.contains(e.local_id)) << e.local_id;
  }
}

TEST(Statements, HaveTheirPlacesInTheFile) {
  core::Diagnostics diagnostics;
  const std::string path = testing::TempDir() + "statements.st";
  {
    std::FILE* const file = std::fopen(path.c_str(), "w");
    ASSERT_NE(file, nullptr);
    std::fputs(
        "PROGRAM Main\nVAR i : INT; a : BOOL; END_VAR\n"
        "IF a THEN\n  i := 1; i := 2;\nELSIF NOT a THEN i := 3;\nELSE\n  CASE i OF 1: i := 4; ELSE i := 5; END_CASE\n"
        "END_IF;\nFOR i := 0 TO 2 DO a := NOT a; END_FOR;\nEND_PROGRAM\n",
        file);
    std::fclose(file);
  }
  const auto project = compiler::read_project(path, diagnostics);
  ASSERT_TRUE(project);
  const Drawings drawings = drawings::make(*project, diagnostics);
  ASSERT_EQ(drawings.bodies.size(), 1u);
  const DrawnBody& body = drawings.bodies[0];
  EXPECT_EQ(body.file, path);
  EXPECT_EQ(body.language, DrawnLanguage::kSt);
  std::string places;
  for (const DrawnStatement& s : body.statements) places += fmt::format("{}:{} ", s.line, s.column);
  EXPECT_EQ(places, "3:1 4:3 4:11 5:18 7:3 7:16 7:29 9:1 9:20 ");
  EXPECT_EQ(body.statements[1].end_line, 4u);
  EXPECT_EQ(body.statements[1].end_column, 9u);
  // The text begins where its place says.
  EXPECT_LE(body.text_line, 3u);
}

TEST(Statements, HaveTheCommentsBeforeThem) {
  core::Diagnostics diagnostics;
  const std::string path = testing::TempDir() + "comments.st";
  {
    std::FILE* const file = std::fopen(path.c_str(), "w");
    ASSERT_NE(file, nullptr);
    std::fputs(
        "PROGRAM Main\nVAR i : INT; END_VAR // the counter\n\n  // What it is for,\n  (* in two\n  lines. *)\n  i := i "
        "+ 1;\n"
        "END_PROGRAM\n// Nothing of Second.\nPROGRAM Second\nVAR i : INT; END_VAR (* a *) (* b *)\n  i := 2; // two\n"
        "END_PROGRAM\nPROGRAM Third\nVAR i : INT; END_VAR\n// No statement.\nEND_PROGRAM\n",
        file);
    std::fclose(file);
  }
  const auto project = compiler::read_project(path, diagnostics);
  ASSERT_TRUE(project);
  const Drawings drawings = drawings::make(*project, diagnostics);
  ASSERT_EQ(drawings.bodies.size(), 2u) << "Third has none";
  const DrawnBody& main = drawings.bodies[0];
  EXPECT_EQ(main.text, "  // What it is for,\n  (* in two\n  lines. *)\n  i := i + 1;");
  EXPECT_EQ(main.text_line, 4u);
  EXPECT_EQ(main.text_column, 1u);
  ASSERT_EQ(main.statements.size(), 1u);
  EXPECT_EQ(main.statements[0].line, 7u);
  EXPECT_EQ(main.statements[0].column, 3u);
  EXPECT_EQ(bytecode::DrawnLines(main).name_at(7, 8), "i");
  const DrawnBody& second = drawings.bodies[1];
  EXPECT_EQ(second.text, "i := 2; // two") << "what stands behind declarations is about those";
  EXPECT_EQ(second.text_line, 12u);
}

}  // namespace
}  // namespace plc::test
