// Runs `plc check` on every bad project of diagnostics/<name>/ and looks for the messages of expected.txt: place, code
// and texts. Also that the same answer as JSON can be parsed.
//
// expected.txt: `exit N`, `options ..`, and one line per message that must appear: `line:col code [texts that the
// message holds]`; `?` stands for any line, column or code. `only`: nothing else is reported. Does not belong here:
// knowledge of a single project.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::command_line;
using plc::test::run_tool;
using plc::test::ToolResult;

const char* const kTool = PLC_TOOL;
const char* const kFolder = PLC_DIAGNOSTICS;

struct Message {
  std::string line = "?", column = "?", code = "?";
  std::vector<std::string> texts;
  std::string written;  ///< the line of expected.txt
};

struct Expected {
  int exit = 1;
  bool only = false;  ///< nothing else is reported
  std::vector<std::string> options;
  std::vector<Message> messages;
};

Expected read_expected(const fs::path& path) {
  Expected result;
  std::ifstream in(path);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    std::string first;
    words >> first;
    if (first == "exit") {
      words >> result.exit;
    } else if (first == "only") {
      result.only = true;
    } else if (first == "options") {
      for (std::string word; words >> word;) result.options.push_back(word);
    } else {
      Message message;
      message.written = line;
      const std::size_t colon = first.find(':');
      if (colon == std::string::npos) {
        ADD_FAILURE() << "expected.txt: no line:col in: " << line;
        continue;
      }
      message.line = first.substr(0, colon);
      message.column = first.substr(colon + 1);
      words >> message.code;
      for (std::string word; words >> word;) message.texts.push_back(word);
      result.messages.push_back(message);
    }
  }
  return result;
}

/// One rendered message with its help lines: `name.xml:12:5: error P3008: text`; and the line of the file with a caret
/// below it, ` 12 | x` and `    | ^`.
struct Rendered {
  std::string line, column, code, text;
  std::vector<std::string> excerpt;
};

std::vector<Rendered> parse(const std::string& output, const std::string& file_name) {
  std::vector<Rendered> result;
  std::istringstream in(output);
  for (std::string row; std::getline(in, row);) {
    const std::size_t error = row.find("error ");
    const std::size_t warning = row.find("warning ");
    const std::size_t severity = std::min({error, warning, row.find("note ")});
    const std::size_t name = row.find(file_name);
    const std::size_t bar = row.find_first_not_of(" 0123456789");
    if (!result.empty() && row.starts_with(' ') && bar != std::string::npos && row.compare(bar, 2, "| ") == 0) {
      result.back().excerpt.push_back(row);
      continue;
    }
    if (severity != std::string::npos && (name == std::string::npos || name < severity)) {
      Rendered message;
      if (name != std::string::npos) {
        std::istringstream place(row.substr(name + file_name.size(), severity - name - file_name.size()));
        std::getline(place, message.line, ':');  // empty: before the first colon
        std::getline(place, message.line, ':');
        std::getline(place, message.column, ':');
      }
      const std::size_t code = row.find(' ', severity) + 1;
      message.code = row.substr(code, row.find(':', code) - code);
      message.text = row;
      result.push_back(message);
    } else if (!result.empty()) {
      result.back().text += "\n" + row;
    }
  }
  return result;
}

bool matches(const Message& expected, const Rendered& actual) {
  return (expected.line == "?" || expected.line == actual.line) &&
         (expected.column == "?" || expected.column == actual.column) &&
         (expected.code == "?" || expected.code == actual.code) &&
         std::all_of(expected.texts.begin(), expected.texts.end(),
                     [&](const std::string& text) { return actual.text.find(text) != std::string::npos; });
}

std::vector<std::string> folders() {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder)) {
    if (fs::exists(entry.path() / "expected.txt")) names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<fs::path> projects(const fs::path& folder) {
  std::vector<fs::path> result;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename().string().rfind("bad-", 0) == 0) result.push_back(entry.path());
  }
  std::sort(result.begin(), result.end());
  return result;
}

std::string test_name(const ::testing::TestParamInfo<std::string>& param) {
  std::string name = param.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class Diagnostics : public ::testing::TestWithParam<std::string> {};

TEST_P(Diagnostics, NamePlaceCodeAndWords) {
  const fs::path folder = fs::path(kFolder) / GetParam();
  const Expected expected = read_expected(folder / "expected.txt");
  ASSERT_FALSE(expected.messages.empty());
  ASSERT_FALSE(projects(folder).empty());
  for (const fs::path& project : projects(folder)) {
    std::vector<std::string> arguments = {kTool, "check", project.string()};
    arguments.insert(arguments.end(), expected.options.begin(), expected.options.end());
    const ToolResult result = run_tool(arguments);
    EXPECT_EQ(result.code, expected.exit) << command_line(arguments) << "\n" << result.all();
    const std::vector<Rendered> rendered = parse(result.all(), project.filename().string());
    for (const Message& message : expected.messages) {
      EXPECT_TRUE(std::any_of(rendered.begin(), rendered.end(),
                              [&](const Rendered& actual) { return matches(message, actual); }))
          << "missing: " << message.written << "\noutput:\n"
          << result.all();
    }
    for (const Rendered& one : rendered) {
      EXPECT_TRUE(!expected.only || std::any_of(expected.messages.begin(), expected.messages.end(),
                                                [&](const Message& message) { return matches(message, one); }))
          << "unexpected: " << one.text;
      if (one.column.empty() || one.column == " ") continue;
      ASSERT_EQ(one.excerpt.size(), 2u) << one.text;
      EXPECT_EQ(one.excerpt[0].rfind(" " + one.line + " | ", 0), 0u) << one.excerpt[0];
      EXPECT_EQ(one.excerpt[1].find_first_not_of(" |\t"), one.excerpt[1].size() - 1) << one.excerpt[1];
      EXPECT_EQ(one.excerpt[1].back(), '^');
    }
  }
}

TEST_P(Diagnostics, AreValidJson) {
  const fs::path folder = fs::path(kFolder) / GetParam();
  const Expected expected = read_expected(folder / "expected.txt");
  for (const fs::path& project : projects(folder)) {
    std::vector<std::string> arguments = {kTool, "check", "--json", project.string()};
    arguments.insert(arguments.end(), expected.options.begin(), expected.options.end());
    const ToolResult result = run_tool(arguments);
    EXPECT_EQ(result.code, expected.exit) << command_line(arguments);
    const nlohmann::json parsed = nlohmann::json::parse(result.out, nullptr, false);
    ASSERT_FALSE(parsed.is_discarded()) << command_line(arguments) << "\n" << result.out << result.err;
    for (const Message& message : expected.messages) {
      if (message.code != "?") {
        EXPECT_NE(result.out.find('"' + message.code + '"'), std::string::npos) << result.out;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Projects, Diagnostics, ::testing::ValuesIn(folders()), test_name);

}  // namespace
