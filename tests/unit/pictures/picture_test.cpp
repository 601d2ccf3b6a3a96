// Pictures: any text whatever stays well-formed, looks are drawn, golden pictures of a few bodies.
#include "pictures/picture.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "compiler/compile.h"
#include "drawings/make.h"
#include "tests/support/golden.h"

namespace plc::test {
namespace {

using namespace bytecode;
using pictures::Look;
using pictures::Marks;

TEST(Escaped, AnyBytesStandInXml) {
  EXPECT_EQ(pictures::escaped("a < b & \"c\" > d"), "a &lt; b &amp; &quot;c&quot; &gt; d");
  EXPECT_EQ(pictures::escaped("\xc3\xa4\xe6\xb0\xb4\xf0\x9f\x98\x80"), "\xc3\xa4\xe6\xb0\xb4\xf0\x9f\x98\x80");
  const std::string r = "\xef\xbf\xbd";
  EXPECT_EQ(pictures::escaped(std::string("a\0b\x1b", 4)), "a" + r + "b" + r);
  EXPECT_EQ(pictures::escaped("\t\n"), "  ");
  EXPECT_EQ(pictures::escaped("\xff\xc3"), r + r) << "no UTF-8, and cut off";
  EXPECT_EQ(pictures::escaped("\xed\xa0\x80"), r) << "half of a pair";
  EXPECT_EQ(pictures::escaped("\xc0\xaf"), r + r) << "longer than it need be";
  EXPECT_EQ(pictures::escaped("\xef\xbf\xbe"), r) << "no character";
  EXPECT_EQ(pictures::escaped("\xf5\x80\x80\x80"), r + r + r + r) << "beyond Unicode";
}

/// The drawings of a project of this repository.
Drawings drawings_of(const std::string& path) {
  core::Diagnostics diagnostics;
  const auto project = compiler::read_project((source_root() / path).string(), diagnostics);
  return project ? drawings::make(*project, diagnostics) : Drawings{};
}

std::string picture(const Drawings& drawings, const Marks& marks = {}) {
  std::vector<pictures::PicturedBody> bodies;
  for (const DrawnBody& body : drawings.bodies) bodies.push_back({&body, body.name, 0});
  return pictures::svg("Test", bodies, marks);
}

TEST(Picture, GoldenPictures) {
  for (const auto& [name, path] : {std::pair("ladder", "tests/cases/ld/parallel-branches-into-one-coil/project.xml"),
                                   std::pair("blocks", "tests/cases/fbd/latch-out-of-two-gates/project.xml"),
                                   std::pair("modifiers", "tests/cases/fbd/edges-at-pins/project.xml"),
                                   std::pair("chart", "tests/cases/sfc/choice-in-simultaneous/project.st"),
                                   std::pair("macro", "tests/cases/sfc/a-macro-step-stands-for-its-chart/project.xml"),
                                   std::pair("box", "tests/cases/fbd/execute-box-runs-st-under-en/project.xml")}) {
    const Drawings drawings = drawings_of(path);
    ASSERT_FALSE(drawings.bodies.empty()) << path;
    expect_golden(std::string("tests/golden/pictures/") + name + ".svg", picture(drawings));
  }
}

/// A rung: rail, contact, coil.
Drawings rung() {
  const auto element = [](core::ElementKind kind, std::int64_t id, std::int32_t x, const char* text) {
    DrawnElement e;
    e.kind = kind;
    e.local_id = id;
    e.line = 7;
    e.x = x;
    e.y = 40;
    e.width = 30;
    e.height = 20;
    e.text = text;
    e.pins = {{"", "", false, 0, {}, {x, 50}}, {"", "", true, 0, {}, {x + 30, 50}}};
    return e;
  };
  DrawnBody body;
  body.name = "Main";
  body.sheets = {"Main"};
  body.elements = {element(core::ElementKind::kLeftRail, 1, 0, ""),
                   element(core::ElementKind::kContact, 2, 60, "Start"),
                   element(core::ElementKind::kCoil, 3, 120, "Run")};
  body.wires = {{0, 1, 1, 0, {{30, 50}, {60, 50}}}, {1, 1, 2, 0, {{90, 50}, {120, 50}}}};
  return {{body}};
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(Picture, ShowsWhatIsKnownOfEachPlace) {
  const Drawings drawings = rung();
  const DrawnElement& contact = drawings.bodies[0].elements[1];
  const DrawnElement& coil = drawings.bodies[0].elements[2];
  const std::string plain = picture(drawings);
  EXPECT_EQ(count(plain, "class=\"wire\""), 2u);
  Marks marks;
  marks[key_of(0, drawings.bodies[0].elements[0], drawings.bodies[0].elements[0].pins[1])] = {Look::kOn, ""};
  marks[key_of(0, contact)] = {Look::kOn, "TRUE"};
  marks[key_of(0, coil, coil.pins[0])] = {Look::kOff, "0"};
  const std::string shown = picture(drawings, marks);
  EXPECT_EQ(count(shown, "<polyline class=\"wire on\" points=\"30,68 60,68\"/>"), 1u) << "by the output it comes from\n"
                                                                                      << shown;
  EXPECT_EQ(count(shown, "<polyline class=\"wire off\""), 1u) << "by the input it leads to";
  EXPECT_EQ(count(shown, "<path class=\"shape on\""), 1u);
  EXPECT_NE(shown.find("<title>contact Start, on, TRUE (line 7, 2)</title>"), std::string::npos) << shown;
  EXPECT_NE(shown.find("class=\"value on\">TRUE</text>"), std::string::npos);
  EXPECT_NE(shown.find("class=\"value\">0</text>"), std::string::npos);
  // A value that both ends of a wire have stands at its output alone.
  Marks both;
  both[key_of(0, contact, contact.pins[1])] = {Look::kOn, "17"};
  both[key_of(0, coil, coil.pins[0])] = {Look::kOn, "17"};
  EXPECT_EQ(count(picture(drawings, both), ">17</text>"), 1u);
  both[key_of(0, coil, coil.pins[0])].text = "18";
  EXPECT_EQ(count(picture(drawings, both), ">18</text>"), 1u);
  // Marks of another POU are not its own.
  Marks others;
  for (const auto& [key, mark] : marks) {
    DrawnKey other = key;
    other.pou = 1;
    others[other] = mark;
  }
  EXPECT_EQ(picture(drawings, others), plain);
}

TEST(Picture, HostileNamesStayTexts) {
  Drawings drawings = rung();
  const std::string hostile = "</text></svg><script>alert('x')</script>\" onload=\"y\x1b\xff";
  for (DrawnElement& e : drawings.bodies[0].elements) {
    e.text = e.instance = e.code = hostile;
    e.actions = {{hostile, hostile, hostile, hostile, 1, 1}};
    for (DrawnPin& pin : e.pins) pin.name = pin.text = hostile;
  }
  drawings.bodies[0].comments = {{hostile, 0, 0, 0, 10, 10}};
  for (int kind = 0; kind <= static_cast<int>(core::kLastElementKind); ++kind) {
    drawings.bodies[0].elements[1].kind = static_cast<core::ElementKind>(kind);
    const pictures::PicturedBody body{&drawings.bodies[0], hostile, 0};
    const std::string text =
        pictures::svg(hostile, {&body, 1}, {{key_of(0, drawings.bodies[0].elements[1]), {Look::kOn, hostile}}});
    EXPECT_EQ(text.find("<script"), std::string::npos) << kind;
    EXPECT_EQ(text.find("\" onload"), std::string::npos) << kind;
    EXPECT_EQ(text.find('\x1b'), std::string::npos) << kind;
    EXPECT_EQ(text.find('\xff'), std::string::npos) << kind;
    EXPECT_EQ(count(text, "<svg"), 1u);
    EXPECT_EQ(count(text, "<g "), count(text, "</g>"));
  }
}

TEST(Picture, TextsShowWhatWasReachedAndValues) {
  DrawnBody body;
  body.name = "Calc";
  body.language = DrawnLanguage::kSt;
  body.text = "IF a THEN\r\n\tb := c;\nEND_IF;";
  body.text_line = 9;
  body.text_column = 1;
  body.statements = {{9, 1, 11, 7}, {10, 2, 10, 8}};
  Marks marks;
  marks[key_of(0, body.statements[0])] = {Look::kOn, ""};
  marks[key_of(0, body.statements[1])] = {Look::kNotRun, ""};
  marks[{0, -1, 9, 4, 0, DrawnSide::kOutput}] = {Look::kPlain, "a = FALSE"};
  const pictures::PicturedBody one{&body, "", 0};
  const std::string text = pictures::svg("Calc", {&one, 1}, marks);
  EXPECT_NE(text.find(">IF a THEN</text>"), std::string::npos) << text;
  EXPECT_NE(text.find(">a = FALSE</text>"), std::string::npos);
  EXPECT_NE(text.find("class=\"quiet\">    b := c;</text>"), std::string::npos);
  EXPECT_EQ(count(text, "class=\"shape on\""), 1u);
  EXPECT_EQ(count(text, "class=\"shape notrun\""), 1u);
  EXPECT_NE(text.find(">11</text>"), std::string::npos) << "lines are those of the file";
  // Nothing at all is a picture, too.
  EXPECT_NE(pictures::svg("Empty", {}).find("</svg>"), std::string::npos);
}

}  // namespace
}  // namespace plc::test
