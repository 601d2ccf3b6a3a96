// Pragmas that choose: what counts of a text, where the rest stays, what holds where.
#include "frontend-st/conditions.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tests/unit/frontend-st/reading.h"

namespace plc::st {
namespace {

struct Few : Surroundings {
  [[nodiscard]] bool has_variable(std::string_view path) const override { return path == "a" || path == "list.x"; }
  [[nodiscard]] bool has_type(std::string_view name) const override { return name == "T"; }
  [[nodiscard]] bool has_pou(std::string_view name) const override { return name == "P"; }
  [[nodiscard]] bool has_task(std::string_view name) const override { return name == "Fast"; }
  [[nodiscard]] bool is_of_type(std::string_view path, std::string_view type) const override {
    return path == "a" && type == "INT";
  }
  [[nodiscard]] bool pou_has_attribute(std::string_view pou, std::string_view attribute) const override {
    return pou == "P" && attribute == "simple";
  }
  [[nodiscard]] bool variable_has_attribute(std::string_view variable, std::string_view attribute) const override {
    return variable == "a" && attribute == "hide";
  }
};

struct Choice {
  std::string text;
  std::vector<std::string> codes;
};

Choice chosen(const std::string& text, const std::vector<std::string>& defines = {}) {
  core::Diagnostics diagnostics;
  core::SourceRef at;
  at.line = at.column = 1;
  const SourceText source(text, at, diagnostics);
  const ChosenText chosen(source, Defines(defines), Few(), diagnostics, "P");
  EXPECT_EQ(chosen.fine(), !diagnostics.has_errors());
  Choice out{std::string(chosen.text()), {}};
  for (const core::Diagnostic& d : diagnostics.all()) out.codes.emplace_back(core::info(d.code).name);
  return out;
}

/// Whether a condition holds.
bool holds(const std::string& condition, const std::vector<std::string>& defines = {}) {
  const Choice out = chosen("{IF " + condition + "}x{END_IF}", defines);
  EXPECT_TRUE(out.codes.empty()) << condition;
  return out.text.find('x') != std::string::npos;
}

TEST(Chosen, IsOneBranch) {
  const std::string text = "{IF defined (A)} a {ELSIF defined (B)} b {ELSE} c {END_IF} d";
  const auto left = [&](const std::vector<std::string>& defines) {
    std::string letters;
    for (const char c : chosen(text, defines).text) letters += c == ' ' ? "" : std::string(1, c);
    return letters;
  };
  EXPECT_EQ(left({"A"}), "ad");
  EXPECT_EQ(left({"A", "B"}), "ad") << "the first that holds";
  EXPECT_EQ(left({"b"}), "bd") << "in any letter case";
  EXPECT_EQ(left({}), "cd");
}

TEST(Chosen, KeepsPlaces) {
  EXPECT_EQ(chosen("{IF defined(A)}\näö\n{END_IF} x").text, "               \n  \n         x");
  const std::string plain = "{attribute 'hide'} x := 'a{IF}'; (* {ELSE} *)";
  EXPECT_EQ(chosen(plain).text, plain) << "other pragmas, texts and comments stay";
}

TEST(Chosen, Nests) {
  const std::string text =
      "{IF defined(A)}{IF defined(B)}1{ELSE}2{END_IF}{ELSE}{IF defined(B)}3{ELSE}4{END_IF}{END_IF}";
  const auto digit = [&](const std::vector<std::string>& defines) {
    const std::string left = chosen(text, defines).text;
    return left.substr(left.find_first_not_of(' '), 1);
  };
  EXPECT_EQ(digit({"A", "B"}), "1");
  EXPECT_EQ(digit({"A"}), "2");
  EXPECT_EQ(digit({"B"}), "3");
  EXPECT_EQ(digit({}), "4");
}

TEST(Conditions, Know) {
  EXPECT_TRUE(holds("defined (variable: list.x)"));
  EXPECT_FALSE(holds("defined (variable: b)"));
  EXPECT_TRUE(holds("defined (type: T)"));
  EXPECT_TRUE(holds("defined (pou: P)"));
  EXPECT_TRUE(holds("defined (task: Fast)"));
  EXPECT_TRUE(holds("hastype (variable: a, INT)"));
  EXPECT_TRUE(holds("hasattribute (pou: P, 'simple') AND hasattribute (variable: a, 'hide')"));
  EXPECT_TRUE(holds("hasvalue (Mode, 'fast')", {"MODE=fast"}));
  EXPECT_FALSE(holds("hasvalue (Mode, 'slow')", {"MODE=fast"}));
  EXPECT_TRUE(holds("defined (IsLittleEndian)"));
  EXPECT_FALSE(holds("defined (IsSimulationMode)"));
}

TEST(Conditions, Combine) {
  EXPECT_TRUE(holds("defined(A) OR defined(B) AND defined(C)", {"A"})) << "AND binds more than OR";
  EXPECT_FALSE(holds("(defined(A) OR defined(B)) AND defined(C)", {"A"}));
  EXPECT_TRUE(holds("NOT defined(B) and not not defined(A)", {"A"}));
  EXPECT_FALSE(holds("NOT (defined(A) OR defined(B))", {"B"}));
}

TEST(Defines, HoldFromThereOn) {
  EXPECT_EQ(chosen("{IF defined(A)}1{END_IF}{define A}{IF defined(A)}2{END_IF}{undefine A}{IF defined(A)}3{END_IF}")
                .text.find('1'),
            std::string::npos);
  const std::string left =
      chosen("{define A 'x'}{IF hasvalue(A, 'x')}2{END_IF}{undefine A}{IF defined(A)}3{END_IF}").text;
  EXPECT_NE(left.find('2'), std::string::npos);
  EXPECT_EQ(left.find('3'), std::string::npos);
  EXPECT_EQ(chosen("{IF defined(A)}{define B}{END_IF}{IF defined(B)}3{END_IF}").text.find('3'), std::string::npos)
      << "what is not chosen defines nothing";
}

TEST(Chosen, NamesWhatIsWrong) {
  using Codes = std::vector<std::string>;
  EXPECT_EQ(chosen("{IF defined(A)} x").codes, Codes{"P4520"});
  EXPECT_EQ(chosen("x {END_IF}").codes, Codes{"P4520"});
  EXPECT_EQ(chosen("{ELSE}").codes, Codes{"P4520"});
  EXPECT_EQ(chosen("{IF defined(A)}{ELSE}{ELSIF defined(B)}{END_IF}").codes, Codes{"P4520"});
  EXPECT_EQ(chosen("{IFDEF A}").codes, Codes{"P4520"});
  EXPECT_EQ(chosen("{IF}x{END_IF}").codes, Codes{"P4521"});
  EXPECT_EQ(chosen("{IF A}x{END_IF}").codes, Codes{"P4521"});
  EXPECT_EQ(chosen("{IF defined(A) defined(B)}x{END_IF}").codes, Codes{"P4521"});
  EXPECT_EQ(chosen("{IF defined(place: A)}x{END_IF}").codes, Codes{"P4521"});
  EXPECT_EQ(chosen("{IF defined(A)}{IF nonsense}{END_IF}{END_IF}").codes, Codes{})
      << "what is passed over may be anything";
  EXPECT_EQ(chosen("{define}").codes, Codes{"P4521"});
  EXPECT_EQ(chosen("{IF " + std::string(1000, '(') + "}{END_IF}").codes, Codes{"P4521"});
}

// ---- among declarations -----------------------------------------------------------------------------------------

TEST(DeclaredChoices, AreMadeBeforeReading) {
  const std::string text = R"({IF defined (BIG)}
TYPE T : INT; END_TYPE
{ELSE}
TYPE T : SINT; END_TYPE
{END_IF}
PROGRAM p
VAR
  a : T;
  {IF defined (BIG)} b : INT; {ELSE} c : INT; d : INT; {END_IF}
END_VAR
  a := 1;
END_PROGRAM
)";
  core::Diagnostics diagnostics;
  const auto small = read_memory(text, "test.st", diagnostics);
  ASSERT_EQ(small->data_types.size(), 1u);
  EXPECT_EQ(small->data_types[0].type.name, "SINT");
  EXPECT_EQ(small->pous.at(0).variables.size(), 3u);
  EXPECT_EQ(small->pous[0].variables[2].at.line, 9u);
  EXPECT_EQ(small->pous[0].variables[2].at.column, 47u);
  const auto big = read_memory(text, "test.st", diagnostics, {"BIG"});
  EXPECT_EQ(big->data_types.at(0).type.name, "INT");
  EXPECT_EQ(big->pous.at(0).variables.size(), 2u);
  EXPECT_EQ(diagnostics.error_count(), 0u);
}

TEST(DeclaredChoices, LeaveBodiesAsTheyAre) {
  core::Diagnostics diagnostics;
  const auto project = read_memory(R"({define OUTSIDE}
PROGRAM p
{define INSIDE}
VAR a : INT; END_VAR
  {IF defined (pou: p)}
  a := 1;
  {END_IF}
END_PROGRAM
PROGRAM q VAR a : INT; END_VAR
  a := 1;
  ACTION r: {IF defined (OUTSIDE)} a := 2; {END_IF} END_ACTION
END_PROGRAM
)",
                                   "test.st", diagnostics, {"GIVEN=1"});
  EXPECT_EQ(diagnostics.error_count(), 0u);
  const plcopen::Body& body = project->pous.at(0).bodies.at(0);
  EXPECT_EQ(body.text, "{IF defined (pou: p)}\n  a := 1;\n  {END_IF}");
  EXPECT_EQ(body.text_at.line, 5u);
  ASSERT_TRUE(body.defines);
  EXPECT_EQ(*body.defines, (std::vector<std::string>{"GIVEN=1", "INSIDE", "OUTSIDE"}));
  EXPECT_EQ(*project->pous.at(1).bodies.at(0).defines, (std::vector<std::string>{"GIVEN=1", "OUTSIDE"}))
      << "what a POU defines is its own";
  EXPECT_EQ(project->pous[1].actions.at(0).bodies.at(0).text, "{IF defined (OUTSIDE)} a := 2; {END_IF}");
}

