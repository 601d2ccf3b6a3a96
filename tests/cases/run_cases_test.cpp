// Runs every folder cases/<area>/<case>: simulates the project from its file and again from its image, there as native
// code, and compares the trace with what was worked out by hand. Why the numbers prove the point
// stands at the head of the project.
//
// Form of a case: docs in cases/README.md. Does not belong here: any knowledge of a single case.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "testing/case_file.h"
#include "testing/table.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::command_line;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::test::ToolResult;
using plc::tests::CaseFile;
using plc::tests::CaseRun;
using plc::tests::CsvTable;
using plc::tests::ExpectedFault;
using plc::tests::ExpectedWarning;
using plc::tests::same_value;

const char* const kTool = PLC_TOOL;
const char* const kCases = PLC_CASES;

bool contains(const std::string& line, const std::string& text) { return line.find(text) != std::string::npos; }

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) result.push_back(line);
  return result;
}

bool matches(const ExpectedWarning& expected, const std::string& line) {
  if (expected.code != "?" && !contains(line, " " + expected.code)) return false;
  return std::all_of(expected.texts.begin(), expected.texts.end(),
                     [&](const std::string& text) { return contains(line, text); });
}

/// Every expected warning is printed, and nothing warns that the case does not expect.
void check_warnings(const CaseFile& the_case, const std::string& output) {
  std::vector<std::string> lines = lines_of(output);
  std::erase_if(lines, [](const std::string& line) { return !contains(line, ": warning "); });
  for (const ExpectedWarning& expected : the_case.warnings) {
    EXPECT_TRUE(
        std::any_of(lines.begin(), lines.end(), [&](const std::string& line) { return matches(expected, line); }))
        << "missing warning " << expected.code << " naming: " << command_line(expected.texts) << "\noutput:\n"
        << output;
  }
  for (const std::string& line : lines) {
    EXPECT_TRUE(std::any_of(the_case.warnings.begin(), the_case.warnings.end(),
                            [&](const ExpectedWarning& expected) { return matches(expected, line); }))
        << "unexpected: " << line;
  }
}

/// Counts the lines "event: <kind> at <place>, <n> times" by kind.
std::map<std::string, std::uint64_t> events_of(const std::string& output) {
  std::map<std::string, std::uint64_t> result;
  for (const std::string& line : lines_of(output)) {
    const std::vector<std::string> parts = plc::tests::words(line);
    if (parts.size() < 4 || parts[0] != "event:") continue;
    result[parts[1]] += std::strtoull(parts[parts.size() - 2].c_str(), nullptr, 10);
  }
  return result;
}

/// Events and faults of a simulation are those that the case names, no more and no less.
void check_run(const CaseFile& the_case, const ToolResult& result) {
  EXPECT_EQ(events_of(result.all()), the_case.events) << result.all();
  EXPECT_EQ(result.code, the_case.faults.empty() ? 0 : 1) << result.all();
  std::vector<std::string> lines = lines_of(result.all());
  std::erase_if(lines, [](const std::string& line) { return line.rfind("fault ", 0) != 0; });
  EXPECT_EQ(lines.size(), the_case.faults.size()) << result.all();
  for (const ExpectedFault& fault : the_case.faults) {
    EXPECT_TRUE(std::any_of(lines.begin(), lines.end(),
                            [&](const std::string& line) {
                              return contains(line, "fault " + fault.code + ":") &&
                                     contains(line, " task " + fault.task + ",") &&
                                     contains(line, " cycle " + fault.cycle + ",");
                            }))
        << "missing fault " << fault.code << " in task " << fault.task << ", cycle " << fault.cycle << "\n"
        << result.all();
  }
}

void compare(const CaseFile& the_case, const CsvTable& expected, const std::string& expected_name,
             const CsvTable& actual) {
  ASSERT_EQ(expected.rows.size(), actual.rows.size()) << expected_name << ": number of release instants";
  for (std::size_t c = 0; c < expected.header.size(); ++c) {
    const std::size_t column = actual.column(expected.header[c]);
    ASSERT_LT(column, actual.header.size()) << "the trace has no column " << expected.header[c];
    for (std::size_t r = 0; r < expected.rows.size(); ++r) {
      ASSERT_LT(c, expected.rows[r].size()) << expected_name << ":" << expected.lines[r] << ": short row";
      ASSERT_LT(column, actual.rows[r].size()) << "the trace has a short row " << r + 1;
      EXPECT_TRUE(same_value(expected.rows[r][c], actual.rows[r][column],
                             plc::tests::tolerance_of(the_case, expected.header[c])))
          << expected_name << ":" << expected.lines[r] << ": " << expected.header[c] << " in cycle "
          << expected.rows[r][0] << " is " << actual.rows[r][column] << ", should be " << expected.rows[r][c];
    }
  }
}

