// Layout of charts by rule: elements in rows downwards, a row below all that lead to it. Everything below an element is
// in a stretch of its own, so branches stand beside each other and a wire goes straight down to what follows. Wires
// that lead back, or past others, run in the gaps between rows and at the right of the chart.
#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "drawings/network_layout.h"

namespace plc::drawings {
namespace {

constexpr std::int32_t kRowGap = 18;
constexpr std::int32_t kBranchGap = 24;
constexpr std::int32_t kBarEnd = 14;  ///< of a bar beyond the outermost branch
constexpr std::int32_t kNone = -1;

class ChartLayout {
 public:
  explicit ChartLayout(Sheet& sheet) : sheet_(sheet) {}

  void lay_out() {
    give_sizes(sheet_, false);
    top_ = place_comments(sheet_, 0, 0);
    find_nodes();
    find_conditions();
    find_tree();
    find_rows();
    std::int32_t left = 0;
    for (const std::uint32_t root : roots_) {
      measure(root);
      place(root, left);
      left += width_[root] + kBranchGap;
    }
    right_ = left;
    span_bars();
    choose_ways();
    place_networks_aside();
    place_rows();
    draw();
    place_networks();
  }

 private:
  struct Way {
    std::uint32_t wire = 0;
    bool margin = false;            ///< along the right side, else straight down
    std::int32_t out_lane = kNone;  ///< in the gap below the source
    std::int32_t in_lane = kNone;   ///< in the gap above the target
    std::int32_t margin_lane = kNone;
  };

  [[nodiscard]] DrawnElement& at(std::uint32_t i) { return sheet_.elements[i]; }
  [[nodiscard]] bool is_node(std::uint32_t i) const {
    const ElementKind kind = sheet_.elements[i].kind;
    return is_chart_element(kind) && kind != ElementKind::kActionBlock;
  }

  // ---- what follows what ----

  void find_nodes() {
    const std::size_t n = sheet_.elements.size();
    out_.resize(n);
    in_.resize(n);
    actions_.assign(n, kNone);
    for (std::uint32_t w = 0; w < sheet_.wires.size(); ++w) {
      const DrawnWire& wire = sheet_.wires[w];
      if (is_node(wire.from) && at(wire.to).kind == ElementKind::kActionBlock) {
        if (actions_[wire.from] == kNone && !taken(wire.to)) {
          actions_[wire.from] = static_cast<std::int32_t>(wire.to);
          taken_.push_back(wire.to);
        }
      } else if (is_node(wire.from) && is_node(wire.to)) {
        out_[wire.from].push_back(w);
      }
    }
  }
  [[nodiscard]] bool taken(std::uint32_t block) const {
    return std::find(taken_.begin(), taken_.end(), block) != taken_.end();
  }

  /// Conditions of CODESYS: a variable that nothing else reads stands beside its transition.
  void find_conditions() {
    beside_.assign(sheet_.elements.size(), kNone);
    std::vector<std::uint32_t> readers(sheet_.elements.size(), 0);
    for (const DrawnWire& wire : sheet_.wires) ++readers[wire.from];
    for (const DrawnWire& wire : sheet_.wires) {
      const bool one = at(wire.from).kind == ElementKind::kInVariable && readers[wire.from] == 1;
      if (!one || at(wire.to).kind != ElementKind::kTransition || beside_[wire.to] != kNone) continue;
      beside_[wire.to] = static_cast<std::int32_t>(wire.from);
    }
  }
  [[nodiscard]] bool is_beside(std::uint32_t from, std::uint32_t to) const {
    return beside_[to] == static_cast<std::int32_t>(from);
  }

