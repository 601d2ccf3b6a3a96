// Columns from left to right, an element in the first column behind all that feed it. Wires that pass a column have a
// place of their own in it, so that no wire crosses an element; between the columns each wire that changes its height
// has a track. What leads back runs below.
#include "drawings/network_layout.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>
#include <set>
#include <utility>

namespace plc::drawings {
namespace {

constexpr std::int32_t kRowGap = 10;  ///< between elements of a column, beyond their pads
constexpr std::int32_t kNone = -1;

/// They stand as close as the pins of blocks do.
bool is_variable(ElementKind kind) {
  return kind == ElementKind::kInVariable || kind == ElementKind::kOutVariable || kind == ElementKind::kInOutVariable ||
         kind == ElementKind::kConnector || kind == ElementKind::kContinuation;
}

/// A place in a column: an element, or a wire that passes.
struct Item {
  std::int32_t element = kNone;
  std::int32_t net = kNone;
  std::int32_t rank = 0;  ///< order in the column
  std::int32_t top = 0;   ///< of the box, or height of the wire
  std::int32_t height = 0;
  std::int32_t pad_top = 2, pad_bottom = 2;
};

/// All wires from one output, or one wire from a rail, which begins anywhere.
struct Net {
  std::uint32_t element = 0, pin = 0;
  bool from_rail = false;
  std::int32_t first = 0, last = 0;             ///< columns: of the source, and of the last reader
  std::vector<std::uint32_t> wires;             ///< forward
  std::map<std::int32_t, std::int32_t> passes;  ///< item by column
  std::map<std::int32_t, std::int32_t> tracks;  ///< x of the vertical piece, by the gap after a column
};

class Network {
 public:
  Network(Sheet& sheet, std::vector<std::uint32_t> elements, std::vector<std::uint32_t> wires)
      : sheet_(sheet), members_(std::move(elements)), wires_(std::move(wires)) {
    for (std::uint32_t i = 0; i < members_.size(); ++i) local_[members_[i]] = static_cast<std::int32_t>(i);
  }

  PlacedNetwork lay_out(std::int32_t left, std::int32_t top) {
    left_ = left;
    find_back_wires();
    find_columns();
    make_nets();
    rank();
    stack(top);
    align();
    place_columns(left);
    draw();
    return {{right_, bottom_}, std::move(open_)};
  }

 private:
  [[nodiscard]] DrawnElement& element(std::uint32_t member) { return sheet_.elements[members_[member]]; }
  [[nodiscard]] std::int32_t member_of(std::uint32_t element) const {
    const auto found = local_.find(element);
    return found == local_.end() ? kNone : found->second;
  }

  // ---- columns ----

  /// Wires that close a loop: the last one on a way that begins where the drawing does.
  void find_back_wires() {
    const std::size_t n = members_.size();
    std::vector<std::vector<std::uint32_t>> out(n);
    for (const std::uint32_t w : wires_) {
      const std::int32_t from = member_of(sheet_.wires[w].from), to = member_of(sheet_.wires[w].to);
      if (from != kNone && to != kNone) out[static_cast<std::size_t>(from)].push_back(w);
    }
    enum : std::uint8_t { kNew, kOpen, kDone };
    std::vector<std::uint8_t> state(n, kNew);
    for (std::uint32_t start = 0; start < n; ++start) {
      if (state[start] != kNew) continue;
      std::vector<std::pair<std::uint32_t, std::size_t>> path = {{start, 0}};
      state[start] = kOpen;
      while (!path.empty()) {
        auto& [at, next] = path.back();
        if (next == out[at].size()) {
          state[at] = kDone;
          path.pop_back();
          continue;
        }
        const std::uint32_t w = out[at][next++];
        const auto to = static_cast<std::uint32_t>(member_of(sheet_.wires[w].to));
        if (state[to] == kOpen) {
          back_.push_back(w);
        } else if (state[to] == kNew) {
          state[to] = kOpen;
          path.emplace_back(to, 0);
        }
      }
    }
    std::sort(back_.begin(), back_.end());
  }
  [[nodiscard]] bool is_back(std::uint32_t wire) const { return std::binary_search(back_.begin(), back_.end(), wire); }

