// Real files: no error, and every element accounted for.
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/support/golden.h"
#include "tests/unit/plcopen/fixture.h"

namespace plc::plcopen {
namespace {

namespace fs = std::filesystem;

/// Start tags counted without the reader: comments, CDATA and declarations skipped.
std::size_t count_elements(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t i = text.find('<'); i != std::string_view::npos; i = text.find('<', i + 1)) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("<!--"))
      i = text.find("-->", i);
    else if (rest.starts_with("<![CDATA["))
      i = text.find("]]>", i);
    else if (!rest.starts_with("</") && !rest.starts_with("<?"))
      ++count;
  }
  return count;
}

TEST(Corpus, EveryFileIsReadAndAccountedFor) {
  const fs::path folder = test::source_root() / "../shared/corpus";
  if (!fs::is_directory(folder)) GTEST_SKIP() << "the collected project files are not here: " << folder;
  std::size_t files = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".xml") continue;
    ++files;
    SCOPED_TRACE(entry.path().filename());
    core::Diagnostics diagnostics;
    const auto project = read(entry.path(), diagnostics);
    std::ostringstream shown;
    diagnostics.render(shown);
    ASSERT_NE(project, nullptr) << shown.str();
    EXPECT_EQ(diagnostics.error_count(), 0u) << shown.str();
    EXPECT_TRUE(diagnostics.all().empty()) << shown.str();
    std::size_t sum = 0;
    for (const ReportRow& row : project->report) {
      sum += row.count;
      EXPECT_TRUE(row.fate == Fate::kUsed || !row.reason.empty()) << row.element;
      EXPECT_GT(row.first_line, 0u);
    }
    std::ifstream file(entry.path(), std::ios::binary);
    std::stringstream content;
    content << file.rdbuf();
    EXPECT_EQ(sum, count_elements(content.str()));
    EXPECT_FALSE(project->pous.empty());
  }
  EXPECT_GT(files, 0u);
}

}  // namespace
}  // namespace plc::plcopen
