// Rails, contacts, coils and the power between them: what a rung leaves in its coils, scan by scan, and how few
// instructions it takes.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <vector>

#include "tests/unit/frontend-ld/ladder.h"

namespace plc {
namespace {

using ir::Op;
using test::after_a;
using test::Ladder;
using test::Sketch;

// ---- contacts -----------------------------------------------------------------------------------------------------

struct Modified {
  const char* text;      ///< as a Sketch writes it
  const char* expected;  ///< scan by scan
};

class Contacts : public testing::TestWithParam<Modified> {};

TEST_P(Contacts, PassPowerAsTheirModifiersSay) {
  Sketch s;
  s.rail(1);
  s.contact(2, GetParam().text, "1");
  s.coil(3, "Y", "2");
  Ladder d("A, Y : BOOL;", s);
  EXPECT_EQ(d.over("A", "0 1 1 0 0 1", "Y"), GetParam().expected) << GetParam().text;
}

// Negation, then the edge, then storage. The memory of an edge begins FALSE.
INSTANTIATE_TEST_SUITE_P(Modifiers, Contacts,
                         testing::Values(Modified{"A", "0 1 1 0 0 1"}, Modified{"!A", "1 0 0 1 1 0"},
                                         Modified{"^A", "0 1 0 0 0 1"}, Modified{"~A", "0 0 0 1 0 0"},
                                         Modified{"!^A", "1 0 0 1 0 0"}, Modified{"!~A", "0 1 0 0 0 1"},
                                         Modified{"(S)A", "0 1 1 1 1 1"}, Modified{"(R)A", "0 0 0 0 0 0"},
                                         Modified{"!(S)A", "1 1 1 1 1 1"}, Modified{"~(S)A", "0 0 0 1 1 1"}));

class BeremizContacts : public testing::TestWithParam<Modified> {};

TEST_P(BeremizContacts, HaveTheEdgesOfItsCode) {
  Sketch s;
  s.rail(1);
  s.contact(2, GetParam().text, "1");
  s.coil(3, "Y", "2");
  Ladder d("A, Y : BOOL;", s);
  d.options.compat = core::Compat::kBeremiz;
  EXPECT_EQ(d.over("A", "0 1 1 0 0 1", "Y"), GetParam().expected) << GetParam().text;
}

// F_TRIG fires in the first scan; beside a negation the edge is left out.
INSTANTIATE_TEST_SUITE_P(Modifiers, BeremizContacts,
                         testing::Values(Modified{"^A", "0 1 0 0 0 1"}, Modified{"~A", "1 0 0 1 0 0"},
                                         Modified{"!^A", "1 0 0 1 1 0"}, Modified{"!~A", "1 0 0 1 1 0"}));

TEST(Contact, SeesItsEdgeWithoutPower) {
  Sketch s = after_a();
  s.contact(3, "^B", "2");
  s.coil(4, "Y", "3");
  Ladder d("A, B, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=0 B=1", "Y"), "0");
  EXPECT_EQ(d.scan("A=1", "Y"), "0") << "the edge is over when power comes";
  EXPECT_EQ(d.scan("B=0", "Y"), "0");
  EXPECT_EQ(d.scan("B=1", "Y"), "1");
}

TEST(Contact, MayNameAnExpression) {
  Sketch s;
  s.rail(1);
  s.contact(2, "n > 3 AND w.1", "1");
  s.coil(3, "Y", "2");
  Ladder d("n : INT; w : WORD; Y : BOOL;", s);
  EXPECT_EQ(d.scan("n=4 w=1", "Y"), "0");
  EXPECT_EQ(d.scan("n=4 w=2", "Y"), "1");
  EXPECT_EQ(d.scan("n=3", "Y"), "0");
}

TEST(Contact, OfOneScanHasOneValueForAllCoils) {
  const auto drawn = [] {
    Sketch s = after_a();
    s.coil(3, "(R)A", "2");
    s.coil(4, "Y", "2");
    return s;
  };
  Ladder d("A, Y : BOOL;", drawn());
  EXPECT_EQ(d.scan("A=1", "A Y"), "0 1");
  Ladder beremiz("A, Y : BOOL;", drawn());
  beremiz.options.compat = core::Compat::kBeremiz;
  EXPECT_EQ(beremiz.scan("A=1", "A Y"), "0 0") << "the contact is read again for the second coil";
}

TEST(Contact, WithAnEdgeIsNotEvaluatedAgainForBeremiz) {
  Sketch s;
  s.rail(1);
  s.contact(2, "^A", "1");
  s.coil(3, "X", "2");
  s.coil(4, "Y", "2");
  Ladder d("A, X, Y : BOOL;", s);
  d.options.compat = core::Compat::kBeremiz;
  EXPECT_EQ(d.over("A", "0 1 1", "Y"), "0 1 0");
  EXPECT_EQ(d.hidden(), "#edge.A.3");
}

// ---- coils --------------------------------------------------------------------------------------------------------

struct CoilRow {
  const char* text;
  const char* initial;
  const char* expected;
};

class Coils : public testing::TestWithParam<CoilRow> {};

TEST_P(Coils, StoreAsTheirModifiersSay) {
  Sketch s = after_a();
  s.coil(3, GetParam().text, "2");
  Ladder d("A : BOOL; Y : BOOL := " + std::string(GetParam().initial) + ";", s);
  EXPECT_EQ(d.over("A", "0 1 1 0 0 1", "Y"), GetParam().expected) << GetParam().text;
}

INSTANTIATE_TEST_SUITE_P(Modifiers, Coils,
                         testing::Values(CoilRow{"Y", "TRUE", "0 1 1 0 0 1"}, CoilRow{"!Y", "FALSE", "1 0 0 1 1 0"},
                                         CoilRow{"(S)Y", "FALSE", "0 1 1 1 1 1"},
                                         CoilRow{"(R)Y", "TRUE", "1 0 0 0 0 0"}, CoilRow{"^Y", "FALSE", "0 1 0 0 0 1"},
                                         CoilRow{"~Y", "FALSE", "0 0 0 1 0 0"}, CoilRow{"!^Y", "FALSE", "1 0 0 1 0 0"},
                                         CoilRow{"!~Y", "FALSE", "0 1 0 0 0 1"},
                                         CoilRow{"~(S)Y", "FALSE", "0 0 0 1 1 1"},
                                         CoilRow{"!(R)Y", "TRUE", "0 0 0 0 0 0"},
                                         CoilRow{"^(R)Y", "TRUE", "1 0 0 0 0 0"}));

TEST(Coil, IsTransparent) {
  Sketch s = after_a();
  s.coil(3, "!X", "2");
  s.contact(4, "B", "3");
  s.coil(5, "Y", "4");
  Ladder d("A, B, X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1 B=1", "X Y"), "0 1") << "the flow after a coil is not what it stores";
  EXPECT_EQ(d.scan("A=0", "X Y"), "1 0");
}

