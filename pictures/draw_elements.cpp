// Drawings: comments, then wires, then elements, so that wires end behind the boxes.
#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "pictures/canvas.h"

namespace plc::pictures {
namespace {

using bytecode::DrawnAction;
using bytecode::DrawnBody;
using bytecode::DrawnEdge;
using bytecode::DrawnElement;
using bytecode::DrawnModifiers;
using bytecode::DrawnPin;
using bytecode::DrawnStorage;
using bytecode::DrawnWire;
using core::ElementKind;

constexpr std::int32_t kLine = bytecode::kDrawnLineHeight;
constexpr std::int32_t kMiddle = 4;  ///< from the middle of a line of text down to its baseline
constexpr std::int32_t kNoPin = 0xffff;
/// Bytes of a name that viewers select something by.
constexpr std::size_t kMostName = 1000;

std::string_view mark_of(const DrawnModifiers& m) {
  if (m.storage == DrawnStorage::kSet) return "S";
  if (m.storage == DrawnStorage::kReset) return "R";
  if (m.edge == DrawnEdge::kRising) return "P";
  if (m.edge == DrawnEdge::kFalling) return "N";
  return {};
}

std::string described(const DrawnModifiers& m) {
  std::string out;
  if (m.negated) out += ", negated";
  if (m.edge == DrawnEdge::kRising) out += ", rising edge";
  if (m.edge == DrawnEdge::kFalling) out += ", falling edge";
  if (m.storage == DrawnStorage::kSet) out += ", set";
  if (m.storage == DrawnStorage::kReset) out += ", reset";
  return out;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (true) {
    const std::size_t end = text.find('\n');
    lines.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return lines;
    text.remove_prefix(end + 1);
  }
}

/// Draws any piece of a body on a canvas. `told`: inputs whose value stands elsewhere.
class Elements {
 public:
  using Told = std::set<std::pair<const DrawnElement*, std::size_t>>;
  Elements(Canvas& canvas, const DrawnBody& body, const Known& known, std::int32_t top, const Told& told)
      : canvas_(canvas), body_(body), known_(known), top_(top), told_(told) {}

  /// Of the chart of a macro step, above it.
  void draw_caption(std::size_t sheet) {
    std::int32_t first = bytecode::kMaxDrawn;
    for (const DrawnElement& e : body_.elements) {
      if (e.sheet == sheet) first = std::min(first, e.y);
    }
    if (first == bytecode::kMaxDrawn) return;
    canvas_.text(12, y_of(first) - 2 * kLine, "macro step " + body_.sheets[sheet], Anchor::kStart, "title");
    canvas_.put("\n");
  }

  void draw_comment(const bytecode::DrawnComment& comment) {
    canvas_.begin_group("comment", "comment");
    canvas_.rect(comment.x, y_of(comment.y), comment.width, comment.height, "note");
    std::int32_t y = y_of(comment.y) + kLine - 2;
    for (const std::string_view line : lines_of(comment.text)) {
      canvas_.text(comment.x + 4, y, line);
      y += kLine;
    }
    canvas_.end_group();
  }

  // ---- wires ----

  void draw_wire(const DrawnWire& wire) {
    const DrawnElement& from = body_.elements[wire.from];
    const DrawnElement& to = body_.elements[wire.to];
    const Mark* mark = known_.at(bytecode::key_of(known_.pou(), from, from.pins[wire.from_pin]));
    if (mark == nullptr) mark = known_.at(bytecode::key_of(known_.pou(), to, to.pins[wire.to_pin]));
    canvas_.put(fmt::format("<polyline {} points=\"", attributes_of("wire", mark)));
    for (std::size_t i = 0; i < wire.points.size(); ++i) {
      const std::int32_t x = wire.points[i].x, y = y_of(wire.points[i].y);
      canvas_.put(fmt::format("{}{},{}", i == 0 ? "" : " ", x, y));
      canvas_.cover(x, y, x, y);
    }
    canvas_.put("\"/>\n");
  }

  // ---- elements ----

  void draw_element(const DrawnElement& e) {
    canvas_.begin_group(core::element_word(e.kind), title_of(e), selected_by(e));
    canvas_.cover(e.x, y_of(e.y), e.x + e.width, y_of(e.y + e.height));
    draw_shape(e, known_.at(key(e)));
    for (std::size_t i = 0; i < e.pins.size(); ++i) draw_pin(e, e.pins[i], told_.contains({&e, i}));
    canvas_.end_group();
  }

 private:
  [[nodiscard]] std::int32_t y_of(std::int32_t y) const { return y + top_; }
  [[nodiscard]] bytecode::DrawnKey key(const DrawnElement& e) const { return bytecode::key_of(known_.pou(), e); }

