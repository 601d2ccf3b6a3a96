// Runs every folder cases/<area>/<case>: simulates project.xml from the file and again from its image, and compares the
// trace with what was worked out by hand from the drawing (README.md of the case).
//
// Form of a case: docs in cases/README.md. Does not belong here: any knowledge of a single case.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/csv_table.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::command_line;
using plc::test::CsvTable;
using plc::test::run_tool;
using plc::test::same_value;
using plc::test::ScratchFolder;
using plc::test::ToolResult;

const char* const kTool = PLC_TOOL;
const char* const kCases = PLC_CASES;

/// One simulation of the project: the options it takes and the table its trace must equal.
struct Simulation {
  std::string expected;
  std::vector<std::string> options;
};

/// A warning that must be printed: its code ("?" = any) and texts that must stand in the same message.
struct ExpectedWarning {
  std::string code;
  std::vector<std::string> texts;
};

struct CaseFile {
  std::vector<Simulation> runs;
  std::vector<std::string> order;  ///< localIds as `plc explain` must list them, whatever stands between
  std::vector<ExpectedWarning> warnings;
};

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> result;
  for (std::string word; in >> word;) result.push_back(word);
  return result;
}

CaseFile read_case(const fs::path& folder) {
  CaseFile result;
  std::ifstream in(folder / "case.txt");
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string> parts = words(line);
    if (parts.empty() || parts[0].front() == '#') continue;
    if (parts.size() < 2) {
      ADD_FAILURE() << "case.txt: line without a value: " << line;
    } else if (parts[0] == "run:") {
      result.runs.push_back({parts[1], {parts.begin() + 2, parts.end()}});
    } else if (parts[0] == "order:") {
      result.order.assign(parts.begin() + 1, parts.end());
    } else if (parts[0] == "warning:") {
      result.warnings.push_back({parts[1], {parts.begin() + 2, parts.end()}});
    } else {
      ADD_FAILURE() << "case.txt: unknown key: " << line;
    }
  }
  if (result.runs.empty()) result.runs.push_back({"expected.csv", {}});
  return result;
}

/// Lines of the tool's output that report a warning.
std::vector<std::string> warning_lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.find(": warning ") != std::string::npos) result.push_back(line);
  }
  return result;
}

bool matches(const ExpectedWarning& expected, const std::string& line) {
  if (expected.code != "?" && line.find(" " + expected.code) == std::string::npos) return false;
  return std::all_of(expected.texts.begin(), expected.texts.end(),
                     [&](const std::string& text) { return line.find(text) != std::string::npos; });
}

/// Every expected warning is printed, and nothing warns that the case does not expect.
void check_warnings(const CaseFile& the_case, const std::string& output) {
  const std::vector<std::string> lines = warning_lines(output);
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

void compare(const CsvTable& expected, const std::string& expected_name, const CsvTable& actual) {
  ASSERT_EQ(expected.rows.size(), actual.rows.size()) << expected_name << ": number of release instants";
  for (std::size_t c = 0; c < expected.header.size(); ++c) {
    const std::size_t column = actual.column(expected.header[c]);
    ASSERT_LT(column, actual.header.size()) << "the trace has no column " << expected.header[c];
    for (std::size_t r = 0; r < expected.rows.size(); ++r) {
      ASSERT_LT(c, expected.rows[r].size()) << expected_name << ":" << expected.lines[r] << ": short row";
      ASSERT_LT(column, actual.rows[r].size()) << "the trace has a short row " << r + 1;
      EXPECT_TRUE(same_value(expected.rows[r][c], actual.rows[r][column]))
          << expected_name << ":" << expected.lines[r] << ": " << expected.header[c] << " in cycle "
          << expected.rows[r][0] << " is " << actual.rows[r][column] << ", should be " << expected.rows[r][c];
    }
  }
}

/// `plc sim source`; `options` only where the source is the XML (an image carries its own).
void simulate(const fs::path& folder, const std::string& source, const std::vector<std::string>& options,
              const std::string& expected_name, const CaseFile* warnings_of) {
  SCOPED_TRACE(source);
  const CsvTable expected = plc::test::read_csv((folder / expected_name).string());
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
  ASSERT_EQ(result.code, 0) << result.all();
  if (warnings_of != nullptr) check_warnings(*warnings_of, result.all());
  compare(expected, expected_name, plc::test::read_csv(scratch.file("trace.csv")));
}

std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kCases)) {
    if (entry.path().filename() == "project.xml") {
      names.push_back(fs::relative(entry.path().parent_path(), kCases).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string test_name(const ::testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '/' || c == '-'; }, '_');
  return name;
}

class Case : public ::testing::TestWithParam<std::string> {};

TEST_P(Case, TraceEqualsTheHandWorkedTable) {
  const fs::path folder = fs::path(kCases) / GetParam();
  ASSERT_TRUE(fs::exists(folder / "README.md")) << "a case says why its numbers prove its point";
  const CaseFile the_case = read_case(folder);
  const std::string project = (folder / "project.xml").string();
  for (std::size_t i = 0; i < the_case.runs.size(); ++i) {
    const Simulation& run = the_case.runs[i];
    SCOPED_TRACE("run " + run.expected + " " + command_line(run.options));
    simulate(folder, project, run.options, run.expected, i == 0 ? &the_case : nullptr);

    const ScratchFolder scratch;
    const std::string image = scratch.file("project.pbc");
    std::vector<std::string> compile = {kTool, "compile", project, "-o", image};
    compile.insert(compile.end(), run.options.begin(), run.options.end());
    const ToolResult compiled = run_tool(compile);
    ASSERT_EQ(compiled.code, 0) << command_line(compile) << "\n" << compiled.all();
    simulate(folder, image, {}, run.expected, nullptr);
  }
  if (the_case.order.empty()) return;
  const ToolResult explained = run_tool({kTool, "explain", project});
  EXPECT_EQ(explained.code, 0) << explained.all();
  EXPECT_TRUE(plc::test::in_sequence(the_case.order, plc::test::explained_order(explained.out)))
      << "explain should list " << command_line(the_case.order) << " in this order:\n"
      << explained.out;
}

INSTANTIATE_TEST_SUITE_P(Cases, Case, ::testing::ValuesIn(case_names()), test_name);

}  // namespace
