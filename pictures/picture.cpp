#include "pictures/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "pictures/canvas.h"
#include "pictures/sheet.h"

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
/// Of a sheet: for a value at the right border.
constexpr std::int32_t kValueRoom = 80;
/// Of a text, and of the lines of one piece, in a sheet.
constexpr std::size_t kMostBytes = 500, kMostLines = 200;
constexpr std::string_view kAnchors[] = {"", " text-anchor=\"middle\"", " text-anchor=\"end\""};

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

std::string attributes_of(std::string_view classes, const Mark* mark) {
  const std::string_view look = mark == nullptr ? std::string_view() : class_of(mark->look);
  if (mark == nullptr || mark->id < 0) return fmt::format("class=\"{}{}\"", classes, look);
  return fmt::format("class=\"{}{}\" data-k=\"{}\"", classes, look, mark->id);
}

void Canvas::begin_group(std::string_view classes, std::string_view title, std::string_view attributes) {
  put(fmt::format("<g class=\"{}\"{}><title>{}</title>", classes, attributes, escaped(title.substr(0, most_bytes_))));
}

std::string Canvas::take(Box& box) {
  box = std::exchange(box_, Box{});
  lines_ = 0;
  return std::exchange(out_, {});
}

void Canvas::text(std::int32_t x, std::int32_t y, std::string_view line, Anchor anchor, std::string_view classes,
                  const Mark* mark) {
  if (line.empty() || lines_++ >= most_lines_) return;
  const bool cut = line.size() > most_bytes_;
  std::string shown = escaped(line.substr(0, most_bytes_));
  if (cut) shown += "…";
  std::string style;
  if (mark != nullptr && mark->id >= 0) {
    style = " " + attributes_of(classes, mark);
  } else if (mark != nullptr && mark->look != Look::kPlain) {
    style = fmt::format(" class=\"{}\"", only(class_of(mark->look)));
  } else if (!classes.empty()) {
    style = fmt::format(" class=\"{}\"", classes);
  }
  put(fmt::format("<text x=\"{}\" y=\"{}\"{}{}>{}</text>", x, y, kAnchors[static_cast<std::size_t>(anchor)], style,
                  shown));
  const std::int32_t width = width_of(line.substr(0, most_bytes_));
  const std::int32_t left = anchor == Anchor::kStart ? x : anchor == Anchor::kMiddle ? x - width / 2 : x - width;
  cover(left, y - bytecode::kDrawnLineHeight, anchor == Anchor::kMiddle ? x + width / 2 : left + width, y + 4);
}

void Canvas::value(std::int32_t x, std::int32_t y, const Mark* mark, Anchor anchor, std::string_view classes) {
  if (mark == nullptr) return;
  if (mark->id < 0) return text(x, y, mark->text, anchor, classes);
  put(fmt::format("<text x=\"{}\" y=\"{}\"{} class=\"value\" data-k=\"{}\"></text>", x, y,
                  kAnchors[static_cast<std::size_t>(anchor)], mark->id));
}

void Canvas::rect(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height, std::string_view classes,
                  const Mark* mark) {
  const std::string style = classes.empty() && mark == nullptr ? std::string() : " " + attributes_of(classes, mark);
  put(fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"{}/>", x, y, width, height, style));
  cover(x, y, x + width, y + height);
}

std::string Canvas::document(std::string_view title) const {
  const std::int32_t width = right_ + kMargin, height = bottom_ + kMargin;
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\">\n"
      "<title>{2}</title>\n{3}<rect class=\"page\" width=\"{0}\" height=\"{1}\"/>\n{4}</svg>\n",
      width, height, escaped(title), kStyle, out_);
}

namespace {

class Caption final : public Pieces {
 public:
  Caption(std::string text, std::int32_t y) : text_(std::move(text)), y_(y) {}
  [[nodiscard]] std::size_t count() const override { return 1; }
  void draw(std::size_t /*piece*/, Canvas& canvas) const override {
    canvas.text(kMargin, y_, text_, Anchor::kStart, "title");
    canvas.put("\n");
  }

 private:
  std::string text_;
  std::int32_t y_;
};

/// Draws the bodies below each other, and calls drawn(piece) after each piece. What they were drawn by.
template <class Drawn>
std::vector<std::unique_ptr<Pieces>> draw_bodies(std::span<const PicturedBody> bodies, const Marks& marks, bool live,
                                                 Canvas& canvas, Drawn&& drawn) {
  std::vector<std::unique_ptr<Pieces>> all;
  const auto draw = [&](std::unique_ptr<Pieces> pieces) {
    for (std::size_t i = 0; i < pieces->count(); ++i) {
      pieces->draw(i, canvas);
      drawn(all.size(), i);
    }
    all.push_back(std::move(pieces));
  };
  for (const PicturedBody& one : bodies) {
    std::int32_t top = canvas.bottom() == 0 ? 0 : canvas.bottom() + 2 * kMargin;
    if (!one.caption.empty()) {
      top += bytecode::kDrawnLineHeight + 4;
      draw(std::make_unique<Caption>(one.caption, top));
    }
    const Known known(marks, one.pou, live, static_cast<std::size_t>(&one - bodies.data()));
    const bool text = one.body->elements.empty() && one.body->comments.empty();
    draw(text ? pieces_of_text(*one.body, known, top) : pieces_of_drawing(*one.body, known, top));
  }
  return all;
}

}  // namespace