  /// What viewers select it by: the variable or instance, and the type of a block.
  [[nodiscard]] std::string selected_by(const DrawnElement& e) const {
    if (!known_.live()) return {};
    const bool block = e.kind == ElementKind::kBlock;
    std::string out =
        fmt::format(" data-e=\"{}.{}\" tabindex=\"-1\" role=\"button\"", known_.body(), &e - body_.elements.data());
    const std::string& name = block ? e.instance : e.text;
    if (!name.empty()) out += fmt::format(" data-name=\"{}\"", escaped(std::string_view(name).substr(0, kMostName)));
    if (block) out += fmt::format(" data-type=\"{}\"", escaped(std::string_view(e.text).substr(0, kMostName)));
    return out;
  }

  [[nodiscard]] std::string title_of(const DrawnElement& e) const {
    std::string title(core::element_word(e.kind));
    if (!e.instance.empty()) title += " " + e.instance + " :";
    if (!e.text.empty()) title += " " + e.text;
    title += described(e.modifiers);
    if (const Mark* const mark = known_.at(key(e))) {
      if (mark->look != Look::kPlain) title += ", " + std::string(word_of(mark->look));
      if (!mark->text.empty()) title += ", " + mark->text;
    }
    if (e.line != 0)
      title += fmt::format(" (line {}{})", e.line, e.local_id < 0 ? "" : fmt::format(", {}", e.local_id));
    return title;
  }

  void draw_shape(const DrawnElement& e, const Mark* look) {
    switch (e.kind) {
      case ElementKind::kContact:
        draw_contact(e, look);
        break;
      case ElementKind::kCoil:
        draw_coil(e, look);
        break;
      case ElementKind::kBlock:
        draw_block(e, look);
        break;
      case ElementKind::kLeftRail:
      case ElementKind::kRightRail: {
        const std::int32_t x = e.kind == ElementKind::kLeftRail ? e.x + e.width : e.x;
        canvas_.put(fmt::format("<path class=\"bar\" d=\"M{},{}v{}\"/>", x, y_of(e.y), e.height));
        break;
      }
      case ElementKind::kStep:
      case ElementKind::kMacroStep:
        draw_step(e, look);
        break;
      case ElementKind::kTransition:
        draw_transition(e, look);
        break;
      case ElementKind::kJumpStep:
        draw_jump_step(e);
        break;
      case ElementKind::kSelectionDivergence:
      case ElementKind::kSelectionConvergence:
        canvas_.put(fmt::format("<path class=\"shape\" d=\"M{},{}h{}\"/>", e.x, y_of(e.y) + e.height / 2, e.width));
        break;
      case ElementKind::kSimultaneousDivergence:
      case ElementKind::kSimultaneousConvergence:
        canvas_.put(fmt::format("<path class=\"shape\" d=\"M{0},{1}h{3}M{0},{2}h{3}\"/>", e.x, y_of(e.y),
                                y_of(e.y) + std::max(e.height, std::int32_t{4}), e.width));
        break;
      case ElementKind::kActionBlock:
        draw_actions(e);
        break;
      default:
        draw_labelled_box(e, look);
    }
  }

  [[nodiscard]] static std::int32_t flow_y(const DrawnElement& e) {
    return e.pins.empty() ? e.y + e.height / 2 : e.pins.front().at.y;
  }

  /// The name above, a value or remark below.
  void label(const DrawnElement& e, std::string_view name, const Mark* look) {
    const std::int32_t x = e.x + e.width / 2;
    canvas_.text(x, y_of(e.y) - 4, name, Anchor::kMiddle);
    canvas_.value(x, y_of(e.y + e.height) + kLine - 2, look, Anchor::kMiddle,
                  "value" + std::string(look == nullptr ? "" : class_of(look->look)));
  }

  void draw_contact(const DrawnElement& e, const Mark* look) {
    const std::int32_t middle = e.x + e.width / 2, y = y_of(flow_y(e));
    const std::int32_t gap = std::min(std::int32_t{5}, e.width / 4 + 1),
                       high = std::min(e.height / 2, std::int32_t{10});
    canvas_.put(fmt::format("<path {} d=\"M{},{}H{}M{},{}V{}M{},{}V{}M{},{}H{}", attributes_of("shape", look), e.x, y,
                            middle - gap, middle - gap, y - high, y + high, middle + gap, y - high, y + high,
                            middle + gap, y, e.x + e.width));
    if (e.modifiers.negated) canvas_.put(fmt::format("M{},{}L{},{}", middle - gap, y + high, middle + gap, y - high));
    canvas_.put("\"/>");
    canvas_.text(middle, y + kMiddle, mark_of(e.modifiers), Anchor::kMiddle);
    label(e, e.text, look);
  }

