// The bodies of tasks that docs/guides/coherence.md shows are those that `plc dump` prints.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/run_tool.h"

namespace {

using plc::test::run_tool;
using plc::test::ScratchFolder;

const std::filesystem::path kGuides = std::filesystem::path(PLC_SOURCE_DIR) / "docs/guides";

/// "READ_N 5, 4" of a line that begins so, without comments; empty for lines that are no instruction.
std::string instruction(const std::string& line) {
  std::istringstream words(line.substr(0, line.find(';')));
  std::string text;
  for (std::string word; words >> word;) {
    if (text.empty() && word.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ_") != std::string::npos) return {};
    // Operands end with the first word that does not end with a comma; what follows is a remark.
    const bool last = !text.empty() && word.back() != ',';
    text += (text.empty() ? "" : " ") + word;
    const bool alone = text == "LOCK" || text == "UNLOCK" || text == "RESCHEDULE" || text == "RETURN";
    if (last || alone) break;
  }
  return text;
}

std::vector<std::string> instructions(std::istream& lines) {
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line) && (all.empty() || all.back() != "RETURN");) {
    const std::string text = instruction(line);
    if (!text.empty()) all.push_back(text);
  }
  return all;
}

/// The body of a task of flow.st.
std::vector<std::string> dumped(const std::string& coherence, const std::string& task) {
  const ScratchFolder scratch;
  const std::string image = scratch.file("flow.pbc");
  EXPECT_EQ(run_tool({PLC_TOOL, "compile", kGuides / "flow.st", "--coherence", coherence, "-o", image}).code, 0);
  const std::string listing = run_tool({PLC_TOOL, "dump", image}).out;
  const std::size_t at = listing.find("pou \"" + task + "\" task");
  EXPECT_NE(at, std::string::npos) << listing;
  std::istringstream lines(listing.substr(listing.find('\n', at)));
  return instructions(lines);
}

TEST(CoherenceGuide, ShowsTheBodiesThatTheCompilerMakes) {
  std::ifstream guide(kGuides / "coherence.md");
  const std::string text{std::istreambuf_iterator<char>(guide), {}};
  const struct {
    const char* section;
    const char* task;
  } shown[] = {{"wait-free", "Fast"}, {"priority-ceiling", "Middle"}, {"global-lock", "Middle"}};
  for (const auto& [section, task] : shown) {
    const std::size_t heading = text.find(std::string("\n## ") + section + "\n");
    ASSERT_NE(heading, std::string::npos) << section;
    std::istringstream lines(text.substr(heading, text.find("\n## ", heading + 1) - heading));
    // Code alone: indented by four.
    std::string code;
    for (std::string line; std::getline(lines, line);) code += line.rfind("    ", 0) == 0 ? line + "\n" : "";
    std::istringstream code_lines(code);
    const std::vector<std::string> in_guide = instructions(code_lines);
    ASSERT_GE(in_guide.size(), 4u) << section;
    EXPECT_EQ(in_guide, dumped(section, task)) << section;
  }
}

}  // namespace