std::string svg(std::string_view title, std::span<const PicturedBody> bodies, const Marks& marks) {
  Canvas canvas;
  draw_bodies(bodies, marks, false, canvas, [](std::size_t, std::size_t) {});
  return canvas.document(title);
}

struct Sheet::Contents {
  struct Piece {
    std::uint32_t group = 0, number = 0;
    Box box;
  };
  Marks marks;
  std::vector<std::unique_ptr<Pieces>> groups;
  std::vector<Piece> pieces;
  std::vector<std::size_t> bodies;  ///< their groups
  std::int32_t width = 0, height = 0;
};

Sheet::Sheet(std::span<const PicturedBody> bodies, Marks marks) : contents_(std::make_unique<Contents>()) {
  Contents& c = *contents_;
  c.marks = std::move(marks);
  Canvas canvas;
  canvas.limit(kMostBytes, kMostLines);
  c.groups = draw_bodies(bodies, c.marks, true, canvas, [&](std::size_t group, std::size_t number) {
    Contents::Piece& piece = c.pieces.emplace_back();
    piece.group = static_cast<std::uint32_t>(group);
    piece.number = static_cast<std::uint32_t>(number);
    static_cast<void>(canvas.take(piece.box));
  });
  for (std::size_t group = 0, b = 0; b < bodies.size(); ++b, ++group) {
    if (!bodies[b].caption.empty()) ++group;
    c.bodies.push_back(group);
  }
  c.width = canvas.right() + kMargin + kValueRoom;
  c.height = canvas.bottom() + kMargin;
}

Sheet::~Sheet() = default;

std::int32_t Sheet::width() const { return contents_->width; }
std::int32_t Sheet::height() const { return contents_->height; }

Sheet::Part Sheet::draw(std::int32_t x, std::int32_t y, std::int32_t width, std::int32_t height,
                        std::size_t most) const {
  Part part;
  std::vector<const Contents::Piece*> found;
  for (const Contents::Piece& piece : contents_->pieces) {
    // Signs at pins, and values that a viewer writes, reach a little further.
    const Box& box = piece.box;
    if (box.right >= x - kValueRoom && box.left <= std::int64_t{x} + width + kValueRoom && box.bottom >= y - kMargin &&
        box.top <= std::int64_t{y} + height + kMargin)
      found.push_back(&piece);
  }
  if (found.size() > most) {
    // Long wires that pass go first.
    const auto size = [](const Contents::Piece* p) {
      return std::int64_t{p->box.right} - p->box.left + p->box.bottom - p->box.top;
    };
    std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(most), found.end(),
                     [&](const auto* a, const auto* b) { return size(a) < size(b); });
    part.left_out = found.size() - most;
    found.resize(most);
    std::sort(found.begin(), found.end());
  }
  Canvas canvas;
  canvas.limit(kMostBytes, kMostLines);
  for (const Contents::Piece* const piece : found) {
    contents_->groups[piece->group]->draw(piece->number, canvas);
    Box ignored;
    part.svg += canvas.take(ignored);
  }
  return part;
}

std::optional<Sheet::Place> Sheet::place_of(std::size_t body, std::size_t element) const {
  if (body >= contents_->bodies.size()) return {};
  const std::size_t group = contents_->bodies[body];
  const std::uint64_t number = contents_->groups[group]->first() + std::uint64_t{element};
  const auto found =
      std::lower_bound(contents_->pieces.begin(), contents_->pieces.end(), std::pair(group, number),
                       [](const Contents::Piece& piece, const auto& wanted) {
                         return std::pair<std::size_t, std::uint64_t>(piece.group, piece.number) < wanted;
                       });
  if (found == contents_->pieces.end() || found->group != group || found->number != number) return {};
  const Box& box = found->box;
  if (box.left > box.right) return {};
  return Place{box.left, box.top, box.right - box.left, box.bottom - box.top};
}

std::vector<std::int32_t> Sheet::breaks() const {
  struct Span {
    std::int32_t top = 0, bottom = 0;
    bool heads = false;
  };
  std::vector<Span> spans;
  for (const Contents::Piece& piece : contents_->pieces) {
    if (piece.box.top > piece.box.bottom) continue;
    spans.push_back({piece.box.top, piece.box.bottom, contents_->groups[piece.group]->heads(piece.number)});
  }
  std::sort(spans.begin(), spans.end(), [](const Span& a, const Span& b) { return a.top < b.top; });
  std::vector<std::int32_t> between;
  std::int32_t bottom = 0;
  bool heads = true;
  for (const Span& span : spans) {
    if (span.top > bottom) {
      // Nothing but comments above: they go with the next rung.
      if (bottom != 0 && !heads) between.push_back(bottom + (span.top - bottom) / 2);
      heads = true;
    }
    heads = heads && span.heads;
    bottom = std::max(bottom, span.bottom);
  }
  return between;
}

}  // namespace plc::pictures