/// `plc sim source`; compile options only where the source is the project (an image carries its own).
void simulate(const fs::path& folder, const CaseFile& the_case, const std::string& source,
              const std::vector<std::string>& options, const std::string& expected_name, bool with_warnings) {
  SCOPED_TRACE(source);
  const CsvTable expected = plc::tests::read_csv((folder / expected_name).string());
  ASSERT_GE(expected.header.size(), 3U) << expected_name << ": columns are cycle, time_ms and at least one path";
  const ScratchFolder scratch;
  std::vector<std::string> arguments = {
      kTool, "sim", source, "--cycles", std::to_string(expected.rows.size()), "--trace", scratch.file("trace.csv")};
  if (fs::exists(folder / "stimulus.csv")) {
    arguments.insert(arguments.end(), {"--stimulus", (folder / "stimulus.csv").string()});
  }
  for (std::size_t c = 2; c < expected.header.size(); ++c) {
    arguments.insert(arguments.end(), {"--watch", expected.header[c]});
  }
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ToolResult result = run_tool(arguments);
  SCOPED_TRACE(command_line(arguments));
  ASSERT_TRUE(fs::exists(scratch.file("trace.csv"))) << result.all();
  check_run(the_case, result);
  if (with_warnings) check_warnings(the_case, result.all());
  compare(the_case, expected, expected_name, plc::tests::read_csv(scratch.file("trace.csv")));
}

std::string test_name(const ::testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == '-'; }, '_');
  return name;
}

/// The comment that a project begins with, behind the declaration of XML, or nothing.
std::string reason_of(const fs::path& project) {
  std::ifstream in(fs::is_directory(project) ? project / "README.md" : project);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (fs::is_directory(project)) return text;
  if (project.extension() == ".xml") {
    text.erase(0, text.find("?>") + 2);
    text.erase(0, text.find_first_not_of("\r\n"));
  }
  for (const auto& [begin, end] : {std::pair("<!--", "-->"), std::pair("(*", "*)"), std::pair("//", "\n")}) {
    const std::size_t size = std::string_view(begin).size();
    if (text.rfind(begin, 0) == 0) return text.substr(size, text.find(end) - size);
  }
  return {};
}

class Case : public ::testing::TestWithParam<std::string> {};

TEST_P(Case, TraceEqualsTheHandWorkedTable) {
  const fs::path folder = fs::path(kCases) / GetParam();
  const std::string project = plc::tests::project_of(folder).string();
  EXPECT_NE(reason_of(project).find_first_not_of(" \r\n"), std::string::npos)
      << "the head of the project says why its numbers prove its point";
  const CaseFile the_case = plc::tests::read_case(folder);
  EXPECT_TRUE(the_case.wrong.empty()) << the_case.wrong.front();
  for (std::size_t i = 0; i < the_case.runs.size(); ++i) {
    const CaseRun& run = the_case.runs[i];
    SCOPED_TRACE("run " + run.expected + " " + command_line(run.options));
    std::vector<std::string> options = run.options;
    for (const std::string& library : the_case.libraries) {
      options.insert(options.end(), {"--lib", (folder / library).string()});
    }
    simulate(folder, the_case, project, options, run.expected, i == 0);
    const fs::path drawn = folder / "drawn.xml";
    if (fs::exists(drawn)) simulate(folder, the_case, drawn.string(), options, run.expected, i == 0);

    const ScratchFolder scratch;
    const std::string image = scratch.file("project.pbc");
    std::vector<std::string> compile = {kTool, "compile", project, "-o", image};
    compile.insert(compile.end(), options.begin(), options.end());
    const ToolResult compiled = run_tool(compile);
    ASSERT_EQ(compiled.code, 0) << command_line(compile) << "\n" << compiled.all();
    simulate(folder, the_case, image, {"--engine", "native"}, run.expected, false);
  }
  if (the_case.order.empty()) return;
  const ToolResult explained = run_tool({kTool, "explain", project});
  EXPECT_EQ(explained.code, 0) << explained.all();
  EXPECT_TRUE(plc::tests::in_sequence(the_case.order, plc::test::explained_order(explained.out)))
      << "explain should list " << command_line(the_case.order) << " in this order:\n"
      << explained.out;
}

INSTANTIATE_TEST_SUITE_P(Cases, Case, ::testing::ValuesIn(plc::tests::case_names(kCases)), test_name);

}  // namespace
