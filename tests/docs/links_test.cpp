// Documents lead somewhere: links to files and headings that exist, in the tree and where documents are installed; an
// index that names every page; a front page that stays one; facts that are said once.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/docs/tree.h"
#include "tests/support/run_tool.h"

namespace {

namespace fs = std::filesystem;
using plc::test::kRoot;
using plc::test::run_tool;
using plc::test::text_of;
using plc::test::ToolResult;
using plc::test::tree;

struct Link {
  std::string file;     ///< as written; empty: the document itself
  std::string heading;  ///< after #; or empty
};

/// Links of a document to files; none to other hosts.
std::vector<Link> links_of(const fs::path& document) {
  static const std::regex link(R"(\]\(([^)#\s]*)(?:#([^)\s]*))?\))");
  const std::string text = text_of(document);
  std::vector<Link> links;
  for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it) {
    const std::string file = (*it)[1];
    if (file.find("://") != std::string::npos || file.rfind("mailto:", 0) == 0) continue;
    if (!file.empty() || (*it)[2].matched) links.push_back({file, (*it)[2]});
  }
  return links;
}

std::vector<fs::path> documents(const fs::path& root = kRoot) {
  std::vector<fs::path> files = tree(root);
  files.erase(std::remove_if(files.begin(), files.end(), [](const fs::path& f) { return f.extension() != ".md"; }),
              files.end());
  return files;
}

fs::path target_of(const fs::path& document, const Link& link) {
  return link.file.empty() ? document : (document.parent_path() / link.file).lexically_normal();
}

/// What GitHub makes of a heading: small letters, hyphens for blanks, no punctuation.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == ' ') {
      anchor += '-';
    } else if (byte >= 0x80 || std::isalnum(byte) != 0 || c == '-' || c == '_') {
      anchor += static_cast<char>(byte < 0x80 ? std::tolower(byte) : byte);
    }
  }
  return anchor;
}

std::set<std::string> anchors_of(const fs::path& document) {
  std::istringstream lines(text_of(document));
  std::set<std::string> anchors;
  bool code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) == 0) code = !code;
    const std::size_t level = line.find_first_not_of('#');
    if (code || level == 0 || level > 6 || level == std::string::npos || line[level] != ' ') continue;
    const std::string anchor = anchor_of(line.substr(level + 1));
    std::string unique = anchor;
    for (int n = 1; !anchors.insert(unique).second; ++n) unique = anchor + "-" + std::to_string(n);
  }
  return anchors;
}

TEST(Links, LeadToFilesThatExist) {
  std::size_t seen = 0;
  for (const fs::path& file : documents()) {
    for (const Link& link : links_of(file)) {
      ++seen;
      EXPECT_TRUE(fs::exists(target_of(file, link))) << fs::relative(file, kRoot) << " links to " << link.file;
    }
  }
  EXPECT_GT(seen, 100u);
}

TEST(Links, LeadToHeadingsThatExist) {
  std::map<fs::path, std::set<std::string>> anchors;
  std::size_t seen = 0;
  for (const fs::path& file : documents()) {
    for (const Link& link : links_of(file)) {
      const fs::path target = target_of(file, link);
      if (link.heading.empty() || target.extension() != ".md" || !fs::exists(target)) continue;
      ++seen;
      if (anchors.count(target) == 0) anchors[target] = anchors_of(target);
      EXPECT_EQ(anchors[target].count(link.heading), 1u)
          << fs::relative(file, kRoot) << " links to #" << link.heading << " of " << fs::relative(target, kRoot);
    }
  }
  EXPECT_GT(seen, 10u);
}