TEST(Coil, WritesAnElementOfAnArrayChosenByAnExpression) {
  Sketch s = after_a();
  s.coil(3, "list[i + 1]", "2");
  Ladder d("A : BOOL; i : INT; list : ARRAY [1..3] OF BOOL;", s);
  EXPECT_EQ(d.scan("A=1 i=1", "list"), "[0, 1, 0]");
  EXPECT_EQ(d.scan("A=0 i=1", "list"), "[0, 0, 0]");
}

TEST(Coil, SetWritesNothingWithoutPowerButKeepsWhatOthersWrote) {
  Sketch s = after_a();
  s.coil(3, "(S)Y", "2");
  s.contact(4, "B", "1");
  s.coil(5, "(R)Y", "4");
  Ladder d("A, B, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1 B=1", "Y"), "0") << "the lower coil comes last";
  EXPECT_EQ(d.scan("B=0", "Y"), "1");
  EXPECT_EQ(d.scan("A=0", "Y"), "1");
  EXPECT_EQ(d.scan("B=1", "Y"), "0");
  EXPECT_EQ(d.codes(), "") << "set and reset coils of one variable belong together";
}

// ---- power --------------------------------------------------------------------------------------------------------

TEST(Power, OfARailIsTrueAndOneRailServesAll) {
  Sketch s;
  s.rail(1);
  s.coil(2, "X", "1");
  s.coil(3, "!Y", "1");
  s.right_rail(4, "2|3");
  Ladder d("X : BOOL; Y : BOOL := TRUE;", s);
  EXPECT_EQ(d.scan("", "X Y"), "1 0");
  EXPECT_EQ(d.codes(), "");
}