  void draw_coil(const DrawnElement& e, const Mark* look) {
    const std::int32_t middle = e.x + e.width / 2, y = y_of(flow_y(e));
    const std::int32_t gap = std::min(std::int32_t{8}, e.width / 3), high = std::min(e.height / 2, std::int32_t{10});
    canvas_.put(fmt::format("<path {0} d=\"M{1},{2}H{3}M{4},{5}Q{6},{2} {4},{7}M{8},{5}Q{9},{2} {8},{7}M{10},{2}H{11}",
                            attributes_of("shape", look), e.x, y, middle - gap - 1, middle - gap + 3, y - high,
                            middle - gap - 5, y + high, middle + gap - 3, middle + gap + 5, middle + gap + 1,
                            e.x + e.width));
    if (e.modifiers.negated)
      canvas_.put(fmt::format("M{},{}L{},{}", middle - 4, y + high - 2, middle + 4, y - high + 2));
    canvas_.put("\"/>");
    canvas_.text(middle, y + kMiddle, mark_of(e.modifiers), Anchor::kMiddle);
    label(e, e.text, look);
  }

  void box(const DrawnElement& e, const Mark* look) {
    canvas_.rect(e.x, y_of(e.y), e.width, e.height, "shape box", look);
  }

  void draw_block(const DrawnElement& e, const Mark* look) {
    box(e, look);
    canvas_.text(e.x + e.width / 2, y_of(e.y) + kLine - 1, e.text, Anchor::kMiddle, "title");
    label(e, e.instance, look);
    if (e.code.empty()) return;
    const std::vector<std::string_view> lines = lines_of(e.code);
    const std::int32_t room = e.height - code_top(e) - 2;
    const auto fit = static_cast<std::size_t>(std::max(room / kLine, std::int32_t{1}));
    std::int32_t y = y_of(e.y) + code_top(e) + kLine - 3;
    for (std::size_t i = 0; i < std::min(lines.size(), fit); ++i, y += kLine) {
      const bool cut = i + 1 == fit && lines.size() > fit;
      canvas_.text(e.x + 8, y, cut ? std::string_view("..") : lines[i]);
    }
  }
  /// Below the lowest pin.
  [[nodiscard]] static std::int32_t code_top(const DrawnElement& e) {
    std::int32_t low = kLine + 4;
    for (const DrawnPin& pin : e.pins) low = std::max(low, pin.at.y - e.y + kLine / 2 + 2);
    return low;
  }

  /// Variables, connectors, labels, jumps, returns.
  void draw_labelled_box(const DrawnElement& e, const Mark* look) {
    const std::int32_t middle = y_of(e.y) + e.height / 2, left = e.x, right = e.x + e.width;
    const auto arrow = [&](std::string_view classes) {
      const std::int32_t tip = std::min(e.height / 2, std::int32_t{8});
      canvas_.put(fmt::format("<path {} d=\"M{},{}H{}L{},{}L{},{}H{}Z\"/>", attributes_of(classes, look), left,
                              y_of(e.y), right - tip, right, middle, right - tip, y_of(e.y) + e.height, left));
    };
    std::string text = e.text;
    switch (e.kind) {
      case ElementKind::kConnector:
      case ElementKind::kContinuation:
        arrow("shape box");
        break;
      case ElementKind::kLabel:
        text += ':';
        break;
      case ElementKind::kJump:
        arrow("shape box");
        break;
      case ElementKind::kReturn:
        text = "RETURN";
        arrow("shape box");
        break;
      default:
        box(e, look);
    }
    canvas_.text(left + e.width / 2, middle + kMiddle, text, Anchor::kMiddle,
                 e.kind == ElementKind::kLabel ? "title" : "");
    const bool modified = e.modifiers.negated || !mark_of(e.modifiers).empty();
    if (modified && !e.pins.empty()) draw_modifiers(e.pins.front(), e.modifiers);
    if (says_for_pin(e)) return canvas_.value(right + 4, y_of(e.pins.front().at.y) - 3, look);
    canvas_.value(left + e.width / 2, y_of(e.y + e.height) + kLine - 2, look, Anchor::kMiddle);
  }

  // ---- charts ----

