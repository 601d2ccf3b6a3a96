// Export files of CODESYS 2.3 and TwinCAT 2.
#include "sources/export_file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace plc::sources {
namespace {

struct Reading {
  explicit Reading(const std::string& bytes) : project(read_export_memory(bytes, "plant.exp", diagnostics)) {}
  [[nodiscard]] std::size_t count(core::Code code) const {
    return static_cast<std::size_t>(std::count_if(diagnostics.all().begin(), diagnostics.all().end(),
                                                  [&](const core::Diagnostic& one) { return one.code == code; }));
  }
  core::Diagnostics diagnostics;
  std::unique_ptr<plcopen::Project> project;
};

TEST(ExportFile, SeveralObjectsAListAndAnAction) {
  const Reading r(
      "(* @NESTEDCOMMENTS := 'Yes' *)\r\n(* @GLOBAL_VARIABLE_LIST := 'Plant' *)\r\nVAR_GLOBAL\r\n\tlevel : INT; (* (* "
      "f\x81 *) *)\r\n"
      "END_VAR\r\n\r\n(* @OBJECT_END := 'Plant' *)\r\n(* @CONNECTIONS := Plant\r\nFILENAME : ''\r\n*)\r\n"
      "PROGRAM P\r\nVAR\r\n\tx : INT;\r\nEND_VAR\r\n(* @END_DECLARATION := '0' *)\r\nx := 1;\r\nEND_PROGRAM\r\n\r\n"
      "ACTION A:\r\nx := 2;\r\nEND_ACTION\r\n");
  ASSERT_TRUE(r.project);
  EXPECT_TRUE(r.diagnostics.all().empty());
  ASSERT_EQ(r.project->pous.size(), 1u);
  EXPECT_EQ(r.project->pous[0].at.line, 11u);
  ASSERT_EQ(r.project->pous[0].actions.size(), 1u);
  EXPECT_EQ(r.project->pous[0].actions[0].name, "A");
  ASSERT_EQ(r.project->configurations.size(), 1u);
  EXPECT_EQ(r.project->configurations[0].globals[0].prefix, "Plant");
  EXPECT_EQ(r.project->configurations[0].globals[0].at.line, 4u);
}

TEST(ExportFile, CommentsNestWhereTheToolNestedThem) {
  const std::string text =
      "PROGRAM P\r\nVAR\r\n\tx : INT; (* was (* y *)\r\nEND_VAR\r\n"
      "(* @END_DECLARATION := '0' *)\r\nx := 1; (* over (* two\r\nlines (*) x := 2;\r\nEND_PROGRAM\r\n";
  const Reading flat("(* @NESTEDCOMMENTS := 'No' *)\r\n" + text);
  ASSERT_TRUE(flat.project);
  EXPECT_TRUE(flat.diagnostics.all().empty());
  ASSERT_EQ(flat.project->pous.size(), 1u);
  ASSERT_EQ(flat.project->pous[0].variables.size(), 1u);
  EXPECT_TRUE(flat.project->pous[0].bodies[0].text.ends_with("*) x := 2;"));
  const Reading nested("(* @NESTEDCOMMENTS := 'Yes' *)\r\n" + text);
  EXPECT_NE(nested.count(core::Code::P4040), 0u);
}

TEST(ExportFile, FunctionblockIsOneWord) {
  const Reading r("FUNCTIONBLOCK B\r\nVAR\r\n\tx : INT;\r\nEND_VAR\r\nx := 1;\r\nEND_FUNCTION_BLOCK\r\n");
  ASSERT_TRUE(r.project);
  ASSERT_EQ(r.project->pous.size(), 1u);
  EXPECT_EQ(r.project->pous[0].bodies[0].text, "x := 1;");
}

TEST(ExportFile, DrawingsAreNamedWithTheirPouAndOthersGoOn) {
  const Reading r(
      "FUNCTION_BLOCK Drawn\r\nVAR_INPUT\r\n\ta : BOOL;\r\nEND_VAR\r\n(* @END_DECLARATION := '0' "
      "*)\r\n_LD_BODY\r\n_NETWORKS : 1\r\n"
      "_NETWORK\r\n_COMMENT\r\n'it's (* anything\r\n_END_COMMENT\r\n_LD_ASSIGN\r\nEND_FUNCTION_BLOCK\r\n"
      "PROGRAM P\r\nVAR\r\n\tx : INT;\r\nEND_VAR\r\nx := 1;\r\nEND_PROGRAM\r\n"
      "ACTION A:\r\n_IL_BODY\r\nLD 1\r\nEND_ACTION\r\n");
  ASSERT_TRUE(r.project);
  EXPECT_TRUE(r.diagnostics.all().empty());
  ASSERT_EQ(r.project->pous.size(), 2u);
  EXPECT_EQ(r.project->pous[0].variables.size(), 1u);
  EXPECT_NE(r.project->pous[0].unread.find("drawn in LD"), std::string::npos);
  EXPECT_TRUE(r.project->pous[1].unread.empty());
  EXPECT_EQ(r.project->pous[1].at.line, 14u);
  EXPECT_EQ(r.project->pous[1].bodies[0].text, "x := 1;");
  ASSERT_EQ(r.project->pous[1].actions.size(), 1u);
  EXPECT_NE(r.project->pous[1].actions[0].unread.find("IL"), std::string::npos);
}

TEST(ExportFile, WhatIsNoProgramIsPassedOver) {
  const Reading r(
      "LIBRARY\r\nStandard.lib 2.12\r\nit's: 0\r\nEND_LIBRARY\r\nPLC_CONFIGURATION\r\n(* "
      "\r\nPLC_END\r\nSTRANGE\r\nx\r\n"
      "(* @NESTEDCOMMENTS := 'Yes' *)\r\nPROGRAM P\r\nVAR x : INT; END_VAR\r\nx := 1;\r\nEND_PROGRAM\r\n");
  ASSERT_TRUE(r.project);
  EXPECT_EQ(r.count(core::Code::P1210), 1u);
  EXPECT_FALSE(r.diagnostics.has_errors());
  ASSERT_EQ(r.project->pous.size(), 1u);
  EXPECT_EQ(r.project->pous[0].at.line, 11u);
}

TEST(ExportFile, HostileBytesAreErrors) {
  EXPECT_FALSE(Reading(std::string("PROGRAM P\0END_PROGRAM", 21)).project);
  EXPECT_TRUE(Reading("PROGRAM P (* ").diagnostics.has_errors());
  EXPECT_TRUE(Reading("PROGRAM P\n_LD_BODY\n").diagnostics.has_errors());
  Reading("'");
  Reading("VAR_GLOBAL 'x$");
}

}  // namespace
}  // namespace plc::sources