  void find_tree() {
    const std::size_t n = sheet_.elements.size();
    parent_.assign(n, kNone);
    children_.resize(n);
    enum : std::uint8_t { kNew, kOpen, kDone };
    std::vector<std::uint8_t> state(n, kNew);
    const auto visit = [&](std::uint32_t root) {
      if (state[root] != kNew) return;
      roots_.push_back(root);
      std::vector<std::pair<std::uint32_t, std::size_t>> path = {{root, 0}};
      state[root] = kOpen;
      while (!path.empty()) {
        auto& [node, next] = path.back();
        if (next == out_[node].size()) {
          state[node] = kDone;
          path.pop_back();
          continue;
        }
        const std::uint32_t w = out_[node][next++];
        const std::uint32_t to = sheet_.wires[w].to;
        if (state[to] == kOpen) continue;  // leads back
        in_[to].push_back(w);
        if (state[to] == kDone) continue;
        state[to] = kOpen;
        parent_[to] = static_cast<std::int32_t>(node);
        children_[node].push_back(to);
        path.emplace_back(to, 0);
      }
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      if (is_node(i) && at(i).initial) visit(i);
    }
    std::vector<bool> led_to(n, false);
    for (const DrawnWire& wire : sheet_.wires) led_to[wire.to] = led_to[wire.to] || is_node(wire.from);
    for (const bool any : {false, true}) {
      for (std::uint32_t i = 0; i < n; ++i) {
        if (is_node(i) && (any || !led_to[i])) visit(i);
      }
    }
    // Action blocks that no step has stand for themselves.
    for (std::uint32_t i = 0; i < n; ++i) {
      if (at(i).kind == ElementKind::kActionBlock && !taken(i)) visit(i);
    }
  }

  /// Longest ways. Wires that lead back are in nobody's `in_`.
  void find_rows() {
    const std::size_t n = sheet_.elements.size();
    row_.assign(n, 0);
    std::vector<std::size_t> waiting(n, 0);
    std::vector<std::vector<std::uint32_t>> next(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      waiting[i] = in_[i].size();
      for (const std::uint32_t w : in_[i]) next[sheet_.wires[w].from].push_back(i);
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (waiting[i] == 0) order.push_back(i);
    }
    for (std::size_t k = 0; k < order.size(); ++k) {
      for (const std::uint32_t to : next[order[k]]) {
        row_[to] = std::max(row_[to], row_[order[k]] + 1);
        if (--waiting[to] == 0) order.push_back(to);
      }
    }
    for (std::uint32_t i = 0; i < n; ++i) rows_ = is_drawn(i) ? std::max(rows_, row_[i] + 1) : rows_;
  }
  [[nodiscard]] bool is_drawn(std::uint32_t i) const {
    return is_node(i) || std::find(roots_.begin(), roots_.end(), i) != roots_.end();
  }

  // ---- x ----

  [[nodiscard]] std::int32_t left_of_axis(std::uint32_t i) {
    const bool conditioned = std::any_of(at(i).pins.begin(), at(i).pins.end(),
                                         [](const DrawnPin& pin) { return !pin.output && pin.pin != kNoPin; });
    const std::int32_t beside = beside_[i] == kNone ? 0 : at(static_cast<std::uint32_t>(beside_[i])).width;
    return pads_of(at(i)).left + (conditioned ? 2 * kTrack : 0) + beside + at(i).width / 2;
  }
  [[nodiscard]] std::int32_t right_of_axis(std::uint32_t i) {
    std::int32_t right = at(i).width - at(i).width / 2 + pads_of(at(i)).right;
    if (actions_[i] != kNone) right += kBranchGap + at(static_cast<std::uint32_t>(actions_[i])).width;
    return right;
  }

  /// Widths of what is below an element, and where its axis is in it; from below upwards.
  void measure(std::uint32_t root) {
    width_.resize(sheet_.elements.size(), 0);
    axis_.resize(sheet_.elements.size(), 0);
    std::vector<std::uint32_t> order = {root};
    for (std::size_t k = 0; k < order.size(); ++k) {
      const auto& below = children_[order[k]];
      order.insert(order.end(), below.begin(), below.end());
    }
    for (auto i = order.rbegin(); i != order.rend(); ++i) {
      std::int32_t axis = left_of_axis(*i), below = 0;
      for (const std::uint32_t child : children_[*i]) below += width_[child] + (below == 0 ? 0 : kBranchGap);
      std::int32_t shift = 0;
      if (!children_[*i].empty()) {
        const std::int32_t first = axis_[children_[*i].front()];
        shift = std::max(0, axis - first);
        axis = std::max(axis, first);
      }
      axis_[*i] = axis;
      width_[*i] = std::max(axis + right_of_axis(*i), shift + below);
    }
  }