// Everything that `cmake --install` installs, also what is there to be copied (share/picard).
TEST(Links, LeadToInstalledFiles) {
  const plc::test::ScratchFolder scratch;
  const fs::path prefix = scratch.file("prefix");
  const ToolResult installed = run_tool({PLC_CMAKE, "--install", PLC_BUILD, "--prefix", prefix.string()}, 120);
  ASSERT_EQ(installed.code, 0) << installed.all();
  std::set<std::string> names;
  std::size_t seen = 0;
  for (const fs::path& file : documents(prefix)) {
    names.insert(file.filename().string());
    for (const Link& link : links_of(file)) {
      ++seen;
      const fs::path target = target_of(file, link);
      const fs::path inside = target.lexically_relative(prefix);
      EXPECT_TRUE(fs::exists(target) && *inside.begin() != "..")
          << fs::relative(file, prefix) << " links to " << link.file << ", which is not installed";
    }
  }
  EXPECT_GT(seen, 100u);
  for (const char* document : {"README.md", "start.md", "P3007.md", "conformance.md", "CONTRIBUTING.md"}) {
    EXPECT_EQ(names.count(document), 1u) << document << " is not installed";
  }
}

TEST(Index, NamesEveryPage) {
  std::set<fs::path> named;
  const fs::path index = kRoot / "docs/README.md";
  for (const Link& link : links_of(index)) named.insert(target_of(index, link));
  for (const char* folder : {"docs", "docs/guides", "docs/internals", "docs/reference"}) {
    for (const auto& entry : fs::directory_iterator(kRoot / folder)) {
      if (entry.path().extension() != ".md" || entry.path() == index) continue;
      EXPECT_EQ(named.count(entry.path()), 1u) << "docs/README.md does not name " << fs::relative(entry.path(), kRoot);
    }
  }
  for (const char* group : {"\n## Start\n", "\n## Guides\n", "\n## Reference\n", "\n## Inside\n"}) {
    EXPECT_NE(text_of(index).find(group), std::string::npos) << group;
  }
}

TEST(Index, OfDecisionsNamesEveryRecord) {
  std::set<fs::path> named;
  const fs::path index = kRoot / "docs/adr/README.md";
  for (const Link& link : links_of(index)) named.insert(target_of(index, link));
  for (const auto& entry : fs::directory_iterator(kRoot / "docs/adr")) {
    if (entry.path() == index) continue;
    EXPECT_EQ(named.count(entry.path()), 1u) << "docs/adr/README.md does not name " << entry.path().filename();
  }
}

TEST(FrontPages, AreOnePage) {
  constexpr std::ptrdiff_t kMostLines = 80;
  constexpr std::size_t kMostBytes = 8'000;  // not a page of few long lines either
  for (const char* page : {"README.md", "ARCHITECTURE.md"}) {
    const std::string text = text_of(kRoot / page);
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), kMostLines) << page;
    EXPECT_LE(text.size(), kMostBytes) << page;
  }
}

// How long a build takes is in README.md alone: other places became wrong one by one.
TEST(Times, AreSaidOnce) {
  static const std::regex minutes(R"(\b(\d+|an?|quarter|half)( of)?( an)? (minutes?|hour)\b)");
  std::vector<fs::path> files = documents();
  for (const char* script : {"run-demo", "run-tests", "bench/run", "scripts/check-aarch64", ".ci/run"}) {
    files.push_back(kRoot / script);
  }
  static const std::regex build("build|first run|first time|run-tests|run-demo|bench/");
  for (const fs::path& file : files) {
    if (file == kRoot / "README.md") continue;
    std::istringstream lines(text_of(file));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_FALSE(std::regex_search(line, minutes) && std::regex_search(line, build))
          << fs::relative(file, kRoot) << ": " << line;
    }
  }
}

TEST(References, NameThePaper) {
  const std::string references = text_of(kRoot / "docs/references.md");
  for (const char* word : {"PICARD on RT-Linux", "2000", "Authors", "PVM", "PICE", "LVT", "GVT"}) {
    EXPECT_NE(references.find(word), std::string::npos) << word;
  }
  static const std::regex paper(R"(\b[Tt]he paper\b)");
  for (const fs::path& file : documents()) {
    const std::string text = text_of(file);
    if (file.filename() == "references.md" || !std::regex_search(text, paper)) continue;
    EXPECT_NE(text.find("references.md"), std::string::npos)
        << fs::relative(file, kRoot) << " says \"the paper\" and does not lead to docs/references.md";
  }
}

}  // namespace
