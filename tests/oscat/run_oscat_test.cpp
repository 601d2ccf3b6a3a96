// OSCAT Basic 3.33 with --lib: it disturbs nothing, its POUs can be used one by one, and what they compute is right.
//
// The library is not part of this repository: PLC_OSCAT names the folder of its .EXP files, as CODESYS 2.3 exported
// them, which joins the project beside the global lists of its own. Does not belong here: code of the library.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "testing/table.h"
#include "tests/support/golden.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::run_tool;
using plc::test::ScratchFolder;
using plc::tests::CsvTable;
using plc::tests::read_csv;
using plc::tests::same_value;

const char* const kTool = PLC_TOOL;

std::string read_bytes(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

/// Comments nest in these files.
std::string without_comments(const std::string& text) {
  std::string out;
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view two = std::string_view(text).substr(i, 2);
    if (two == "(*") {
      ++depth;
      ++i;
    } else if (two == "*)" && depth > 0) {
      --depth;
      ++i;
    } else if (depth == 0) {
      out += text[i];
    }
  }
  return out;
}

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(trimmed(part));
  return parts;
}

struct Pou {
  std::string name;
  bool function = false;
  std::vector<std::pair<std::string, std::string>> in_outs;  ///< names and types
};

class Oscat : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("PLC_OSCAT");
    if (folder == nullptr) GTEST_SKIP() << "PLC_OSCAT does not name the folder of OSCAT Basic's .EXP files";
    ASSERT_TRUE(fs::is_directory(folder)) << folder;
    if (!fs::exists(PLC_OSCAT_GLOBALS)) GTEST_SKIP() << "no file " << PLC_OSCAT_GLOBALS;
    folder_ = folder;
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".EXP") files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files) note_pou(without_comments(read_bytes(file)));
  }

  /// The command with the library.
  [[nodiscard]] std::vector<std::string> with_library(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), kTool);
    arguments.insert(arguments.end(), {"--lib", PLC_OSCAT_GLOBALS, "--lib", folder_});
    return arguments;
  }

  /// Variables and statements as a program, run for so many scans; the trace.
  [[nodiscard]] CsvTable run(const std::string& variables, const std::string& statements, std::size_t scans) const {
    const std::string source = scratch_.file("main.st"), trace = scratch_.file("trace.csv");
    write_bytes(source, "PROGRAM main\nVAR\nk : INT := -1;\n" + variables + "END_VAR\nk := k + 1;\n" + statements +
                            "END_PROGRAM\n");
    const auto result =
        run_tool(with_library({"sim", source, "--pou", "main", "--cycles", std::to_string(scans), "--trace", trace}));
    EXPECT_EQ(result.code, 0) << result.err;
    return result.code == 0 ? read_csv(trace) : CsvTable{};
  }

  std::vector<Pou> pous_;
  ScratchFolder scratch_;
  std::string folder_;  ///< of the .EXP files

 private:
  void note_pou(const std::string& text) {
    static const std::regex kHead(R"(\b(FUNCTION_?BLOCK|FUNCTION)\s+(\w+))");
    static const std::regex kVariables(R"(([\w\s,]+?)\s*:\s*([^;:]+?)\s*;)");
    std::smatch head;
    if (!std::regex_search(text, head, kHead)) return;
    Pou pou{head[2], head[1] == "FUNCTION", {}};
    for (std::size_t at = text.find("VAR_IN_OUT"); at != std::string::npos; at = text.find("VAR_IN_OUT", at + 1)) {
      const std::string section = text.substr(at + 10, text.find("END_VAR", at) - at - 10);
      for (std::sregex_iterator it(section.begin(), section.end(), kVariables), end; it != end; ++it) {
        for (const std::string& name : split((*it)[1], ',')) pou.in_outs.emplace_back(name, (*it)[2]);
      }
    }
    pous_.push_back(std::move(pou));
  }
};

/// A program that uses the POU.
std::string use_of(const Pou& pou) {
  std::string variables, arguments;
  for (std::size_t i = 0; i < pou.in_outs.size(); ++i) {
    const std::string variable = "io" + std::to_string(i);
    variables += variable + " : " + pou.in_outs[i].second + ";\n";
    arguments += (i == 0 ? "" : ", ") + pou.in_outs[i].first + " := " + variable;
  }
  if (!pou.function) variables += "instance : " + pou.name + ";\n";
  return "PROGRAM use_" + pou.name + "\nVAR\n" + variables + "END_VAR\n" + (pou.function ? pou.name : "instance") +
         "(" + arguments + ");\nEND_PROGRAM\n";
}

std::string configuration_of(const std::vector<const Pou*>& pous) {
  std::string text = "CONFIGURATION c RESOURCE r ON plc\nTASK t (INTERVAL := T#20ms, PRIORITY := 1);\n";
  for (const Pou* pou : pous) text += "PROGRAM p_" + pou->name + " WITH t : use_" + pou->name + ";\n";
  return text + "END_RESOURCE END_CONFIGURATION\n";
}

