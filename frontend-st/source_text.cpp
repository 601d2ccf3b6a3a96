#include "frontend-st/source_text.h"

#include <algorithm>

namespace plc::st {

SourceText::SourceText(std::string_view text, const core::SourceRef& at) : text_(text), at_(at) {
  for (std::size_t i = text.find('\n'); i != std::string_view::npos; i = text.find('\n', i + 1)) {
    line_starts_.push_back(static_cast<std::uint32_t>(i + 1));
  }
}

// Places are mostly asked for from the beginning to the end: on the line counted last, or soon behind it.
std::uint32_t SourceText::line_of(std::uint32_t offset) const {
  constexpr std::uint32_t kNear = 4;
  const auto count = static_cast<std::uint32_t>(line_starts_.size());
  if (counted_line_ == 0 || line_starts_[counted_line_ - 1] <= offset) {
    for (std::uint32_t line = counted_line_; line <= counted_line_ + kNear; ++line) {
      if (line == count || offset < line_starts_[line]) return line;
    }
  }
  const auto after = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
  return static_cast<std::uint32_t>(after - line_starts_.begin());
}

core::SourceRef SourceText::locate(std::uint32_t offset) const {
  core::SourceRef out = at_;
  if (at_.line == 0) return out;
  const std::uint32_t lines = line_of(offset);
  const std::uint32_t start = lines == 0 ? 0 : line_starts_[lines - 1];
  if (lines == 0 && at_.column == 0) return out;
  const bool resume = counted_line_ == lines && counted_offset_ >= start && counted_offset_ <= offset;
  std::uint32_t characters = resume ? counted_characters_ : 0;
  for (std::uint32_t i = resume ? counted_offset_ : start; i < offset && i < text_.size(); ++i) {
    if ((static_cast<unsigned char>(text_[i]) & 0xc0u) != 0x80u) ++characters;
  }
  if (offset > counted_offset_) {
    counted_offset_ = offset;
    counted_line_ = lines;
    counted_characters_ = characters;
  }
  out.line = at_.line + lines;
  out.column = (lines == 0 ? at_.column : 1) + characters;
  return out;
}

}  // namespace plc::st
