// Rewriting: the same project written in another way, and where each of its characters went: line ends, byte order
// mark, encodings, sections and entities. And lines and columns, counted here once more.
//
// In: the text of a project. Out: variants. Does not belong here: what is done with them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plc::test {

struct Position {
  std::uint32_t line = 1;
  std::uint32_t column = 1;
  friend bool operator==(const Position&, const Position&) = default;
};

/// Lines end with LF and nothing else; columns count characters of UTF-8; a byte order mark takes none.
Position position_of(std::string_view text, std::size_t offset);
/// npos where the text has no such place; after the last character of a line is one. Column 0: the beginning of the
/// line.
std::size_t offset_of(std::string_view text, const Position& position);

struct Variant {
  std::string name;
  std::string text;              ///< as UTF-8
  std::vector<std::size_t> map;  ///< where the byte at each offset of the original went, and its end
  std::string bytes;             ///< of the file
};

/// `original` has no CR. `markup`: it is XML.
std::vector<Variant> variants_of(const std::string& original, bool markup);

}  // namespace plc::test
