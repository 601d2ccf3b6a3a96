#include "testing/discover.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>

#include "core/text.h"
#include "frontend-st/lexer.h"
#include "testing/case_file.h"

namespace plc::tests {
namespace {

namespace fs = std::filesystem;

bool is_text(const fs::path& path) {
  return core::iequals(path.extension().string(), ".st") || core::iequals(path.extension().string(), ".iecst");
}

bool names_tests(const fs::path& path) {
  const std::string stem = path.stem().string();
  return is_text(path) && stem.size() > kTestSuffix.size() && stem.ends_with(kTestSuffix);
}

/// The project beside a file of tests; the file itself where there is none.
fs::path project_beside(const fs::path& tests) {
  std::string stem = tests.stem().string();
  stem.resize(stem.size() - kTestSuffix.size());
  for (const char* const extension : {".xml", ".st", ".iecst", ".plcproj", ".EXP", ".exp"}) {
    fs::path project = tests.parent_path() / (stem + extension);
    if (fs::is_regular_file(project)) return project;
  }
  return tests;
}

/// The text, as far as words are looked for in it: of UTF-16 the characters that ASCII has, too.
std::string text_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
    text.erase(0, 2);
    std::erase(text, '\0');
  }
  return text;
}

class Finder {
 public:
  std::optional<core::Problem> add(const fs::path& path) {
    std::error_code ignored;
    if (fs::is_directory(path, ignored)) {
      if (!add_case(path)) add_folder(path);
      return std::nullopt;
    }
    if (!fs::is_regular_file(path, ignored) || !std::ifstream(path)) {
      return core::Problem{core::Code::P7001, path.string() + " cannot be opened for reading",
                           "give files and folders with tests"};
    }
    if (names_tests(path)) {
      add_tests(path);
      return std::nullopt;
    }
    Unit& unit = project(path);
    const fs::path tests = path.parent_path() / (path.stem().string() + std::string(kTestSuffix) + ".st");
    if (fs::is_regular_file(tests, ignored)) add_to(unit, tests);
    return std::nullopt;
  }

  std::vector<Unit> take() {
    std::vector<Unit> units;
    for (auto& [path, unit] : units_) units.push_back(std::move(unit));
    return units;
  }

 private:
  Unit& project(const fs::path& path) {
    Unit& unit = units_[path.string()];
    unit.path = path.string();
    return unit;
  }
  static void add_to(Unit& unit, const fs::path& tests) {
    if (std::find(unit.files.begin(), unit.files.end(), tests.string()) == unit.files.end())
      unit.files.push_back(tests.string());
  }
  void add_tests(const fs::path& path) {
    const fs::path owner = project_beside(path);
    Unit& unit = project(owner);
    if (owner != path) add_to(unit, path);
  }

  bool add_case(const fs::path& folder) {
    if (!is_case(folder)) return false;
    Unit& unit = units_[folder.string()];
    unit.path = folder.string();
    unit.is_case = true;
    return true;
  }

  void add_folder(const fs::path& folder) {
    std::error_code ignored;
    if (!seen_.insert(fs::canonical(folder, ignored)).second) return;  // links may lead back
    std::vector<fs::path> entries;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) entries.push_back(entry.path());
    std::sort(entries.begin(), entries.end());
    for (const fs::path& entry : entries) {
      if (entry.filename().string().starts_with('.')) continue;
      if (fs::is_directory(entry, ignored)) {
        if (!add_case(entry)) add_folder(entry);
      } else if (is_text(entry) && has_tests(text_of(entry))) {
        names_tests(entry) ? add_tests(entry) : static_cast<void>(project(entry));
      }
    }
  }

  std::map<std::string, Unit> units_;
  std::set<fs::path> seen_;  ///< folders that were looked through
};

}  // namespace

bool has_tests(std::string_view text) {
  st::Lexer lexer(text);
  bool opener = false;
  for (st::Token token = lexer.next(); token.kind != st::TokenKind::kEnd; token = lexer.next()) {
    if (token.kind == st::TokenKind::kUnterminatedComment) return false;
    if (opener && token.kind == st::TokenKind::kString) return true;
    opener = token.kind == st::TokenKind::kIdentifier &&
             core::iequals(text.substr(token.begin, token.end - token.begin), "TEST");
  }
  return false;
}

core::Result<std::vector<Unit>> find_units(const std::vector<std::string>& paths) {
  Finder finder;
  for (const std::string& path : paths) {
    if (auto problem = finder.add(fs::path(path).lexically_normal())) return *problem;
  }
  return finder.take();
}

}  // namespace plc::tests
