// CSV as RFC 4180 has it, for stimuli: quoted cells, doubled quotes, CR LF or LF, with the place of every cell.
//
// In: text. Out: rows of cells with line and column. Does not belong here: what cells mean.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace plc::io {

struct CsvCell {
  std::string text;
  bool quoted = false;       ///< an empty quoted cell is a value, an empty bare cell is none
  std::uint32_t line = 0;    ///< 1-based
  std::uint32_t column = 0;  ///< 1-based, in bytes
};
using CsvRow = std::vector<CsvCell>;

/// Splits `text`; rows without any character are left out, and so are those that start with '#'. `file` names it in
/// problems (P7201, "file:line:column: ...").
core::Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view file);
/// Appends `cell`, quoted when it has to be.
void append_csv(std::string& out, std::string_view cell);

}  // namespace plc::io
