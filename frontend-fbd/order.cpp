#include "frontend-fbd/order.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <span>
#include <tuple>
#include <utility>

#include "core/text.h"
#include "frontend-fbd/loops.h"

namespace plc::fbd {
namespace {

using core::Code;
using core::ElementKind;
using plcopen::Element;

bool is_rail(ElementKind kind) { return kind == ElementKind::kLeftRail || kind == ElementKind::kRightRail; }

class Orderer {
 public:
  Orderer(Graph& graph, std::string_view pou, core::Diagnostics& diagnostics)
      : graph_(graph),
        pou_(pou),
        diagnostics_(diagnostics),
        placed_(graph.nodes.size(), false),
        passes_(graph.nodes.size(), false),
        waits_(graph.nodes.size(), false),
        visited_(graph.nodes.size(), false),
        pulling_(graph.nodes.size(), false),
        pulled_through_(graph.nodes.size(), false),
        blocks_missing_(graph.nodes.size(), 0),
        network_of_(graph.nodes.size(), 0) {
    const auto& elements = graph.body->elements;
    positioned_ = std::any_of(elements.begin(), elements.end(), [](const Element& e) { return e.x != 0 || e.y != 0; });
    sequence_.steps.reserve(graph.nodes.size());
    keys_.reserve(graph.nodes.size());
    for (NodeId n = 0; n < graph.nodes.size(); ++n) {
      const Element& e = graph.element(n);
      const auto wires = graph.wires_into(n);
      keys_.push_back(positioned_ ? PlaceKey{e.y, e.x, n} : PlaceKey{0, 0, n});
      passes_[n] = only_passes_on(graph, n) && e.execution_order == 0;
      waits_[n] = passes_[n] || (is_output(n) && std::all_of(wires.begin(), wires.end(), [&](const Wire& wire) {
                                   return graph.element(wire.from.node).kind == ElementKind::kBlock;
                                 }));
      blocks_missing_[n] = static_cast<std::uint32_t>(wires.size());
    }
    find_readers();
  }

  Sequence run(core::Order rule) {
    find_networks();
    place_rails(ElementKind::kLeftRail);
    place_by_execution_order_id();
    if (rule == core::Order::kDocument) {
      for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
        if (!placed_[n] && !passes_[n] && !is_rail(graph_.element(n).kind)) {
          pull(n, Reason::kDocument, Reason::kDocument);
        }
      }
      for (NodeId n = 0; n < graph_.nodes.size(); ++n) {  // what is never read
        if (placed_[n] || is_rail(graph_.element(n).kind)) continue;
        pull(n, Reason::kDocument, Reason::kDocument);
        place(n, Reason::kDocument);
      }
    } else {
      warn_of_places();
      place_networks();
    }
    place_rails(ElementKind::kRightRail);
    mark_feedback(rule);
    return std::move(sequence_);
  }

 private:
  struct Reader {
    NodeId node;
    std::uint32_t wire;  ///< into Graph::wires
  };
  /// Of a network: title group, then the top-most corner.
  using NetworkKey = std::tuple<std::uint32_t, std::int32_t, std::int32_t, NodeId>;

  /// Variables that a block writes to: their place is that of the block, unless the file gives them one.
  [[nodiscard]] bool is_output(NodeId n) const {
    const Element& e = graph_.element(n);
    return (e.kind == ElementKind::kOutVariable || e.kind == ElementKind::kInOutVariable) && e.execution_order == 0 &&
           !graph_.wires_into(n).empty();
  }

  [[nodiscard]] bool is_passage(NodeId n) const {
    const ElementKind kind = graph_.element(n).kind;
    return kind == ElementKind::kConnector || kind == ElementKind::kContinuation;
  }

  void find_readers() {
    first_reader_.resize(graph_.nodes.size() + 1, 0);
    for (const Wire& wire : graph_.wires) ++first_reader_[wire.from.node + 1];
    std::partial_sum(first_reader_.begin(), first_reader_.end(), first_reader_.begin());
    readers_.resize(graph_.wires.size());
    std::vector<std::uint32_t> fill(first_reader_.begin(), first_reader_.end() - 1);
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      for (const Wire& wire : graph_.wires_into(n)) {
        readers_[fill[wire.from.node]++] = {n, static_cast<std::uint32_t>(&wire - graph_.wires.data())};
      }
    }
  }
  [[nodiscard]] std::span<const Reader> readers_of(NodeId n) const {
    return {readers_.data() + first_reader_[n], first_reader_[n + 1] - first_reader_[n]};
  }