TEST(Power, WiresThatMeetAreOr) {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1");
  s.contact(3, "B", "1");
  s.contact(4, "C", "2|3");
  s.coil(5, "Y", "4|3");
  Ladder d("A, B, C, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1 B=0 C=1", "Y"), "1");
  EXPECT_EQ(d.scan("C=0", "Y"), "0");
  EXPECT_EQ(d.scan("B=1", "Y"), "1");
}

TEST(Power, ConnectionPointsOfOneElementAreOr) {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1");
  s.contact(3, "B", "1");
  auto& coil = s.coil(4, "Y", "2");
  test::BodyBuilder::feed(coil, {3});
  Ladder d("A, B, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=0 B=1", "Y"), "1");
  EXPECT_EQ(d.scan("A=1 B=0", "Y"), "1");
  EXPECT_EQ(d.scan("A=0", "Y"), "0");
}

// A in front of both branches is evaluated once: A AND (B OR C) AND D.
TEST(Power, OfBranchesIsTakenOutOfThem) {
  Sketch s = after_a();
  s.contact(3, "B", "2");
  s.contact(4, "C", "2");
  s.contact(5, "D", "3|4");
  s.coil(6, "Y", "5");
  Ladder d("A, B, C, D, Y : BOOL;", s);
  const std::string listing = d.listing();
  EXPECT_NE(listing.find("%7 := load D\n%8 := %3 or %5\n%9 := %2 and %8\n%10 := %9 and %7\nstore Y := %10\n"),
            std::string::npos)
      << listing << "%2 is A, %3 is B, %5 is C";
  EXPECT_EQ(d.count(Op::kOr), 1u);
}

TEST(Power, PastAContactMakesTheContactMeaningless) {
  Sketch s = after_a();
  s.contact(3, "B", "2");
  s.coil(4, "Y", "2|3");
  Ladder d("A, B, Y : BOOL;", s);
  EXPECT_EQ(d.count(Op::kOr), 0u) << d.listing();
  EXPECT_EQ(d.scan("A=1 B=0", "Y"), "1");
}

TEST(Power, OfASealInIsWhatTheCoilHeldBefore) {
  Sketch s;
  s.rail(1);
  s.contact(2, "Start", "1");
  s.contact(3, "Y", "1");
  s.contact(4, "!Stop", "2|3");
  s.coil(5, "Y", "4");
  Ladder d("Start, Stop, Y : BOOL;", s);
  EXPECT_EQ(d.scan("Start=1", "Y"), "1");
  EXPECT_EQ(d.scan("Start=0", "Y"), "1");
  EXPECT_EQ(d.scan("Stop=1", "Y"), "0");
  EXPECT_EQ(d.scan("Stop=0", "Y"), "0");
}

/// Random nets of contacts against a direct walk over them, for every combination of four variables.
TEST(Power, ThroughRandomNetsIsThatOfAWalk) {
  std::mt19937 random(23);
  for (int round = 0; round < 60; ++round) {
    Sketch s;
    s.rail(1);
    struct Node {
      unsigned variable = 0;
      bool negated = false;
      std::vector<std::size_t> from;  ///< 0: the rail
    };
    std::vector<Node> nodes(1);
    const auto some = [&](std::size_t below) {
      std::vector<std::size_t> from;
      for (unsigned i = 0; i <= random() % 3; ++i) from.push_back(random() % below);
      return from;
    };
    const auto wires = [](const std::vector<std::size_t>& from) {
      std::string text;
      for (const std::size_t one : from) text += (text.empty() ? "" : "|") + std::to_string(one + 1);
      return text;
    };
    const std::size_t contacts = 2 + random() % 9;
    for (std::size_t n = 1; n <= contacts; ++n) {
      nodes.push_back({static_cast<unsigned>(random() % 4), random() % 2 == 0, some(n)});
      const std::string name(1, static_cast<char>('A' + nodes[n].variable));
      s.contact(static_cast<std::int64_t>(n + 1), (nodes[n].negated ? "!" : "") + name, wires(nodes[n].from));
    }
    const std::vector<std::size_t> end = some(nodes.size());
    s.coil(99, "Y", wires(end));
    Ladder d("A, B, C, D, Y : BOOL;", s);
    for (unsigned bits = 0; bits < 16; ++bits) {
      std::vector<bool> power(1, true);
      const auto joined = [&](const std::vector<std::size_t>& from) {
        bool any = false;
        for (const std::size_t one : from) any = any || power[one];
        return any;
      };
      for (std::size_t n = 1; n < nodes.size(); ++n) {
        power.push_back(joined(nodes[n].from) && ((bits >> nodes[n].variable & 1) != 0) != nodes[n].negated);
      }
      std::string inputs;
      for (unsigned v = 0; v < 4; ++v) {
        inputs += std::string(1, static_cast<char>('A' + v)) + (bits >> v & 1 ? "=1 " : "=0 ");
      }
      ASSERT_EQ(d.scan(inputs, "Y"), joined(end) ? "1" : "0") << inputs << "\n" << d.listing();
    }
  }
}