  void find_columns() {
    const std::size_t n = members_.size();
    column_.assign(n, 0);
    std::vector<std::uint32_t> waiting(n, 0);
    std::vector<std::vector<std::uint32_t>> readers(n);
    std::vector<bool> fed(n, false), feeds(n, false);
    for (const std::uint32_t w : wires_) {
      const std::int32_t from = member_of(sheet_.wires[w].from), to = member_of(sheet_.wires[w].to);
      if (to != kNone) fed[static_cast<std::size_t>(to)] = true;
      if (from != kNone) feeds[static_cast<std::size_t>(from)] = true;
      if (from == kNone || to == kNone || is_back(w)) continue;
      readers[static_cast<std::size_t>(from)].push_back(static_cast<std::uint32_t>(to));
      ++waiting[static_cast<std::size_t>(to)];
    }
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < n; ++i) {
      if (waiting[i] == 0) order.push_back(i);
    }
    for (std::size_t k = 0; k < order.size(); ++k) {
      for (const std::uint32_t reader : readers[order[k]]) {
        column_[reader] = std::max(column_[reader], column_[order[k]] + 1);
        if (--waiting[reader] == 0) order.push_back(reader);
      }
    }
    std::int32_t last = 0;
    for (const std::int32_t column : column_) last = std::max(last, column);
    for (std::uint32_t i = 0; i < n; ++i) {
      const ElementKind kind = element(i).kind;
      const bool ends = kind == ElementKind::kCoil || kind == ElementKind::kJump || kind == ElementKind::kReturn;
      const bool leads_on = feeds[i] && !readers[i].empty();
      if (ends && fed[i] && !leads_on) column_[i] = last;  // coils stand below each other
      // What nothing feeds stands right before its first reader.
      if (!fed[i] && !readers[i].empty()) {
        std::int32_t first = std::numeric_limits<std::int32_t>::max();
        for (const std::uint32_t reader : readers[i]) first = std::min(first, column_[reader]);
        column_[i] = first - 1;
      }
    }
    columns_ = static_cast<std::size_t>(last) + 1;
  }

  // ---- nets and places in columns ----

  void make_nets() {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;
    items_.resize(columns_);
    item_of_.resize(members_.size());
    for (std::uint32_t i = 0; i < members_.size(); ++i) {
      Item item;
      item.element = static_cast<std::int32_t>(i);
      item.height = element(i).height;
      const Pads pads = pads_of(element(i));
      const std::int32_t gap = is_variable(element(i).kind) ? 1 : kRowGap / 2;
      item.pad_top = pads.top + gap;
      item.pad_bottom = pads.bottom + gap;
      add_item(column_[i], item);
      item_of_[i] = static_cast<std::uint32_t>(items_[static_cast<std::size_t>(column_[i])].size() - 1);
    }
    for (const std::uint32_t w : wires_) {
      if (is_back(w)) continue;
      const DrawnWire& wire = sheet_.wires[w];
      const std::int32_t from = member_of(wire.from);
      const bool rail = from == kNone;
      std::size_t index = nets_.size();
      if (!rail) index = known.try_emplace({wire.from, wire.from_pin}, index).first->second;
      if (index == nets_.size()) {
        Net net;
        net.element = wire.from;
        net.pin = wire.from_pin;
        net.from_rail = rail;
        net.first = rail ? -1 : column_[static_cast<std::size_t>(from)];
        net.last = net.first;
        nets_.push_back(std::move(net));
      }
      const std::int32_t to = member_of(wire.to);
      const std::int32_t end =
          to == kNone ? static_cast<std::int32_t>(columns_) : column_[static_cast<std::size_t>(to)];
      nets_[index].last = std::max(nets_[index].last, end);
      nets_[index].wires.push_back(w);
      net_of_.emplace(w, index);
    }
    for (std::size_t n = 0; n < nets_.size(); ++n) {
      for (std::int32_t column = nets_[n].first + 1; column < nets_[n].last; ++column) {
        Item item;
        item.net = static_cast<std::int32_t>(n);
        item.pad_top = item.pad_bottom = kRowGap / 2;
        nets_[n].passes[column] = add_item(column, item);
      }
    }
    nets_into_.resize(columns_);
    wires_into_.resize(columns_);
    for (std::size_t n = 0; n < nets_.size(); ++n) {
      const std::int32_t last = std::min(nets_[n].last, static_cast<std::int32_t>(columns_) - 1);
      for (std::int32_t c = nets_[n].first + 1; c <= last; ++c) nets_into_[static_cast<std::size_t>(c)].push_back(n);
      for (const std::uint32_t w : nets_[n].wires) {
        const std::int32_t to = member_of(sheet_.wires[w].to);
        if (to != kNone) wires_into_[static_cast<std::size_t>(column_[static_cast<std::size_t>(to)])].push_back(w);
      }
    }
  }

