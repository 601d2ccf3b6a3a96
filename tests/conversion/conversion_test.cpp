// Every case and every real project is converted to text and read back: the same image, or the same behaviour and the
// reason in reasons.txt. What cannot be converted is there, too, with the message.
//
// Does not belong here: how a single thing is written (tests/unit/convert).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "testing/case_file.h"
#include "testing/table.h"
#include "tests/support/golden.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;
using tests::CsvTable;

const char* const kTool = PLC_TOOL;

std::string first_error(const std::string& output) {
  static const std::regex kError(R"((error|plc convert): ?(P\d+)?:? ?([^\n]*))");
  std::smatch found;
  static const std::regex kCoded(R"(error (P\d+): ([^\n]*))");
  if (std::regex_search(output, found, kCoded)) return found[1].str() + " " + found[2].str();
  if (std::regex_search(output, found, kError)) return found[0].str();
  return "no message";
}

struct Project {
  std::string name;  ///< in reasons.txt
  std::string path;
  std::vector<std::string> options;
  std::string stimulus;  ///< or empty
  std::size_t cycles = 20;
};

/// A trace of all variables.
CsvTable trace_of(const Project& project, const std::string& path, const std::string& file) {
  std::vector<std::string> arguments = {kTool,     "sim", path, "--cycles", std::to_string(project.cycles),
                                        "--trace", file};
  if (!project.stimulus.empty()) arguments.insert(arguments.end(), {"--stimulus", project.stimulus});
  arguments.insert(arguments.end(), project.options.begin(), project.options.end());
  const ToolResult result = run_tool(arguments, 120);
  EXPECT_TRUE(fs::exists(file)) << result.all();
  return fs::exists(file) ? tests::read_csv(file) : CsvTable{};
}

/// A stimulus for the text: a keyword is no name there.
std::string for_text(const std::string& stimulus, const std::string& to) {
  std::ifstream in(stimulus);
  const std::string rows{std::istreambuf_iterator<char>(in), {}};
  static const std::regex kKeyword(R"(\.(By|Not)\b)");
  std::ofstream(to) << std::regex_replace(rows, kKeyword, ".$1_");
  return to;
}

/// What both have, changes alike.
void expect_same_behaviour(Project project, const std::string& text) {
  const ScratchFolder scratch;
  const CsvTable drawn = trace_of(project, project.path, scratch.file("drawn.csv"));
  if (!project.stimulus.empty()) project.stimulus = for_text(project.stimulus, scratch.file("stimulus.csv"));
  const CsvTable written = trace_of(project, text, scratch.file("written.csv"));
  ASSERT_EQ(drawn.rows.size(), written.rows.size());
  for (std::size_t c = 0; c < drawn.header.size(); ++c) {
    std::size_t column = written.column(drawn.header[c]);
    // A keyword is no name in a text.
    if (column >= written.header.size()) column = written.column(drawn.header[c] + "_");
    ASSERT_LT(column, written.header.size()) << "the text has no " << drawn.header[c];
    for (std::size_t r = 0; r < drawn.rows.size(); ++r) {
      ASSERT_TRUE(tests::same_value(drawn.rows[r][c], written.rows[r][column]))
          << drawn.header[c] << " in cycle " << r << " is " << written.rows[r][column] << ", drawn "
          << drawn.rows[r][c];
    }
  }
}

/// Nothing for the same image, else why not.
std::string reason(const Project& project) {
  SCOPED_TRACE(project.path);
  const ScratchFolder scratch;
  const std::string text = scratch.file("converted.st");
  std::vector<std::string> arguments = {kTool, "convert", project.path, "-o", text};
  arguments.insert(arguments.end(), project.options.begin(), project.options.end());
  const ToolResult result = run_tool(arguments, 120);
  EXPECT_TRUE(result.code == 0 || result.code == 1) << result.all();
  // Errors name the scratch file, which is another one each time.
  if (result.code != 0) return first_error(result.err);
  if (result.out.find(": same image as ") != std::string::npos) return {};
  if (result.out.find("no images to compare") != std::string::npos) return "no task runs a program";
  expect_same_behaviour(project, text);
  const std::size_t open = result.out.find("another one (");
  std::string out = result.out.substr(open + 13, result.out.find(")\n", open) - open - 13);
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("  ", 0) == 0) out += ";" + line.substr(1);
  }
  return out;
}

/// Converts all of them; those that give another image, or none, as lines.
std::string reasons(const std::vector<Project>& projects, std::size_t& same) {
  std::string list;
  for (const Project& project : projects) {
    const std::string why = reason(project);
    if (why.empty()) ++same;
    if (!why.empty()) list += project.name + ": " + why + "\n";
  }
  std::cout << same << " of " << projects.size() << " give the same image\n";
  return list;
}

TEST(Convert, CasesGiveTheSameImageOrAReason) {
  std::vector<Project> projects;
  for (const std::string& name : tests::case_names(PLC_CASES)) {
    const fs::path folder = fs::path(PLC_CASES) / name;
    const tests::CaseFile the_case = tests::read_case(folder);
    Project project{name, tests::project_of(folder).string(), the_case.runs.front().options, {}, 20};
    for (const std::string& library : the_case.libraries) {
      project.options.insert(project.options.end(), {"--lib", (folder / library).string()});
    }
    if (fs::exists(folder / "stimulus.csv")) project.stimulus = (folder / "stimulus.csv").string();
    projects.push_back(project);
    if (!fs::exists(folder / "drawn.xml")) continue;
    project.name += " (drawn)";
    project.path = (folder / "drawn.xml").string();
    projects.push_back(std::move(project));
  }
  std::size_t same = 0;
  expect_golden("tests/conversion/reasons.txt", reasons(projects, same));
  EXPECT_GT(same, projects.size() / 2);
}

TEST(Convert, RealProjectsGiveTheSameImageOrAReason) {
  const char* const chosen = std::getenv("PLC_CORPUS");
  const fs::path corpus = chosen != nullptr ? fs::path(chosen) : fs::path(PLC_CORPUS_DEFAULT);
  if (!fs::is_directory(corpus)) {
    GTEST_SKIP() << "no folder " << corpus << ": real projects are not part of this repository (set PLC_CORPUS)";
  }
  std::vector<Project> projects;
  for (const auto& entry : fs::directory_iterator(corpus)) {
    if (entry.path().extension() != ".xml") continue;
    projects.push_back({entry.path().filename().string(), entry.path().string(), {"--stub-missing"}, {}, 20});
  }
  std::sort(projects.begin(), projects.end(), [](const Project& a, const Project& b) { return a.name < b.name; });
  std::size_t same = 0;
  expect_golden("tests/conversion/corpus_reasons.txt", reasons(projects, same));
}

}  // namespace
}  // namespace plc::test
