// Comments of a text in TOML, which the parser drops.
//
// In: text that the parser takes. Out: its comments, and which lines have anything else. Does not belong here: what
// they belong to.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plc::hmi {

struct Comment {
  std::uint32_t line = 0;  ///< from 1
  std::string text;        ///< after the #
  bool alone = true;       ///< nothing before it in its line
};

struct Lines {
  std::vector<Comment> comments;
  std::vector<bool> used;  ///< by line, from 1: something other than blanks and comments is in it
};
Lines lines_of(std::string_view toml);

}  // namespace plc::hmi
