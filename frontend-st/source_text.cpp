#include "frontend-st/source_text.h"

#include <algorithm>

namespace plc::st {

namespace {

bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xc0u) != 0x80u; }

}  // namespace

SourceText::SourceText(std::string_view text, const core::SourceRef& at, const core::Diagnostics& diagnostics)
    : text_(text), at_(at) {
  if (at.line == 0) return;
  anchors_.push_back({0, {at.line, at.column}});
  const core::TextJumps* jumps = at.column == 0 ? nullptr : diagnostics.text_jumps(at.file);
  if (jumps != nullptr && !jumps->all().empty()) {
    follow(*jumps);
    return;
  }
  std::uint32_t line = at.line;
  for (std::size_t i = text.find('\n'); i != std::string_view::npos; i = text.find('\n', i + 1)) {
    anchors_.push_back({static_cast<std::uint32_t>(i + 1), {++line, 1}});
  }
}

void SourceText::follow(const core::TextJumps& jumps) {
  core::Spot spot = anchors_.front().spot;
  std::size_t next = jumps.first_from(spot);
  const auto place = [&](std::size_t offset, const core::Spot& at) {
    spot = at;
    anchors_.push_back({static_cast<std::uint32_t>(offset), at});
    while (next < jumps.all().size() && jumps.all()[next].at < spot) ++next;
  };
  std::size_t i = 0;
  while (i < text_.size()) {
    std::size_t end = i + 1;
    while (end < text_.size() && !begins_character(text_[end])) ++end;
    const bool jump = next < jumps.all().size() && jumps.all()[next].at == spot;
    if (jump) {
      place(end, jumps.all()[next].next);
    } else if (text_[i] == '\n') {
      place(end, {spot.line + 1, 1});
    } else {
      ++spot.column;
    }
    i = end;
  }
}

// Places are mostly asked for from the beginning to the end: at the anchor counted from last, or soon after it.
std::size_t SourceText::anchor_of(std::uint32_t offset) const {
  constexpr std::size_t kNear = 4;
  if (anchors_[counted_anchor_].offset <= offset) {
    for (std::size_t i = counted_anchor_; i <= counted_anchor_ + kNear; ++i) {
      if (i + 1 == anchors_.size() || offset < anchors_[i + 1].offset) return i;
    }
  }
  const auto after = std::upper_bound(anchors_.begin(), anchors_.end(), offset,
                                      [](std::uint32_t at, const Anchor& anchor) { return at < anchor.offset; });
  return static_cast<std::size_t>(after - anchors_.begin()) - 1;
}

core::SourceRef SourceText::locate(std::uint32_t offset) const {
  core::SourceRef out = at_;
  if (at_.line == 0) return out;
  const std::size_t index = anchor_of(offset);
  const Anchor& anchor = anchors_[index];
  if (index == 0 && at_.column == 0) return out;
  const bool resume = counted_anchor_ == index && counted_offset_ >= anchor.offset && counted_offset_ <= offset;
  std::uint32_t characters = resume ? counted_characters_ : 0;
  for (std::uint32_t i = resume ? counted_offset_ : anchor.offset; i < offset && i < text_.size(); ++i) {
    if (begins_character(text_[i])) ++characters;
  }
  if (offset > counted_offset_) {
    counted_offset_ = offset;
    counted_anchor_ = index;
    counted_characters_ = characters;
  }
  out.line = anchor.spot.line;
  out.column = anchor.spot.column + characters;
  return out;
}

}  // namespace plc::st