/// "P4009 there is no function *" of an error line.
std::string reason_of(const std::string& line) {
  static const std::regex kUse(R"re("[^"]*" of library .* cannot be used: (.*) \(line \d+\)( \[POU .*\])?$)re");
  static const std::regex kNeeds(R"re(^it needs "[^"]*": )re");
  static const std::regex kQuoted(R"re("[^"]*")re");
  std::smatch use;
  const std::string text = std::regex_search(line, use, kUse) ? use[1].str() : line;
  return std::regex_replace(std::regex_replace(text, kNeeds, ""), kQuoted, "*");
}

TEST_F(Oscat, PousAreUsableOneByOne) {
  ASSERT_GE(pous_.size(), 500u);
  const std::string source = scratch_.file("use.st");
  std::map<std::string, std::vector<std::string>> unusable;  // by reason
  std::vector<const Pou*> usable;
  // Errors that are kept have a limit: some at a time.
  constexpr std::size_t kAtATime = 40;
  for (std::size_t first = 0; first < pous_.size(); first += kAtATime) {
    std::string text;
    std::vector<const Pou*> some;
    for (std::size_t i = first; i < std::min(pous_.size(), first + kAtATime); ++i) {
      text += use_of(pous_[i]);
      some.push_back(&pous_[i]);
    }
    write_bytes(source, text + configuration_of(some));
    const auto result = run_tool(with_library({"compile", source, "-o", scratch_.file("use.pbc")}), 120);
    ASSERT_TRUE(result.code == 0 || result.code == 1) << result.all();
    std::map<std::string, std::string> reasons;
    std::istringstream lines(result.err);
    for (std::string line; std::getline(lines, line);) {
      const std::size_t use = line.rfind("[POU use_");
      const std::size_t error = line.find(" error P");
      if (use == std::string::npos || error == std::string::npos || line.rfind(source, 0) != 0) continue;
      const std::string name = line.substr(use + 9, line.find_first_of(",]", use) - use - 9);
      reasons.emplace(name, reason_of(line.substr(error + 7)));
    }
    EXPECT_TRUE(result.code == 0 || !reasons.empty()) << result.err;
    for (const Pou* pou : some) {
      const auto found = reasons.find(pou->name);
      if (found == reasons.end()) usable.push_back(pou);
      if (found != reasons.end()) unusable[found->second].push_back(pou->name);
    }
  }
  std::string list = std::to_string(usable.size()) + " of " + std::to_string(pous_.size()) + " POUs are usable.\n";
  for (const auto& [reason, names] : unusable) {
    list += "\n" + std::to_string(names.size()) + ": " + reason + "\n ";
    for (const std::string& name : names) list += " " + name;
    list += "\n";
  }
  EXPECT_GE(usable.size(), 440u) << list;
  plc::test::expect_golden("tests/oscat/unusable.txt", list);

  // All of them in one program, in less than a second.
  std::string text;
  for (const Pou* pou : usable) text += use_of(*pou);
  write_bytes(source, text + configuration_of(usable));
  const auto begin = std::chrono::steady_clock::now();
  const auto result = run_tool(with_library({"compile", source, "-o", scratch_.file("use.pbc")}), 120);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(result.code, 0) << result.err;
  std::cout << usable.size() << " POUs compiled in " << took.count() << " s\n";
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(took.count(), 1.0);
#endif
}

// What the cases of the language do, they do with the library, too.
TEST_F(Oscat, DisturbsNothing) {
  std::size_t compared = 0;
  for (const auto& entry : fs::directory_iterator(PLC_CASES)) {
    const fs::path source = entry.path() / "project.st";
    // Cases with libraries of their own are no programs without them.
    if (!fs::exists(source) || read_bytes(entry.path() / "case.txt").find("lib:") != std::string::npos) continue;
    // OSCAT's own ATAN2 is for REAL alone, and its DAY_OF_WEEK counts from Monday: they hide the standard's (P4019).
    const std::string text = read_bytes(source);
    if (text.find("ATAN2(LREAL#") != std::string::npos || text.find("DAY_OF_WEEK") != std::string::npos) continue;
    SCOPED_TRACE(source);
    const std::string alone = scratch_.file("alone.csv"), beside = scratch_.file("beside.csv");
    std::vector<std::string> arguments = {"sim", source.string(), "--cycles", "5", "--trace", alone};
    if (fs::exists(entry.path() / "stimulus.csv")) {
      arguments.insert(arguments.end(), {"--stimulus", (entry.path() / "stimulus.csv").string()});
    }
    std::vector<std::string> command = arguments;
    command.insert(command.begin(), kTool);
    const auto without = run_tool(command);
    arguments[5] = beside;
    const auto with = run_tool(with_library(arguments));
    EXPECT_EQ(with.code, without.code) << with.err;
    // Only what the project hides of the library, and the library of the standard, is new.
    std::istringstream lines(with.err);
    for (std::string line; std::getline(lines, line);) {
      const bool problem = line.find(": warning P") != std::string::npos || line.find(": error P") != std::string::npos;
      const bool known = line.find("P5110") != std::string::npos || line.find("P4019") != std::string::npos ||
                         without.err.find(line) != std::string::npos;
      EXPECT_TRUE(!problem || known) << line;
    }
    if (with.code != 0 || without.code != 0) continue;
    const CsvTable a = read_csv(alone), b = read_csv(beside);
    ASSERT_EQ(a.rows.size(), b.rows.size());
    for (std::size_t column = 0; column < a.header.size(); ++column) {
      // A number that a program makes of an address depends on how many variables there are.
      if (a.header[column] == "main.address") continue;
      const std::size_t other = b.column(a.header[column]);
      ASSERT_LT(other, b.header.size()) << a.header[column];
      for (std::size_t row = 0; row < a.rows.size(); ++row) {
        EXPECT_EQ(a.rows[row][column], b.rows[row][other]) << a.header[column];
      }
    }
    ++compared;
  }
  EXPECT_GT(compared, 50u);
}

/// Whether `actual` is the expected value: "12", "1.5" (to 1e-5 of it), "1.5~0.2".
bool fits(const std::string& expected, const std::string& actual, double relative) {
  if (expected == ".") return true;
  const std::size_t tilde = expected.find('~');
  if (tilde == std::string::npos && expected.find('.') == std::string::npos) return same_value(expected, actual);
  if (expected.front() == '\'') return same_value(expected, actual);
  const double wanted = std::strtod(expected.c_str(), nullptr);
  const double found = std::strtod(actual.c_str(), nullptr);
  const double most = tilde == std::string::npos ? relative * std::max(std::abs(wanted), 0.01)
                                                 : std::strtod(expected.c_str() + tilde + 1, nullptr);
  return std::abs(wanted - found) <= most;
}

TEST_F(Oscat, FunctionsGiveKnownAnswers) {
  std::ifstream in(std::string(PLC_OSCAT_HERE) + "/answers.txt");
  std::string area;
  std::map<std::string, std::vector<std::vector<std::string>>> areas;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("## ", 0) == 0) area = line.substr(3);
    if (line.empty() || line.front() == '#') continue;
    areas[area].push_back(split(line, ';'));
    ASSERT_GE(areas[area].back().size(), 3u) << line;
  }
  std::set<std::string> functions;
  for (const auto& [name, answers] : areas) {
    SCOPED_TRACE(name);
    std::string variables, statements;
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const std::string variable = "r" + std::to_string(i);
      variables += variable + " : " + answers[i][0] + ";\n";
      statements += variable + " := " + answers[i][1] + ";\n";
      functions.insert(answers[i][1].substr(0, answers[i][1].find('(')));
    }
    const CsvTable table = run(variables, statements, 1);
    ASSERT_EQ(table.rows.size(), 1u);
    for (std::size_t i = 0; i < answers.size(); ++i) {
      const std::size_t column = table.column("main.r" + std::to_string(i));
      ASSERT_LT(column, table.header.size());
      const double relative = answers[i].size() > 3 ? std::stod(answers[i][3]) : 1e-5;
      EXPECT_TRUE(fits(answers[i][2], table.rows[0][column], relative))
          << answers[i][1] << " is " << table.rows[0][column] << ", not " << answers[i][2];
    }
  }
  EXPECT_GE(areas.size(), 8u);
  EXPECT_GE(functions.size(), 60u);
}

