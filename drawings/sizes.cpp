// Sizes of elements: as the file has them, or as their texts need. Pins relative to their element.
#include <algorithm>
#include <string_view>

#include "drawings/sheet.h"

namespace plc::drawings {
namespace {

constexpr std::int32_t kFlowWidth = 30, kFlowHeight = 20;
constexpr std::int32_t kTextHeight = kPinPitch - 2;  ///< of a variable: level with each pin of a block
constexpr std::int32_t kBlockHead = 18;              ///< of a block above its first pin: its type
constexpr std::int32_t kStepWidth = 60, kStepHeight = 30;
constexpr std::int32_t kMostCodeLines = 24;
constexpr std::int32_t kMostCharacters = 1000;  ///< that a box is made wide for

/// Calls `line` for each line of a text.
template <class Line>
void each_line(std::string_view text, const Line& line) {
  while (true) {
    const std::size_t end = text.find('\n');
    line(text.substr(0, end));
    if (end == std::string_view::npos) return;
    text.remove_prefix(end + 1);
  }
}

DrawnPoint size_of_lines(std::string_view text) {
  DrawnPoint size;
  each_line(text, [&](std::string_view line) {
    size.x = std::max(size.x, width_of(line));
    size.y += kLineHeight;
  });
  return size;
}

DrawnPoint size_of_block(const DrawnElement& e) {
  std::int32_t in = 0, out = 0, rows_in = 0, rows_out = 0;
  for (const DrawnPin& pin : e.pins) {
    std::int32_t& widest = pin.output ? out : in;
    widest = std::max(widest, width_of(pin.name));
    ++(pin.output ? rows_out : rows_in);
  }
  DrawnPoint size{std::max({width_of(e.text) + 12, in + out + 24, std::int32_t{50}}),
                  kBlockHead + kPinPitch * std::max({rows_in, rows_out, std::int32_t{1}}) + 4};
  if (!e.code.empty()) {
    const DrawnPoint code = size_of_lines(e.code);
    size.x = std::max(size.x, code.x + 16);
    size.y += std::min(code.y, kMostCodeLines * kLineHeight) + 4;
  }
  return size;
}

/// Qualifier and time, then the action, then its indicator.
DrawnPoint size_of_actions(const DrawnElement& e) {
  std::int32_t first = 0, second = 0, third = 0, height = 0;
  for (const DrawnAction& action : e.actions) {
    const DrawnPoint text = size_of_lines(action.text);
    first =
        std::max(first, width_of(action.qualifier) + (action.time.empty() ? 0 : width_of(action.time) + kCharWidth));
    second = std::max(second, text.x);
    third = std::max(third, width_of(action.indicator));
    height += std::max(kLineHeight, std::min(text.y, kMostCodeLines * kLineHeight)) + 6;
  }
  return {std::max(std::int32_t{60}, first + second + 24 + (third == 0 ? 0 : third + 12)),
          std::max(height, kFlowHeight)};
}

DrawnPoint size_by_rule(const DrawnElement& e) {
  switch (e.kind) {
    case ElementKind::kBlock:
      return size_of_block(e);
    case ElementKind::kInVariable:
    case ElementKind::kOutVariable:
    case ElementKind::kInOutVariable:
    case ElementKind::kConnector:
    case ElementKind::kContinuation:
      return {std::max(kFlowWidth, width_of(e.text) + 16), kTextHeight};
    case ElementKind::kLabel:
    case ElementKind::kJump:
      return {std::max(kFlowWidth, width_of(e.text) + 16), kFlowHeight};
    case ElementKind::kReturn:
      return {width_of("RETURN") + 12, kFlowHeight};
    case ElementKind::kLeftRail:
    case ElementKind::kRightRail:
      return {4, kFlowHeight};
    case ElementKind::kActionBlock:
      return size_of_actions(e);
    case ElementKind::kStep:
    case ElementKind::kMacroStep:
      return {std::max(kStepWidth, width_of(e.text) + 20),
              std::max(kStepHeight, static_cast<std::int32_t>(e.actions.size()) * kLineHeight + 6)};
    case ElementKind::kJumpStep:
      return {std::max(kFlowWidth, width_of(e.text) + 8), 24};
    case ElementKind::kTransition:
      return {24, 4};
    case ElementKind::kSelectionDivergence:
    case ElementKind::kSelectionConvergence:
      return {24, 2};
    case ElementKind::kSimultaneousDivergence:
    case ElementKind::kSimultaneousConvergence:
      return {24, 6};
    default:
      return {kFlowWidth, kFlowHeight};
  }
}

/// Places of the pins of one side, evenly along the border; blocks have them below their head.
class PinRows {
 public:
  explicit PinRows(const DrawnElement& e) : e_(e) {
    for (const DrawnPin& pin : e.pins) ++(pin.output ? outputs_ : inputs_);
  }
  DrawnPoint next(const DrawnPin& pin) {
    std::int32_t& index = pin.output ? output_ : input_;
    const std::int32_t count = pin.output ? outputs_ : inputs_;
    const std::int32_t at = index++;
    if (is_vertical(e_.kind) && pin.pin == kNoPin) {
      return {e_.width * (at + 1) / (count + 1), pin.output ? e_.height : 0};
    }
    const std::int32_t x = pin.output ? e_.width : 0;
    if (e_.kind != ElementKind::kBlock) return {x, e_.height * (at + 1) / (count + 1)};
    const std::int32_t rule = kBlockHead + kPinPitch * at + kPinPitch / 2;
    const bool fits = kBlockHead + kPinPitch * count <= e_.height;
    return {x, fits ? rule : e_.height * (at + 1) / (count + 1)};
  }

