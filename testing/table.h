// Comma-separated tables as the simulator writes them and cases expect them.
//
// In: text of a CSV file, cells optionally in double quotes. Out: header and rows of texts; whether two cells mean the
// same. Does not belong here: what a column means.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace plc::tests {

struct CsvTable {
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;
  std::vector<std::size_t> lines;  ///< line of each row in the file, 1-based
  /// Index of the column whose name equals `name` in any letter case, or header.size().
  [[nodiscard]] std::size_t column(const std::string& name) const;
};

/// Reads a file. Lines that begin with # and empty lines are skipped. Throws std::runtime_error when it cannot be
/// opened.
CsvTable read_csv(const std::string& path);

/// True when two cells mean the same value: equal texts, numbers that differ by at most `tolerance` (by nothing, and as
/// doubles where a decimal point or exponent makes them reals, when it is 0), strings with or without IEC quotes.
bool same_value(const std::string& expected, const std::string& actual, double tolerance = 0);

}  // namespace plc::tests
