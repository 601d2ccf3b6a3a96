#include "tools/feature_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tools/library_text.h"

namespace plc::tools {
namespace {

namespace fs = std::filesystem;

/// Feature -> cases that name it, sorted.
std::map<std::string, std::vector<std::string>> cases_by_feature(const fs::path& folder) {
  std::map<std::string, std::vector<std::string>> cases;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().filename() != "case.txt") continue;
    std::ifstream in(entry.path());
    for (std::string line; std::getline(in, line);) {
      std::istringstream words(line);
      std::string word;
      if (!(words >> word) || word != "tables:") continue;
      while (words >> word) cases[word].push_back(fs::relative(entry.path().parent_path(), folder).generic_string());
    }
  }
  for (auto& [feature, names] : cases) std::sort(names.begin(), names.end());
  return cases;
}

std::vector<std::string> parts_of(const std::string& line) {
  constexpr std::string_view kBar = " | ";
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t bar = line.find(kBar); bar != std::string::npos; bar = line.find(kBar, begin)) {
    parts.push_back(line.substr(begin, bar - begin));
    begin = bar + kBar.size();
  }
  parts.push_back(line.substr(begin));
  return parts;
}

/// "A_TO_{B, C}": A_TO_B and A_TO_C.
void add_expanded(std::string_view name, std::vector<std::string>& names) {
  const std::size_t brace = name.find('{');
  if (brace == std::string_view::npos || name.back() != '}') {
    names.emplace_back(name);
    return;
  }
  std::istringstream endings{std::string(name.substr(brace + 1, name.size() - brace - 2))};
  for (std::string ending; std::getline(endings >> std::ws, ending, ',');) {
    names.push_back(std::string(name.substr(0, brace)) + ending);
  }
}

/// Names between backquotes.
std::vector<std::string> quoted_names(std::string_view text) {
  std::vector<std::string> names;
  for (std::size_t begin = text.find('`'); begin != std::string_view::npos;) {
    const std::size_t end = text.find('`', begin + 1);
    if (end == std::string_view::npos) break;
    add_expanded(text.substr(begin + 1, end - begin - 1), names);
    begin = text.find('`', end + 1);
  }
  return names;
}

class Reader {
 public:
  explicit Reader(const fs::path& folder) : folder_(folder), cases_(cases_by_feature(folder)) {}

  FeatureTables read() {
    std::ifstream in(folder_ / "tables.txt");
    for (std::string line; std::getline(in, line);) {
      if (line.rfind("## ", 0) == 0) {
        result_.tables.push_back({line.substr(3), {}});
      } else if (!line.empty() && line[0] != '#') {
        add(line);
      }
    }
    if (listed_.empty()) complain((folder_ / "tables.txt").string() + " lists nothing");
    for (const auto& [feature, names] : cases_) {
      if (!listed_.contains(feature)) complain(fmt::format("{} names {}, which is not listed", names.front(), feature));
    }
    return std::move(result_);
  }

 private:
  void complain(std::string problem) { result_.problems.push_back(std::move(problem)); }

  /// "71.3 | dereference", "~ 17.1 | what | what is missing", "- 8.9 | what | why not".
  void add(const std::string& line) {
    Feature feature;
    const bool marked = line.rfind("- ", 0) == 0 || line.rfind("~ ", 0) == 0;
    if (marked) feature.answer = line[0] == '-' ? Answer::kNo : Answer::kPartly;
    const std::vector<std::string> parts = parts_of(marked ? line.substr(2) : line);
    if (result_.tables.empty() || parts.size() != (marked ? 3U : 2U)) {
      complain("neither a table nor a feature of one: " + line);
      return;
    }
    feature.number = parts[0];
    feature.text = parts[1];
    if (marked) feature.note = parts[2];
    if (!listed_.insert(feature.number).second) complain(feature.number + " is there twice");
    if (const auto proven = cases_.find(feature.number); proven != cases_.end()) feature.cases = proven->second;
    ask_library(feature);
    check(feature);
    result_.tables.back().features.push_back(std::move(feature));
  }

  /// What the library has decides, whatever the line says.
  static void ask_library(Feature& feature) {
    const std::vector<std::string> names = quoted_names(feature.text);
    if (names.empty()) return;
    feature.of_library = true;
    std::vector<std::string_view> missing;
    for (const std::string& name : names) {
      const std::string_view group = group_of(name);
      if (group.empty()) missing.push_back(name);
      if (feature.group.empty()) feature.group = group;
    }
    if (missing.empty()) return;
    feature.answer = missing.size() == names.size() ? Answer::kNo : Answer::kPartly;
    if (feature.note.empty()) feature.note = fmt::format("{} not in the library", joined(missing));
  }

  void check(const Feature& feature) {
    if (feature.answer == Answer::kNo && !feature.cases.empty()) {
      complain(fmt::format("{} ({}) is missing: {}, and {} proves it", feature.number, feature.text, feature.note,
                           feature.cases.front()));
    }
    if (feature.answer != Answer::kNo && !feature.of_library && feature.cases.empty()) {
      complain(fmt::format("{} ({}) has no case", feature.number, feature.text));
    }
  }

  fs::path folder_;
  std::map<std::string, std::vector<std::string>> cases_;
  std::set<std::string> listed_;
  FeatureTables result_;
};

}  // namespace

FeatureTables read_feature_tables(const fs::path& cases) { return Reader(cases).read(); }

}  // namespace plc::tools
