#include "pictures/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "pictures/canvas.h"

namespace plc::pictures {
namespace {

/// The looks differ in width and dashes too: for print without colour, and for those who do not see them.
constexpr std::string_view kStyle = R"(<style>
text { fill: #1f2937; font: 11px "DejaVu Sans Mono", Menlo, Consolas, monospace; stroke: #ffffff; stroke-width: 2;
paint-order: stroke; white-space: pre; }
.page { fill: #ffffff; }
.title { font-weight: bold; }
.quiet { fill: #6b7280; }
.value { fill: #1d4ed8; }
.wire { stroke: #4b5563; fill: none; shape-rendering: crispEdges; }
.shape { stroke: #374151; stroke-width: 1.5; fill: none; }
.box { fill: #ffffff; }
.bar { stroke: #374151; stroke-width: 3; fill: none; }
.note { fill: #fef9c3; stroke: #e5d97a; }
.comment text { fill: #57534e; stroke: none; }
.on { stroke: #15803d; stroke-width: 3; }
.off { stroke: #9ca3af; stroke-width: 1; }
.notrun { stroke: #9ca3af; stroke-width: 1; stroke-dasharray: 4 3; }
.box.on { fill: #dcfce7; }
.seen { stroke: #15803d; stroke-width: 2.5; }
.half { stroke: #d97706; stroke-width: 2.5; stroke-dasharray: 6 2; }
.unseen { stroke: #b91c1c; stroke-width: 2.5; stroke-dasharray: 2 2; }
text.on, text.off, text.notrun, text.seen, text.half, text.unseen { stroke: #ffffff; stroke-width: 2; stroke-dasharray: none; }
text.on { fill: #15803d; font-weight: bold; }
text.off, text.notrun { fill: #6b7280; }
text.half { fill: #b45309; }
text.unseen { fill: #b91c1c; }
@media screen and (prefers-color-scheme: dark) {
text { fill: #e5e7eb; stroke: #14181f; }
.page, .box { fill: #14181f; }
.quiet { fill: #9ca3af; }
.value { fill: #93c5fd; }
.wire, .shape, .bar { stroke: #9ca3af; }
.note { fill: #3b3a1e; stroke: #6b6a2e; }
.comment text { fill: #d6d3d1; }
.on { stroke: #4ade80; }
.off, .notrun { stroke: #6b7280; }
.box.on { fill: #14341f; }
.seen { stroke: #4ade80; }
.half { stroke: #fbbf24; }
.unseen { stroke: #f87171; }
text.on, text.off, text.notrun, text.seen, text.half, text.unseen { stroke: #14181f; }
text.on { fill: #4ade80; }
text.half { fill: #fbbf24; }
text.unseen { fill: #f87171; }
}
</style>
)";

constexpr std::int32_t kMargin = 12;

}  // namespace

std::string_view class_of(Look look) {
  constexpr std::string_view kClasses[] = {"", " on", " off", " notrun", " seen", " half", " unseen"};
  return kClasses[static_cast<std::size_t>(look)];
}

std::string_view word_of(Look look) {
  constexpr std::string_view kWords[] = {
      "", "on", "off", "not executed", "seen in every state", "seen in one state only", "never seen"};
  return kWords[static_cast<std::size_t>(look)];
}

std::int32_t width_of(std::string_view text) {
  std::int32_t characters = 0;
  for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xc0u) != 0x80u ? 1 : 0;
  return characters * bytecode::kDrawnCharWidth;
}

void Canvas::begin_group(std::string_view classes, std::string_view title) {
  put(fmt::format("<g class=\"{}\"><title>{}</title>", classes, escaped(title)));
}

void Canvas::reach(std::int32_t x, std::int32_t y) {
  right_ = std::max(right_, x);
  bottom_ = std::max(bottom_, y);
}

void Canvas::text(std::int32_t x, std::int32_t y, std::string_view line, Anchor anchor, std::string_view classes) {
  if (line.empty()) return;
  constexpr std::string_view kAnchors[] = {"", " text-anchor=\"middle\"", " text-anchor=\"end\""};
  const std::string style = classes.empty() ? std::string() : fmt::format(" class=\"{}\"", classes);
  put(fmt::format("<text x=\"{}\" y=\"{}\"{}{}>{}</text>", x, y, kAnchors[static_cast<std::size_t>(anchor)], style,
                  escaped(line)));
  const std::int32_t width = width_of(line);
  reach(anchor == Anchor::kStart ? x + width : anchor == Anchor::kMiddle ? x + width / 2 : x, y + 4);
}

void Canvas::rect(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height, std::string_view classes) {
  const std::string style = classes.empty() ? std::string() : fmt::format(" class=\"{}\"", classes);
  put(fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}/>", x, y, width, height, style));
  reach(x + width, y + height);
}

std::string Canvas::document(std::string_view title) const {
  const std::int32_t width = right_ + kMargin, height = bottom_ + kMargin;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\">\n"
      "<title>{2}</title>\n{3}<rect class=\"page\" width=\"{0}\" height=\"{1}\"/>\n{4}</svg>\n",
      width, height, escaped(title), kStyle, out_);
}

std::string svg(std::string_view title, std::span<const PicturedBody> bodies, const Marks& marks) {
  Canvas canvas;
  for (const PicturedBody& one : bodies) {
    std::int32_t top = canvas.bottom() == 0 ? 0 : canvas.bottom() + 2 * kMargin;
    if (!one.caption.empty()) {
      top += bytecode::kDrawnLineHeight + 4;
      canvas.text(kMargin, top, one.caption, Anchor::kStart, "title");
      canvas.put("\n");
    }
    const Known known(marks, one.pou);
    if (!one.body->elements.empty() || !one.body->comments.empty()) {
      draw_elements(canvas, *one.body, known, top);
    } else {
      draw_text(canvas, *one.body, known, top);
    }
  }
  return canvas.document(title);
}

}  // namespace plc::pictures
