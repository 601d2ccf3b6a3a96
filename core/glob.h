// Glob: patterns of names, as in --watch and plc lib.
//
// In: a pattern, a name. Out: whether they match. Does not belong here: lists of names.
#pragma once

#include <string_view>

namespace plc::core {

/// True when `pattern` is `text`, ASCII letter case ignored: '*' stands for any characters, '?' for one.
bool glob_match(std::string_view pattern, std::string_view text);

}  // namespace plc::core
