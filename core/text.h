// Small text helpers shared by all steps: IEC identifiers are case-insensitive, so names compare and hash folded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace plc::core {

constexpr char fold(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }
constexpr char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

/// Equality of identifiers, ASCII letter case ignored (IEC 61131-3, 6.1.2).
constexpr bool iequals(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (fold(a[i]) != fold(b[i])) return false;
  }
  return true;
}
/// `text` with ASCII letters in lower (folded) or upper case.
std::string folded(std::string_view text);
std::string uppered(std::string_view text);
/// `text` without ASCII blanks (space, tab, CR, LF) at both ends.
std::string_view trimmed(std::string_view text);

/// Hash and equality for unordered containers keyed by identifiers; both accept std::string_view (no copy to look up).
struct NameHash {
  using is_transparent = void;
  std::size_t operator()(std::string_view text) const {
    std::uint64_t h = 1469598103934665603ull;
    for (char c : text) h = (h ^ static_cast<unsigned char>(fold(c))) * 1099511628211ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};
struct NameEqual {
  using is_transparent = void;
  bool operator()(std::string_view a, std::string_view b) const { return iequals(a, b); }
};

}  // namespace plc::core
