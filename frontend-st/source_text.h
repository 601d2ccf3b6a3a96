// SourceText: a piece of ST together with the place it has in its file, so that offsets become lines and columns.
//
// In: text, the SourceRef of its first character, the jumps of the file. Out: SourceRefs for diagnostics. Does not
// belong here: tokens.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/source_ref.h"

namespace plc::st {

/// Texts longer than this are refused: offsets are 32 bits, and no POU is this long.
inline constexpr std::size_t kMaxTextBytes = std::size_t{64} << 20;

class SourceText {
 public:
  /// `diagnostics` knows the file that `at` names.
  SourceText(std::string_view text, const core::SourceRef& at, const core::Diagnostics& diagnostics);
  /// A text without a place.
  explicit SourceText(std::string_view text) : text_(text) {}

  [[nodiscard]] std::string_view text() const { return text_; }
  [[nodiscard]] std::string_view slice(std::uint32_t begin, std::uint32_t end) const {
    return text_.substr(begin, end - begin);
  }
  /// The place of the character at byte `offset`; columns count characters, not bytes.
  [[nodiscard]] core::SourceRef locate(std::uint32_t offset) const;

 private:
  /// A character whose place is known: the first of the text, of a line, and what comes after a jump.
  struct Anchor {
    std::uint32_t offset = 0;
    core::Spot spot;
  };
  void follow(const core::TextJumps& jumps);
  /// Index of the last anchor at or before `offset`.
  [[nodiscard]] std::size_t anchor_of(std::uint32_t offset) const;

  std::string_view text_;
  core::SourceRef at_;
  std::vector<Anchor> anchors_;
  // Columns are counted on from the furthest place asked for: long lines are mostly read from left to right.
  mutable std::uint32_t counted_offset_ = 0;
  mutable std::size_t counted_anchor_ = 0;
  mutable std::uint32_t counted_characters_ = 0;
};

}  // namespace plc::st
