#include "tools/plc/pou_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>

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
text { fill: #1f2937; font: 11px "DejaVu Sans Mono", Menlo, Consolas, monospace; }
.page { fill: #ffffff; }
.wire { stroke: #9ca3af; fill: none; }
.shape { stroke: #374151; stroke-width: 1.5; fill: none; }
.seen { stroke: #15803d; stroke-width: 2.5; }
.half { stroke: #d97706; stroke-width: 2.5; }
.unseen { stroke: #b91c1c; stroke-width: 2.5; }
text.half { fill: #b45309; stroke: none; }
text.unseen { fill: #b91c1c; stroke: none; }
@media (prefers-color-scheme: dark) {
text { fill: #e5e7eb; }
.page { fill: #14181f; }
.shape { stroke: #9ca3af; }
.seen { stroke: #4ade80; }
.half { stroke: #fbbf24; }
.unseen { stroke: #f87171; }
text.half { fill: #fbbf24; }
text.unseen { fill: #f87171; }
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

  /// Where pin `index` of `count` on a side of the element is: the file's places of pins are not kept.
  [[nodiscard]] Point pin_at(const Element& e, std::size_t index, std::size_t count, bool output) const {
    const Point at = corner(e);
    const int x = output ? at.x + width_of(e) : at.x;
    const bool rail = e.kind == ElementKind::kLeftRail || e.kind == ElementKind::kRightRail;
    if (!is_block(e) && (!rail || count < 2)) return {x, at.y + height_of(e) / 2};
    return {x, at.y + height_of(e) * (static_cast<int>(index) + 1) / (static_cast<int>(count) + 1)};
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
        const Point to = pin_at(e, index++, count, false);
        for (const plcopen::Connection& wire : pin.connections) {
          const auto source = by_id_.find(wire.ref_local_id);
          if (source != by_id_.end()) add_wire(output_at(*source->second, wire.formal_parameter, to), to);
        }
      }
    }
  }

  /// Where a wire to `to` leaves the element: rails are as long as they are drawn.
  [[nodiscard]] Point output_at(const Element& e, const std::string& name, Point to) const {
    if (e.kind == ElementKind::kLeftRail) {
      const Point at = corner(e);
      return {at.x + width_of(e), std::clamp(to.y, at.y, at.y + height_of(e))};
    }
    for (std::size_t i = 0; i < e.outputs.size(); ++i) {
      if (core::iequals(e.outputs[i].name, name)) return pin_at(e, i, e.outputs.size(), true);
    }
    return pin_at(e, 0, std::max<std::size_t>(e.outputs.size(), 1), true);
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
        shapes_ += fmt::format("<path d=\"M{},{}V{}\"/>", at.x + w / 2, at.y, at.y + h);
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
  std::map<std::int64_t, std::uint32_t> sites_;  ///< by localId
  int left_ = INT32_MAX, top_ = INT32_MAX, right_ = INT32_MIN, bottom_ = INT32_MIN;
  std::string wires_, shapes_;
};

}  // namespace

std::string pou_svg(const plcopen::Body& body, const std::string& pou, const tests::CoverageReport& coverage) {
  return Drawing(body, pou, coverage).draw();
}

}  // namespace plc::tools
