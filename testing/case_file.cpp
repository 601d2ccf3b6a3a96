#include "testing/case_file.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "core/glob.h"

namespace plc::tests {

namespace fs = std::filesystem;

namespace {

/// A file, or a folder of source files.
constexpr const char* kProjects[] = {"project.st", "project.xml", "project.exp", "project"};

}  // namespace

std::vector<std::string> words(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> result;
  for (std::string word; in >> word;) result.push_back(word);
  return result;
}

namespace {
bool is_number(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  return *end == '\0' && value >= 0;
}
}  // namespace

CaseFile read_case(const fs::path& folder) {
  CaseFile result;
  std::ifstream in(folder / "case.txt");
  std::size_t number = 0;
  for (std::string line; std::getline(in, line);) {
    const std::string place = "case.txt:" + std::to_string(++number) + ": ";
    const std::vector<std::string> parts = words(line);
    if (parts.empty() || parts[0].front() == '#') continue;
    const std::string& key = parts[0];
    if (parts.size() < 2) {
      result.wrong.push_back(place + "line without a value: " + line);
    } else if (key == "run:") {
      result.runs.push_back({parts[1], {parts.begin() + 2, parts.end()}});
    } else if (key == "order:") {
      result.order.assign(parts.begin() + 1, parts.end());
    } else if (key == "warning:") {
      result.warnings.push_back({parts[1], {parts.begin() + 2, parts.end()}});
    } else if (key == "event:" && parts.size() == 3) {
      result.events[parts[1]] += std::strtoull(parts[2].c_str(), nullptr, 10);
    } else if (key == "fault:" && parts.size() == 4) {
      result.faults.push_back({parts[1], parts[2], parts[3]});
    } else if (key == "start:") {
      result.start = parts[1];
    } else if (key == "lib:") {
      result.libraries.insert(result.libraries.end(), parts.begin() + 1, parts.end());
    } else if (key == "tables:") {
      result.tables.insert(result.tables.end(), parts.begin() + 1, parts.end());
    } else if (key == "tolerance:" && parts.size() == 3 && is_number(parts[2])) {
      result.tolerances.push_back({parts[1], std::strtod(parts[2].c_str(), nullptr)});
    } else if (key == "only:" && parts.size() > 2) {
      result.only = line.substr(line.find(parts[1]));
    } else {
      result.wrong.push_back(place + "line that is not understood: " + line);
    }
  }
  if (result.runs.empty()) result.runs.push_back({"expected.csv", {}});
  return result;
}

bool in_sequence(const std::vector<std::string>& ids, const std::vector<std::string>& order) {
  std::size_t next = 0;
  for (const std::string& id : order) {
    if (next < ids.size() && id == ids[next]) ++next;
  }
  return next == ids.size();
}

double tolerance_of(const CaseFile& the_case, const std::string& path) {
  double most = 0;
  for (const Tolerance& one : the_case.tolerances) {
    if (core::glob_match(one.pattern, path)) most = one.most;
  }
  return most;
}

bool is_case(const fs::path& folder) {
  std::error_code ignored;
  return fs::exists(project_of(folder), ignored) &&
         (fs::exists(folder / "expected.csv", ignored) || fs::exists(folder / "case.txt", ignored));
}

fs::path project_of(const fs::path& folder) {
  for (const char* const name : kProjects) {
    if (fs::exists(folder / name)) return folder / name;
  }
  return folder / "project.xml";
}

std::vector<std::string> case_names(const fs::path& root) {
  std::vector<std::string> names;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string name = entry.path().filename().string();
    if (std::find(std::begin(kProjects), std::end(kProjects), name) != std::end(kProjects)) {
      names.push_back(fs::relative(entry.path().parent_path(), root).generic_string());
    }
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace plc::tests