  // ---- placing: what an element reads right before it, what a block writes right after it ----

  /// Places `n` unless it has a place already; before it, what only passes values on to it.
  void place(NodeId n, Reason reason, NodeId with = kNoNode) {
    if (placed_[n]) return;
    struct Frame {
      NodeId node;
      std::size_t next = 0;
    };
    visited_[n] = true;
    std::vector<Frame> stack{{n}};
    while (!stack.empty()) {
      Frame& frame = stack.back();
      const auto wires = graph_.wires_into(frame.node);
      if (frame.next < wires.size()) {
        const NodeId from = wires[frame.next++].from.node;
        if (!passes_[from] || placed_[from] || visited_[from]) continue;
        visited_[from] = true;
        stack.push_back({from});
        continue;
      }
      const NodeId done = frame.node;
      stack.pop_back();
      placed_[done] = true;
      sequence_.steps.push_back(
          {done, network_of_[done], done == n ? reason : Reason::kForReader, done == n ? with : n});
    }
    if (graph_.element(n).kind == ElementKind::kBlock) place_outputs(n);
  }

  /// An element is complete when its outputs are (IEC 61131-3, evaluation of networks): variables wired to outputs of
  /// blocks alone, also through connectors, are written after the last of these blocks.
  void place_outputs(NodeId block) {
    std::vector<NodeId> outputs;
    std::vector<NodeId> passing{block};
    while (!passing.empty()) {
      const NodeId n = passing.back();
      passing.pop_back();
      for (const Reader& reader : readers_of(n)) {
        if (--blocks_missing_[reader.node] != 0) continue;
        if (is_passage(reader.node) && passes_[reader.node]) {
          passing.push_back(reader.node);
        } else if (is_output(reader.node) && !placed_[reader.node]) {
          outputs.push_back(reader.node);
        }
      }
    }
    std::sort(outputs.begin(), outputs.end(), [&](NodeId a, NodeId b) { return keys_[a] < keys_[b]; });
    for (NodeId n : outputs) place(n, Reason::kWithBlock, block);
  }

