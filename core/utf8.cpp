#include "core/utf8.h"

#include <cstdint>

namespace plc::core {

char32_t decode_utf8(std::string_view text, std::size_t& i) {
  const auto byte = [text](std::size_t k) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[k])); };
  const std::uint32_t lead = byte(i);
  const std::size_t extra = lead >= 0xf0 ? 3 : lead >= 0xe0 ? 2 : lead >= 0xc0 ? 1 : 0;
  bool whole = extra != 0 && i + extra < text.size();
  for (std::size_t k = 1; k <= extra && whole; ++k) whole = (byte(i + k) & 0xc0u) == 0x80u;
  if (!whole) return byte(i++);
  std::uint32_t point = lead & (0x3fu >> extra);
  for (std::size_t k = 1; k <= extra; ++k) point = (point << 6) | (byte(i + k) & 0x3fu);
  i += extra + 1;
  return point;
}

void append_utf8(char32_t character, std::string& out) {
  const auto put = [&out](char32_t bits) { out += static_cast<char>(bits); };
  if (character < 0x80) {
    put(character);
  } else if (character < 0x800) {
    put(0xc0 | (character >> 6));
    put(0x80 | (character & 0x3f));
  } else if (character < 0x10000) {
    put(0xe0 | (character >> 12));
    put(0x80 | ((character >> 6) & 0x3f));
    put(0x80 | (character & 0x3f));
  } else {
    put(0xf0 | (character >> 18));
    put(0x80 | ((character >> 12) & 0x3f));
    put(0x80 | ((character >> 6) & 0x3f));
    put(0x80 | (character & 0x3f));
  }
}

bool is_utf8(std::string_view bytes) {
  for (std::size_t i = 0; i < bytes.size();) {
    const auto lead = static_cast<unsigned char>(bytes[i]);
    const std::size_t length = lead < 0x80   ? 1
                               : lead < 0xC2 ? 0
                               : lead < 0xE0 ? 2
                               : lead < 0xF0 ? 3
                               : lead < 0xF5 ? 4
                                             : 0;
    if (length == 0 || bytes.size() - i < length) return false;
    for (std::size_t k = 1; k < length; ++k) {
      if ((static_cast<unsigned char>(bytes[i + k]) & 0xC0u) != 0x80u) return false;
    }
    i += length;
  }
  return true;
}

}  // namespace plc::core
