// Action blocks: what each qualifier does with power, scan by scan every 10 ms, to variables and to ST; what R undoes;
// what cannot be executed.
#include "frontend-ld/action_block.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/unit/frontend-ld/ladder.h"

namespace plc {
namespace {

using test::after_a;
using test::Ladder;
using test::Sketch;

using Actions = std::vector<std::string>;

Sketch block_of(const Actions& actions) {
  Sketch s = after_a();
  s.actions(3, "2", actions);
  return s;
}

struct Row {
  const char* action;
  const char* power;
  const char* variable;  ///< Y after each scan
  const char* runs;      ///< of the same as ST: n after each scan, which counts the scans in which it is active
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.action; }

class Qualifiers : public testing::TestWithParam<Row> {};

TEST_P(Qualifiers, DriveAVariable) {
  const Row& row = GetParam();
  std::string action = row.action;
  const std::size_t blank = action.find(' ');
  action.insert(blank == std::string::npos ? action.size() : blank, " Y");
  Ladder d("A, Y : BOOL;", block_of({action}));
  EXPECT_EQ(d.over("A", row.power, "Y"), row.variable) << action;
}

TEST_P(Qualifiers, RunST) {
  const Row& row = GetParam();
  std::string action = row.action;
  const std::size_t blank = action.find(' ');
  action.insert(blank == std::string::npos ? action.size() : blank, " text");
  Ladder d("A : BOOL; n : INT;", block_of({action + " {n := n + 1;}"}));
  EXPECT_EQ(d.over("A", row.power, "n"), row.runs) << action;
}

INSTANTIATE_TEST_SUITE_P(
    All, Qualifiers,
    testing::Values(Row{"N", "0 1 1 0 1", "0 1 1 0 1", "0 1 2 2 3"}, Row{"-", "0 1 1 0 1", "0 1 1 0 1", "0 1 2 2 3"},
                    Row{"n", "0 1 1 0 1", "0 1 1 0 1", "0 1 2 2 3"}, Row{"S", "0 1 0 0", "0 1 1 1", "0 1 2 3"},
                    Row{"P", "0 1 1 0 1", "0 1 0 0 1", "0 1 1 1 2"}, Row{"P1", "1 1 0 1", "1 0 0 1", "1 1 1 2"},
                    Row{"P0", "0 1 1 0 0", "0 0 0 1 0", "0 0 0 1 1"},
                    Row{"L T#20ms", "1 1 1 1 0 1", "1 1 0 0 0 1", "1 2 2 2 2 3"},
                    Row{"L T#20ms", "1 0 1 1 1", "1 0 1 1 0", "1 1 2 3 3"},
                    Row{"D T#20ms", "1 1 1 1 0 1", "0 0 1 1 0 0", "0 0 1 2 2 2"},
                    Row{"DS T#20ms", "1 0 1 1 1 0 0", "0 0 0 0 1 1 1", "0 0 0 0 1 2 3"},
                    Row{"SD T#20ms", "1 0 0 0 0", "0 0 1 1 1", "0 0 1 2 3"},
                    Row{"SL T#20ms", "1 0 0 0 1 1", "1 1 0 0 0 0", "1 2 2 2 2 2"}));

TEST(ActionBlock, ResetClearsTheVariableWithPowerOnly) {
  Ladder d("A : BOOL; Y : BOOL := TRUE;", block_of({"R Y"}));
  EXPECT_EQ(d.over("A", "0 1 0", "Y"), "1 0 0");
}

TEST(ActionBlock, IsTransparentAndItsNegationIsNot) {
  Sketch s = after_a();
  s.actions(3, "2", {"N X"}).negated = true;
  s.coil(4, "Y", "3");
  Ladder d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.scan("A=1", "X Y"), "0 1");
  EXPECT_EQ(d.scan("A=0", "X Y"), "1 0");
}

TEST(ActionBlock, HasWiresFromItsActions) {
  Sketch s = after_a();
  s.actions(3, "2", {"N X"}).actions[0].local_id = 30;
  s.coil(4, "Y", "30");
  Ladder d("A, X, Y : BOOL;", s);
  EXPECT_EQ(d.codes(), "");
  EXPECT_EQ(d.over("A", "1 0", "Y"), "1 0");
}

TEST(ActionBlock, ActionsOfOneBlockOnOneVariableAreOr) {
  Ladder d("A, Y : BOOL;", block_of({"P Y", "D y T#20ms"}));
  EXPECT_EQ(d.over("A", "0 1 1 1 1 0", "Y"), "0 1 0 1 1 0");
  EXPECT_EQ(d.codes(), "") << "no double write";
}

TEST(ActionBlock, AStoredActionIsNotPartOfTheOr) {
  Ladder d("A, Y : BOOL;", block_of({"P Y", "S Y"}));
  EXPECT_EQ(d.over("A", "1 1 0", "Y"), "1 1 0") << "P writes FALSE, S sets with power only";
}

TEST(ActionBlock, BlocksOnOneVariableAreDoubleWrites) {
  Sketch s = after_a();
  s.actions(3, "2", {"N Y"});
  s.actions(4, "1", {"N Y"});
  EXPECT_EQ(Ladder("A, Y : BOOL;", s).codes(), "P2002");
  Sketch stored = after_a();
  stored.actions(3, "2", {"S Y"});
  stored.actions(4, "1", {"R Y"});
  EXPECT_EQ(Ladder("A, Y : BOOL;", stored).codes(), "");
}

TEST(ActionBlock, DurationsMayBeComputed) {
  Ladder d("A, Y : BOOL; time : TIME := T#10ms;", block_of({"D Y time*2"}));
  EXPECT_EQ(d.over("A", "1 1 1", "Y"), "0 0 1");
}

// ---- what R undoes ------------------------------------------------------------------------------------------------

/// A resets after an action that B feeds; `above`: the R is drawn first.
Sketch with_reset(const std::string& action, const std::string& name, bool above) {
  Sketch s;
  s.rail(1);
  const auto reset = [&] {
    s.contact(2, "A", "1");
    s.actions(3, "2", {"R " + name});
  };
  if (above) reset();
  s.contact(4, "B", "1");
  s.actions(5, "4", {action});
  if (!above) reset();
  return s;
}

TEST(Reset, ForgetsAStoredDelayWhereverItIsDrawn) {
  for (const bool above : {true, false}) {
    Ladder d("A, B, Y : BOOL;", with_reset("SD Y T#20ms", "y", above));
    EXPECT_EQ(d.over("B", "1 0", "Y"), "0 0");
    EXPECT_EQ(d.scan("A=1", "Y"), "0") << above;
    EXPECT_EQ(d.scan("A=0", "Y"), "0") << "the time is over, and forgotten";
    EXPECT_EQ(d.over("B", "1 0 0 0", "Y"), "0 0 1 1") << "and begins anew";
  }
}

TEST(Reset, LetsALimitedActionRunAgain) {
  Ladder d("A, B, Y : BOOL;", with_reset("SL Y T#20ms", "Y", true));
  EXPECT_EQ(d.over("B", "1 0 0 1 0", "Y"), "1 1 0 0 0");
  EXPECT_EQ(d.over("A", "1 0", "Y"), "0 0");
  EXPECT_EQ(d.over("B", "1 0 0", "Y"), "1 1 0");
}

TEST(Reset, StopsStoredST) {
  Ladder d("A, B : BOOL; n : INT;", with_reset("S work {n := n + 1;}", "Work", false));
  EXPECT_EQ(d.over("B", "1 0 0", "n"), "1 2 3");
  EXPECT_EQ(d.over("A", "1 0 0", "n"), "4 4 4") << "drawn below, it counts from the next scan on";
}

TEST(Reset, LeavesTheTimerOfDsToPower) {
  Ladder d("A, B : BOOL; n : INT;", with_reset("DS work T#20ms {n := n + 1;}", "work", true));
  EXPECT_EQ(d.over("B", "1 1 1", "n"), "0 0 1");
  EXPECT_EQ(d.over("A", "1", "n"), "2") << "power lasts, and has lasted long enough";
}

TEST(Reset, OfOneNameLeavesOthers) {
  Sketch s = after_a();
  s.actions(3, "1", {"SD Y T#10ms", "SD Z T#10ms"});
  s.actions(4, "2", {"R Y"});
  Ladder d("A, Y, Z : BOOL;", s);
  EXPECT_EQ(d.over("A", "0 0", "Y"), "0 1");
  EXPECT_EQ(d.scan("A=1", "Y Z"), "0 1");
}

// ---- actions of POUs ----------------------------------------------------------------------------------------------

constexpr const char* kPump =
    "FUNCTION_BLOCK Pump VAR starts : INT; END_VAR END_FUNCTION_BLOCK\n"
    "ACTION Pump.Start starts := starts + 1; END_ACTION\n"
    "ACTION Main.Work n := n + 10; END_ACTION\n";

TEST(ActionBlock, RunsActionsOfThePouAndOfInstances) {
  Ladder d("A : BOOL; n : INT; p : Pump;", block_of({"N Work", "P p.Start"}), kPump);
  EXPECT_EQ(d.scan("A=1", "n p.starts"), "10 1");
  EXPECT_EQ(d.scan("", "n p.starts"), "20 1");
  EXPECT_EQ(d.scan("A=0", "n p.starts"), "20 1");
}

TEST(ActionBlock, ResetStopsAnActionOfThePou) {
  Ladder d("A, B : BOOL; n : INT; p : Pump;", with_reset("S Work", "Work", true), kPump);
  EXPECT_EQ(d.over("B", "1 0", "n"), "10 20");
  EXPECT_EQ(d.over("A", "1 0", "n"), "20 20");
}

// ---- what is reported ---------------------------------------------------------------------------------------------

struct Wrong {
  const char* action;
  const char* message;
};

TEST(ActionBlock, ReportsWhatCannotBeExecuted) {
  const Wrong wrong[] = {
      {"Q Y", "qualifier \"Q\" of action \"Y\" is not known"},
      {"N -", "names no variable and has no ST"},
      {"R -", "names no variable and has no ST"},
      {"N nothing", "action \"nothing\" of the action block is not a BOOL variable | declare the variable"},
      {"N n", "action \"n\" of the action block is not a BOOL variable, but has type INT"},
      {"S 5", "action \"5\" of the action block is not a BOOL variable"},
      {"L Y", "action \"Y\" with qualifier L has no duration"},
      {"SD work {n := 1;}", "action \"work\" with qualifier SD has no duration"},
  };
  for (const Wrong& one : wrong) {
    Ladder d("A, Y : BOOL; n : INT;", block_of({one.action}));
    EXPECT_EQ(d.codes(), "P2004") << one.action;
    EXPECT_NE(d.message().find(one.message), std::string::npos) << one.action << ": " << d.message();
  }
}

TEST(ActionBlock, ReportsADurationThatIsNoTime) {
  Ladder d("A, Y : BOOL; n : INT;", block_of({"D Y n"}));
  EXPECT_EQ(d.diagnostics.error_count() + (d.codes().empty() ? 0 : 1), 1u) << d.message();
  EXPECT_NE(d.message().find("duration of action \"Y\""), std::string::npos) << d.message();
}

TEST(ActionBlock, GoesOnAfterAWrongAction) {
  Ladder d("A, Y : BOOL;", block_of({"Q Y", "L Y", "N Y"}));
  EXPECT_EQ(d.codes(), "P2004 P2004");
}

TEST(ActionBlock, InAFunctionRemembersNothing) {
  const auto drawn = [](const std::string& action) {
    Sketch main;
    main.in(1, "A");
    main.block(2, "F", "x=1", "F");
    main.out(3, "Y", "2.F");
    Sketch function;
    function.rail(1);
    function.contact(2, "x", "1");
    function.actions(3, "2", {action});
    auto d =
        std::make_unique<Ladder>("A, Y : BOOL;", main, "FUNCTION F : BOOL VAR_INPUT x : BOOL; END_VAR END_FUNCTION");
    d->draw("F", function);
    return d;
  };
  EXPECT_EQ(drawn("N F")->over("A", "1 0", "Y"), "1 0");
  EXPECT_EQ(drawn("S F")->over("A", "1 0", "Y"), "1 0") << "S of a variable needs no memory";
  for (const char* action : {"P F", "L F T#1s", "SD F T#1s", "S work {F := TRUE;}"}) {
    const auto d = drawn(action);
    EXPECT_EQ(d->codes(), "P2004") << action;
    EXPECT_NE(d->message().find("is in a function, which remembers nothing"), std::string::npos);
  }
}

TEST(ActionBlock, KeepsOneTimerAndOneMemoryPerAction) {
  Ladder d("A, X, Y : BOOL;", block_of({"SD X T#1s", "L Y T#1s", "S Y", "N X"}));
  EXPECT_EQ(d.codes(), "");
  std::size_t timers = 0, stored = 0;
  for (const ir::Variable& v : d.pou().variables) {
    timers += v.name.rfind("#timer.", 0) == 0;
    stored += v.name.rfind("#stored.", 0) == 0;
  }
  EXPECT_EQ(timers, 2u);
  EXPECT_EQ(stored, 1u);
}

}  // namespace
}  // namespace plc
