// Characters of UTF-8 text.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace plc::core {

/// The character that begins at byte `i`, which moves past it. A byte that begins none counts as its own value.
char32_t decode_utf8(std::string_view text, std::size_t& i);

/// Appends the bytes of a character.
void append_utf8(char32_t character, std::string& out);

/// True when every lead byte has its continuation bytes, and no byte stands alone.
bool is_utf8(std::string_view bytes);

}  // namespace plc::core
