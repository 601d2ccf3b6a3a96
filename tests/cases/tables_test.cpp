// Which features of IEC 61131-3:2013 the cases prove: tables.txt lists the features, `tables:` of each case.txt names
// those it proves. No feature without a case, no case for a feature that the list lacks; tables.md shows both together.
//
// Does not belong here: running cases.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/cases/case_file.h"
#include "tests/support/golden.h"

namespace {

namespace fs = std::filesystem;

const char* const kCases = PLC_CASES;

/// A line of tables.txt that names a feature.
struct Feature {
  std::string number;   ///< "72.4"
  std::string text;     ///< what it is
  std::string missing;  ///< why PICARD does not have it, or nothing
};

/// A table of the standard, "## 72 Statements", and its features.
struct Table {
  std::string title;
  std::vector<Feature> features;
};

/// "71.3 | dereference" or "- 8.9 | what | why not".
Feature read_feature(const std::string& line) {
  Feature result;
  const bool missing = line.rfind("- ", 0) == 0;
  const std::size_t first = line.find(" | ");
  const std::size_t second = line.find(" | ", first == std::string::npos ? first : first + 3);
  if (first == std::string::npos || missing != (second != std::string::npos)) {
    ADD_FAILURE() << "tables.txt: neither \"<number> | <text>\" nor \"- <number> | <text> | <reason>\": " << line;
    return result;
  }
  const std::size_t begin = missing ? 2 : 0;
  result.number = line.substr(begin, first - begin);
  result.text = line.substr(first + 3, missing ? second - first - 3 : std::string::npos);
  if (missing) result.missing = line.substr(second + 3);
  return result;
}

std::vector<Table> read_tables() {
  std::vector<Table> result;
  std::ifstream in(fs::path(kCases) / "tables.txt");
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || (line[0] == '#' && line.rfind("## ", 0) != 0)) continue;
    if (line.rfind("## ", 0) == 0) {
      result.push_back({line.substr(3), {}});
    } else if (result.empty()) {
      ADD_FAILURE() << "tables.txt: a feature outside of a table: " << line;
    } else {
      result.back().features.push_back(read_feature(line));
    }
  }
  return result;
}

/// Feature -> cases that name it.
std::map<std::string, std::vector<std::string>> cases_by_feature() {
  std::map<std::string, std::vector<std::string>> result;
  for (const std::string& name : plc::test::case_names(kCases)) {
    for (const std::string& feature : plc::test::read_case(fs::path(kCases) / name).tables) {
      result[feature].push_back(name);
    }
  }
  return result;
}

TEST(CaseTables, EveryFeatureHasACaseOrAReason) {
  const auto proven = cases_by_feature();
  std::map<std::string, bool> listed;  // number -> PICARD has it
  for (const Table& table : read_tables()) {
    for (const Feature& feature : table.features) {
      EXPECT_TRUE(listed.emplace(feature.number, feature.missing.empty()).second) << feature.number << " stands twice";
      EXPECT_EQ(proven.count(feature.number), feature.missing.empty() ? 1U : 0U)
          << feature.number << " (" << feature.text << ") "
          << (feature.missing.empty() ? "has no case" : "has a case and a reason to have none");
    }
  }
  EXPECT_GT(listed.size(), 100U);
  for (const auto& [feature, cases] : proven) {
    EXPECT_EQ(listed.count(feature), 1U) << cases.front() << " names " << feature << ", which tables.txt does not list";
  }
}

TEST(CaseTables, TheListOfCasesIsUpToDate) {
  const auto proven = cases_by_feature();
  std::string out =
      "<!-- Generated from tables.txt and the cases; PLC_GOLDEN_UPDATE=1 test_cases --gtest_filter='CaseTables.*' "
      "rewrites it. -->\n# Features and their cases\n\nTables and features of IEC 61131-3:2013, the texts in our own "
      "words.\n";
  for (const Table& table : read_tables()) {
    out += "\n## Table " + table.title + "\n\n| feature | | cases |\n| --- | --- | --- |\n";
    for (const Feature& feature : table.features) {
      out += "| " + feature.number + " | " + feature.text + " | ";
      if (!feature.missing.empty()) out += "none: " + feature.missing;
      const auto found = proven.find(feature.number);
      if (found != proven.end()) {
        for (std::size_t i = 0; i < found->second.size(); ++i) {
          const std::string& name = found->second[i];
          out += (i == 0 ? "[" : ", [") + name + "](" + name + "/README.md)";
        }
      }
      out += " |\n";
    }
  }
  plc::test::expect_golden((fs::path(kCases) / "tables.md").string(), out);
}

}  // namespace
