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

/// Long flags in a text, such as a help page.
std::set<std::string> flags_in(const std::string& text) {
  static const std::regex flag("--[a-z][a-z-]+[a-z]");
  return {std::sregex_token_iterator(text.begin(), text.end(), flag), std::sregex_token_iterator()};
}

void expect_documented(const std::vector<std::string>& command, const fs::path& page) {
  std::vector<std::string> arguments = command;
  arguments.push_back("--help");
  const auto help = run_tool(arguments);
  ASSERT_EQ(help.code, 0) << plc::test::command_line(arguments);
  const std::string manual = std::regex_replace(text_of(page), std::regex(R"(\\-)"), "-");
  const std::set<std::string> flags = flags_in(help.out);
  EXPECT_FALSE(flags.empty());
  for (const std::string& flag : flags) {
    EXPECT_NE(manual.find(flag), std::string::npos)
        << page.filename() << " does not mention " << flag << " of " << plc::test::command_line(command);
  }
}

/// `plc` with each of its commands.
const std::vector<std::vector<std::string>> kCommands = {{PLC_TOOL, "blocks"},
                                                         {PLC_TOOL, "calibrate"},
                                                         {PLC_TOOL, "check"},
                                                         {PLC_TOOL, "compile"},
                                                         {PLC_TOOL, "config", "init"},
                                                         {PLC_TOOL, "config", "check"},
                                                         {PLC_TOOL, "dump"},
                                                         {PLC_TOOL, "explain"},
                                                         {PLC_TOOL, "lib"},
                                                         {PLC_TOOL, "map"},
                                                         {PLC_TOOL, "sim"},
                                                         {PLC_TOOL, "report"}};

TEST(Manuals, MentionEveryFlag) {
  for (const auto& command : kCommands) expect_documented(command, kRoot / "docs/man/plc.1");
  expect_documented({PLC_RUN_TOOL}, kRoot / "docs/man/plc-run.1");
}

TEST(Manuals, MentionNoFlagThatDoesNotExist) {
  std::set<std::string> known = {"--help", "--version"};
  for (std::vector<std::string> command : kCommands) {
    command.push_back("--help");
    known.merge(flags_in(run_tool(command).out));
  }
  const std::set<std::string> run_flags = flags_in(run_tool({PLC_RUN_TOOL, "--help"}).out);
  const auto manual = [](const char* name) {
    return flags_in(std::regex_replace(text_of(kRoot / "docs/man" / name), std::regex(R"(\\-)"), "-"));
  };
  for (const std::string& flag : manual("plc.1")) EXPECT_EQ(known.count(flag), 1u) << "plc.1 invents " << flag;
  known.insert(run_flags.begin(), run_flags.end());
  for (const std::string& flag : manual("plc-run.1")) EXPECT_EQ(known.count(flag), 1u) << "plc-run.1 invents " << flag;
}

TEST(DecisionRecords, HaveUniqueNumbersAndAStatus) {
  std::map<std::string, std::string> by_number;
  for (const auto& entry : fs::directory_iterator(kRoot / "docs/adr")) {
    const std::string name = entry.path().filename().string();
    if (name == "README.md") continue;
    const auto [it, fresh] = by_number.emplace(name.substr(0, 4), name);
    EXPECT_TRUE(fresh) << name << " and " << it->second << " share a number";
    const std::string text = text_of(entry.path());
    EXPECT_NE(text.find("Status: accepted"), std::string::npos)
        << name << " is not accepted: decide, or do not merge it";
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
