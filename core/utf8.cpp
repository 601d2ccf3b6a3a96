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