  void place(std::uint32_t root, std::int32_t left) {
    std::vector<std::pair<std::uint32_t, std::int32_t>> todo = {{root, left}};
    while (!todo.empty()) {
      const auto [node, begin] = todo.back();
      todo.pop_back();
      at(node).x = begin + axis_[node] - at(node).width / 2;
      if (children_[node].empty()) continue;
      std::int32_t x = begin + std::max(0, axis_[node] - axis_[children_[node].front()]);
      for (const std::uint32_t child : children_[node]) {
        todo.emplace_back(child, x);
        x += width_[child] + kBranchGap;
      }
    }
  }
  [[nodiscard]] std::int32_t axis_of(std::uint32_t i) { return at(i).x + at(i).width / 2; }

  /// Bars reach over all that they join, where nothing else is in their row.
  void span_bars() {
    spans_.assign(sheet_.elements.size(), {});
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      spans_[i] = {axis_of(i), axis_of(i)};
      if (!is_bar(at(i).kind)) continue;
      auto [low, high] = spans_[i];
      for (const std::uint32_t child : children_[i]) high = std::max(high, axis_of(child));
      for (const std::uint32_t w : in_[i]) {
        const std::uint32_t from = sheet_.wires[w].from;
        if (!goes_straight(from, i)) continue;
        low = std::min(low, axis_of(from));
        high = std::max(high, axis_of(from));
      }
      bool free = true;
      for (std::uint32_t other = 0; other < sheet_.elements.size() && free; ++other) {
        if (other == i || !is_drawn(other) || row_[other] != row_[i]) continue;
        const std::int32_t end = axis_of(other) + right_of_axis(other);
        free = axis_of(other) - left_of_axis(other) >= high + kBarEnd || end <= low - kBarEnd;
      }
      if (!free) continue;
      spans_[i] = {low, high};
      at(i).x = low - kBarEnd;
      at(i).width = high - low + 2 * kBarEnd;
    }
  }
  /// Nothing is below `from` but `to`.
  [[nodiscard]] bool goes_straight(std::uint32_t from, std::uint32_t to) const {
    return parent_[to] == static_cast<std::int32_t>(from) || children_[from].empty();
  }

  // ---- ways of the wires ----

  /// x at which a wire leaves an element downwards, and comes to one from above.
  [[nodiscard]] std::int32_t out_x(std::uint32_t from, std::uint32_t to) {
    const std::int32_t x = spans_[to].first == spans_[to].second ? spans_[to].first : axis_x(to);
    if (is_bar(at(from).kind) && x >= spans_[from].first && x <= spans_[from].second &&
        parent_[to] == static_cast<std::int32_t>(from))
      return x;
    return axis_x(from);
  }
  [[nodiscard]] std::int32_t in_x(std::uint32_t from, std::uint32_t to) {
    const std::int32_t x = axis_x(from);
    if (is_bar(at(to).kind) && x >= spans_[to].first && x <= spans_[to].second && goes_straight(from, to)) return x;
    return axis_x(to);
  }
  [[nodiscard]] std::int32_t axis_x(std::uint32_t i) { return is_bar(at(i).kind) ? axes_.at(i) : axis_of(i); }

  std::int32_t lane(std::int32_t gap) { return lanes_[gap]++; }