  void draw_step(const DrawnElement& e, const Mark* look) {
    box(e, look);
    if (e.initial) {
      canvas_.put(fmt::format("<rect {} x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\"/>",
                              attributes_of("shape", look), e.x + 3, y_of(e.y) + 3, std::max(e.width - 6, 1),
                              std::max(e.height - 6, 1)));
    }
    if (e.kind == ElementKind::kMacroStep) {
      canvas_.put(fmt::format("<path class=\"shape\" d=\"M{0},{1}h{3}M{0},{2}h{3}\"/>", e.x, y_of(e.y) + 4,
                              y_of(e.y) + e.height - 4, e.width));
    }
    canvas_.text(e.x + e.width / 2, y_of(e.y) + e.height / 2 + kMiddle, e.text, Anchor::kMiddle);
    canvas_.value(e.x + e.width + 4, y_of(e.y) - 2, look);
    std::int32_t y = y_of(e.y) + kLine - 2;
    for (std::size_t i = 0; i < e.actions.size(); ++i, y += kLine) {
      const DrawnAction& action = e.actions[i];
      canvas_.text(e.x + e.width + 8, y, action.qualifier + " " + action.text, Anchor::kStart, {},
                   known_.at(bytecode::key_of(known_.pou(), e, i)));
    }
  }

  void draw_transition(const DrawnElement& e, const Mark* look) {
    const std::int32_t y = y_of(e.y) + e.height / 2;
    canvas_.put(fmt::format("<path {} d=\"M{},{}h{}\"/>", attributes_of("bar", look), e.x, y, e.width));
    bytecode::DrawnKey condition = key(e);
    condition.side = bytecode::DrawnSide::kInput;
    const Mark* const of = known_.at(condition);
    std::string text = e.text;
    if (e.priority >= 0) text = fmt::format("{}: {}", e.priority, text);
    std::int32_t line_y = y + kMiddle;
    for (const std::string_view line : lines_of(text)) {
      canvas_.text(e.x + e.width + 6, line_y, line, Anchor::kStart, {}, of);
      line_y += kLine;
    }
  }

  void draw_jump_step(const DrawnElement& e) {
    const std::int32_t x = e.pins.empty() ? e.x + e.width / 2 : e.pins.front().at.x, y = y_of(e.y);
    canvas_.put(fmt::format("<path class=\"shape\" d=\"M{0},{1}v8m-5,-5l5,5l5,-5\"/>", x, y));
    canvas_.text(x, y + 8 + kLine, e.text, Anchor::kMiddle);
  }

  void draw_actions(const DrawnElement& e) {
    canvas_.rect(e.x, y_of(e.y), e.width, e.height, "shape box");
    if (e.actions.empty()) return;
    const auto first_column = [](const DrawnAction& a) {
      return a.time.empty() ? a.qualifier : a.qualifier + " " + a.time;
    };
    std::int32_t first = 0;
    std::size_t lines = 0;
    for (const DrawnAction& a : e.actions) {
      first = std::max(first, width_of(first_column(a)));
      lines += lines_of(a.text).size();
    }
    const std::int32_t column = e.x + first + 10;
    canvas_.put(fmt::format("<path class=\"shape\" d=\"M{},{}v{}\"/>", column, y_of(e.y), e.height));
    const auto fit = [&](std::size_t n) {
      return static_cast<std::int32_t>(n) * e.height / static_cast<std::int32_t>(lines);
    };
    std::size_t line = 0;
    for (std::size_t i = 0; i < e.actions.size(); ++i) {
      const DrawnAction& a = e.actions[i];
      const std::int32_t top = y_of(e.y) + fit(line);
      if (i != 0) canvas_.put(fmt::format("<path class=\"shape\" d=\"M{},{}h{}\"/>", e.x, top, e.width));
      const Mark* const look = known_.at(bytecode::key_of(known_.pou(), e, i));
      const std::int32_t row = fit(1);
      canvas_.text(e.x + 5, top + row / 2 + kMiddle, first_column(a), Anchor::kStart, {}, look);
      for (const std::string_view text : lines_of(a.text)) {
        canvas_.text(column + 5, y_of(e.y) + fit(line) + row / 2 + kMiddle, text, Anchor::kStart, {}, look);
        ++line;
      }
      canvas_.text(e.x + e.width - 5, top + row / 2 + kMiddle, a.indicator, Anchor::kEnd, "quiet");
    }
  }

  // ---- pins ----

