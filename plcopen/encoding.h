// Character encodings of project files: which one it is, and the way to UTF-8.
//
// In: raw bytes. Out: UTF-8. Does not belong here: reading files (input_text.h), XML.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace plc::plcopen {

struct Encoding {
  enum class Kind : std::uint8_t { kUtf8, kUtf16Le, kUtf16Be, kLatin1, kWindows1252, kUnknown };
  Kind kind = Kind::kUtf8;
  std::size_t bom = 0;  ///< bytes of the byte order mark
  std::string name;     ///< as declared
};

/// By byte order mark, by the bytes of the first character, then by the XML declaration.
Encoding detect_encoding(std::string_view bytes);
/// Bytes `to_utf8` writes for `bytes`.
std::size_t utf8_size(std::string_view bytes, Encoding::Kind kind);
/// Writes `bytes` as UTF-8 to `out`. Lone surrogates and a trailing odd byte become U+FFFD.
void to_utf8(std::string_view bytes, Encoding::Kind kind, char* out);

}  // namespace plc::plcopen
