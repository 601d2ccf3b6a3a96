// Windows-1252, the characters of STRING: ISO 8859-1, and 27 more where that has control codes.
//
// In: a byte or a code point. Out: the other. Does not belong here: encodings of files (plcopen/encoding.h).
#pragma once

#include <cstdint>
#include <optional>

namespace plc::core {

/// Code points of the bytes 16#80 to 16#9F; the five unassigned ones stay C1 controls.
inline constexpr char16_t kWindows1252[32] = {0x20AC, 0x81,   0x201A, 0x0192, 0x201E, 0x2026, 0x2020, 0x2021,
                                              0x02C6, 0x2030, 0x0160, 0x2039, 0x0152, 0x8D,   0x017D, 0x8F,
                                              0x90,   0x2018, 0x2019, 0x201C, 0x201D, 0x2022, 0x2013, 0x2014,
                                              0x02DC, 0x2122, 0x0161, 0x203A, 0x0153, 0x9D,   0x017E, 0x0178};

/// The character of a byte. RT.
constexpr char16_t from_windows_1252(std::uint8_t byte) noexcept {
  return byte >= 0x80 && byte < 0xa0 ? kWindows1252[byte - 0x80] : char16_t{byte};
}
/// The byte of a character. A control code 16#80 to 16#9F, as files in ISO 8859-1 have it, is the byte of its number.
/// Nothing when there is none. RT.
constexpr std::optional<std::uint8_t> to_windows_1252(char32_t point) noexcept {
  if (point <= 0xff) return static_cast<std::uint8_t>(point);
  for (std::uint8_t i = 0; i < 32; ++i) {
    if (kWindows1252[i] == point) return static_cast<std::uint8_t>(0x80 + i);
  }
  return std::nullopt;
}

}  // namespace plc::core