TEST(DeclaredChoices, TakeNamesLikeSectionsForNames) {
  core::Diagnostics diagnostics;
  const auto project =
      read_memory("PROGRAM p VAR VAR_1 : INT; END_VAR {IF defined (variable: VAR_1)} VAR_1 := 1; {END_IF} END_PROGRAM",
                  "test.st", diagnostics);
  EXPECT_EQ(diagnostics.error_count(), 0u);
  EXPECT_EQ(project->pous.at(0).bodies.at(0).text, "{IF defined (variable: VAR_1)} VAR_1 := 1; {END_IF}");
}

TEST(DeclaredChoices, AskForDefinesAlone) {
  core::Diagnostics diagnostics;
  const auto project = read_memory("PROGRAM p VAR {IF defined (type: T)} a : T; {END_IF} b : INT; END_VAR END_PROGRAM",
                                   "test.st", diagnostics);
  ASSERT_EQ(diagnostics.all().size(), 1u);
  EXPECT_EQ(diagnostics.all()[0].code, core::Code::P4521);
  EXPECT_EQ(project->pous.at(0).variables.size(), 1u);
}

TEST(Attributes, BelongToWhatFollowsThem) {
  core::Diagnostics diagnostics;
  const auto project = read_memory(R"({attribute 'outer'}
FUNCTION_BLOCK f
VAR
  {attribute 'hide'} {attribute 'reflection' := 'x'}
  a, b : INT;
  c : INT;
END_VAR
END_FUNCTION_BLOCK)",
                                   "test.st", diagnostics);
  std::set<std::string> all;
  for (const plcopen::Attribute& one : project->attributes) all.insert(one.pou + "." + one.variable + "." + one.name);
  EXPECT_EQ(all, (std::set<std::string>{"f..outer", "f.a.hide", "f.a.reflection", "f.b.hide", "f.b.reflection"}));
}

}  // namespace
}  // namespace plc::st