 private:
  static bool is_vertical(ElementKind kind) { return is_chart_element(kind) && kind != ElementKind::kActionBlock; }
  const DrawnElement& e_;
  std::int32_t inputs_ = 0, outputs_ = 0, input_ = 0, output_ = 0;
};

}  // namespace

std::int32_t width_of(std::string_view text) {
  std::int32_t characters = 0;
  for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xc0u) != 0x80u ? 1 : 0;
  return std::min(characters, kMostCharacters) * kCharWidth;
}

void give_sizes(Sheet& sheet, bool keep) {
  for (std::size_t i = 0; i < sheet.elements.size(); ++i) {
    DrawnElement& e = sheet.elements[i];
    const DrawnPoint size = size_by_rule(e);
    if (!keep || e.width <= 0) e.width = size.x;
    if (!keep || e.height <= 0) e.height = size.y;
    PinRows rows(e);
    for (std::size_t p = 0; p < e.pins.size(); ++p) {
      const DrawnPoint by_rule = rows.next(e.pins[p]);
      if (!keep || !sheet.pin_places[i][p]) e.pins[p].at = by_rule;
    }
  }
}

Pads pads_of(const DrawnElement& e) {
  Pads pads;
  for (const DrawnPin& pin : e.pins) {
    std::int32_t& side = pin.output ? pads.right : pads.left;
    if (!pin.text.empty()) side = std::max(side, width_of(pin.text) + 12);
  }
  const auto above = [&](std::string_view text) {
    const std::int32_t wider = std::max(0, (width_of(text) - e.width + 1) / 2) + 4;
    pads.left = std::max(pads.left, wider);
    pads.right = std::max(pads.right, wider);
    pads.top = kLineHeight + 4;
  };
  switch (e.kind) {
    case ElementKind::kContact:
    case ElementKind::kCoil:
      above(e.text);
      break;
    case ElementKind::kBlock:
      if (!e.instance.empty()) above(e.instance);
      break;
    case ElementKind::kTransition: {
      std::int32_t widest = 0;
      each_line(e.text, [&](std::string_view line) { widest = std::max(widest, width_of(line)); });
      pads.right = widest + 8 + (e.priority >= 0 ? 3 * kCharWidth : 0);
      pads.top = pads.bottom = kLineHeight / 2;
      break;
    }
    case ElementKind::kStep:
    case ElementKind::kMacroStep:
      for (const DrawnAction& action : e.actions) {
        pads.right = std::max(pads.right, width_of(action.qualifier) + width_of(action.text) + 2 * kCharWidth + 8);
      }
      break;
    default:
      break;
  }
  return pads;
}

}  // namespace plc::drawings
