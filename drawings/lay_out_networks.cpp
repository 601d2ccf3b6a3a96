// Layout of LD and FBD by rule: networks below each other between rails that are as long as their wires need.
#include <algorithm>
#include <limits>
#include <map>
#include <string_view>
#include <utility>

#include "drawings/network_layout.h"

namespace plc::drawings {
namespace {

constexpr std::int32_t kNetworkGap = 26;
constexpr std::int32_t kRailWidth = 4;

}  // namespace

std::int32_t place_comments(Sheet& sheet, std::uint32_t network, std::int32_t top) {
  for (std::size_t i = 0; i < sheet.comments.size(); ++i) {
    if (sheet.comment_networks[i] != network) continue;
    DrawnComment& comment = sheet.comments[i];
    comment.x = kRailWidth + kTrack;
    comment.y = top;
    comment.width = 0;
    comment.height = 0;
    for (std::size_t begin = 0; begin <= comment.text.size();) {
      const std::size_t end = std::min(comment.text.find('\n', begin), comment.text.size());
      comment.width = std::max(comment.width, width_of(std::string_view(comment.text).substr(begin, end - begin)) + 8);
      comment.height += kLineHeight;
      begin = end + 1;
    }
    comment.height += 4;
    top = comment.y + comment.height + 4;
  }
  return top;
}

namespace {

/// Rails as long as their wires need; several left rails of one stretch stand beside each other, away from the drawing.
void place_rails(Sheet& sheet, std::int32_t wall, std::int32_t right, std::int32_t bottom,
                 const std::vector<std::uint32_t>& to_rail) {
  struct Span {
    std::int32_t top = std::numeric_limits<std::int32_t>::max(), bottom = std::numeric_limits<std::int32_t>::min();
  };
  std::map<std::uint32_t, Span> spans;
  const auto reach = [&](std::uint32_t rail, std::int32_t y) {
    spans[rail].top = std::min(spans[rail].top, y);
    spans[rail].bottom = std::max(spans[rail].bottom, y);
  };
  for (const DrawnWire& wire : sheet.wires) {
    if (is_rail(sheet.elements[wire.from].kind)) reach(wire.from, wire.points.front().y);
    if (is_rail(sheet.elements[wire.to].kind)) reach(wire.to, wire.points.back().y);
  }
  std::vector<std::pair<Span, std::uint32_t>> order;
  for (std::uint32_t i = 0; i < sheet.elements.size(); ++i) {
    if (!is_rail(sheet.elements[i].kind)) continue;
    auto span = spans.find(i);
    if (span == spans.end()) {  // nothing is wired to it
      span = spans.emplace(i, Span{kPinPitch, std::max(bottom - 2 * kPinPitch, kPinPitch)}).first;
    }
    order.emplace_back(Span{span->second.top - kPinPitch, span->second.bottom + kPinPitch}, i);
  }
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first.top < b.first.top; });
  std::vector<std::int32_t> left_ends, right_ends;  // of the rails beside each other, the lowest so far
  std::map<std::uint32_t, std::int32_t> shift;
  for (const auto& [span, rail] : order) {
    DrawnElement& e = sheet.elements[rail];
    const bool left = e.kind == ElementKind::kLeftRail;
    std::vector<std::int32_t>& ends = left ? left_ends : right_ends;
    std::size_t lane = 0;
    while (lane < ends.size() && ends[lane] > span.top) ++lane;
    if (lane == ends.size()) ends.push_back(0);
    ends[lane] = span.bottom;
    shift[rail] = static_cast<std::int32_t>(lane) * 2 * kRailWidth;
    e.width = kRailWidth;
    e.height = span.bottom - span.top;
    e.y = span.top;
    e.x = left ? wall - kRailWidth - shift[rail] : right + shift[rail];
    // Pins that no wire uses stand at its end.
    for (DrawnPin& pin : e.pins) pin.at = {left ? e.x + e.width : e.x, std::clamp(pin.at.y, e.y, e.y + e.height)};
  }
  for (DrawnWire& wire : sheet.wires) {
    if (is_rail(sheet.elements[wire.from].kind)) wire.points.front().x = sheet.elements[wire.from].x + kRailWidth;
  }
  for (const std::uint32_t w : to_rail) {
    DrawnWire& wire = sheet.wires[w];
    const DrawnPoint end{sheet.elements[wire.to].x, wire.points.back().y};
    wire.to_pin = pin_at(sheet, wire.to, wire.to_pin, end);
    wire.points.push_back(end);
    wire.points = straightened(wire.points);
  }
}

}  // namespace

void lay_out_networks(Sheet& sheet) {
  give_sizes(sheet, false);
  std::uint32_t count = 0;
  for (const DrawnElement& e : sheet.elements) count = std::max(count, e.network);
  std::vector<std::vector<std::uint32_t>> members(count + 1), wires(count + 1);
  bool left_rail = false;
  for (std::uint32_t i = 0; i < sheet.elements.size(); ++i) {
    const DrawnElement& e = sheet.elements[i];
    left_rail = left_rail || e.kind == ElementKind::kLeftRail;
    if (e.network != 0) members[e.network].push_back(i);
  }
  for (std::uint32_t w = 0; w < sheet.wires.size(); ++w) {
    const DrawnWire& wire = sheet.wires[w];
    wires[std::max(sheet.elements[wire.from].network, sheet.elements[wire.to].network)].push_back(w);
  }
  const std::int32_t wall = left_rail ? kRailWidth : 0;
  std::int32_t top = place_comments(sheet, 0, 0), right = 0;
  std::vector<std::uint32_t> to_rail;
  for (std::uint32_t n = 1; n <= count; ++n) {
    top = place_comments(sheet, n, top);
    if (members[n].empty()) continue;
    const PlacedNetwork placed = lay_out_network(sheet, std::move(members[n]), std::move(wires[n]), wall, top);
    to_rail.insert(to_rail.end(), placed.open.begin(), placed.open.end());
    right = std::max(right, placed.corner.x);
    top = placed.corner.y + kNetworkGap;
  }
  top = place_comments(sheet, count + 1, top);
  for (const std::uint32_t w : wires[0]) {  // from rail to rail
    DrawnWire& wire = sheet.wires[w];
    wire.from_pin = pin_at(sheet, wire.from, wire.from_pin, {wall, top});
    wire.points = {{wall, top}, {wall, top}};
    to_rail.push_back(w);
    top += kPinPitch;
  }
  place_rails(sheet, wall, right + kNetworkGap, top, to_rail);
}

}  // namespace plc::drawings
