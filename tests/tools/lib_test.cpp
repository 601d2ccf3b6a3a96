// plc lib: what it prints (golden files in lib/; PLC_GOLDEN_UPDATE=1 rewrites them), and its XML library in projects.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "tests/support/golden.h"
#include "tests/tools/fixture.h"
#include "tools/library_text.h"

namespace plc::test {
namespace {

/// What `plc lib NAME` prints is what is in the golden file.
void expect_text(const std::string& name, const std::string& golden) {
  std::vector<std::string> command = {PLC_TOOL, "lib"};
  if (!name.empty()) command.push_back(name);
  const auto result = run_tool(command);
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  expect_golden("tests/tools/lib/" + golden, result.out);
}

TEST(Lib, ExplainsAFunctionOfSeveralRows) { expect_text("add", "add.txt"); }
TEST(Lib, ExplainsAFunctionWithEvents) { expect_text("DIV", "div.txt"); }
TEST(Lib, ExplainsAConversionByItsOwnName) { expect_text("real_to_int", "real_to_int.txt"); }
TEST(Lib, ExplainsAFamily) { expect_text("TRUNC_*", "trunc_family.txt"); }
TEST(Lib, ExplainsABlock) { expect_text("ton", "ton.txt"); }
TEST(Lib, ExplainsAFunctionOfSeveralOutputs) { expect_text("switch", "switch.txt"); }
TEST(Lib, ExplainsABlockThatIsDrawnOnly) { expect_text("delay", "delay.txt"); }
TEST(Lib, ListsWhatMatches) { expect_text("?OD_TO_*", "pattern.txt"); }

TEST(Lib, ListsEverythingInGroups) {
  const auto result = run_tool({PLC_TOOL, "lib"});
  EXPECT_EQ(result.code, 0);
  std::size_t at = 0;
  for (const char* part : {"Arithmetic\n", "ADD", "Strings\n", "CONCAT", "Conversions\n", "*_TO_*", "Counters\n",
                           "CTU, CTU_INT, CTU_DINT", "Timers\n", "TON, TON_TIME, TON_LTIME"}) {
    at = result.out.find(part, at);
    ASSERT_NE(at, std::string::npos) << part;
  }
  EXPECT_EQ(result.out.find("DINT_TO_REAL "), std::string::npos) << "families are folded";
}

TEST(Lib, AnUnknownNameExitsWith1AndTheNearest) {
  const auto result = run_tool({PLC_TOOL, "lib", "LIMTI"});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_NE(result.err.find("\"LIMTI\""), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("did you mean \"LIMIT\"?"), std::string::npos) << result.err;
  EXPECT_EQ(run_tool({PLC_TOOL, "lib", "XYZ*"}).code, 1);
  EXPECT_EQ(run_tool({PLC_TOOL, "lib", "INT_TO_REAL", "--xml"}).code, 1) << "no row of its own";
  EXPECT_EQ(run_tool({PLC_TOOL, "lib", "ADD", "--json", "--xml"}).code, 2);
}

TEST(Lib, PrintsJson) {
  const auto all = nlohmann::json::parse(run_tool({PLC_TOOL, "lib", "--json"}).out);
  EXPECT_GT(all["functions"].size(), 50u);
  EXPECT_GT(all["blocks"].size(), 20u);
  const auto div = nlohmann::json::parse(run_tool({PLC_TOOL, "lib", "div", "--json"}).out)["functions"];
  EXPECT_EQ(div[0]["name"], "DIV");
  EXPECT_EQ(div[0]["events"], nlohmann::json({"divide_by_zero"}));
  const auto ton = nlohmann::json::parse(run_tool({PLC_TOOL, "lib", "TON", "--json"}).out)["blocks"];
  EXPECT_EQ(ton[0]["fields"][1]["name"], "PT");
}

// ---- words ------------------------------------------------------------------------------------------------------

TEST(LibraryText, NamesTheFewestGenericTypes) {
  using core::TypeId;
  EXPECT_EQ(tools::generic_text({TypeId::kReal, TypeId::kLreal}), "ANY_REAL");
  EXPECT_EQ(tools::generic_text({TypeId::kBool, TypeId::kReal, TypeId::kLreal}), "ANY_REAL, BOOL");
  EXPECT_EQ(tools::generic_text({TypeId::kInt}), "INT");
}

TEST(LibraryText, ReadsTheTableOfABlock) {
  constexpr stdlib::BlockExample kExample = {"title", "at IN | Q\n\nT#0s  TRUE | .\n"};
  EXPECT_EQ(tools::example_cells(kExample),
            (std::vector<std::vector<std::string>>{{"at", "IN", "|", "Q"}, {"T#0s", "TRUE", "|", "."}}));
}

TEST(LibraryText, TellsTheStandardsRowsFromOthers) {
  EXPECT_TRUE(stdlib::is_standard("IEC 61131-3:2013, table 29"));
  EXPECT_FALSE(stdlib::is_standard("IEC 61131-3:2003, annex F"));
  EXPECT_FALSE(stdlib::is_standard("not in the standard; as in CODESYS Util"));
  EXPECT_EQ(tools::group_of("ton_ltime"), "Timers");
  EXPECT_EQ(tools::group_of("real_to_int"), "Conversions");
  EXPECT_EQ(tools::group_of("nothing"), "");
}

// ---- the library for editors ------------------------------------------------------------------------------------

TEST(LibXml, IsValidAgainstTheSchemaOfPlcopen) {
  const char* const named = std::getenv("PLC_TC6_SCHEMA");
  const std::string schema = named != nullptr ? named : PLC_TC6_SCHEMA_DEFAULT;
  if (!std::filesystem::exists(schema)) {
    GTEST_SKIP() << "no file " << schema << ": PLCopen's schema is not part of this repository (set PLC_TC6_SCHEMA)";
  }
  const ScratchFolder scratch;
  for (const char* name : {"", "*"}) {
    std::vector<std::string> command = {PLC_TOOL, "lib", "--xml", "-o", scratch.file("library.xml")};
    if (*name != '\0') command.emplace_back(name);
    ASSERT_EQ(run_tool(command).code, 0);
    const auto lint = run_tool({"/usr/bin/env", "xmllint", "--noout", "--schema", schema, scratch.file("library.xml")});
    EXPECT_EQ(lint.code, 0) << lint.err;
  }
}

constexpr const char* kUser = R"(PROGRAM Main
VAR t : TON; high : INT; chosen : BOOL; END_VAR
  t(IN := TRUE, PT := T#30ms);
  SWITCH(K := 4, S4 => chosen);
  high := MAX(3, 4);
END_PROGRAM
CONFIGURATION C TASK T(INTERVAL := T#20ms); PROGRAM main WITH T : Main; END_CONFIGURATION
)";

TEST(LibXml, WhatItDeclaresIsTheLibrarysOwn) {
  const ScratchFolder scratch;
  const std::string library = scratch.file("library.xml"), user = scratch.file("user.st");
  ASSERT_EQ(run_tool({PLC_TOOL, "lib", "--xml", "*", "-o", library}).code, 0);
  write_text(user, kUser);
  const auto sim = run_tool(
      {PLC_TOOL, "sim", user, "--lib", library, "--cycles", "3", "--watch", "main.t.Q", "--watch", "main.high"});
  EXPECT_EQ(sim.code, 0) << sim.all();
  EXPECT_EQ(sim.err.find("P4019"), std::string::npos) << sim.err;
  EXPECT_EQ(sim.out, "cycle,time_ms,main.t.Q,main.high\n0,0,0,4\n1,20,0,4\n2,40,1,4\n");
  // Alone it is a library, and in order.
  const auto check = run_tool({PLC_TOOL, "check", library});
  EXPECT_EQ(check.code, 0) << check.all();
}

TEST(LibXml, HasWhatEditorsDoNotKnow) {
  const std::string all = run_tool({PLC_TOOL, "lib", "--xml"}).out;
  for (const char* own : {"SWITCH", "DELAY", "PID"}) {
    EXPECT_NE(all.find(std::string("<pou name=\"") + own + "\""), std::string::npos) << own;
    EXPECT_EQ(run_tool({PLC_TOOL, "lib", own, "--xml"}).code, 0) << own;
  }
  for (const char* known : {"SPLIT_DATE", "LOWER_BOUND", "SWITCH.S0"})
    EXPECT_EQ(all.find(std::string("<pou name=\"") + known + "\""), std::string::npos) << known;
  EXPECT_EQ(run_tool({PLC_TOOL, "lib", "SPLIT_DATE", "--xml"}).code, 0);
  EXPECT_EQ(run_tool({PLC_TOOL, "lib", "LOWER_BOUND", "--xml"}).code, 1) << "it is of variables";
}

TEST(LibXml, WhatDiffersFromTheLibraryCountsAsItStands) {
  const ScratchFolder scratch;
  const std::string user = scratch.file("user.st");
  for (const char* own :
       {"FUNCTION_BLOCK TON VAR_INPUT IN : BOOL; PT : TIME; END_VAR VAR_OUTPUT Q : BOOL; ET : TIME; END_VAR\n"
        "  Q := IN;\nEND_FUNCTION_BLOCK\n",
        "FUNCTION_BLOCK TON VAR_INPUT IN : BOOL; PT : TIME; END_VAR VAR_OUTPUT Q : BOOL; END_VAR\n"
        "END_FUNCTION_BLOCK\n",
        "FUNCTION_BLOCK TON VAR_INPUT IN : BOOL; PT : LTIME; END_VAR VAR_OUTPUT Q : BOOL; ET : TIME; END_VAR\n"
        "END_FUNCTION_BLOCK\n"}) {
    write_text(user, std::string(kUser) + own);
    const auto check = run_tool({PLC_TOOL, "check", user});
    EXPECT_NE(check.err.find("P4019"), std::string::npos) << own << check.all();
  }
  // A name of PICARD's own is no surprise to hide.
  using Own = std::pair<const char*, const char*>;
  for (const auto& [outputs, chosen] : {Own{"S4 : BOOL;", "0"}, Own{"S0, S1, S2, S3, S4, S5, S6, S7 : BOOL;", "1"}}) {
    write_text(user, std::string(kUser) + "FUNCTION SWITCH VAR_INPUT K : DINT; END_VAR VAR_OUTPUT " + outputs +
                         " END_VAR\nEND_FUNCTION\n");
    const auto sim = run_tool({PLC_TOOL, "sim", user, "--cycles", "1", "--watch", "main.chosen"});
    EXPECT_EQ(sim.code, 0) << sim.err;
    EXPECT_EQ(sim.err.find("P4019"), std::string::npos) << sim.err;
    EXPECT_EQ(sim.out, std::string("cycle,time_ms,main.chosen\n0,0,") + chosen + "\n");
  }
}

}  // namespace
}  // namespace plc::test
