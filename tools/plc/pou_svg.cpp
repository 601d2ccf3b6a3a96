#include "tools/plc/pou_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"

namespace plc::tools {
namespace {

using core::ElementKind;
using plcopen::Element;
using plcopen::Pin;

constexpr int kMargin = 30;
constexpr int kFont = 11;
/// Sizes of elements whose file gives none.
constexpr int kSmallWidth = 24, kSmallHeight = 18, kBlockWidth = 80, kPinPitch = 18;

constexpr std::string_view kStyle = R"(<style>
text { fill: #1f2937; font: 11px "DejaVu Sans Mono", Menlo, Consolas, monospace; stroke: #ffffff; stroke-width: 2;
paint-order: stroke; }
.page { fill: #ffffff; }
.wire { stroke: #9ca3af; fill: none; shape-rendering: crispEdges; }
.shape { stroke: #374151; stroke-width: 1.5; fill: none; }
.seen { stroke: #15803d; stroke-width: 2.5; }
.half { stroke: #d97706; stroke-width: 2.5; }
.unseen { stroke: #b91c1c; stroke-width: 2.5; }
text.half { fill: #b45309; stroke: #ffffff; stroke-width: 2; }
text.unseen { fill: #b91c1c; stroke: #ffffff; stroke-width: 2; }
@media (prefers-color-scheme: dark) {
text { fill: #e5e7eb; stroke: #14181f; }
.page { fill: #14181f; }
.shape { stroke: #9ca3af; }
.seen { stroke: #4ade80; }
.half { stroke: #fbbf24; }
.unseen { stroke: #f87171; }
text.half { fill: #fbbf24; stroke: #14181f; }
text.unseen { fill: #f87171; stroke: #14181f; }
}
</style>
)";

std::string xml(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&') out += "&amp;";
    if (c == '<') out += "&lt;";
    if (c == '>') out += "&gt;";
    if (c == '"') out += "&quot;";
    if (c != '&' && c != '<' && c != '>' && c != '"') out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return out;
}

struct Point {
  int x = 0, y = 0;
};

class Drawing {
 public:
  Drawing(const plcopen::Body& body, const std::string& pou, const tests::CoverageReport& coverage)
      : body_(body), pou_(pou), coverage_(coverage) {}

  std::string draw() {
    for (const Element& e : body_.elements) {
      if (!e.has_position) continue;
      by_id_.emplace(e.at.local_id, &e);
      left_ = std::min(left_, e.x);
      top_ = std::min(top_, e.y);
      right_ = std::max(right_, e.x + width_of(e));
      bottom_ = std::max(bottom_, e.y + height_of(e));
    }
    if (by_id_.empty()) return {};
    find_sites();
    find_ends();
    for (const Element& e : body_.elements) {
      if (e.has_position) wires_of(e);
    }
    for (const Element& e : body_.elements) {
      if (e.has_position) element(e);
    }
    const int width = right_ - left_ + 2 * kMargin;
    const int height = bottom_ - top_ + 3 * kMargin;
    std::string out = fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\">\n"
        "<title>Coverage of {2}</title>\n",
        width, height, xml(pou_));
    out += kStyle;
    out += fmt::format("<rect class=\"page\" width=\"{}\" height=\"{}\"/>\n", width, height);
    out += fmt::format("<text x=\"{}\" y=\"18\">{}: green was seen in every state, amber in one, red in none</text>\n",
                       kMargin, xml(pou_));
    return out + wires_ + shapes_ + "</svg>\n";
  }

 private:
  static bool is_block(const Element& e) { return e.kind == ElementKind::kBlock; }
  static int width_of(const Element& e) {
    if (e.width > 0) return e.width;
    return is_block(e) ? kBlockWidth : kSmallWidth;
  }
  static int height_of(const Element& e) {
    if (e.height > 0) return e.height;
    const std::size_t pins = std::max(e.inputs.size() + e.in_outs.size(), e.outputs.size());
    return is_block(e) ? static_cast<int>(pins + 1) * kPinPitch : kSmallHeight;
  }
  [[nodiscard]] Point corner(const Element& e) const { return {e.x - left_ + kMargin, e.y - top_ + 2 * kMargin}; }

  static bool is_rail(const Element& e) {
    return e.kind == ElementKind::kLeftRail || e.kind == ElementKind::kRightRail;
  }

  /// Where the pins of blocks are wired to: an element with one place for its wire.
  void find_ends() {
    for (const Element& e : body_.elements) {
      if (!e.has_position) continue;
      const int middle = corner(e).y + height_of(e) / 2;
      std::size_t index = 0;
      for (const auto* pins : {&e.inputs, &e.in_outs}) {
        for (const Pin& pin : *pins) {
          for (const plcopen::Connection& wire : pin.connections) {
            const auto source = by_id_.find(wire.ref_local_id);
            if (source == by_id_.end()) continue;
            const Element& from = *source->second;
            if (is_block(e) && !is_block(from) && !is_rail(from))
              ends_[{&e, false}].try_emplace(index, corner(from).y + height_of(from) / 2);
            if (is_block(from) && !is_block(e) && !is_rail(e))
              ends_[{&from, true}].try_emplace(output_index(from, wire.formal_parameter), middle);
          }
          ++index;
        }
      }
    }
  }

  static std::size_t output_index(const Element& e, const std::string& name) {
    for (std::size_t i = 0; i < e.outputs.size(); ++i) {
      if (core::iequals(e.outputs[i].name, name)) return i;
    }
    return 0;
  }

  /// Heights of the `count` pins on a side of a block: where their wires go straight, if all find room there, else
  /// evenly. The file's places of pins are not kept.
  [[nodiscard]] std::vector<int> rows_of(const Element& e, std::size_t count, bool output) const {
    const int top = corner(e).y, height = height_of(e);
    std::vector<int> even, straight;
    for (std::size_t i = 0; i < count; ++i)
      even.push_back(top + height * (static_cast<int>(i) + 1) / (static_cast<int>(count) + 1));
    const auto ends = ends_.find({&e, output});
    if (ends == ends_.end()) return even;
    int last = top + kFont;
    for (std::size_t i = 0; i < count; ++i) {
      const auto end = ends->second.find(i);
      const int row = end == ends->second.end() ? even[i] : end->second;
      if (row < last + kFont || row > top + height - kFont / 2) return even;
      straight.push_back(row);
      last = row;
    }
    return straight;
  }

  [[nodiscard]] Point pin_at(const Element& e, std::size_t index, std::size_t count, bool output) const {
    const Point at = corner(e);
    const int x = output ? at.x + width_of(e) : at.x;
    return {x, is_block(e) ? rows_of(e, count, output)[index] : at.y + height_of(e) / 2};
  }

  void find_sites() {
    for (std::uint32_t s = 0; s < coverage_.sites().size(); ++s) {
      const ir::CoverSite& site = coverage_.sites()[s];
      const bool drawn = site.kind == ir::CoverKind::kContact || site.kind == ir::CoverKind::kCoil;
      if (drawn && core::iequals(site.pou, pou_)) sites_.emplace(site.at.local_id, s);
    }
  }

  void wires_of(const Element& e) {
    const std::size_t count = e.inputs.size() + e.in_outs.size();
    std::size_t index = 0;
    for (const auto* pins : {&e.inputs, &e.in_outs}) {
      for (const Pin& pin : *pins) {
        Point to = pin_at(e, index++, count, false);
        for (const plcopen::Connection& wire : pin.connections) {
          const auto source = by_id_.find(wire.ref_local_id);
          if (source == by_id_.end()) continue;
          const Element& from = *source->second;
          Point begin = pin_at(from, output_index(from, wire.formal_parameter),
                               std::max<std::size_t>(from.outputs.size(), 1), true);
          // Wires meet rails wherever they come from.
          if (is_rail(from)) begin.y = reach(from, to.y);
          if (is_rail(e)) to.y = reach(e, begin.y);
          add_wire(begin, to);
        }
      }
    }
  }

  /// The rail is at least as long as to the height `y`, which it returns.
  int reach(const Element& rail, int y) {
    const auto [span, fresh] = rails_.try_emplace(&rail, y, y);
    span->second.first = std::min(span->second.first, y);
    span->second.second = std::max(span->second.second, y);
    return y;
  }

  void add_wire(Point from, Point to) {
    const int bend = to.x > from.x + 8 ? to.x - 6 : from.x + 6;
    wires_ += fmt::format("<polyline class=\"wire\" points=\"{},{} {},{} {},{} {},{}\"/>\n", from.x, from.y, bend,
                          from.y, bend, to.y, to.x, to.y);
  }

  void label(Point at, std::string_view text, const char* type = "") {
    shapes_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\"{}>{}</text>\n", at.x, at.y, type, xml(text));
  }

  void element(const Element& e) {
    const Point at = corner(e);
    const int w = width_of(e), h = height_of(e);
    const auto site = sites_.find(e.at.local_id);
    std::string seen = "shape", missing;
    if (site != sites_.end()) {
      const bool first = coverage_.seen(site->second, 0), second = coverage_.seen(site->second, 1);
      seen = first && second ? "shape seen" : first || second ? "shape half" : "shape unseen";
      const ir::CoverKindInfo& kind = ir::info(coverage_.sites()[site->second].kind);
      if (first != second) missing = "not " + std::string(first ? kind.second : kind.first);
      if (!first && !second) missing = "never";
    }
    shapes_ += fmt::format("<g class=\"{}\">", seen);
    const int middle = at.y + h / 2;
    switch (e.kind) {
      case ElementKind::kContact:
        shapes_ +=
            fmt::format("<path d=\"M{0},{2}V{3}M{1},{2}V{3}\"/>", at.x + w / 3, at.x + w - w / 3, at.y, at.y + h);
        shapes_ += fmt::format("<path d=\"M{},{}H{}M{},{}H{}\"/>", at.x, middle, at.x + w / 3, at.x + w - w / 3, middle,
                               at.x + w);
        if (e.negated)
          shapes_ += fmt::format("<path d=\"M{},{}L{},{}\"/>", at.x + w / 3, at.y + h, at.x + w - w / 3, at.y);
        break;
      case ElementKind::kCoil:
        shapes_ += fmt::format("<path d=\"M{0},{2}Q{3},{4} {0},{5}M{1},{2}Q{6},{4} {1},{5}\"/>", at.x + w / 3,
                               at.x + w - w / 3, at.y, at.x, middle, at.y + h, at.x + w);
        break;
      case ElementKind::kLeftRail:
      case ElementKind::kRightRail:
        shapes_ += rail(e, at, w, h);
        break;
      default:
        shapes_ += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>", at.x, at.y, w, h);
    }
    shapes_ += "</g>\n";
    labels(e, at, w, h);
    if (!missing.empty()) {
      label({at.x + w / 2, at.y + h + kFont}, missing,
            seen == "shape unseen" ? " class=\"unseen\"" : " class=\"half\"");
    }
  }

  /// A line where the wires begin or end.
  [[nodiscard]] std::string rail(const Element& e, Point at, int w, int h) const {
    const auto span = rails_.find(&e);
    const int top = span == rails_.end() ? at.y : std::min(at.y, span->second.first);
    const int bottom = span == rails_.end() ? at.y + h : std::max(at.y + h, span->second.second);
    return fmt::format("<path d=\"M{},{}V{}\"/>", e.kind == ElementKind::kLeftRail ? at.x + w : at.x, top, bottom);
  }

  void labels(const Element& e, Point at, int w, int h) {
    const int center = at.x + w / 2;
    switch (e.kind) {
      case ElementKind::kContact:
      case ElementKind::kCoil: {
        label({center, at.y - 4}, e.text);
        std::string mark;
        if (e.kind == ElementKind::kCoil && e.negated) mark = "/";
        if (e.edge == plcopen::Edge::kRising) mark = "P";
        if (e.edge == plcopen::Edge::kFalling) mark = "N";
        if (e.storage == plcopen::Storage::kSet) mark = "S";
        if (e.storage == plcopen::Storage::kReset) mark = "R";
        if (!mark.empty()) label({center, at.y + h / 2 + kFont / 3}, mark);
        break;
      }
      case ElementKind::kBlock: {
        label({center, at.y + kFont}, e.text);
        label({center, at.y - 4}, e.instance_name);
        std::size_t index = 0;
        const std::size_t count = e.inputs.size() + e.in_outs.size();
        for (const auto* pins : {&e.inputs, &e.in_outs}) {
          for (const Pin& pin : *pins) {
            const Point p = pin_at(e, index++, count, false);
            shapes_ += fmt::format("<text x=\"{}\" y=\"{}\">{}</text>\n", p.x + 3, p.y + kFont / 3, xml(pin.name));
          }
        }
        for (std::size_t i = 0; i < e.outputs.size(); ++i) {
          const Point p = pin_at(e, i, e.outputs.size(), true);
          shapes_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>\n", p.x - 3, p.y + kFont / 3,
                                 xml(e.outputs[i].name));
        }
        break;
      }
      case ElementKind::kLeftRail:
      case ElementKind::kRightRail:
        break;
      default:
        label({center, at.y + h / 2 + kFont / 3}, e.text);
    }
  }

  const plcopen::Body& body_;
  const std::string& pou_;
  const tests::CoverageReport& coverage_;
  std::map<std::int64_t, const Element*> by_id_;
  std::map<std::int64_t, std::uint32_t> sites_;                                 ///< by localId
  std::map<std::pair<const Element*, bool>, std::map<std::size_t, int>> ends_;  ///< by block and side (output), pin
  std::map<const Element*, std::pair<int, int>> rails_;                         ///< highest and lowest wire
  int left_ = INT32_MAX, top_ = INT32_MAX, right_ = INT32_MIN, bottom_ = INT32_MIN;
  std::string wires_, shapes_;
};

}  // namespace

std::string pou_svg(const plcopen::Body& body, const std::string& pou, const tests::CoverageReport& coverage) {
  return Drawing(body, pou, coverage).draw();
}

}  // namespace plc::tools