  void choose_ways() {
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) axes_[i] = bar_axis(i);
    for (std::uint32_t w = 0; w < sheet_.wires.size(); ++w) {
      const DrawnWire& wire = sheet_.wires[w];
      if (!is_node(wire.from) || !is_node(wire.to)) continue;
      Way way;
      way.wire = w;
      const bool forward = std::find(in_[wire.to].begin(), in_[wire.to].end(), w) != in_[wire.to].end();
      way.margin = !forward || !goes_straight(wire.from, wire.to);
      if (way.margin) {
        way.out_lane = lane(row_[wire.from]);
        way.in_lane = lane(row_[wire.to] - 1);
        way.margin_lane = margins_++;
      } else if (out_x(wire.from, wire.to) != in_x(wire.from, wire.to)) {
        way.in_lane =
            lane(parent_[wire.to] == static_cast<std::int32_t>(wire.from) ? row_[wire.from] : row_[wire.to] - 1);
      }
      ways_.push_back(way);
    }
  }
  /// Where the wire in the middle of a bar is: above its first branch, or below the branch it continues.
  [[nodiscard]] std::int32_t bar_axis(std::uint32_t i) {
    if (!is_bar(at(i).kind)) return axis_of(i);
    if (parent_[i] != kNone) {
      const auto parent = static_cast<std::uint32_t>(parent_[i]);
      const std::int32_t x = axis_of(parent);
      if (!is_bar(at(parent).kind) && x >= at(i).x && x <= at(i).x + at(i).width) return x;
    }
    if (!children_[i].empty() && !is_bar(at(children_[i].front()).kind)) return axis_of(children_[i].front());
    return spans_[i].first;
  }

  /// Conditions that are drawn need a lane each.
  void place_networks_aside() {
    for (std::uint32_t w = 0; w < sheet_.wires.size(); ++w) {
      const DrawnWire& wire = sheet_.wires[w];
      if (is_chart_element(at(wire.from).kind) || !is_node(wire.to) || is_beside(wire.from, wire.to)) continue;
      Way way;
      way.wire = w;
      way.margin = true;
      way.in_lane = lane(row_[wire.to] - 1);
      way.margin_lane = margins_++;
      conditions_.push_back(way);
    }
  }

  // ---- y ----

