#include "testing/table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace plc::tests {
namespace {

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        cells.back() += '"';
        ++i;
      } else {
        quoted = !quoted;
      }
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

bool is_real_text(const std::string& text) {
  return text.find_first_of(".eE") != std::string::npos || lower(text).find("inf") != std::string::npos;
}

std::string unquoted(const std::string& text) {
  if (text.size() >= 2 && text.front() == '\'' && text.back() == '\'') return text.substr(1, text.size() - 2);
  return text;
}

}  // namespace

std::size_t CsvTable::column(const std::string& name) const {
  for (std::size_t i = 0; i < header.size(); ++i) {
    if (lower(header[i]) == lower(name)) return i;
  }
  return header.size();
}

CsvTable read_csv(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error("cannot open " + path);
  CsvTable table;
  std::string line;
  std::size_t number = 0;
  while (std::getline(in, line)) {
    ++number;
    if (line.empty() || line == "\r" || line.front() == '#') continue;
    if (table.header.empty()) {
      table.header = split(line);
    } else {
      table.rows.push_back(split(line));
      table.lines.push_back(number);
    }
  }
  return table;
}

bool same_value(const std::string& expected, const std::string& actual, double tolerance) {
  if (expected == actual) return true;
  if (unquoted(expected) == unquoted(actual)) return true;
  if (lower(expected) == "nan") return lower(actual) == "nan";
  if (tolerance == 0 && !is_real_text(expected) && !is_real_text(actual)) return false;
  char* end_expected = nullptr;
  char* end_actual = nullptr;
  const double a = std::strtod(expected.c_str(), &end_expected);
  const double b = std::strtod(actual.c_str(), &end_actual);
  const bool numbers = !expected.empty() && !actual.empty() && *end_expected == '\0' && *end_actual == '\0';
  return numbers && (a == b || std::fabs(a - b) <= tolerance);
}

}  // namespace plc::tests
