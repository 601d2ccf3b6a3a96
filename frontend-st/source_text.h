// SourceText: a piece of ST together with the place it has in the XML file, so that offsets become lines and columns.
//
// In: text and the SourceRef of its first character. Out: SourceRefs for diagnostics. Does not belong here: tokens.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/source_ref.h"

namespace plc::st {

/// Texts longer than this are refused: offsets are 32 bits, and no POU is this long.
inline constexpr std::size_t kMaxTextBytes = std::size_t{64} << 20;

class SourceText {
 public:
  SourceText(std::string_view text, const core::SourceRef& at);

  [[nodiscard]] std::string_view text() const { return text_; }
  [[nodiscard]] std::string_view slice(std::uint32_t begin, std::uint32_t end) const {
    return text_.substr(begin, end - begin);
  }
  /// The place of the character at byte `offset`; columns count characters, not bytes.
  [[nodiscard]] core::SourceRef locate(std::uint32_t offset) const;

 private:
  /// Lines that begin at or before `offset`, the first one not counted.
  [[nodiscard]] std::uint32_t line_of(std::uint32_t offset) const;
  std::string_view text_;
  core::SourceRef at_;
  std::vector<std::uint32_t> line_starts_;  ///< offsets of the second, third .. line
  // Columns are counted on from the furthest place asked for: long lines are mostly read from left to right.
  mutable std::uint32_t counted_offset_ = 0;
  mutable std::uint32_t counted_line_ = 0;
  mutable std::uint32_t counted_characters_ = 0;
};

}  // namespace plc::st