  void place_rails(ElementKind kind) {
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      if (graph_.element(n).kind == kind) place(n, positioned_ ? Reason::kPosition : Reason::kDocument);
    }
  }

  /// A wire carries the value of the previous scan when what it leads to comes before what it leads from.
  void mark_feedback(core::Order rule) {
    std::vector<std::uint32_t> at(graph_.nodes.size(), 0);
    for (std::uint32_t i = 0; i < sequence_.steps.size(); ++i) at[sequence_.steps[i].node] = i;
    for (Step& step : sequence_.steps) {
      for (Wire& wire : graph_.wires_into(step.node)) {
        wire.feedback = at[wire.from.node] >= at[step.node];
        const bool by_drawing = step.reason == Reason::kPosition || step.reason == Reason::kDataFlow ||
                                (step.reason == Reason::kDocument && rule == core::Order::kDrawing);
        if (wire.feedback && by_drawing) step.reason = Reason::kFeedback;
      }
    }
  }

  // ---- networks: what wires connect; power rails do not connect ----

  NodeId root(NodeId n) {
    while (parent_[n] != n) n = parent_[n] = parent_[parent_[n]];
    return n;
  }

  void find_networks() {
    const auto count = static_cast<NodeId>(graph_.nodes.size());
    parent_.resize(count);
    std::iota(parent_.begin(), parent_.end(), 0u);
    for (NodeId n = 0; n < count; ++n) {
      if (is_rail(graph_.element(n).kind)) continue;
      for (const Wire& wire : graph_.wires_into(n)) {
        if (!is_rail(graph_.element(wire.from.node).kind)) parent_[root(n)] = root(wire.from.node);
      }
    }
    constexpr NetworkKey kLast{0xffffffffu, INT32_MAX, INT32_MAX, kNoNode};
    std::vector<NetworkKey> keys(count, kLast);
    std::vector<std::int64_t> bottoms(count, INT64_MIN);
    for (NodeId n = 0; n < count; ++n) {
      const Element& e = graph_.element(n);
      if (is_rail(e.kind)) continue;
      auto& [group, y, x, document] = keys[root(n)];
      const auto [ey, ex, en] = keys_[n];
      group = std::min(group, e.network);
      y = std::min(y, ey);
      x = std::min(x, ex);
      document = std::min(document, en);
      std::int64_t& bottom = bottoms[root(n)];
      bottom = std::max(bottom, std::int64_t{ey} + std::max(e.height, 0));
    }
    for (NodeId n = 0; n < count; ++n) {
      if (!is_rail(graph_.element(n).kind) && root(n) == n) networks_.push_back(n);
    }
    head_networks(keys, bottoms);
    std::sort(networks_.begin(), networks_.end(), [&](NodeId a, NodeId b) { return keys[a] < keys[b]; });
    std::vector<std::uint32_t> number(count, 0);
    for (std::uint32_t i = 0; i < networks_.size(); ++i) number[networks_[i]] = i + 1;
    members_.resize(networks_.size());
    for (NodeId n = 0; n < count; ++n) {
      if (is_rail(graph_.element(n).kind)) continue;
      network_of_[n] = number[root(n)];
      members_[network_of_[n] - 1].push_back(n);
    }
    sequence_.network_count = static_cast<std::uint32_t>(networks_.size());
  }

  /// A label heads a network, and no wire tells which. Among titles it comes first in its group; drawn to the left of a
  /// network and lower than the top of it, it heads that one, unless the next below is nearer.
  void head_networks(std::vector<NetworkKey>& keys, const std::vector<std::int64_t>& bottoms) {
    std::vector<NodeId> labels;
    std::vector<NodeId> others;
    for (NodeId n : networks_) (graph_.element(n).kind == ElementKind::kLabel ? labels : others).push_back(n);
    if (labels.empty()) return;
    std::sort(others.begin(), others.end(), [&](NodeId a, NodeId b) { return keys[a] < keys[b]; });
    // How far down the first i of them reach: above a label that is lower than that, none is beside it.
    std::vector<std::int64_t> reach(others.size() + 1, INT64_MIN);
    for (std::size_t i = 0; i < others.size(); ++i) reach[i + 1] = std::max(reach[i], bottoms[others[i]]);
    for (NodeId label : labels) {
      const auto [group, y, x, document] = keys[label];
      if (group != 0) keys[label] = {group, INT32_MIN, INT32_MIN, document};
      if (group != 0 || !positioned_) continue;
      const auto next = std::partition_point(others.begin(), others.end(), [&, y = y](NodeId n) {
        return std::get<0>(keys[n]) == 0 && std::get<1>(keys[n]) <= y;
      });
      auto beside = static_cast<std::size_t>(next - others.begin());
      while (reach[beside] >= y && (bottoms[others[beside - 1]] < y || std::get<2>(keys[others[beside - 1]]) < x))
        --beside;
      if (reach[beside] < y) continue;
      const std::int32_t top = std::get<1>(keys[others[beside - 1]]);
      const bool nearer_below = next != others.end() && std::get<0>(keys[*next]) == 0 &&
                                std::int64_t{std::get<1>(keys[*next])} - y < std::int64_t{y} - top;
      if (!nearer_below) keys[label] = {0, top, INT32_MIN, document};
    }
  }

  // ---- pulling: what acts among the feeders first, depth first; a wire back into what is being pulled is a loop ----

  void pull(NodeId start, Reason own, Reason feeders, bool stop_at_ordered = false) {
    struct Frame {
      NodeId node;
      std::size_t next = 0;
    };
    if (pulled_through_[start]) return;
    pulling_[start] = true;
    std::vector<Frame> stack{{start}};
    while (!stack.empty()) {
      Frame& frame = stack.back();
      const auto wires = graph_.wires_into(frame.node);
      if (frame.next < wires.size()) {
        const NodeId from = wires[frame.next++].from.node;
        if (placed_[from] || pulled_through_[from]) continue;
        if (pulling_[from]) {
          check_loop(from, frame.node, stack);
        } else if (!stop_at_ordered || graph_.element(from).execution_order == 0) {
          // An id of its own puts it later: then the wire carries its value of the previous scan.
          pulling_[from] = true;
          stack.push_back({from});
        }
        continue;
      }
      const NodeId n = frame.node;
      stack.pop_back();
      pulling_[n] = false;
      if (passes_[n]) {
        pulled_through_[n] = true;
      } else {
        place(n, n == start ? own : feeders);
      }
    }
  }

  template <class Stack>
  void check_loop(NodeId from, NodeId to, const Stack& stack) {
    bool holds = false;
    bool inside = false;
    for (const auto& frame : stack) {
      inside = inside || frame.node == from;
      if (inside) holds = holds || can_hold(graph_.element(frame.node));
    }
    if (!holds) report_loop(std::min(from, to));
  }

  void report_loop(NodeId n) {
    const Element& e = graph_.element(n);
    diagnostics_.report(Code::P3006, e.at, pou_,
                        "wires form a loop without a block or an inOutVariable" +
                            (e.text.empty() ? std::string() : " through \"" + e.text + "\""),
                        "power flow cannot depend on itself; break the loop with a variable or a block");
  }

  void place_by_execution_order_id() {
    std::vector<NodeId> ordered;
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      if (graph_.element(n).execution_order > 0 && !placed_[n]) ordered.push_back(n);
    }
    std::stable_sort(ordered.begin(), ordered.end(), [&](NodeId a, NodeId b) {
      return graph_.element(a).execution_order < graph_.element(b).execution_order;
    });
    for (NodeId n : ordered) pull(n, Reason::kExecutionOrderId, Reason::kFeedsOrdered, true);
    if (ordered.empty()) return;
    warn_of_late_jumps();
    warn_of_zero();
  }

  /// One 0 among ids is the first of them in tools that count from 0; others write 0 at all elements without an id.
  void warn_of_zero() {
    const Element* zero = nullptr;
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      const Element& e = graph_.element(n);
      if (!e.order_zero) continue;
      if (std::exchange(zero, &e) != nullptr) return;
    }
    if (zero == nullptr) return;
    diagnostics_.report(Code::P3018, zero->at, pou_,
                        std::string(core::element_word(zero->kind)) + (zero->text.empty() ? "" : " ") + zero->text +
                            " has executionOrderId 0, which counts as none: it comes after all elements that have one",
                        "where it is meant to be the first, count from 1");
  }

  /// Jumps without an executionOrderId come after all that has one: they skip nothing of it, wherever they are drawn.
  void warn_of_late_jumps() {
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      const Element& e = graph_.element(n);
      const bool jumps = e.kind == ElementKind::kJump || e.kind == ElementKind::kReturn;
      if (!jumps || e.execution_order > 0) continue;
      diagnostics_.report(Code::P3018, e.at, pou_,
                          std::string(core::element_word(e.kind)) + (e.text.empty() ? "" : " to \"" + e.text + "\"") +
                              " has no executionOrderId: it comes after all elements that have one, and skips none",
                          "give an executionOrderId to the jumps, returns and labels of the body, too");
    }
  }

  /// Where others are drawn somewhere, what has no place counts as drawn at the left upper corner.
  void warn_of_places() {
    const Element* first = nullptr;
    std::size_t count = 0;
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      const Element& e = graph_.element(n);
      if (!positioned_ || e.has_position || is_rail(e.kind) || placed_[n]) continue;
      if (count++ == 0) first = &e;
    }
    if (first == nullptr) return;
    diagnostics_.report(Code::P3018, first->at, pou_,
                        std::string(core::element_word(first->kind)) + (first->text.empty() ? "" : " ") + first->text +
                            (count > 1 ? " and " + std::to_string(count - 1) + " more have" : " has") +
                            " no position, and others have: taken as drawn at the left upper corner",
                        "draw it where it is to be executed, or give it an executionOrderId");
  }

  // ---- drawing order: networks, then data flow, ties top to bottom, left to right ----

  void place_networks() {
    Loops loops({graph_, placed_, waits_, keys_, [this](NodeId n) { report_loop(n); }});
    std::vector<std::uint32_t> waiting(graph_.nodes.size(), 0);
    for (std::vector<NodeId>& members : members_) {
      std::erase_if(members, [&](NodeId n) { return placed_[n]; });
      loops.open(members);
      place_network(members, waiting);
    }
  }

  void place_network(std::vector<NodeId>& members, std::vector<std::uint32_t>& waiting) {
    using Entry = std::pair<PlaceKey, NodeId>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> ready;
    std::vector<NodeId> has_value;  // who reads these has one feeder less to wait for
    const auto is_free = [&](NodeId n) {
      if (passes_[n]) {
        has_value.push_back(n);
      } else if (!placed_[n]) {
        ready.emplace(keys_[n], n);
      }
    };
    for (NodeId n : members) {
      for (const Wire& wire : graph_.wires_into(n)) waiting[n] += !wire.feedback && !placed_[wire.from.node] ? 1 : 0;
    }
    for (NodeId n : members) {
      if (waiting[n] == 0) is_free(n);
    }
    const auto tell_readers = [&] {
      while (!has_value.empty()) {
        const NodeId n = has_value.back();
        has_value.pop_back();
        for (const Reader& reader : readers_of(n)) {
          if (graph_.wires[reader.wire].feedback || placed_[reader.node]) continue;
          if (--waiting[reader.node] == 0) is_free(reader.node);
        }
      }
    };
    tell_readers();
    PlaceKey highest{INT32_MIN, INT32_MIN, 0};
    while (!ready.empty()) {
      const auto [own, n] = ready.top();
      ready.pop();
      if (placed_[n]) continue;  // written with its block meanwhile
      const std::size_t before = sequence_.steps.size();
      place(n, own < highest ? Reason::kDataFlow : positioned_ ? Reason::kPosition : Reason::kDocument);
      highest = std::max(highest, own);
      for (std::size_t i = before; i < sequence_.steps.size(); ++i) {
        if (!passes_[sequence_.steps[i].node]) has_value.push_back(sequence_.steps[i].node);
      }
      tell_readers();
    }
    // What is never read.
    std::erase_if(members, [&](NodeId n) { return placed_[n]; });
    std::sort(members.begin(), members.end(), [&](NodeId a, NodeId b) { return keys_[a] < keys_[b]; });
    for (NodeId n : members) place(n, positioned_ ? Reason::kPosition : Reason::kDocument);
  }

  Graph& graph_;
  std::string_view pou_;
  core::Diagnostics& diagnostics_;
  bool positioned_ = false;
  Sequence sequence_;
  std::vector<PlaceKey> keys_;
  std::vector<bool> placed_;
  std::vector<bool> passes_;          ///< has no place of its own
  std::vector<bool> waits_;           ///< the same, or an output of blocks
  std::vector<bool> visited_;         ///< by place(): power that depends on itself ends there
  std::vector<bool> pulling_;         ///< by pull()
  std::vector<bool> pulled_through_;  ///< all that feeds it has been pulled
  std::vector<std::uint32_t>
      blocks_missing_;                       ///< wires into it whose block has no place yet, or that lead from no block
  std::vector<std::uint32_t> first_reader_;  ///< per node, and one past the end
  std::vector<Reader> readers_;
  std::vector<std::uint32_t> network_of_;
  std::vector<NodeId> parent_;
  std::vector<NodeId> networks_;              // root node of each network, in execution order
  std::vector<std::vector<NodeId>> members_;  // nodes of each network
};

}  // namespace