TEST_F(Oscat, BlocksGiveKnownAnswers) {
  std::ifstream in(std::string(PLC_OSCAT_HERE) + "/blocks.txt");
  struct Case {
    std::string title, variables, statements;
    std::vector<std::pair<std::string, std::vector<std::string>>> expected;
  };
  std::vector<Case> cases;
  int part = 0;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("== ", 0) == 0) {
      cases.push_back({line.substr(3), {}, {}, {}});
      part = 0;
    } else if (line == "--") {
      ++part;
    } else if (!line.empty() && line.front() != '#' && !cases.empty()) {
      if (part == 0) cases.back().variables += line + "\n";
      if (part == 1) cases.back().statements += line + "\n";
      if (part != 2) continue;
      const std::size_t colon = line.find(':');
      std::vector<std::string> values = split(line.substr(colon + 2), ' ');
      cases.back().expected.emplace_back("main." + line.substr(0, colon), std::move(values));
    }
  }
  for (const Case& one : cases) {
    SCOPED_TRACE(one.title);
    std::size_t scans = 1;
    for (const auto& [path, values] : one.expected) scans = std::max(scans, values.size());
    const CsvTable table = run(one.variables, one.statements, scans);
    if (table.rows.size() != scans) {
      ADD_FAILURE() << "it did not run";
      continue;
    }
    for (const auto& [path, values] : one.expected) {
      const std::size_t column = table.column(path);
      ASSERT_LT(column, table.header.size()) << path;
      for (std::size_t scan = 0; scan < values.size(); ++scan) {
        EXPECT_TRUE(fits(values[scan], table.rows[scan][column], 1e-5))
            << path << " is " << table.rows[scan][column] << " after scan " << scan << ", not " << values[scan];
      }
    }
  }
  EXPECT_GE(cases.size(), 25u);
}

}  // namespace
