// The protocol by which tasks exchange globals changes when copies are made, never what is computed: on one thread, all
// variables of every case with several tasks go the same way under each --coherence, byte for byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <vector>

#include "testing/case_file.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::ToolResult;

/// A file, or all files of a folder.
std::string text_of(const fs::path& path) {
  std::string text;
  if (fs::is_directory(path)) {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path)) {
      if (entry.is_regular_file()) text += text_of(entry.path());
    }
    return text;
  }
  std::ifstream in(path, std::ios::binary);
  text.assign(std::istreambuf_iterator<char>(in), {});
  return text;
}

/// Cases whose project declares more than one task.
std::vector<std::string> cases_with_tasks() {
  const std::regex task(R"(<[tT]ask |^\s*TASK )", std::regex::multiline);
  std::vector<std::string> names = plc::tests::case_names(PLC_CASES);
  std::erase_if(names, [&](const std::string& name) {
    const std::string text = text_of(plc::tests::project_of(fs::path(PLC_CASES) / name));
    return std::distance(std::sregex_iterator(text.begin(), text.end(), task), std::sregex_iterator()) < 2;
  });
  return names;
}

class Coherence : public ::testing::TestWithParam<std::string> {};

TEST_P(Coherence, TracesAreTheSameUnderEveryProtocol) {
  const fs::path folder = fs::path(PLC_CASES) / GetParam();
  const plc::tests::CaseFile the_case = plc::tests::read_case(folder);
  std::string expected, faults;
  for (const char* protocol : {"wait-free", "global-lock", "priority-ceiling"}) {
    const plc::test::ScratchFolder scratch;
    std::vector<std::string> arguments = {PLC_TOOL,      "sim",     plc::tests::project_of(folder).string(),
                                          "--cycles",    "60",      "--watch",
                                          "*",           "--trace", scratch.file("trace.csv"),
                                          "--coherence", protocol};
    if (fs::exists(folder / "stimulus.csv")) {
      arguments.insert(arguments.end(), {"--stimulus", (folder / "stimulus.csv").string()});
    }
    const std::vector<std::string>& options = the_case.runs.front().options;
    arguments.insert(arguments.end(), options.begin(), options.end());
    const ToolResult result = plc::test::run_tool(arguments);
    const std::string trace = text_of(scratch.file("trace.csv"));
    ASSERT_FALSE(trace.empty()) << plc::test::command_line(arguments) << "\n" << result.all();
    if (expected.empty()) {
      expected = trace;
      faults = result.err;
    }
    EXPECT_EQ(trace, expected) << protocol;
    EXPECT_EQ(result.err, faults) << protocol;
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, Coherence, ::testing::ValuesIn(cases_with_tasks()), [](const auto& param) {
  std::string name = param.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == '-'; }, '_');
  return name;
});

TEST(CoherenceCases, ThereAreSome) { EXPECT_GE(cases_with_tasks().size(), 10u); }

}  // namespace