  std::int32_t add_item(std::int32_t column, const Item& item) {
    auto& items = items_[static_cast<std::size_t>(column)];
    items.push_back(item);
    return static_cast<std::int32_t>(items.size() - 1);
  }

  /// The order in columns: as one comes to the elements from what ends the network, following inputs from top to
  /// bottom. Trees have no crossings then.
  void rank() {
    const std::size_t n = members_.size();
    std::vector<std::vector<std::uint32_t>> in(n);
    std::vector<bool> feeds(n, false);
    for (const std::uint32_t w : wires_) {
      if (is_back(w)) continue;
      const std::int32_t to = member_of(sheet_.wires[w].to), from = member_of(sheet_.wires[w].from);
      if (to != kNone) in[static_cast<std::size_t>(to)].push_back(w);
      if (from != kNone && to != kNone) feeds[static_cast<std::size_t>(from)] = true;
    }
    for (auto& wires : in) {
      std::stable_sort(wires.begin(), wires.end(),
                       [&](auto a, auto b) { return sheet_.wires[a].to_pin < sheet_.wires[b].to_pin; });
    }
    std::int32_t next = 0;
    std::vector<bool> seen(n, false);
    const auto visit = [&](std::uint32_t start) {
      std::vector<std::pair<std::uint32_t, std::size_t>> path = {{start, 0}};
      seen[start] = true;
      while (!path.empty()) {
        auto& [at, i] = path.back();
        if (i == 0) item_at(at).rank = next++;
        if (i == in[at].size()) {
          path.pop_back();
          continue;
        }
        const std::uint32_t w = in[at][i++];
        rank_passes(net_of_.at(w), next);
        const std::int32_t from = member_of(sheet_.wires[w].from);
        if (from == kNone || seen[static_cast<std::size_t>(from)]) continue;
        seen[static_cast<std::size_t>(from)] = true;
        path.emplace_back(static_cast<std::uint32_t>(from), 0);
      }
    };
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!feeds[i]) visit(i);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!seen[i]) visit(i);
    }
    for (std::size_t net = 0; net < nets_.size(); ++net) rank_passes(net, next);
    for (auto& items : items_) {
      order_.emplace_back(items.size());
      std::iota(order_.back().begin(), order_.back().end(), 0u);
      std::stable_sort(order_.back().begin(), order_.back().end(),
                       [&](auto a, auto b) { return items[a].rank < items[b].rank; });
    }
  }
  Item& item_at(std::uint32_t member) { return items_[static_cast<std::size_t>(column_[member])][item_of_[member]]; }
  void rank_passes(std::size_t net, std::int32_t& next) {
    if (ranked_.size() < nets_.size()) ranked_.resize(nets_.size(), false);
    if (ranked_[net]) return;
    ranked_[net] = true;
    for (const auto& [column, item] : nets_[net].passes) {
      items_[static_cast<std::size_t>(column)][static_cast<std::size_t>(item)].rank = next;
    }
    ++next;
  }

  // ---- heights ----

  /// Where a net is behind a column: at its source, or where it passes.
  [[nodiscard]] std::int32_t height_behind(const Net& net, std::int32_t column) {
    if (column == net.first) {
      const auto member = static_cast<std::uint32_t>(member_of(net.element));
      return item_at(member).top + sheet_.elements[net.element].pins[net.pin].at.y;
    }
    return items_[static_cast<std::size_t>(column)][static_cast<std::size_t>(net.passes.at(column))].top;
  }

  /// Wires that arrive in a column, by item: the net, and how far below the top of the item.
  struct Arrival {
    std::size_t net = 0;
    std::int32_t offset = 0;
  };
  [[nodiscard]] std::vector<std::vector<Arrival>> arrivals(std::int32_t column) const {
    std::vector<std::vector<Arrival>> out(items_[static_cast<std::size_t>(column)].size());
    for (const std::size_t n : nets_into_[static_cast<std::size_t>(column)]) {
      if (const auto pass = nets_[n].passes.find(column); pass != nets_[n].passes.end()) {
        out[static_cast<std::size_t>(pass->second)].push_back({n, 0});
      }
    }
    for (const std::uint32_t w : wires_into_[static_cast<std::size_t>(column)]) {
      const DrawnPin& pin = sheet_.elements[sheet_.wires[w].to].pins[sheet_.wires[w].to_pin];
      out[item_of_[static_cast<std::size_t>(member_of(sheet_.wires[w].to))]].push_back({net_of_.at(w), pin.at.y});
    }
    return out;
  }

  /// Each column from top to bottom, an item level with what feeds its highest input where there is room.
  void stack(std::int32_t top) {
    for (std::size_t c = 0; c < columns_; ++c) {
      const auto column = static_cast<std::int32_t>(c);
      const auto all = arrivals(column);
      std::int32_t free = top;
      for (const std::uint32_t i : order_[c]) {
        Item& item = items_[c][i];
        std::int32_t wanted = std::numeric_limits<std::int32_t>::min();
        const Arrival* first = nullptr;
        for (const Arrival& arrival : all[i]) {
          if (nets_[arrival.net].from_rail && column == 0) continue;
          if (first == nullptr || arrival.offset < first->offset) first = &arrival;
        }
        if (first != nullptr) wanted = height_behind(nets_[first->net], column - 1) - first->offset;
        item.top = std::max(free + item.pad_top, wanted);
        free = item.top + item.height + item.pad_bottom;
      }
      bottom_ = std::max(bottom_, free);
    }
  }

  /// From right to left: what stands too high for its reader comes down as far as there is room.
  void align() {
    for (std::size_t c = columns_; c-- > 0;) {
      const auto column = static_cast<std::int32_t>(c);
      std::vector<std::int32_t> wanted(items_[c].size(), std::numeric_limits<std::int32_t>::min());
      if (c + 1 < columns_) {
        const auto all = arrivals(column + 1);
        for (std::size_t i = 0; i < all.size(); ++i) {
          for (const Arrival& arrival : all[i]) {
            const Net& net = nets_[arrival.net];
            const std::int32_t at = items_[c + 1][i].top + arrival.offset;
            const bool source = column == net.first;
            const std::size_t item = source ? item_of_[static_cast<std::size_t>(member_of(net.element))]
                                            : static_cast<std::size_t>(net.passes.at(column));
            const std::int32_t offset = source ? sheet_.elements[net.element].pins[net.pin].at.y : 0;
            // The highest reader decides.
            wanted[item] = wanted[item] == std::numeric_limits<std::int32_t>::min()
                               ? at - offset
                               : std::min(wanted[item], at - offset);
          }
        }
      }
      std::int32_t free = std::numeric_limits<std::int32_t>::max() / 2;
      for (auto i = order_[c].rbegin(); i != order_[c].rend(); ++i) {
        Item& item = items_[c][*i];
        const std::int32_t lowest = free - item.pad_bottom - item.height;
        if (wanted[*i] > item.top) item.top = std::max(item.top, std::min(wanted[*i], lowest));
        free = item.top - item.pad_top;
        bottom_ = std::max(bottom_, item.top + item.height + item.pad_bottom);
      }
    }
  }

  // ---- x, tracks ----

  /// A vertical piece in the gap behind a column.
  struct Piece {
    std::int32_t net = kNone;   ///< or
    std::int32_t back = kNone;  ///< index into back_: down from its source, or up to its reader
    bool up = false;
    std::int32_t left = kNone;         ///< height of what comes from the left; kNone = nothing does
    std::vector<std::int32_t> rights;  ///< heights at which it goes on to the right
    std::int32_t direction = 0;
  };

  void place_columns(std::int32_t left) {
    lanes_ = bottom_;
    std::int32_t x = left;
    x = place_gap(-1, x);
    for (std::size_t c = 0; c < columns_; ++c) {
      std::int32_t pad_left = 0, width = 0;
      for (const Item& item : items_[c]) {
        if (item.element != kNone) {
          pad_left = std::max(pad_left, pads_of(element(static_cast<std::uint32_t>(item.element))).left);
        }
      }
      for (const Item& item : items_[c]) {
        if (item.element == kNone) continue;
        DrawnElement& e = element(static_cast<std::uint32_t>(item.element));
        e.x = x + pad_left;
        e.y = item.top;
        width = std::max(width, pad_left + e.width + pads_of(e).right);
      }
      x += width;
      right_ = std::max(right_, x);
      x = place_gap(static_cast<std::int32_t>(c), x);
    }
    bottom_ = lanes_ + static_cast<std::int32_t>(back_.size()) * kTrack;
  }
  [[nodiscard]] std::int32_t lane_of(std::size_t back) const {
    return lanes_ + static_cast<std::int32_t>(back) * kTrack + kTrack / 2;
  }

  std::vector<Piece> pieces_in(std::int32_t gap) {
    std::vector<Piece> pieces;
    // Behind the last column wires go straight to the right rail.
    const bool behind = gap == static_cast<std::int32_t>(columns_) - 1;
    for (const std::size_t n : behind ? std::vector<std::size_t>() : nets_into_[static_cast<std::size_t>(gap + 1)]) {
      const Net& net = nets_[n];
      if (net.from_rail && gap == -1) continue;
      Piece piece;
      piece.net = static_cast<std::int32_t>(n);
      piece.left = height_behind(net, gap);
      if (const auto pass = net.passes.find(gap + 1); pass != net.passes.end()) {
        piece.rights.push_back(items_[static_cast<std::size_t>(gap + 1)][static_cast<std::size_t>(pass->second)].top);
      }
      for (const std::uint32_t w : net.wires) {
        const std::int32_t to = member_of(sheet_.wires[w].to);
        if (to == kNone || column_[static_cast<std::size_t>(to)] != gap + 1) continue;
        piece.rights.push_back(item_at(static_cast<std::uint32_t>(to)).top +
                               sheet_.elements[sheet_.wires[w].to].pins[sheet_.wires[w].to_pin].at.y);
      }
      const auto& r = piece.rights;
      if (std::all_of(r.begin(), r.end(), [&](std::int32_t y) { return y == piece.left; })) continue;
      piece.direction = *std::max_element(r.begin(), r.end()) > piece.left ? 1 : -1;
      pieces.push_back(std::move(piece));
    }
    for (std::size_t b = 0; b < back_.size(); ++b) {
      const DrawnWire& wire = sheet_.wires[back_[b]];
      const auto from = static_cast<std::uint32_t>(member_of(wire.from)),
                 to = static_cast<std::uint32_t>(member_of(wire.to));
      if (column_[from] == gap) {
        Piece down;
        down.back = static_cast<std::int32_t>(b);
        down.left = item_at(from).top + sheet_.elements[wire.from].pins[wire.from_pin].at.y;
        down.direction = 1;
        pieces.push_back(std::move(down));
      }
      if (column_[to] == gap + 1) {
        Piece up;
        up.back = static_cast<std::int32_t>(b);
        up.up = true;
        up.rights.push_back(item_at(to).top + sheet_.elements[wire.to].pins[wire.to_pin].at.y);
        up.direction = -1;
        pieces.push_back(std::move(up));
      }
    }
    return pieces;
  }

  /// Gives the vertical pieces behind a column their tracks, in an order in which no two wires lie on each other: what
  /// comes in at a height stands left of what goes out at it. Returns where the next column begins.
  std::int32_t place_gap(std::int32_t gap, std::int32_t x) {
    std::vector<Piece> pieces = pieces_in(gap);
    std::stable_sort(pieces.begin(), pieces.end(), [](const Piece& a, const Piece& b) {
      if (a.direction != b.direction) return a.direction > b.direction;
      return a.direction > 0 ? a.left > b.left : a.left < b.left;
    });
    // What comes in at a height, and what has to wait for it.
    std::map<std::int32_t, std::size_t> in;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (pieces[i].left != kNone) in.emplace(pieces[i].left, i);
    }
    std::vector<std::vector<std::size_t>> waits(pieces.size());
    std::vector<std::size_t> open(pieces.size(), 0);
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      for (const std::int32_t y : pieces[i].rights) {
        const auto first = in.find(y);
        if (first == in.end() || first->second == i) continue;
        waits[first->second].push_back(i);
        ++open[i];
      }
    }
    std::set<std::size_t> ready, left;
    for (std::size_t i = 0; i < pieces.size(); ++i) (open[i] == 0 ? ready : left).insert(i);
    while (!ready.empty() || !left.empty()) {
      // In a ring of pieces that wait for each other, the first.
      std::set<std::size_t>& from = ready.empty() ? left : ready;
      const std::size_t next = *from.begin();
      from.erase(from.begin());
      for (const std::size_t i : waits[next]) {
        if (--open[i] == 0 && left.erase(i) == 1) ready.insert(i);
      }
      x += kTrack;
      const Piece& piece = pieces[next];
      if (piece.net != kNone) {
        nets_[static_cast<std::size_t>(piece.net)].tracks[gap] = x;
      } else {
        (piece.up ? back_up_ : back_down_)[static_cast<std::size_t>(piece.back)] = x;
      }
    }
    return x + 2 * kTrack;
  }

  // ---- lines ----

  void draw() {
    for (const std::uint32_t member : std::vector<std::uint32_t>(members_)) place_pins(sheet_.elements[member]);
    for (Net& net : nets_) {
      for (const std::uint32_t w : net.wires) draw_wire(net, w);
    }
    for (std::size_t b = 0; b < back_.size(); ++b) {
      DrawnWire& wire = sheet_.wires[back_[b]];
      const DrawnPoint begin = sheet_.elements[wire.from].pins[wire.from_pin].at;
      const DrawnPoint end = sheet_.elements[wire.to].pins[wire.to_pin].at;
      const std::int32_t down = back_down_.at(b), up = back_up_.at(b), lane = lane_of(b);
      wire.points = straightened({begin, {down, begin.y}, {down, lane}, {up, lane}, {up, end.y}, end});
    }
  }

  void draw_wire(const Net& net, std::uint32_t w) {
    DrawnWire& wire = sheet_.wires[w];
    const std::int32_t to = member_of(wire.to);
    const std::int32_t end = to == kNone ? static_cast<std::int32_t>(columns_) : column_[static_cast<std::size_t>(to)];
    std::vector<DrawnPoint> line;
    std::int32_t y = 0;
    if (net.from_rail) {
      const auto pass = net.passes.find(0);
      y = pass != net.passes.end() ? items_[0][static_cast<std::size_t>(pass->second)].top
                                   : sheet_.elements[wire.to].pins[wire.to_pin].at.y;
      wire.from_pin = pin_at(sheet_, wire.from, wire.from_pin, {left_, y});
    }
    const DrawnPoint begin = sheet_.elements[wire.from].pins[wire.from_pin].at;
    y = begin.y;
    line.push_back(begin);
    for (std::int32_t gap = net.first; gap < end; ++gap) {
      const bool last = gap + 1 == end;
      std::int32_t next = y;
      if (!last) {
        next = items_[static_cast<std::size_t>(gap + 1)][static_cast<std::size_t>(net.passes.at(gap + 1))].top;
      } else if (to != kNone) {
        next = sheet_.elements[wire.to].pins[wire.to_pin].at.y;
      }
      if (next == y) continue;
      const auto track = net.tracks.find(gap);
      const std::int32_t x = track != net.tracks.end() ? track->second : line.back().x;
      line.push_back({x, y});
      line.push_back({x, next});
      y = next;
    }
    if (to == kNone) {
      open_.push_back(w);
      line.push_back({line.back().x, y});
    } else {
      line.push_back(sheet_.elements[wire.to].pins[wire.to_pin].at);
    }
    wire.points = straightened(line);
  }

  Sheet& sheet_;
  std::vector<std::uint32_t> members_;
  std::map<std::uint32_t, std::int32_t> local_;
  std::vector<std::uint32_t> wires_, back_, open_;
  std::vector<std::int32_t> column_;  ///< by member
  std::size_t columns_ = 1;
  std::vector<std::vector<Item>> items_;           ///< by column
  std::vector<std::vector<std::uint32_t>> order_;  ///< by column: items from top to bottom
  std::vector<std::uint32_t> item_of_;             ///< by member
  std::vector<Net> nets_;
  std::vector<std::vector<std::size_t>> nets_into_;     ///< by column: those that come to it, or pass
  std::vector<std::vector<std::uint32_t>> wires_into_;  ///< by column: those that end in it
  std::map<std::uint32_t, std::size_t> net_of_;         ///< by wire
  std::vector<bool> ranked_;
  std::map<std::size_t, std::int32_t> back_down_, back_up_;  ///< tracks
  std::int32_t left_ = 0;
  std::int32_t right_ = 0, bottom_ = 0, lanes_ = 0;
};

}  // namespace

PlacedNetwork lay_out_network(Sheet& sheet, std::vector<std::uint32_t> elements, std::vector<std::uint32_t> wires,
                              std::int32_t left, std::int32_t top) {
  return Network(sheet, std::move(elements), std::move(wires)).lay_out(left, top);
}

}  // namespace plc::drawings
