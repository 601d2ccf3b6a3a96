// plc convert: what of a text stays as it was, and what is not kept.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

/// What plc convert makes of a file.
class Convert : public ::testing::Test {
 protected:
  std::string convert(const std::string& name, const std::string& text) {
    write_text(scratch_.file(name), text);
    const std::string to = scratch_.file("converted.st");
    result_ = run_tool({PLC_TOOL, "convert", scratch_.file(name), "-o", to});
    EXPECT_EQ(result_.code, 0) << result_.all();
    std::ifstream in(to);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  ScratchFolder scratch_;
  ToolResult result_;
};

/// In the form that plc convert writes.
const std::string kCommented = R"((* what a colour is *)
TYPE
  Colour : (
    Red,  // the first
    // the second
    Green := 5
  );
END_TYPE

// A pair,
// of two.
TYPE
  Pair : STRUCT
    a : INT;  (* left *)
    // right
    b : INT;
  END_STRUCT;
END_TYPE

(* Doubles
   its input *)
FUNCTION Twice : INT  // an INT
VAR_INPUT
  x : INT;  // what is doubled
END_VAR
  // before the first statement
  Twice := x * 2;  // after the last one
  (* and the very last *)
END_FUNCTION

PROGRAM Main
VAR
  // two of a kind
  p : Pair;
  c : Colour;  (* shown *)
END_VAR
  p.b := Twice(p.a);
END_PROGRAM

// the button
ACTION Press:
  // pressed
  p.a := p.a + 1;
END_ACTION

(* a test *)
TEST 'twice two is four'
VAR
  n : INT := 2;  // two
END_VAR
  ASSERT_EQ(4, Twice(n));
END_TEST

// the plant
CONFIGURATION C
  RESOURCE R ON PLC
    // slow
    TASK T (INTERVAL := T#20ms, PRIORITY := 0);  // 50 Hz
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION

// the end
)";

TEST_F(Convert, KeepsCommentsAndTests) {
  EXPECT_EQ(convert("commented.st", kCommented), kCommented);
  EXPECT_NE(result_.out.find("same image"), std::string::npos) << result_.out;
}

TEST_F(Convert, CommentsGoWithTheirDeclarations) {
  const std::string text = convert("order.st",
                                   "PROGRAM Main\nVAR c : Colour; END_VAR\n  c := Red;\nEND_PROGRAM\n"
                                   "(* of the type *) TYPE Colour : (Red, Green); END_TYPE // behind the type\n"
                                   "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#20ms, PRIORITY := 0);\n"
                                   "PROGRAM main WITH T : Main; END_RESOURCE END_CONFIGURATION\n");
  EXPECT_EQ(text.find("(* of the type *)\nTYPE"), 0u) << text;
  EXPECT_NE(text.find("// behind the type\n"), std::string::npos) << text;
  EXPECT_NE(result_.out.find("same image"), std::string::npos) << result_.out;
}

TEST_F(Convert, ChartsOfCodesysKeepTheirFinalScan) {
  const std::string chart =
      "{attribute 'sfc_final_scan'}\nPROGRAM Main\nVAR\n  n : INT;\nEND_VAR\n  INITIAL_STEP A (MIN := T#40ms):\n"
      "    Begin(ENTRY);\n    Count(N);\n  END_STEP\n  STEP B:\n  END_STEP\n"
      "  TRANSITION FROM A TO B\n    := TRUE;\n  END_TRANSITION\nEND_PROGRAM\n\n"
      "ACTION Begin:\n  n := 100;\nEND_ACTION\n\nACTION Count:\n  n := n + 1;\nEND_ACTION\n\n"
      "CONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T (INTERVAL := T#20ms, PRIORITY := 0);\n"
      "    PROGRAM main WITH T : Main;\n  END_RESOURCE\nEND_CONFIGURATION\n";
  EXPECT_EQ(convert("chart.st", chart), chart);
  EXPECT_NE(result_.out.find("same image"), std::string::npos) << result_.out;
  // 3 scans with A, which may be left after 40 ms, and one when Count ends.
  const ToolResult run =
      run_tool({PLC_TOOL, "sim", scratch_.file("converted.st"), "--cycles", "8", "--watch", "main.n"});
  EXPECT_NE(run.out.find("104"), std::string::npos) << run.all();
  EXPECT_EQ(run.out.find("105"), std::string::npos) << run.all();
}

}  // namespace
}  // namespace plc::test
