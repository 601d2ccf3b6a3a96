// Bounds on the text of plc.toml, checked before the parser sees it.
//
// WHY: toml++ 3.3 destroys nested tables by recursion and bounds only nested values: a dotted key of some 100,000 parts
// overflows the stack. In: text. Out: the place where it goes too deep. Does not belong here: TOML's grammar; what is
// wrong otherwise, the parser says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace plc::io {

inline constexpr std::size_t kMaxConfigurationBytes = 4'000'000;
/// Brackets inside brackets, and dots in one key.
inline constexpr std::uint32_t kMaxConfigurationDepth = 16;

struct TextPlace {
  std::uint32_t line = 1;
  std::uint32_t column = 1;  ///< in characters
};

/// The first place that is nested deeper than kMaxConfigurationDepth, or nothing.
std::optional<TextPlace> too_deep(std::string_view toml);

}  // namespace plc::io
