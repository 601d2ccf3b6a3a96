// Reading and writing STRING and WSTRING values in tables.
//
// In: pointers to core::StringHeader, the characters right after it. Out: views that stay inside the value, writes
// that stay inside the capacity and report what was cut off. STRING holds bytes (ISO 8859-1), WSTRING UTF-16 code
// units. Does not belong here: what the string functions do (functions/strings.h), numbers as text (text_values.h).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>

#include "core/types.h"
#include "stdlib/library.h"

namespace plc::stdlib {

/// The characters in use: min(length, capacity, type_capacity), whatever the header says.
template <class Char>
std::basic_string_view<Char> text_of(const void* value,
                                     std::uint16_t type_capacity = core::kMaxStringCapacity) noexcept {
  core::StringHeader header;
  std::memcpy(&header, value, sizeof header);
  const auto* chars = reinterpret_cast<const Char*>(static_cast<const std::byte*>(value) + sizeof header);
  return {chars, std::min({header.length, header.capacity, type_capacity})};
}

namespace detail {

template <class Char>
void set_text(void* value, core::StringHeader header, std::size_t length) noexcept {
  header.length = static_cast<std::uint16_t>(length);
  std::memcpy(value, &header, sizeof header);
}
template <class Char>
Char* chars_of(void* value) noexcept {
  return reinterpret_cast<Char*>(static_cast<std::byte*>(value) + sizeof(core::StringHeader));
}
/// Copies what fits of `pieces` to `out`; returns how many characters.
template <class Char>
std::size_t gather(Char* out, std::size_t room, std::span<const std::basic_string_view<Char>> pieces) noexcept {
  std::size_t n = 0;
  for (const auto& piece : pieces) {
    const std::size_t take = std::min(piece.size(), room - n);
    if (take != 0) std::memmove(out + n, piece.data(), take * sizeof(Char));
    n += take;
  }
  return n;
}
/// As gather, for pieces that lie in `out` themselves: over a buffer. Kept out of line, it needs 64 KiB of stack.
template <class Char>
[[gnu::noinline]] std::size_t gather_buffered(Char* out, std::size_t room,
                                              std::span<const std::basic_string_view<Char>> pieces) noexcept {
  Char buffer[core::kMaxStringCapacity];
  const std::size_t n = gather<Char>(buffer, std::min<std::size_t>(room, core::kMaxStringCapacity), pieces);
  std::memcpy(out, buffer, n * sizeof(Char));
  return n;
}

}  // namespace detail

/// Writes the pieces one after another; kTruncated when they do not fit. Pieces may lie in `value` itself. RT.
template <class Char>
Event write_text(void* value, std::span<const std::basic_string_view<Char>> pieces) noexcept {
  core::StringHeader header;
  std::memcpy(&header, value, sizeof header);
  const std::size_t room = std::min<std::size_t>(header.capacity, core::kMaxStringCapacity);
  Char* const out = detail::chars_of<Char>(value);
  const auto begin = reinterpret_cast<std::uintptr_t>(out);
  const auto end = begin + room * sizeof(Char);
  std::size_t total = 0;
  bool overlaps = false;
  for (const auto& piece : pieces) {
    const auto at = reinterpret_cast<std::uintptr_t>(piece.data());
    overlaps |= !piece.empty() && at < end && at + piece.size() * sizeof(Char) > begin;
    total += piece.size();
  }
  const std::size_t length = overlaps && pieces.size() > 1 ? detail::gather_buffered<Char>(out, room, pieces)
                                                           : detail::gather<Char>(out, room, pieces);
  detail::set_text<Char>(value, header, length);
  return total > length ? Event::kTruncated : Event::kNone;
}
template <class Char>
Event write_text(void* value, std::basic_string_view<Char> text) noexcept {
  return write_text<Char>(value, std::span<const std::basic_string_view<Char>>{&text, 1});
}

}  // namespace plc::stdlib