TEST(Power, AfterBlocksIsWhatTheirPinGives) {
  Sketch s = after_a();
  s.block(3, "TON t", "IN=2 PT:=T#20ms", "Q");
  s.contact(4, "B", "3.Q");
  s.coil(5, "Y", "4");
  Ladder d("A, B, Y : BOOL; t : TON;", s);
  EXPECT_EQ(d.scan("A=1 B=1", "Y"), "0");
  EXPECT_EQ(d.scan("", "Y"), "0");
  EXPECT_EQ(d.scan("", "Y"), "1");
}

// ---- the IR of a rung, as a golden text ---------------------------------------------------------------------------

TEST(Rung, AsInstructions) {
  Sketch s;
  s.rail(1);
  s.contact(2, "A", "1");
  s.contact(3, "!B", "2");
  s.coil(4, "Y", "3");
  s.coil(5, "(S)Z", "3");
  Ladder d("A, B, Y, Z : BOOL;", s);
  EXPECT_EQ(d.listing(),
            "%0 := TRUE\n"
            "%1 := load A\n"
            "%2 := %0 and %1\n"
            "%3 := load B\n"
            "%4 := not %3\n"
            "%5 := %2 and %4\n"
            "store Y := %5\n"
            "%7 := load Z\n"
            "%8 := %7 or %5\n"
            "store Z := %8\n");
}

// ---- jumps --------------------------------------------------------------------------------------------------------

TEST(Jump, SkipsRungsWhileItHasPower) {
  Sketch s = after_a();
  s.jump(3, "L", "2");
  s.coil(4, "X", "1");
  s.label(5, "L");
  s.coil(6, "Y", "1");
  Ladder d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1", "X Y"), "0 1");
  EXPECT_EQ(d.scan("A=0", "X Y"), "1 1");
}

TEST(Jump, WithoutAWireIsTakenAlways) {
  Sketch s;
  s.rail(1);
  s.jump(2, "end");
  s.coil(3, "X", "1");
  s.label(4, "END");
  s.coil(5, "Y", "1");
  Ladder d("X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("", "X Y"), "0 1") << "labels are the same in any letter case";
}

TEST(Jump, BackwardsLoopsInOneScan) {
  Sketch s;
  s.rail(1);
  s.label(2, "again");
  s.block(3, "ADD", "IN1:=n IN2:=1", "OUT=>n");
  s.block(4, "LT", "IN1:=n IN2:=limit", "OUT");
  s.jump(5, "again", "4.OUT");
  Ladder d("n, limit : INT;", s);
  EXPECT_EQ(d.scan("limit=7", "n"), "7");
  EXPECT_EQ(d.scan("", "n"), "8");
}

TEST(Return, EndsTheBodyWithPowerOnly) {
  Sketch s = after_a();
  s.ret(3, "2");
  s.coil(4, "X", "1");
  s.ret(5);
  s.coil(6, "Y", "1");
  Ladder d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1", "X Y"), "0 0");
  EXPECT_EQ(d.scan("A=0", "X Y"), "1 0");
}

}  // namespace
}  // namespace plc