  void draw_modifiers(const DrawnPin& pin, const DrawnModifiers& m) {
    const std::int32_t x = pin.at.x, y = y_of(pin.at.y), out = pin.output ? 1 : -1;
    if (m.negated)
      canvas_.put(fmt::format("<circle class=\"shape box\" cx=\"{}\" cy=\"{}\" r=\"3\"/>", x + 3 * out, y));
    if (m.edge == DrawnEdge::kRising)
      canvas_.put(fmt::format("<path class=\"shape\" d=\"M{0},{1}l6,4l-6,4\"/>", x, y - 4));
    if (m.edge == DrawnEdge::kFalling)
      canvas_.put(fmt::format("<path class=\"shape\" d=\"M{0},{1}l-6,4l6,4\"/>", x, y - 4));
    if (m.storage != DrawnStorage::kNone) canvas_.text(x + 8 * out, y - 3, mark_of(m), Anchor::kMiddle);
  }

  /// A variable whose value is that of its wire: it stands there once, and boxes below it have their room.
  [[nodiscard]] bool says_for_pin(const DrawnElement& e) const {
    return e.kind == ElementKind::kInVariable && !e.pins.empty() && e.modifiers == DrawnModifiers{} &&
           known_.at(bytecode::key_of(known_.pou(), e)) != nullptr;
  }

  /// `told`: the other end of its wire shows the same value.
  void draw_pin(const DrawnElement& e, const DrawnPin& pin, bool told) {
    const std::int32_t x = pin.at.x, y = y_of(pin.at.y);
    const Anchor inside = pin.output ? Anchor::kEnd : Anchor::kStart;
    const Anchor outside = pin.output ? Anchor::kStart : Anchor::kEnd;
    const std::int32_t out = pin.output ? 4 : -4;
    draw_modifiers(pin, pin.modifiers);
    if (e.kind == ElementKind::kBlock) {
      const std::int32_t shift = pin.modifiers.edge == DrawnEdge::kNone ? 0 : 6;
      canvas_.text(x - out + (pin.output ? -shift : shift), y + kMiddle, pin.name, inside);
    }
    canvas_.text(x + out + (pin.modifiers.negated ? out : 0), y + kMiddle, pin.text, outside);
    if (pin.pin == kNoPin || told || says_for_pin(e)) return;
    canvas_.value(x + out, y - 3, known_.at(bytecode::key_of(known_.pou(), e, pin)), outside);
  }

  Canvas& canvas_;
  const DrawnBody& body_;
  const Known& known_;
  std::int32_t top_;
  const Told& told_;
};

class DrawingPieces final : public Pieces {
 public:
  DrawingPieces(const DrawnBody& body, const Known& known, std::int32_t top) : body_(body), known_(known), top_(top) {
    for (const DrawnWire& wire : body_.wires) {
      if (is_told(wire)) told_.insert({&body_.elements[wire.to], wire.to_pin});
    }
  }

  [[nodiscard]] std::size_t count() const override { return first() + body_.elements.size(); }
  [[nodiscard]] std::size_t first() const override { return captions() + body_.comments.size() + body_.wires.size(); }
  [[nodiscard]] bool heads(std::size_t piece) const override {
    return piece >= captions() && piece < captions() + body_.comments.size();
  }
  void draw(std::size_t piece, Canvas& canvas) const override {
    Elements elements(canvas, body_, known_, top_, told_);
    if (piece < captions()) return elements.draw_caption(piece + 1);
    piece -= captions();
    if (piece < body_.comments.size()) return elements.draw_comment(body_.comments[piece]);
    piece -= body_.comments.size();
    if (piece < body_.wires.size()) return elements.draw_wire(body_.wires[piece]);
    elements.draw_element(body_.elements[piece - body_.wires.size()]);
  }

 private:
  [[nodiscard]] std::size_t captions() const { return body_.sheets.empty() ? 0 : body_.sheets.size() - 1; }
  /// The value at the input of the wire is the one at its output.
  [[nodiscard]] bool is_told(const DrawnWire& wire) const {
    const DrawnElement& from = body_.elements[wire.from];
    const DrawnElement& to = body_.elements[wire.to];
    const DrawnPin& input = to.pins[wire.to_pin];
    const Mark* const source = known_.at(bytecode::key_of(known_.pou(), from, from.pins[wire.from_pin]));
    const Mark* const reader = known_.at(bytecode::key_of(known_.pou(), to, input));
    if (source == nullptr || reader == nullptr) return false;
    return known_.live() ? input.modifiers == DrawnModifiers{} : source->text == reader->text;
  }

  const DrawnBody& body_;
  const Known known_;
  std::int32_t top_;
  Elements::Told told_;  ///< inputs whose value stands at the output
};

}  // namespace

std::unique_ptr<Pieces> pieces_of_drawing(const DrawnBody& body, const Known& known, std::int32_t top) {
  return std::make_unique<DrawingPieces>(body, known, top);
}

}  // namespace plc::pictures
