// What a ladder reports: codes and the words that name the element; nothing twice for one mistake. And the order as
// `plc explain` shows it.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/frontend-ld/ladder.h"

namespace plc {
namespace {

using test::after_a;
using test::Ladder;
using test::Sketch;

constexpr const char* kVariables =
    "A, B, X, Y : BOOL; n : INT; s : STRING; t : TON; q0 AT %QX0.0 : BOOL; q1 AT %QX0.0 : BOOL; END_VAR "
    "VAR CONSTANT k : BOOL := TRUE;";

struct Wrong {
  const char* name;
  void (*draw)(Sketch&);
  const char* codes;
  const char* words;  ///< of the first message and its help
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class Reports : public testing::TestWithParam<Wrong> {};

TEST_P(Reports, WithCodeAndName) {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1");
  GetParam().draw(s);
  Ladder d(kVariables, s);
  EXPECT_EQ(d.codes(), GetParam().codes) << d.message();
  EXPECT_NE(d.message().find(GetParam().words), std::string::npos) << d.message();
}

INSTANTIATE_TEST_SUITE_P(
    Ladder, Reports,
    testing::Values(
        Wrong{"ContactWithoutWire",
              [](Sketch& s) {
                s.contact(3, "B", "");
                s.coil(4, "Y", "3");
              },
              "P2001", "contact \"B\" is not connected"},
        Wrong{"CoilWithoutWire", [](Sketch& s) { s.coil(3, "Y", ""); }, "P2001 P3016", "coil \"Y\" is not connected"},
        Wrong{"ActionBlockWithoutWire",
              [](Sketch& s) {
                s.actions(3, "", {"N Y", "L X T#1s"});
              },
              "P2001 P3016", "actionBlock \"N Y, L X\" is not connected"},
        Wrong{"WireFromNowhere", [](Sketch& s) { s.coil(3, "Y", "99"); }, "P3001 P2001 P3016", "localId 99"},
        Wrong{"WireFromARightRail",
              [](Sketch& s) {
                s.right_rail(3, "2");
                s.coil(4, "Y", "3|2");
              },
              "P3003", "rightPowerRail 3"},
        Wrong{"ContactWithoutName",
              [](Sketch& s) {
                s.contact(3, "", "2");
                s.coil(4, "Y", "3");
              },
              "P3014", "contact names no variable"},
        Wrong{"CoilWithoutName", [](Sketch& s) { s.coil(3, "", "2"); }, "P3014", "coil names no variable"},
        Wrong{"ContactOnANumber",
              [](Sketch& s) {
                s.contact(3, "n", "2");
                s.coil(4, "Y", "3");
              },
              "P2003", "contact \"n\" has type INT, a contact is BOOL"},
        Wrong{"CoilOnAText", [](Sketch& s) { s.coil(3, "s", "2"); }, "P2003", "coil \"s\" has type STRING"},
        Wrong{"UnknownContactIsReportedOnceForAllAfterIt",
              [](Sketch& s) {
                s.contact(3, "nothing", "2");
                s.contact(4, "B", "3");
                s.coil(5, "X", "4");
                s.coil(6, "Y", "4");
              },
              "P4004", "there is no variable \"nothing\""},
        Wrong{"CoilOnAConstant", [](Sketch& s) { s.coil(3, "k", "2"); }, "P4007",
              "\"k\" is a constant and is written here"},
        Wrong{"CoilOnAnExpression", [](Sketch& s) { s.coil(3, "X OR Y", "2"); }, "P4006",
              "\"X OR Y\" is not a variable"},
        Wrong{"PowerFromANumber",
              [](Sketch& s) {
                s.block(3, "ADD", "IN1:=n IN2:=1", "OUT");
                s.coil(4, "Y", "3.OUT");
              },
              "P4101", "power flow into coil \"Y\""},
        Wrong{"TwoCoils",
              [](Sketch& s) {
                s.coil(3, "Y", "2");
                s.coil(4, "y", "1");
              },
              "P2002", "driven by 2 coils: 3 (line 3), 4 (line 4)"},
        Wrong{"CoilsOfOneAddress",
              [](Sketch& s) {
                s.coil(3, "q0", "2");
                s.coil(4, "q1", "1");
              },
              "P2002", "variable at %QX0.0 is driven by 2 coils under several names: \"q0\" 3"},
        Wrong{"JumpWithoutLabel", [](Sketch& s) { s.jump(3, "there", "2"); }, "P3015", "jump to label \"there\""},
        Wrong{"LabelTwice",
              [](Sketch& s) {
                s.label(3, "here");
                s.label(4, "Here");
              },
              "P3015", "label \"Here\" is drawn twice"},
        Wrong{"NegationWithAnEdge",
              [](Sketch& s) {
                s.contact(3, "!^B", "2");
                s.coil(4, "Y", "3");
              },
              "P3027", "contact \"B\" has negation and a rising edge"},
        Wrong{"FallingEdges",
              [](Sketch& s) {
                s.contact(3, "~B", "2");
                s.coil(4, "~Y", "3");
              },
              "P3028", "falling edge of contact \"B\" and 1 more"},
        Wrong{"PowerThatDependsOnItself",
              [](Sketch& s) {
                s.contact(3, "B", "4");
                s.contact(4, "A", "3");
                s.coil(5, "Y", "4");
              },
              "P3006", "power flow cannot depend on itself"},
        Wrong{"NothingThatActs", [](Sketch& s) { s.contact(3, "B", "2"); }, "P3016", "wire the blocks to coils"},
        Wrong{"ElementsWithoutAnyWire", [](Sketch& s) { s.coil(3, "Y", ""); }, "P2001 P3016", "not connected"}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(Reports, ThatRailsAloneDrawNothing) {
  Sketch s;
  s.rail(1);
  s.right_rail(2, "1");
  Ladder d("A : BOOL;", s);
  EXPECT_EQ(d.codes(), "P3017");
  EXPECT_TRUE(d.pou().compiled) << "a warning: the rest of the project runs";
}

TEST(Reports, ThatNothingIsWiredWhereThatIsWhyNothingHappens) {
  Sketch s;
  s.contact(1, "A", "");
  Ladder d("A : BOOL;", s);
  EXPECT_EQ(d.codes(), "P2001 P3016");
  EXPECT_EQ(d.diagnostics.all().back().help, "nothing is wired: connect the elements");
}

TEST(Reports, NoFallingEdgeToWhomTheStandardIsEnough) {
  Sketch s;
  s.rail(1);
  s.contact(2, "~A", "1");
  s.coil(3, "Y", "2");
  Ladder strict("A, Y : BOOL;", s);
  strict.options.strict = true;
  EXPECT_EQ(strict.codes(), "");
  Ladder beremiz("A, Y : BOOL;", s);
  beremiz.options.compat = core::Compat::kBeremiz;
  EXPECT_EQ(beremiz.codes(), "");
}

TEST(Reports, ErrorsKeepThePouFromBeingCompiled) {
  Sketch s = after_a();
  s.coil(3, "", "2");
  s.coil(4, "Y", "2");
  Ladder d("A, Y : BOOL;", s);
  EXPECT_FALSE(d.pou().compiled);
  EXPECT_EQ(d.codes(), "P3014");
}

TEST(Reports, UnconnectedElementsLeaveThePouPartial) {
  Sketch s = after_a();
  s.coil(3, "Y", "2");
  s.coil(4, "X", "");
  Ladder d("A, X, Y : BOOL;", s);
  EXPECT_TRUE(d.pou().partial);
  EXPECT_EQ(d.scan("A=1 X=1", "X Y"), "1 1") << "X keeps its value";
}

TEST(Reports, PowerAfterAnUnconnectedContactIsFalse) {
  Sketch s;
  s.contact(1, "A", "");
  s.coil(2, "Y", "1");
  Ladder d("A : BOOL; Y : BOOL := TRUE;", s);
  EXPECT_EQ(d.scan("A=1", "Y"), "0");
}

// The file has the writer of Y below its reader, the drawing above it.
Sketch read_above_write() {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1").y = 50;
  s.coil(3, "M", "2").y = 50;
  s.contact(4, "M", "1").y = 10;
  s.coil(5, "Y", "4").y = 10;
  return s;
}

TEST(Order, ThatMattersIsReportedAndSwitched) {
  Ladder drawing("A, M, Y : BOOL;", read_above_write());
  EXPECT_EQ(drawing.codes(), "P3018");
  EXPECT_NE(drawing.message().find("\"M\" is read by contact 4 and then written by coil 3; in document order"),
            std::string::npos)
      << drawing.message();
  EXPECT_EQ(drawing.over("A", "1 1 0 0", "Y"), "0 1 1 0");
  Ladder document("A, M, Y : BOOL;", read_above_write());
  document.options.order = core::Order::kDocument;
  EXPECT_EQ(document.codes(), "P3018");
  EXPECT_NE(document.message().find("written by coil 3 and then read by contact 4; in drawing order"),
            std::string::npos)
      << document.message();
  EXPECT_EQ(document.over("A", "1 1 0 0", "Y"), "1 1 0 0");
}

TEST(Order, OfASealInIsTheSameEverywhere) {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1");
  s.contact(3, "Y", "1");
  s.coil(4, "Y", "2|3");
  EXPECT_EQ(Ladder("A, Y : BOOL;", s).codes(), "");
}

// ---- explain ------------------------------------------------------------------------------------------------------

std::string explained(const Sketch& sketch, core::Order rule = core::Order::kDrawing) {
  const plcopen::Body body = sketch.body();
  std::string text;
  for (const ld::OrderLine& line : ld::explain_order(body, rule)) {
    text += std::to_string(line.network) + ": " + std::to_string(line.at.local_id);
    if (!line.text.empty()) text += " [" + line.text + "]";
    text += " " + std::string(fbd::reason_text(line.reason));
    if (line.with.local_id >= 0) text += " " + std::to_string(line.with.local_id);
    for (const std::int64_t id : line.feedback_from) text += " <- " + std::to_string(id);
    text += "\n";
  }
  return text;
}

TEST(Explain, NamesElementsAndReasons) {
  Sketch s;
  s.rail(1);
  s.contact(2, "M", "1").y = 10;
  s.coil(3, "Y", "2").y = 10;
  s.contact(4, "A", "1").y = 50;
  s.coil(5, "M", "4").y = 50;
  s.actions(6, "4", {"N Lamp", "L Horn T#1s", "P - {n := 1;}"}).y = 70;
  EXPECT_EQ(explained(s),
            "0: 1 position\n"
            "1: 2 [M] read for 3\n"
            "1: 3 [Y] position\n"
            "2: 4 [A] read for 5\n"
            "2: 5 [M] position\n"
            "2: 6 [N Lamp, L Horn, P ST] position\n");
}

TEST(Explain, ShowsFeedbackInstancesAndTargets) {
  Sketch s;
  s.block(1, "CTU count", "CU=2 RESET=1.Q PV:=3", "Q CV=>seen");
  s.in(2, "A");
  s.out(3, "Y", "1.Q");
  EXPECT_EQ(explained(s),
            "1: 2 [A] read for 1\n"
            "1: 1 [CTU count, CV => seen] first of a loop: its feedback wires carry the previous scan <- 1\n"
            "1: 3 [Y] written with 1\n");
}

TEST(Explain, FollowsTheRuleAskedFor) {
  const std::string drawing = explained(read_above_write());
  const std::string document = explained(read_above_write(), core::Order::kDocument);
  EXPECT_LT(drawing.find("5 [Y]"), drawing.find("3 [M]"));
  EXPECT_LT(document.find("3 [M] document order"), document.find("5 [Y] document order"));
}

}  // namespace
}  // namespace plc
