// SUPPORT.md is the table of known elements, written out.
#include "plcopen/support.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include "plcopen/rules.h"
#include "tests/support/golden.h"

namespace plc::plcopen {
namespace {

namespace fs = std::filesystem;

const fs::path kPage = test::source_root() / "plcopen/SUPPORT.md";
constexpr std::string_view kMarker =
    "<!-- generated: tables of known elements, PLC_UPDATE=1 test_plcopen writes them -->\n";

TEST(Support, PageMatchesTheTable) {
  std::ifstream file(kPage);
  ASSERT_TRUE(file) << kPage;
  std::stringstream content;
  content << file.rdbuf();
  const std::string page = content.str();
  const std::size_t at = page.find(kMarker);
  ASSERT_NE(at, std::string::npos) << "SUPPORT.md lost its marker";
  const std::string wanted = page.substr(0, at) + std::string(kMarker) + support_tables();
  if (std::getenv("PLC_UPDATE") != nullptr)
    std::ofstream(kPage) << wanted;
  else
    EXPECT_EQ(page, wanted) << "run with PLC_UPDATE=1";
}

TEST(Support, EveryElementThatIsNotUsedHasAReason) {
  for (const Rule& rule : all_rules()) {
    if (rule.fate == Fate::kUsed) continue;
    EXPECT_FALSE(rule.reason.empty()) << state_title(rule.parent) << '/' << rule.name;
  }
}

TEST(Support, NoElementIsDeclaredTwice) {
  std::set<std::tuple<State, std::string_view, std::string_view>> seen;
  for (const Rule& rule : all_rules()) {
    EXPECT_TRUE(seen.emplace(rule.parent, rule.name, rule.variant).second)
        << state_title(rule.parent) << '/' << rule.name << ' ' << rule.variant;
  }
}

TEST(Support, RefusedElementsNameTheirCode) {
  for (const Rule& rule : all_rules()) {
    if (rule.fate != Fate::kRefused) continue;
    EXPECT_NE(rule.reason.find("(P10"), std::string_view::npos) << state_title(rule.parent) << '/' << rule.name;
    EXPECT_NE(rule.start, nullptr) << "nothing reports the code of " << rule.name;
  }
}

}  // namespace
}  // namespace plc::plcopen
