// What the text of a configuration must not have in it when the parser sees it.
//
// WHY: toml++ 3.3 destroys nested tables by recursion and bounds only nested values, so that a dotted key of some
// 100,000 parts overflows the stack; and characters beyond ASCII outside of texts lead it to code that is declared
// unreachable (its issues 190 and 295). In: text. Out: the first such place. Does not belong here: TOML's grammar; what
// is wrong otherwise, the parser says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace plc::core {

inline constexpr std::size_t kMaxTomlBytes = 4'000'000;
/// Brackets inside brackets, and dots in one key.
inline constexpr std::uint32_t kMaxTomlDepth = 16;

struct TextProblem {
  enum class Kind : std::uint8_t {
    kTooDeep,   ///< nested deeper than kMaxTomlDepth
    kNotPlain,  ///< not printable ASCII outside of texts, quoted keys and comments; a quote inside a word
  } kind = Kind::kTooDeep;
  std::uint32_t line = 1;
  std::uint32_t column = 1;  ///< in characters
};

std::optional<TextProblem> find_unsafe(std::string_view toml);

}  // namespace plc::core
