// Canvas: SVG pieces as they come, and how far they reach.
//
// In: lines, texts, shapes. Out: one document. Internal to pictures/. Does not belong here: what is drawn.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "pictures/picture.h"

namespace plc::pictures {

enum class Anchor : std::uint8_t { kStart, kMiddle, kEnd };

class Canvas {
 public:
  void put(std::string_view piece) { out_ += piece; }
  /// What follows belongs together, under a tooltip.
  void begin_group(std::string_view classes, std::string_view title);
  void end_group() { out_ += "</g>\n"; }
  /// One line of text with its baseline at `y`.
  void text(std::int32_t x, std::int32_t y, std::string_view line, Anchor anchor = Anchor::kStart,
            std::string_view classes = {});
  void rect(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height, std::string_view classes = {});
  void reach(std::int32_t x, std::int32_t y);
  /// The whole document.
  [[nodiscard]] std::string document(std::string_view title) const;
  [[nodiscard]] std::int32_t bottom() const { return bottom_; }

 private:
  std::string out_;
  std::int32_t right_ = 0, bottom_ = 0;
};

/// Class of a look: " on"; empty for kPlain.
std::string_view class_of(Look look);
/// "executed in this scan", for tooltips; empty for kPlain.
std::string_view word_of(Look look);
/// Width of a text in pixels.
std::int32_t width_of(std::string_view text);

/// What is known of a place.
class Known {
 public:
  Known(const Marks& marks, std::uint32_t pou) : marks_(marks), pou_(pou) {}
  [[nodiscard]] const Mark* at(const bytecode::DrawnKey& key) const {
    const auto found = marks_.find(key);
    return found == marks_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] Look look(const bytecode::DrawnKey& key) const {
    const Mark* const mark = at(key);
    return mark == nullptr ? Look::kPlain : mark->look;
  }
  [[nodiscard]] const Marks& all() const { return marks_; }
  [[nodiscard]] std::uint32_t pou() const { return pou_; }

 private:
  const Marks& marks_;
  std::uint32_t pou_;
};

/// Elements, wires and comments of a body.
void draw_elements(Canvas& canvas, const bytecode::DrawnBody& body, const Known& known, std::int32_t top);
/// The text of a body, with numbers of its lines.
void draw_text(Canvas& canvas, const bytecode::DrawnBody& body, const Known& known, std::int32_t top);

}  // namespace plc::pictures
