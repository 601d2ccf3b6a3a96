// The documents keep up with the program: a page for every problem code, man pages with every flag, decision records
// with unique numbers, and nothing in the tree that does not belong there. Links: links_test.cpp.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "tests/docs/tree.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::kRoot;
using plc::test::run_tool;
using plc::test::text_of;
using plc::test::tree;

TEST(ProblemPages, EveryCodeHasItsPage) {
  for (const plc::core::CodeInfo& code : plc::core::all_codes()) {
    const fs::path page = kRoot / "docs/problems" / (std::string(code.name) + ".md");
    ASSERT_TRUE(fs::exists(page)) << code.name << " (" << code.title << ") has no page " << page;
    const std::string text = text_of(page);
    EXPECT_EQ(text.substr(0, text.find('\n')), "# " + std::string(code.name) + ": " + std::string(code.title)) << page;
    EXPECT_NE(text.find("\n## Wrong\n"), std::string::npos) << page << " has no wrong example";
    EXPECT_NE(text.find("\n## Right\n"), std::string::npos) << page << " has no right example";
  }
}

TEST(ProblemPages, EveryPageHasItsCode) {
  std::set<std::string> codes;
  for (const plc::core::CodeInfo& code : plc::core::all_codes()) codes.emplace(code.name);
  for (const auto& entry : fs::directory_iterator(kRoot / "docs/problems")) {
    EXPECT_EQ(codes.count(entry.path().stem().string()), 1u) << entry.path() << " explains a code that does not exist";
  }
}

TEST(Manuals, AreWhatTheProgramsSay) {
  const char* const kHow = " is not what the program says: cmake --build --preset release --target docs-update";
  EXPECT_EQ(run_tool({PLC_TOOL, "--manual"}).out, text_of(kRoot / "docs/man/plc.1")) << "docs/man/plc.1" << kHow;
  EXPECT_EQ(run_tool({PLC_RUN_TOOL, "--manual"}).out, text_of(kRoot / "docs/man/plc-run.1"))
      << "docs/man/plc-run.1" << kHow;
}

TEST(Commands, AreAllInTheStart) {
  static const std::regex example("\n  plc ([a-z]+) ");
  const std::string help = run_tool({PLC_TOOL, "--help"}).out;
  const std::string start = text_of(kRoot / "docs/guides/start.md");
  std::set<std::string> commands;
  for (std::sregex_iterator it(help.begin(), help.end(), example), end; it != end; ++it) commands.insert((*it)[1]);
  EXPECT_GE(commands.size(), 11u);
  for (const std::string& command : commands) {
    EXPECT_NE(start.find("plc " + command + " "), std::string::npos) << "start.md does not show plc " << command;
  }
}

TEST(DecisionRecords, HaveUniqueNumbersAndAStatus) {
  std::map<std::string, std::string> by_number;
  for (const auto& entry : fs::directory_iterator(kRoot / "docs/adr")) {
    const std::string name = entry.path().filename().string();
    if (name == "README.md") continue;
    const auto [it, fresh] = by_number.emplace(name.substr(0, 4), name);
    EXPECT_TRUE(fresh) << name << " and " << it->second << " share a number";
    const std::string text = text_of(entry.path());
    const bool decided =
        text.find("Status: accepted") != std::string::npos || text.find("Status: superseded by [") != std::string::npos;
    EXPECT_TRUE(decided) << name << " is neither accepted nor superseded: decide, or do not merge it";
    for (const char* section : {"## Context", "## Decision", "## Consequences"}) {
      EXPECT_NE(text.find(section), std::string::npos) << name << " has no " << section;
    }
  }
  EXPECT_GE(by_number.size(), 9u);
}

TEST(Tree, HoldsNoBuildProducts) {
  constexpr std::uintmax_t kMostBytes = 1'000'000;
  for (const fs::path& file : tree()) {
    std::ifstream in(file, std::ios::binary);
    char head[4] = {};
    in.read(head, 4);
    EXPECT_NE(std::string(head, 4), std::string("\x7f"
                                                "ELF"))
        << fs::relative(file, kRoot) << " is an ELF file";
    EXPECT_LE(fs::file_size(file), kMostBytes) << fs::relative(file, kRoot) << " is large: generate it in the test";
  }
}

}  // namespace