  void place_rows() {
    std::vector<std::int32_t> above(static_cast<std::size_t>(rows_), 0), height(static_cast<std::size_t>(rows_), 0);
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      if (!is_drawn(i)) continue;
      const auto row = static_cast<std::size_t>(row_[i]);
      const Pads pads = pads_of(at(i));
      above[row] = std::max(above[row], pads.top);
      std::int32_t own = at(i).height + pads.bottom;
      if (actions_[i] != kNone) own = std::max(own, at(static_cast<std::uint32_t>(actions_[i])).height);
      height[row] = std::max(height[row], own);
    }
    std::int32_t y = gap_begin(-1, top_);
    for (std::int32_t row = 0; row < rows_; ++row) {
      y += above[static_cast<std::size_t>(row)];
      row_top_.push_back(y);
      y = gap_begin(row, y + height[static_cast<std::size_t>(row)]);
    }
    bottom_ = y;
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      if (!is_drawn(i)) continue;
      at(i).y = row_top_[static_cast<std::size_t>(row_[i])];
      if (beside_[i] != kNone) {
        DrawnElement& condition = at(static_cast<std::uint32_t>(beside_[i]));
        condition.x = at(i).x - 2 * kTrack - condition.width;
        condition.y = at(i).y + at(i).height / 2 - condition.height / 2;
        condition.network = 0;
        place_pins(condition);
      }
      if (actions_[i] == kNone) continue;
      DrawnElement& block = at(static_cast<std::uint32_t>(actions_[i]));
      block.x = at(i).x + at(i).width + pads_of(at(i)).right + kBranchGap;
      block.y = at(i).y;
    }
  }
  /// Notes where the lanes of a gap are; returns where what follows begins.
  std::int32_t gap_begin(std::int32_t gap, std::int32_t y) {
    gap_top_[gap] = y;
    const auto found = lanes_.find(gap);
    const std::int32_t lanes = found == lanes_.end() ? 0 : found->second;
    return y + (gap == -1 && lanes == 0 ? 0 : kRowGap + lanes * kTrack);
  }
  [[nodiscard]] std::int32_t lane_y(std::int32_t gap, std::int32_t lane) const {
    return gap_top_.at(gap) + kTrack * (lane + 1);
  }

  // ---- lines ----

  void draw() {
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      if (is_chart_element(at(i).kind)) place_pins(at(i));
    }
    for (const Way& way : ways_) {
      DrawnWire& wire = sheet_.wires[way.wire];
      const std::uint32_t from = wire.from, to = wire.to;
      const DrawnPoint begin{way.margin ? axis_x(from) : out_x(from, to), at(from).y + at(from).height};
      const DrawnPoint end{way.margin ? axis_x(to) : in_x(from, to), at(to).y};
      wire.from_pin = pin_at(sheet_, from, wire.from_pin, begin);
      wire.to_pin = pin_at(sheet_, to, wire.to_pin, end);
      if (way.margin) {
        const std::int32_t out = lane_y(row_[from], way.out_lane), in = lane_y(row_[to] - 1, way.in_lane);
        const std::int32_t x = margin_x(way.margin_lane);
        wire.points = straightened({begin, {begin.x, out}, {x, out}, {x, in}, {end.x, in}, end});
      } else if (way.in_lane != kNone) {
        const std::int32_t gap = parent_[to] == static_cast<std::int32_t>(from) ? row_[from] : row_[to] - 1;
        const std::int32_t y = lane_y(gap, way.in_lane);
        wire.points = straightened({begin, {begin.x, y}, {end.x, y}, end});
      } else {
        wire.points = straightened({begin, end});
      }
    }
    for (std::size_t w = 0; w < sheet_.wires.size(); ++w) {
      const DrawnWire& wire = sheet_.wires[w];
      if (at(wire.to).kind != ElementKind::kActionBlock || !is_chart_element(at(wire.from).kind)) continue;
      lead_from_side(sheet_, w);
      const DrawnPoint begin = at(wire.from).pins[wire.from_pin].at;
      const DrawnElement& block = at(wire.to);
      // Level with the middle of the step, as far as the block reaches.
      const DrawnPoint end{block.x, std::clamp(begin.y, block.y, block.y + block.height)};
      sheet_.wires[w].to_pin = pin_at(sheet_, wire.to, wire.to_pin, end);
      sheet_.wires[w].points = straightened({begin, end});
    }
    for (DrawnWire& wire : sheet_.wires) {
      if (!is_beside(wire.from, wire.to)) continue;
      wire.points = {at(wire.from).pins[wire.from_pin].at, at(wire.to).pins[wire.to_pin].at};
    }
    drop_unused_pins();
  }
  [[nodiscard]] std::int32_t margin_x(std::int32_t lane) const { return right_ + kTrack * (lane + 1); }

  /// Points of the chart's elements that no wire came to: the wires have places of their own.
  void drop_unused_pins() {
    std::vector<std::vector<bool>> used(sheet_.elements.size());
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) used[i].resize(at(i).pins.size(), !is_node(i));
    for (const DrawnWire& wire : sheet_.wires) {
      used[wire.from][wire.from_pin] = true;
      used[wire.to][wire.to_pin] = true;
    }
    std::vector<std::vector<std::uint32_t>> index(sheet_.elements.size());
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      std::vector<DrawnPin> kept;
      for (std::uint32_t p = 0; p < used[i].size(); ++p) {
        index[i].push_back(static_cast<std::uint32_t>(kept.size()));
        if (used[i][p]) kept.push_back(std::move(at(i).pins[p]));
      }
      at(i).pins = std::move(kept);
    }
    for (DrawnWire& wire : sheet_.wires) {
      wire.from_pin = index[wire.from][wire.from_pin];
      wire.to_pin = index[wire.to][wire.to_pin];
    }
  }

  /// What is drawn in LD and FBD comes below; its wires go up along the right side, and to the left of the transition.
  void place_networks() {
    std::uint32_t count = 0;
    for (const DrawnElement& e : sheet_.elements) count = std::max(count, e.network);
    std::int32_t top = bottom_ + kRowGap;
    std::int32_t right = right_;
    for (std::uint32_t n = 1; n <= count + 1; ++n) {
      top = place_comments(sheet_, n, top);
      std::vector<std::uint32_t> members, wires;
      for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
        if (at(i).network == n) members.push_back(i);
      }
      for (std::uint32_t w = 0; w < sheet_.wires.size(); ++w) {
        if (at(sheet_.wires[w].from).network == n || at(sheet_.wires[w].to).network == n) wires.push_back(w);
      }
      if (members.empty()) continue;
      const PlacedNetwork placed = lay_out_network(sheet_, std::move(members), std::move(wires), 0, top);
      top = placed.corner.y + kRowGap;
      right = std::max(right, placed.corner.x);
    }
    for (const Way& way : conditions_) {
      DrawnWire& wire = sheet_.wires[way.wire];
      const std::int32_t x = std::max(right, margin_x(margins_)) + kTrack * (way.margin_lane + 1);
      const std::int32_t in = lane_y(row_[wire.to] - 1, way.in_lane);
      const DrawnPoint end = at(wire.to).pins[wire.to_pin].at;
      if (wire.points.empty()) wire.points = {at(wire.from).pins[wire.from_pin].at};
      const DrawnPoint last = wire.points.back();
      for (const DrawnPoint point : {DrawnPoint{x, last.y}, DrawnPoint{x, in}, DrawnPoint{end.x - kTrack, in},
                                     DrawnPoint{end.x - kTrack, end.y}, end}) {
        wire.points.push_back(point);
      }
      wire.points = straightened(wire.points);
    }
    // Rails in a chart, for what is drawn in LD.
    for (std::uint32_t i = 0; i < sheet_.elements.size(); ++i) {
      if (!is_rail(at(i).kind)) continue;
      std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = std::numeric_limits<std::int32_t>::min();
      for (const DrawnPin& pin : at(i).pins) low = std::min(low, pin.at.y), high = std::max(high, pin.at.y);
      const bool used = high > bottom_;
      at(i).x = -at(i).width;
      at(i).y = used ? std::max(low, bottom_) - kPinPitch / 2 : top;
      at(i).height = used ? high - at(i).y + kPinPitch / 2 : kPinPitch;
      for (DrawnPin& pin : at(i).pins) pin.at = {0, std::clamp(pin.at.y, at(i).y, at(i).y + at(i).height)};
      top += 2 * kPinPitch;
    }
  }

  Sheet& sheet_;
  std::vector<std::vector<std::uint32_t>> out_, in_;  ///< wires by element; in_: those that do not lead back
  std::vector<std::int32_t> actions_;                 ///< by step: its action block
  std::vector<std::int32_t> beside_;                  ///< by transition: the variable that is its condition
  std::vector<std::uint32_t> taken_;                  ///< action blocks that a step has
  std::vector<std::uint32_t> roots_;
  std::vector<std::int32_t> parent_;
  std::vector<std::vector<std::uint32_t>> children_;
  std::vector<std::int32_t> row_, width_, axis_, row_top_;
  std::vector<std::pair<std::int32_t, std::int32_t>> spans_;  ///< of bars: outermost branches
  std::map<std::uint32_t, std::int32_t> axes_;
  std::vector<Way> ways_, conditions_;
  std::map<std::int32_t, std::int32_t> lanes_, gap_top_;  ///< by gap: the row above it
  std::int32_t rows_ = 0, margins_ = 0, top_ = 0, bottom_ = 0, right_ = 0;
};

}  // namespace

void lay_out_chart(Sheet& sheet) { ChartLayout(sheet).lay_out(); }

}  // namespace plc::drawings
