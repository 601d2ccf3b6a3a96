#include "io-drivers/csv.h"

namespace plc::io {

core::Result<std::vector<CsvRow>> parse_csv(std::string_view text, std::string_view file) {
  std::vector<CsvRow> rows;
  std::uint32_t line = 1;
  std::size_t line_start = 0;
  std::size_t at = 0;
  std::size_t counted = 0;  // offset up to which columns are counted, in characters
  std::uint32_t characters = 0;
  const auto column = [&] {
    if (counted < line_start || counted > at) counted = line_start, characters = 0;
    for (; counted < at; ++counted)
      characters += (static_cast<unsigned char>(text[counted]) & 0xC0u) != 0x80u ? 1u : 0u;
    return characters + 1;
  };
  const auto problem = [&](std::uint32_t l, std::uint32_t c, std::string message) {
    return core::Problem{
        core::Code::P7201,
        std::string(file) + ":" + std::to_string(l) + ":" + std::to_string(c) + ": " + std::move(message),
        "cells with commas, quotes or line ends are in double quotes, quotes inside are doubled"};
  };
  const auto end_of_line = [&] { return at < text.size() && (text[at] == '\n' || text[at] == '\r'); };
  // Rows end with LF, CR LF, CR CR LF or a CR alone; lines are counted by LF, as editors do.
  const auto next_line = [&] {
    std::size_t end = at;
    while (end < text.size() && text[end] == '\r') ++end;
    const bool counts = end < text.size() && text[end] == '\n';
    at = counts ? end + 1 : at + 1;
    if (!counts) return;
    ++line;
    line_start = at;
  };
  if (text.starts_with("\xef\xbb\xbf")) at = line_start = 3;
  while (at < text.size()) {
    if (end_of_line()) {
      next_line();
      continue;
    }
    if (text[at] == '#') {
      while (at < text.size() && !end_of_line()) ++at;
      continue;
    }
    CsvRow row;
    for (;;) {
      CsvCell cell;
      cell.line = line;
      cell.column = column();
      if (at < text.size() && text[at] == '"') {
        cell.quoted = true;
        ++at;
        for (;;) {
          if (at == text.size()) return problem(cell.line, cell.column, "quoted cell has no end");
          if (text[at] == '"') {
            if (!text.substr(at).starts_with("\"\"")) break;
            ++at;
          } else if (text[at] == '\n') {
            ++line;
            line_start = at + 1;
          }
          cell.text += text[at++];
        }
        ++at;
        if (at < text.size() && text[at] != ',' && !end_of_line()) {
          return problem(line, column(), "text after a quoted cell");
        }
      } else {
        while (at < text.size() && text[at] != ',' && !end_of_line()) {
          if (text[at] == '"') return problem(line, column(), "quote inside a cell that is not quoted");
          cell.text += text[at++];
        }
      }
      row.push_back(std::move(cell));
      if (at == text.size() || text[at] != ',') break;
      ++at;
    }
    rows.push_back(std::move(row));
    if (at < text.size()) next_line();
  }
  return rows;
}

void append_csv(std::string& out, std::string_view cell) {
  if (cell.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += cell;
    return;
  }
  out += '"';
  for (const char c : cell) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

}  // namespace plc::io
