// Canvas: SVG pieces as they come, and how far they reach.
//
// In: lines, texts, shapes. Out: one document. Internal to pictures/. Does not belong here: what is drawn.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "pictures/picture.h"

namespace plc::pictures {

enum class Anchor : std::uint8_t { kStart, kMiddle, kEnd };

/// A rectangle of a drawing; without anything in it at first.
struct Box {
  std::int32_t left = std::numeric_limits<std::int32_t>::max(), top = left;
  std::int32_t right = std::numeric_limits<std::int32_t>::min(), bottom = right;
};

class Canvas {
 public:
  void put(std::string_view piece) { out_ += piece; }
  /// What follows belongs together, under a tooltip. `attributes`: further ones, with a blank before each.
  void begin_group(std::string_view classes, std::string_view title, std::string_view attributes = {});
  void end_group() { out_ += "</g>\n"; }
  /// One line of text with its baseline at `y`, in the look of `mark`.
  void text(std::int32_t x, std::int32_t y, std::string_view line, Anchor anchor = Anchor::kStart,
            std::string_view classes = {}, const Mark* mark = nullptr);
  /// The text of a mark, or the place for it when a viewer fills it in.
  void value(std::int32_t x, std::int32_t y, const Mark* mark, Anchor anchor = Anchor::kStart,
             std::string_view classes = "value");
  void rect(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height, std::string_view classes = {},
            const Mark* mark = nullptr);
  void cover(std::int32_t left, std::int32_t top, std::int32_t right, std::int32_t bottom) {
    box_ = {std::min(box_.left, left), std::min(box_.top, top), std::max(box_.right, right),
            std::max(box_.bottom, bottom)};
    right_ = std::max(right_, right);
    bottom_ = std::max(bottom_, bottom);
  }
  /// The whole document.
  [[nodiscard]] std::string document(std::string_view title) const;
  [[nodiscard]] std::int32_t right() const { return right_; }
  [[nodiscard]] std::int32_t bottom() const { return bottom_; }

  /// Texts are cut to so many bytes, and no more than so many lines of text come before take().
  void limit(std::size_t bytes, std::size_t lines) {
    most_bytes_ = bytes;
    most_lines_ = lines;
  }
  /// What was drawn since the last call, and how far it reaches.
  [[nodiscard]] std::string take(Box& box);

 private:
  std::string out_;
  Box box_;
  std::int32_t right_ = 0, bottom_ = 0;
  std::size_t most_bytes_ = std::numeric_limits<std::size_t>::max(), most_lines_ = most_bytes_, lines_ = 0;
};

/// Class of a look: " on"; empty for kPlain.
std::string_view class_of(Look look);
/// "executed in this scan", for tooltips; empty for kPlain.
std::string_view word_of(Look look);
/// Width of a text in pixels.
std::int32_t width_of(std::string_view text);
/// What an element of SVG in the look of a mark has: class="shape on", and the number of the mark.
std::string attributes_of(std::string_view classes, const Mark* mark);
/// A class of a look without its blank.
inline std::string_view only(std::string_view class_of_look) {
  return class_of_look.empty() ? class_of_look : class_of_look.substr(1);
}

/// What is known of a place.
class Known {
 public:
  /// `live`: a viewer fills in looks and values.
  Known(const Marks& marks, std::uint32_t pou, bool live, std::size_t body)
      : marks_(marks), pou_(pou), live_(live), body_(body) {}
  [[nodiscard]] const Mark* at(const bytecode::DrawnKey& key) const {
    const auto found = marks_.find(key);
    return found == marks_.end() ? nullptr : &found->second;
  }
  [[nodiscard]] const Marks& all() const { return marks_; }
  [[nodiscard]] std::uint32_t pou() const { return pou_; }
  [[nodiscard]] bool live() const { return live_; }
  /// Its number among those that are drawn.
  [[nodiscard]] std::size_t body() const { return body_; }

 private:
  const Marks& marks_;
  std::uint32_t pou_;
  bool live_;
  std::size_t body_;
};

/// What the picture of a body is made of, in the order of drawing.
class Pieces {
 public:
  virtual ~Pieces() = default;
  [[nodiscard]] virtual std::size_t count() const = 0;
  virtual void draw(std::size_t piece, Canvas& canvas) const = 0;
  /// The piece of the first element of a drawing, or of the first line of a text; others follow.
  [[nodiscard]] virtual std::size_t first() const { return 0; }
  /// It belongs to what is below it: a comment.
  [[nodiscard]] virtual bool heads(std::size_t piece) const {
    static_cast<void>(piece);
    return false;
  }
};
/// Elements, wires and comments of a body. Body and marks outlive them.
std::unique_ptr<Pieces> pieces_of_drawing(const bytecode::DrawnBody& body, const Known& known, std::int32_t top);
/// The text of a body, with numbers of its lines.
std::unique_ptr<Pieces> pieces_of_text(const bytecode::DrawnBody& body, const Known& known, std::int32_t top);

}  // namespace plc::pictures
