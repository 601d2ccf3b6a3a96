// The wrong and the right example of every page of docs/problems are run: the wrong one must draw the code of its page,
// the right one must not, and must be fine. docs/guides/problem-pages.md says how pages write them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/problem_page.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::Example;
using plc::test::names;
using plc::test::read_example;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;

const fs::path kPages = fs::path(PLC_SOURCE_DIR) / "docs/problems";

/// Codes whose examples need more than the commands, and where they are run.
const std::map<std::string, std::string> kNotHere = {
    {"P7402", "tests/gpio-vm/page_test.cpp"},
    {"P7403", "tests/gpio-vm/page_test.cpp"},
    {"P7404", "tests/gpio-vm/page_test.cpp"},
    {"P7405", "tests/gpio-vm/page_test.cpp"},
    {"P7406", "tests/gpio-vm/page_test.cpp"},
    {"P7410", "tests/gpio-vm/page_test.cpp"},
    {"P7421", "tests/drivers/example_test.cpp"},
    {"P7931", "tests/unit/doctor"},
    {"P7932", "tests/unit/doctor"},
    {"P7934", "tests/unit/doctor"},
    {"P7965", "tests/unit/doctor"},
    {"P7632", "tests/tools/replay_test.cpp"},
    {"P7802", "tests/taskblocks/run_test.cpp"},
    {"R1004", "tests/taskblocks/run_test.cpp"},
    {"R1005", "tests/taskblocks/run_test.cpp"},
    {"P9001", "nowhere: a defect of the program itself"},
};

/// Runs the commands of the example, or the usual one for its files, in a folder of its own.
ToolResult run(Example example) {
  const ScratchFolder scratch;
  if (example.commands.empty() || example.files.count("plc.toml") != 0) {
    const bool project = std::any_of(example.files.begin(), example.files.end(),
                                     [](const auto& file) { return file.first.rfind("example.", 0) == 0; });
    if (!project) example.files["example.st"] = plc::test::kSmallProject;
  }
  if (example.commands.empty()) {
    const std::string file = example.files.count("example.xml") != 0 ? "example.xml" : "example.st";
    example.commands = example.files.count("plc.toml") != 0 ? "plc config check plc.toml " + file : "plc check " + file;
  }
  for (const auto& [name, text] : example.files) std::ofstream(scratch.file(name), std::ios::binary) << text;
  const std::string path = fs::path(PLC_TOOL).parent_path().string();
  return run_tool({"/bin/sh", "-ec", "cd \"$0\"; PATH=\"" + path + ":$PATH\"\n" + example.commands, scratch.file("")});
}

class ProblemExamples : public ::testing::TestWithParam<std::string> {};

/// What is wrong with the examples of a page; empty when nothing is.
std::string complaint(const std::string& code) {
  const std::string page = kPages / (code + ".md");
  const Example wrong = read_example(page, "Wrong");
  const Example right = read_example(page, "Right");
  if (!wrong.runs() || !right.runs()) return "it needs a wrong and a right example: see docs/guides/problem-pages.md";
  const ToolResult bad = run(wrong);
  if (!names(bad.all(), code)) return "the wrong example draws other codes, or none:\n" + bad.all();
  const ToolResult good = run(right);
  if (names(good.all(), code)) return "the right example draws the code too:\n" + good.all();
  if (good.code != 0) return "the right example is not fine:\n" + good.all();
  return {};
}

TEST_P(ProblemExamples, WrongOneDrawsTheCodeAndRightOneDoesNot) {
  const std::string code = GetParam();
  if (kNotHere.contains(code)) return;
  // A file of the kernel that the wrong example takes; containers may have none.
  const std::string commands = read_example(kPages / (code + ".md"), "Wrong").commands;
  const std::size_t at = commands.find(" /sys/");
  const std::string file =
      at == std::string::npos ? "" : commands.substr(at + 1, commands.find_first_of(" \n", at + 1) - at - 1);
  if (!file.empty() && !fs::exists(file)) GTEST_SKIP() << "its example takes " << file << ", which is not here";
  const std::string found = complaint(code);
  EXPECT_TRUE(found.empty()) << code << ": " << found;
}

std::vector<std::string> pages() {
  std::vector<std::string> codes;
  for (const auto& entry : fs::directory_iterator(kPages)) codes.push_back(entry.path().stem().string());
  std::sort(codes.begin(), codes.end());
  return codes;
}

INSTANTIATE_TEST_SUITE_P(Pages, ProblemExamples, ::testing::ValuesIn(pages()),
                         [](const auto& param) { return param.param; });

TEST(ProblemExamples, ListsNameOnlyPagesThatExist) {
  const std::vector<std::string> all = pages();
  const std::set<std::string> known(all.begin(), all.end());
  for (const auto& [code, where] : kNotHere) EXPECT_EQ(known.count(code), 1u) << code << ": " << where;
}

}  // namespace
