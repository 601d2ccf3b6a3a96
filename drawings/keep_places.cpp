// Places as the file has them, where they can be used.
#include <algorithm>
#include <iterator>
#include <map>
#include <utility>

#include "drawings/sheet.h"

namespace plc::drawings {
namespace {

/// Editors that count in cells give elements a height of a few units; in pixels no element is as low as this.
constexpr std::int32_t kLowest = 8;
constexpr std::int32_t kUsualHeight = 18;
/// Beyond any paper: such places are no drawing.
constexpr std::int32_t kFarthest = bytecode::kMaxDrawn / 8;

/// Whether any two elements cover each other: a line sweeps from top to bottom over boxes that stand beside each other.
bool any_overlap(const std::vector<DrawnElement>& elements) {
  struct Event {
    std::int32_t y;
    bool begins;
    const DrawnElement* element;
  };
  std::vector<Event> events;
  events.reserve(2 * elements.size());
  for (const DrawnElement& e : elements) {
    events.push_back({e.y, true, &e});
    events.push_back({e.y + e.height, false, &e});
  }
  // Boxes that touch do not overlap.
  std::sort(events.begin(), events.end(),
            [](const Event& a, const Event& b) { return a.y != b.y ? a.y < b.y : !a.begins && b.begins; });
  std::map<std::int32_t, const DrawnElement*> beside;  // by their left ends
  for (const Event& event : events) {
    const DrawnElement& e = *event.element;
    if (!event.begins) {
      beside.erase(e.x);
      continue;
    }
    const auto right = beside.lower_bound(e.x);
    if (right != beside.end() && right->first < e.x + e.width) return true;
    if (right != beside.begin() && std::prev(right)->first + std::prev(right)->second->width > e.x) return true;
    beside.emplace_hint(right, e.x, &e);
  }
  return false;
}

/// Pixels per unit of the file.
std::int32_t scale_of(const std::vector<DrawnElement>& elements) {
  std::int32_t lowest = kUsualHeight;
  for (const DrawnElement& e : elements) {
    if (is_bar(e.kind) || is_rail(e.kind) || e.kind == ElementKind::kTransition || e.height <= 0) continue;
    lowest = std::min(lowest, e.height);
  }
  return lowest >= kLowest ? 1 : kUsualHeight / lowest;
}

template <class Each>
void each_number(Sheet& sheet, const Each& each) {
  for (DrawnElement& e : sheet.elements) {
    each(e.x, e.y);
    each(e.width, e.height);
    for (DrawnPin& pin : e.pins) each(pin.at.x, pin.at.y);
  }
  for (auto& line : sheet.drawn_lines) {
    for (DrawnPoint& point : line) each(point.x, point.y);
  }
  for (DrawnComment& comment : sheet.comments) {
    each(comment.x, comment.y);
    each(comment.width, comment.height);
  }
}

/// Of a pin that is drawn beside its element, or in it: the place on the border that is level with it.
void move_to_border(const DrawnElement& e, DrawnPoint& at) {
  at.x = std::clamp(at.x, std::int32_t{0}, e.width);
  at.y = std::clamp(at.y, std::int32_t{0}, e.height);
  if (at.x == 0 || at.x == e.width || at.y == 0 || at.y == e.height) return;
  at.x = 2 * at.x <= e.width ? 0 : e.width;
}

bool on_border(const DrawnElement& e, DrawnPoint at) {
  const bool inside = at.x >= e.x && at.x <= e.x + e.width && at.y >= e.y && at.y <= e.y + e.height;
  return inside && (at.x == e.x || at.x == e.x + e.width || at.y == e.y || at.y == e.y + e.height);
}

bool aligned(DrawnPoint a, DrawnPoint b) { return (a.x == b.x) != (a.y == b.y); }

/// The line of the file between the pins, or one in three pieces where it does not lead from one to the other.
void take_line(Sheet& sheet, std::size_t index) {
  std::vector<DrawnPoint>& line = sheet.drawn_lines[index];
  DrawnWire& wire = sheet.wires[index];
  if (line.size() >= 2) {
    // Rails, steps and bars have one output, which wires leave in several places.
    const DrawnElement& from = sheet.elements[wire.from];
    const DrawnElement& to = sheet.elements[wire.to];
    if (from.kind != ElementKind::kBlock && on_border(from, line.front())) {
      wire.from_pin = pin_at(sheet, wire.from, wire.from_pin, line.front());
    }
    if (is_rail(to.kind) && on_border(to, line.back())) wire.to_pin = pin_at(sheet, wire.to, wire.to_pin, line.back());
    const DrawnPoint begin = sheet.elements[wire.from].pins[wire.from_pin].at;
    const DrawnPoint end = sheet.elements[wire.to].pins[wire.to_pin].at;
    // Some editors draw pins as stubs, and wires from their ends.
    if (aligned(line.front(), begin)) line.insert(line.begin(), begin);
    if (aligned(line.back(), end)) line.push_back(end);
    if (line.front() == begin && line.back() == end) {
      wire.points = straightened(line);
      return;
    }
  }
  // A rail is met wherever the wire comes from.
  const DrawnElement& from = sheet.elements[wire.from];
  const DrawnElement& to = sheet.elements[wire.to];
  const auto meet = [&](const DrawnElement& rail, std::int32_t y) {
    return std::clamp(y, rail.y, rail.y + rail.height);
  };
  if (is_rail(from.kind) && !is_rail(to.kind)) {
    wire.from_pin =
        pin_at(sheet, wire.from, wire.from_pin, {from.x + from.width, meet(from, to.pins[wire.to_pin].at.y)});
  } else if (is_rail(to.kind) && !is_rail(from.kind)) {
    wire.to_pin = pin_at(sheet, wire.to, wire.to_pin, {to.x, meet(to, from.pins[wire.from_pin].at.y)});
  } else if (to.kind == ElementKind::kActionBlock && is_chart_element(from.kind)) {
    lead_from_side(sheet, index);
  }
  wire.points = plain_line(sheet, wire);
}

/// Places without sizes are those of a file that nobody has drawn, or whose editor has sizes of its own.
bool has_sizes(const std::vector<DrawnElement>& elements) {
  return std::all_of(elements.begin(), elements.end(), [](const DrawnElement& e) {
    return (e.width > 0 && e.height > 0) || is_bar(e.kind) || is_rail(e.kind);
  });
}

}  // namespace

std::uint32_t pin_at(Sheet& sheet, std::uint32_t element, std::uint32_t pin, DrawnPoint at) {
  DrawnElement& e = sheet.elements[element];
  // Wires of one place follow each other; a rail has as many as a drawing has rungs.
  constexpr std::size_t kLookedAt = 16;
  const std::size_t first = e.pins.size() > kLookedAt ? e.pins.size() - kLookedAt : 0;
  for (auto i = static_cast<std::uint32_t>(first); i < e.pins.size(); ++i) {
    if (e.pins[i].at == at && e.pins[i].output == e.pins[pin].output && e.pins[i].pin == e.pins[pin].pin) return i;
  }
  DrawnPin more = e.pins[pin];
  more.at = at;
  e.pins.push_back(std::move(more));
  sheet.pin_places[element].push_back(false);
  return static_cast<std::uint32_t>(e.pins.size() - 1);
}

void lead_from_side(Sheet& sheet, std::size_t index) {
  DrawnWire& wire = sheet.wires[index];
  const DrawnElement& from = sheet.elements[wire.from];
  wire.from_pin = pin_at(sheet, wire.from, wire.from_pin, {from.x + from.width, from.y + from.height / 2});
}

void place_pins(DrawnElement& e) {
  for (DrawnPin& pin : e.pins) {
    pin.at.x += e.x;
    pin.at.y += e.y;
  }
}

std::vector<DrawnPoint> straightened(const std::vector<DrawnPoint>& line) {
  std::vector<DrawnPoint> out;
  for (const DrawnPoint& point : line) {
    if (!out.empty() && out.back() == point) continue;
    if (out.size() >= 2) {
      const DrawnPoint a = out[out.size() - 2], b = out.back();
      const bool on_x = a.x == b.x && b.x == point.x && (b.y - a.y > 0) == (point.y - b.y > 0);
      const bool on_y = a.y == b.y && b.y == point.y && (b.x - a.x > 0) == (point.x - b.x > 0);
      if (on_x || on_y) out.pop_back();
    }
    out.push_back(point);
  }
  if (out.size() == 1) out.push_back(out.front());  // a wire between pins that touch
  return out;
}

std::vector<DrawnPoint> plain_line(const Sheet& sheet, const DrawnWire& wire) {
  const DrawnPoint begin = sheet.elements[wire.from].pins[wire.from_pin].at;
  const DrawnPoint end = sheet.elements[wire.to].pins[wire.to_pin].at;
  constexpr std::int32_t kStub = 6;
  const DrawnElement& from = sheet.elements[wire.from];
  if (is_chart_element(from.kind) && begin.x != from.x + from.width) {
    const std::int32_t bend = end.y > begin.y + 2 * kStub ? end.y - kStub : begin.y + kStub;
    return straightened({begin, {begin.x, bend}, {end.x, bend}, end});
  }
  const std::int32_t bend = end.x > begin.x + 2 * kStub ? end.x - kStub : begin.x + kStub;
  return straightened({begin, {bend, begin.y}, {bend, end.y}, end});
}

bool keep_places(Sheet& sheet) {
  if (!sheet.placed || sheet.elements.empty() || !has_sizes(sheet.elements)) return false;
  const std::int32_t scale = scale_of(sheet.elements);
  bool near = true;
  each_number(sheet, [&](std::int32_t& x, std::int32_t& y) {
    const std::int32_t far = kFarthest / scale;
    near = near && x > -far && x < far && y > -far && y < far;
    if (near) x *= scale, y *= scale;
  });
  if (near) give_sizes(sheet, true);
  if (!near || any_overlap(sheet.elements)) return false;
  for (DrawnElement& e : sheet.elements) {
    for (DrawnPin& pin : e.pins) move_to_border(e, pin.at);
    place_pins(e);
  }
  for (std::size_t w = 0; w < sheet.wires.size(); ++w) take_line(sheet, w);
  for (DrawnComment& comment : sheet.comments) {
    if (comment.width == 0) comment.width = std::max(width_of(comment.text), std::int32_t{40});
    if (comment.height == 0) comment.height = kLineHeight;
  }
  return true;
}

}  // namespace plc::drawings
