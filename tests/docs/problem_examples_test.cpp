// The wrong and the right example of every page of docs/problems are run: the wrong one must draw the code of its page,
// the right one must not, and must be fine. docs/guides/problem-pages.md says how pages write them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;

const fs::path kPages = fs::path(PLC_SOURCE_DIR) / "docs/problems";

/// Codes that no example can draw, and why.
const std::map<std::string, std::string> kNotShown = {
    {"P6020", "images written as text are read by tests only"},
    {"P7107", "a Modbus client gets it, as exception 6"},
    {"P7402", "needs GPIO lines: tests/gpio-vm has them"},
    {"P7403", "needs GPIO lines: tests/gpio-vm has them"},
    {"P7404", "needs GPIO lines: tests/gpio-vm has them"},
    {"P7405", "needs GPIO lines: tests/gpio-vm has them"},
    {"P7406", "needs GPIO lines: tests/gpio-vm has them"},
    {"P7410", "needs GPIO lines: the process that guards them starts when they are open"},
    {"P9001", "a defect of the program itself"},
};

/// One example: files by name, and the commands to run, or none.
struct Example {
  std::map<std::string, std::string> files;
  std::string commands;
  [[nodiscard]] bool runs() const { return !files.empty() || !commands.empty(); }
};

std::string default_name(const std::string& language) {
  if (language == "toml") return "plc.toml";
  if (language == "csv") return "stimulus.csv";
  return "example." + language;
}

/// A drawn POU alone stands for a project that runs its programs in one task.
std::string whole_project(const std::string& text) {
  if (text.rfind("<pou ", 0) != 0) return text;
  std::string instances;
  static const std::regex program(R"re(<pou name="(\w+)" pouType="program")re");
  for (std::sregex_iterator it(text.begin(), text.end(), program), end; it != end; ++it) {
    const std::string name = (*it)[1];
    instances += "<pouInstance name=\"run" + name + "\" typeName=\"" + name + "\"/>";
  }
  return R"(<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="" productName="example" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="example"><coordinateInfo><fbd><scaling x="0" y="0"/></fbd><ld><scaling x="0" y="0"/></ld><sfc><scaling x="0" y="0"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous>
)" + text +
         R"(</pous></types>
<instances><configurations><configuration name="C"><resource name="R"><task name="T" priority="0" interval="T#20ms">)" +
         instances + "</task></resource></configuration></configurations></instances>\n</project>\n";
}

/// What plc.toml is checked against where the page brings no project.
constexpr const char* kSmallProject = R"(PROGRAM Main
VAR
  Start AT %IX0.0 : BOOL;
  Level AT %IW1 : INT;
  Motor AT %QX0.0 : BOOL;
  Speed AT %QW1 : INT;
END_VAR
  Motor := Start;
  Speed := Level;
END_PROGRAM
CONFIGURATION C
  RESOURCE R ON PLC
    TASK T(INTERVAL := T#20ms, PRIORITY := 0);
    PROGRAM main WITH T : Main;
  END_RESOURCE
END_CONFIGURATION
)";

/// The fenced blocks below "## `heading`".
Example read_example(const std::string& page, const std::string& heading) {
  Example example;
  std::istringstream in(page);
  bool inside = false, fenced = false;
  std::string language, name, text;
  for (std::string line; std::getline(in, line);) {
    if (!fenced && line.rfind("## ", 0) == 0) inside = line == "## " + heading;
    if (line.rfind("```", 0) != 0) {
      if (fenced) text += line + "\n";
      continue;
    }
    fenced = !fenced;
    if (fenced) {
      std::istringstream words(line.substr(3));
      language.clear();
      name.clear();
      words >> language >> name;
      text.clear();
      continue;
    }
    if (!inside || language.empty() || language == "text") continue;
    if (language == "sh") {
      example.commands += text;
    } else {
      example.files[name.empty() ? default_name(language) : name] = language == "xml" ? whole_project(text) : text;
    }
  }
  return example;
}

/// Runs the commands of the example, or the usual one for its files, in a folder of its own.
ToolResult run(Example example) {
  const ScratchFolder scratch;
  if (example.commands.empty() || example.files.count("plc.toml") != 0) {
    const bool project = std::any_of(example.files.begin(), example.files.end(),
                                     [](const auto& file) { return file.first.rfind("example.", 0) == 0; });
    if (!project) example.files["example.st"] = kSmallProject;
  }
  if (example.commands.empty()) {
    const std::string file = example.files.count("example.xml") != 0 ? "example.xml" : "example.st";
    example.commands = example.files.count("plc.toml") != 0 ? "plc config check plc.toml " + file : "plc check " + file;
  }
  for (const auto& [name, text] : example.files) std::ofstream(scratch.file(name), std::ios::binary) << text;
  const std::string path = fs::path(PLC_TOOL).parent_path().string();
  return run_tool({"/bin/sh", "-ec", "cd \"$0\"; PATH=\"" + path + ":$PATH\"\n" + example.commands, scratch.file("")});
}

bool names(const std::string& output, const std::string& code) {
  return std::regex_search(output, std::regex("\\b" + code + "\\b"));
}

class ProblemExamples : public ::testing::TestWithParam<std::string> {};

/// What is wrong with the examples of a page; empty when nothing is.
std::string complaint(const std::string& code) {
  std::ifstream in(kPages / (code + ".md"), std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(in), {}};
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
  if (kNotShown.count(code) != 0) return;
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
  for (const auto& [code, reason] : kNotShown) EXPECT_EQ(known.count(code), 1u) << code << ": " << reason;
}

}  // namespace
