#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

TEST(Check, ExampleCompilesWithoutAWord) {
  const auto result = run_tool({PLC_TOOL, "check", tank()});
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.err, "");
  EXPECT_NE(result.out.find("ok"), std::string::npos) << result.out;
}

TEST(Check, ErrorsGoToStderrWithPlaceAndElement) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("bad.xml");
  write_text(file, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find(file + ":11:"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("Nowhere"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("[POU Main, contact 2]"), std::string::npos) << result.err;
}

TEST(Check, AllFilesAreCheckedAndTheWorstDecides) {
  const ScratchFolder scratch;
  const std::string bad = scratch.file("bad.xml");
  write_text(bad, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", bad, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.out.find("tank.xml: ok"), std::string::npos) << result.out;
  EXPECT_EQ(run_tool({PLC_TOOL, "check", bad, scratch.file("absent.xml")}).code, 2);
}

TEST(Check, JsonIsOneDocumentOnStdout) {
  const ScratchFolder scratch;
  const std::string bad = scratch.file("bad.xml");
  write_text(bad, small_project(true, kUnknownVariableBody));
  const auto result = run_tool({PLC_TOOL, "check", "--json", bad, tank()});
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "");
  const auto document = nlohmann::json::parse(result.out);
  ASSERT_EQ(document["files"].size(), 2u);
  EXPECT_FALSE(document["files"][0]["ok"]);
  EXPECT_TRUE(document["files"][1]["ok"]);
  bool found = false;
  for (const auto& row : document["diagnostics"]) {
    for (const char* key : {"file", "line", "column", "code", "severity", "pou", "element", "localId", "message", "help"}) {
      EXPECT_TRUE(row.contains(key)) << key;
    }
    found = found || (row["severity"] == "error" && row["line"] == 11 && row["pou"] == "Main" && row["localId"] == 2 &&
                      row["element"] == "contact");
  }
  EXPECT_TRUE(found) << result.out;
}

TEST(Check, JsonSurvivesBytesThatAreNoText) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("binary.xml");
  write_text(file, std::string("<project name=\"\xff\xfe\x80\">\x01\x02", 22));
  const auto result = run_tool({PLC_TOOL, "check", "--json", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_TRUE(nlohmann::json::accept(result.out)) << result.out;
}

TEST(Check, BodiesInOtherLanguagesAreNamedEach) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("il.xml");
  write_text(file, small_project(true, kIlBody));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 1);
  EXPECT_NE(result.err.find("P5101"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("\"Main\""), std::string::npos) << result.err;
  const auto stubbed = run_tool({PLC_TOOL, "check", file, "--stub-missing"});
  EXPECT_EQ(stubbed.code, 0) << stubbed.err;
  EXPECT_NE(stubbed.err.find("P5102"), std::string::npos) << stubbed.err;
}

TEST(Check, AProjectThatDrawsNothingSaysSo) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("empty.xml");
  write_text(file, small_project(true, "<LD/>"));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.err.find("P5103"), std::string::npos) << result.err;
}

TEST(Check, AFileWithoutInstancesIsFine) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("library.xml");
  write_text(file, small_project(false));
  const auto result = run_tool({PLC_TOOL, "check", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("no task runs a program"), std::string::npos) << result.out;
}

TEST(Check, ReportAccountsForElements) {
  const auto result = run_tool({PLC_TOOL, "report", tank()});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_NE(result.out.find("PLCopen TC6 2.01"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("Station"), std::string::npos);
  EXPECT_NE(result.out.find("\nUsed\n"), std::string::npos);
}

}  // namespace
}  // namespace plc::test