bool only_passes_on(const Graph& graph, NodeId node) {
  switch (graph.element(node).kind) {
    case ElementKind::kContact:
    case ElementKind::kInVariable:
    case ElementKind::kConnector:
    case ElementKind::kContinuation:
      return true;
    case ElementKind::kInOutVariable: {
      const auto& inputs = graph.element(node).inputs;
      return graph.wires_into(node).empty() &&
             std::all_of(inputs.begin(), inputs.end(), [](const plcopen::Pin& pin) { return pin.expression.empty(); });
    }
    default:
      return false;
  }
}

bool is_delay(const Element& element) {
  return element.kind == ElementKind::kBlock && element.instance_name.empty() && core::iequals(element.text, "DELAY");
}

std::string_view reason_text(Reason reason) {
  switch (reason) {
    case Reason::kExecutionOrderId:
      return "executionOrderId";
    case Reason::kFeedsOrdered:
      return "feeds an element with executionOrderId";
    case Reason::kPosition:
      return "position";
    case Reason::kDataFlow:
      return "data flow: after what feeds it";
    case Reason::kDocument:
      return "document order";
    case Reason::kFeedback:
      return "first of a loop: its feedback wires carry the previous scan";
    case Reason::kForReader:
      return "read for";
    case Reason::kWithBlock:
      return "written with";
  }
  return "";
}

Sequence order(Graph& graph, core::Order rule, std::string_view pou, core::Diagnostics& diagnostics) {
  return Orderer(graph, pou, diagnostics).run(rule);
}

}  // namespace plc::fbd
