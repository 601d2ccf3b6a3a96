// Files made to hurt: each ends with a code or compiles, in a time that does not explode.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

ToolResult check(const ScratchFolder& scratch, const std::string& project) {
  const std::string file = scratch.file("hostile.xml");
  write_text(file, project);
  return run_tool({PLC_TOOL, "check", file});
}

std::string with_types(const std::string& types) {
  std::string project = small_project();
  const std::string_view kNone = "<dataTypes/>";
  return project.replace(project.find(kNone), kNone.size(), "<dataTypes>" + types + "</dataTypes>");
}

std::string structure(int name, const std::string& members) {
  return "<dataType name=\"T" + std::to_string(name) + "\"><baseType><struct>" + members +
         "</struct></baseType></dataType>";
}

std::string member(const std::string& name, int type) {
  return "<variable name=\"" + name + "\"><type><derived name=\"T" + std::to_string(type) + "\"/></type></variable>";
}

TEST(Hostile, StructuresNestedThousandsDeepInAnyOrder) {
  const ScratchFolder scratch;
  constexpr int kDepth = 30000;
  const std::string innermost = "<dataType name=\"T30000\"><baseType><BOOL/></baseType></dataType>";
  std::string outermost_first;
  std::string innermost_first = innermost;
  for (int i = 0; i < kDepth; ++i) outermost_first += structure(i, member("x", i + 1));
  for (int i = kDepth; i-- > 0;) innermost_first += structure(i, member("x", i + 1));
  for (const std::string& types : {outermost_first + innermost, innermost_first}) {
    const auto result = check(scratch, with_types(types));
    EXPECT_EQ(result.code, 1);
    EXPECT_NE(result.err.find("P4017"), std::string::npos) << result.err.substr(0, 500);
  }
}

TEST(Hostile, TwoMembersOfEachTypeDoNotDoubleTheWork) {
  const ScratchFolder scratch;
  std::string types;
  for (int i = 0; i < 50; ++i) types += structure(i, member("x", i + 1) + member("y", i + 1));
  types += "<dataType name=\"T50\"><baseType><BOOL/></baseType></dataType>";
  std::string project = with_types(types);
  project.replace(project.find("<localVars>"), 11, "<localVars>" + member("big", 0));
  const auto result = check(scratch, project);
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("P5001"), std::string::npos) << result.err.substr(0, 500);
}

TEST(Hostile, ThousandsOfConstantsThatNeedEachOther) {
  constexpr int kConstants = 5000;
  for (const bool circle : {false, true}) {
    const ScratchFolder scratch;
    const std::string file = scratch.file("constants.st");
    std::ofstream out(file);
    out << "CONFIGURATION C\nVAR_GLOBAL CONSTANT\n";
    for (int i = 0; i < kConstants; ++i) out << "c" << i << " : INT := c" << i + 1 << ";\n";
    out << "c" << kConstants << " : INT := " << (circle ? "c0" : "1") << ";\nEND_VAR\nEND_CONFIGURATION\n";
    out.close();
    const auto result = run_tool({PLC_TOOL, "check", file});
    EXPECT_EQ(result.code, circle ? 1 : 0) << result.all().substr(0, 500);
    EXPECT_EQ(result.err.find("P4034") != std::string::npos, circle) << result.all().substr(0, 500);
  }
}

TEST(Hostile, ArrayOfAHundredThousandDimensions) {
  const ScratchFolder scratch;
  std::string type = "<dataType name=\"T\"><baseType><array>";
  for (int i = 0; i < 100000; ++i) type += "<dimension lower=\"0\" upper=\"0\"/>";
  const auto result = check(scratch, with_types(type + "<baseType><BOOL/></baseType></array></baseType></dataType>"));
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("P4017"), std::string::npos) << result.err.substr(0, 500);
}

TEST(Hostile, CrossingFeedbackLoopsDoNotDoubleTheWorkWithEachBlock) {
  const ScratchFolder scratch;
  constexpr int kBlocks = 60;
  const auto wire = [](const std::string& pin, int from) {
    return "<variable formalParameter=\"" + pin + "\"><connectionPointIn><connection refLocalId=\"" +
           std::to_string(from) + "\"/></connectionPointIn></variable>";
  };
  std::string body = "<FBD>";
  for (int i = 1; i <= kBlocks; ++i) {
    body += "<block localId=\"" + std::to_string(i) + "\" typeName=\"AND\"><position x=\"" + std::to_string(i * 20) +
            "\" y=\"0\"/><inputVariables>" + wire("IN1", std::max(i - 1, 1)) + wire("IN2", std::min(i + 1, kBlocks)) +
            "</inputVariables><inOutVariables/><outputVariables><variable formalParameter=\"OUT\"><connectionPointOut/>"
            "</variable></outputVariables></block>\n";
  }
  body +=
      "<outVariable localId=\"1000\"><position x=\"9000\" y=\"0\"/><connectionPointIn><connection refLocalId=\"60\"/>"
      "</connectionPointIn><expression>Out</expression></outVariable></FBD>";
  EXPECT_LE(check(scratch, small_project(true, body)).code, 1);
}

TEST(Hostile, LongNamesAreCutInMessages) {
  const ScratchFolder scratch;
  std::string project = small_project();
  const std::string_view kName = "<variable>In<";
  project.replace(project.find(kName), kName.size(), "<variable>" + std::string(1000000, 'A') + "<");
  const auto result = check(scratch, project);
  EXPECT_EQ(result.code, 1);
  EXPECT_LT(result.err.size(), 10000u);
}

TEST(Hostile, PipesAreNotOpened) {
  const ScratchFolder scratch;
  const std::string pipe = scratch.file("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "check", pipe}).code, 2);
  EXPECT_EQ(run_tool({PLC_TOOL, "sim", tank(), "--cycles", "1", "--stimulus", pipe}).code, 2);
}

}  // namespace
}  // namespace plc::test
