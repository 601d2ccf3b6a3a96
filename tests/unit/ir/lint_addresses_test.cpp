// Lints of addresses.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/unit/ir/linted.h"

namespace plc {
namespace {

using test::add_coil;
using test::BodyBuilder;
using test::ladder;
using test::lint;
using test::lint_statements;
using test::Linted;

TEST(LintAddresses, TwoNamesThatAreBothWritten) {
  EXPECT_EQ(lint_statements("two-names", "Motor AT %QX3.0 : BOOL;\nValve AT %QX3.0 : BOOL;\na : BOOL;",
                            "Motor := a;\nValve := NOT a;"),
            "Main:12");
  EXPECT_EQ(lint_statements("two-names", "Motor AT %QX3.0 : BOOL;\na : BOOL;", "Motor := a;\n%QX3.0 := NOT a;"),
            "Main:12")
      << "an address is a name, too";
  EXPECT_EQ(lint("none,two-names",
                 "VAR_GLOBAL A AT %QW1 : INT; B AT %QW1 : INT; END_VAR\n"
                 "PROGRAM Main VAR x : INT; END_VAR\nA := x;\nB := x;\nEND_PROGRAM"),
            "Main:4");
  EXPECT_EQ(lint("none,two-names",
                 "PROGRAM P VAR Motor AT %QX3.0 : BOOL; END_VAR\nMotor := TRUE;\nEND_PROGRAM\n"
                 "PROGRAM Q VAR Pump AT %QX3.0 : BOOL; END_VAR\nPump := FALSE;\nEND_PROGRAM"),
            "Q:5");
}

TEST(LintAddresses, OneNameOrOneWriterIsFine) {
  EXPECT_EQ(lint_statements("two-names", "Motor AT %QX3.0 : BOOL;\nShown AT %QX3.0 : BOOL;\na : BOOL;",
                            "Motor := a;\nMotor := Shown AND a;"),
            "");
  EXPECT_EQ(lint("none,two-names",
                 "PROGRAM P VAR Motor AT %QX3.0 : BOOL; END_VAR\nMotor := TRUE;\nEND_PROGRAM\n"
                 "PROGRAM Q VAR MOTOR AT %QX3.0 : BOOL; END_VAR\nMotor := FALSE;\nEND_PROGRAM"),
            "")
      << "POUs share an output by its name";
  EXPECT_EQ(lint_statements("two-names", "a : INT;\nb : INT;", "a := 1;\nb := 2;"), "");
}

TEST(LintAddresses, CoilsUnderSeveralNamesAreToldOnce) {
  Linted drawn("PROGRAM Main VAR go : BOOL; Motor AT %QX3.0 : BOOL; Valve AT %QX3.0 : BOOL; END_VAR END_PROGRAM");
  drawn.pou("Main").bodies = {ladder("go", [](BodyBuilder& b) {
    add_coil(b, 3, "Motor");
    add_coil(b, 4, "Valve");
  })};
  EXPECT_EQ(drawn.run("none,two-names,double-coil"), "");
  const auto& all = drawn.diagnostics.all();
  const auto is_one = [](const core::Diagnostic& d) { return d.code == core::Code::P2002; };
  ASSERT_EQ(std::count_if(all.begin(), all.end(), is_one), 1);
  const core::Diagnostic& found = *std::find_if(all.begin(), all.end(), is_one);
  for (const char* part : {"%QX3.0", "\"Motor\" 3", "\"Valve\" 4", "2 coils"}) {
    EXPECT_NE(found.message.find(part), std::string::npos) << found.message;
  }
}

TEST(LintAddresses, NumbersTooMany) {
  EXPECT_EQ(lint_statements("dotted-address", "Level AT %IW0.0 : INT;\nb AT %QX1.2.3 : BOOL;\nc AT %QX1.2 : BOOL;",
                            "b := Level > 0; c := b;"),
            ":2 :3");
  EXPECT_EQ(lint_statements("dotted-address", "Level AT %IW0 : INT;\nx AT %I* : BOOL;\nd AT %MD3 : REAL;", "d := 1.0;"),
            "");
}

TEST(LintAddresses, InsideOfArrays) {
  EXPECT_EQ(lint_statements("inside-array",
                            "a AT %MW10 : ARRAY [0..3] OF WORD;\nb AT %MW12 : INT;\nc AT %MW14 : INT;\n"
                            "d AT %MX2.6 : ARRAY [1..4] OF BOOL;\ne AT %MX3.1 : BOOL;\nf AT %MX3.2 : BOOL;",
                            "b := 1; c := 2; e := TRUE; f := e; a[0] := 3; d[1] := f;"),
            ":3 :6");
  EXPECT_EQ(lint("none,inside-array",
                 "VAR_GLOBAL A AT %MW0 : ARRAY [0..1, 0..4] OF INT; END_VAR\n"
                 "PROGRAM Main VAR x : WORD; END_VAR\nx := %MW9;\nx := %MW10;\nEND_PROGRAM"),
            ":3")
      << "an address in a statement is a variable, too";
  EXPECT_EQ(lint_statements("inside-array",
                            "a AT %MW10 : ARRAY [0..3] OF WORD;\nb AT %QW11 : INT;\nc AT %MD11 : DINT;\n"
                            "d AT %MW12.1 : WORD;\ne AT %MW10 : ARRAY [0..3] OF WORD;\ns AT %MB200 : STRING[9];",
                            "b := 1; c := 2; d := 3; e[0] := 4;"),
            "")
      << "other areas, sizes, and one array under two names";
  EXPECT_EQ(lint_statements("inside-array",
                            "b AT %IW10 : INT;\na AT %IW10 : ARRAY [0..3] OF WORD;\nc AT %IW10 : WORD;\n"
                            "d AT %IW12 : INT;\nx : INT;",
                            "x := b; x := d;"),
            ":5")
      << "the first element under another type is the same input";
}

}  // namespace
}  // namespace plc
