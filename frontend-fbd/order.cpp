#include "frontend-fbd/order.h"

#include <algorithm>
#include <numeric>
#include <queue>
#include <tuple>
#include <utility>

#include "core/text.h"

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
        network_of_(graph.nodes.size(), 0) {
    const auto& elements = graph.body->elements;
    positioned_ = std::any_of(elements.begin(), elements.end(), [](const Element& e) { return e.x != 0 || e.y != 0; });
    sequence_.steps.reserve(graph.nodes.size());
  }

  Sequence run(core::Order rule) {
    find_networks();
    place_rails(ElementKind::kLeftRail);
    place_by_execution_order_id();
    if (rule == core::Order::kDocument) {
      for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
        if (!placed_[n] && has_effect(graph_.element(n))) pull(n, Reason::kDocument, Reason::kDocument);
      }
      for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
        if (!placed_[n] && !is_rail(graph_.element(n).kind)) pull(n, Reason::kDocument, Reason::kDocument);
      }
    } else {
      place_networks();
    }
    place_rails(ElementKind::kRightRail);
    return std::move(sequence_);
  }

 private:
  using Key = std::tuple<std::int32_t, std::int32_t, NodeId>;  // y, x, document order

  [[nodiscard]] Key key(NodeId n) const {
    const Element& e = graph_.element(n);
    return positioned_ ? Key{e.y, e.x, n} : Key{0, 0, n};
  }

  template <class Visit>
  void for_each_wire(NodeId n, Visit visit) {
    const Node& node = graph_.nodes[n];
    for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
      const Input& input = graph_.inputs[i];
      for (std::uint32_t w = input.first_wire; w < input.first_wire + input.wire_count; ++w) visit(graph_.wires[w]);
    }
  }

  void place(NodeId n, Reason reason) {
    placed_[n] = true;
    sequence_.steps.push_back({n, network_of_[n], reason});
  }

  void place_rails(ElementKind kind) {
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      if (graph_.element(n).kind == kind) place(n, positioned_ ? Reason::kPosition : Reason::kDocument);
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
      for_each_wire(n, [&](const Wire& wire) {
        if (!is_rail(graph_.element(wire.from.node).kind)) parent_[root(n)] = root(wire.from.node);
      });
    }
    using NetworkKey =
        std::tuple<std::uint32_t, std::int32_t, std::int32_t, NodeId>;  // title group, then the top-most corner
    constexpr NetworkKey kLast{0xffffffffu, INT32_MAX, INT32_MAX, kNoNode};
    std::vector<NetworkKey> keys(count, kLast);
    for (NodeId n = 0; n < count; ++n) {
      const Element& e = graph_.element(n);
      if (is_rail(e.kind)) continue;
      auto& [group, y, x, document] = keys[root(n)];
      const auto [ey, ex, en] = key(n);
      group = std::min(group, e.network);
      y = std::min(y, ey);
      x = std::min(x, ex);
      document = std::min(document, en);
    }
    for (NodeId n = 0; n < count; ++n) {
      if (!is_rail(graph_.element(n).kind) && root(n) == n) networks_.push_back(n);
    }
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

  // ---- pulling: feeders first, depth first; a wire back into the element being pulled is feedback ----

  void pull(NodeId start, Reason own, Reason feeders, bool stop_at_ordered = false) {
    struct Frame {
      NodeId node;
      std::vector<std::uint32_t> wires;
      std::size_t next = 0;
    };
    if (pulling_.empty()) pulling_.resize(graph_.nodes.size(), false);
    std::vector<Frame> stack;
    const auto push = [&](NodeId n) {
      pulling_[n] = true;
      Frame frame{n, {}, 0};
      const Node& node = graph_.nodes[n];
      for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
        const Input& input = graph_.inputs[i];
        for (std::uint32_t w = 0; w < input.wire_count; ++w) frame.wires.push_back(input.first_wire + w);
      }
      stack.push_back(std::move(frame));
    };
    push(start);
    while (!stack.empty()) {
      Frame& frame = stack.back();
      if (frame.next < frame.wires.size()) {
        Wire& wire = graph_.wires[frame.wires[frame.next++]];
        const NodeId from = wire.from.node;
        if (placed_[from]) continue;
        if (pulling_[from]) {
          wire.feedback = true;
          check_loop(from, frame.node, stack);
        } else if (stop_at_ordered && graph_.element(from).execution_order > 0) {
          wire.feedback = true;  // its own id puts it later: the wire carries its value of the previous scan
        } else {
          push(from);
        }
        continue;
      }
      const NodeId n = frame.node;
      pulling_[n] = false;
      place(n, n == start ? own : feeders);
      stack.pop_back();
    }
  }

  template <class Stack>
  void check_loop(NodeId from, NodeId to, const Stack& stack) {
    bool holds = false;
    bool inside = false;
    for (const auto& frame : stack) {
      inside = inside || frame.node == from;
      if (inside) holds = holds || can_hold(frame.node);
    }
    if (!holds) report_loop(std::min(from, to));
  }

  [[nodiscard]] bool can_hold(NodeId n) const {
    const ElementKind kind = graph_.element(n).kind;
    return kind == ElementKind::kBlock || kind == ElementKind::kInOutVariable;
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
  }

  // ---- drawing order: networks, then data flow, ties top to bottom, left to right ----

  void place_networks() {
    std::vector<std::uint32_t> waiting(graph_.nodes.size(), 0);
    std::vector<std::uint32_t> first_reader(graph_.nodes.size() + 1, 0);
    for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
      for_each_wire(n, [&](const Wire& wire) { ++first_reader[wire.from.node + 1]; });
    }
    std::partial_sum(first_reader.begin(), first_reader.end(), first_reader.begin());
    std::vector<NodeId> readers(first_reader.back());
    std::vector<std::uint32_t> fill(first_reader.begin(), first_reader.end() - 1);
    for (std::vector<NodeId>& members : members_) {
      std::erase_if(members, [&](NodeId n) { return placed_[n]; });
      break_loops(members);
      for (NodeId n : members) {
        for_each_wire(n, [&](const Wire& wire) {
          if (wire.feedback || placed_[wire.from.node]) return;
          ++waiting[n];
          readers[fill[wire.from.node]++] = n;
        });
      }
      using Entry = std::pair<Key, NodeId>;
      std::priority_queue<Entry, std::vector<Entry>, std::greater<>> ready;
      for (NodeId n : members) {
        if (waiting[n] == 0) ready.emplace(key(n), n);
      }
      Key highest{INT32_MIN, INT32_MIN, 0};
      while (!ready.empty()) {
        const auto [own, n] = ready.top();
        ready.pop();
        place(n, reason_of(n, own < highest));
        highest = std::max(highest, own);
        for (std::uint32_t r = first_reader[n]; r < fill[n]; ++r) {
          if (--waiting[readers[r]] == 0) ready.emplace(key(readers[r]), readers[r]);
        }
      }
    }
  }

  Reason reason_of(NodeId n, bool delayed) {
    bool feedback = false;
    for_each_wire(n, [&](const Wire& wire) { feedback = feedback || wire.feedback; });
    if (feedback) return Reason::kFeedback;
    if (delayed) return Reason::kDataFlow;
    return positioned_ ? Reason::kPosition : Reason::kDocument;
  }

  /// Marks feedback wires until the members' wires form no loop: in each loop the wires from an inOutVariable or DELAY
  /// into its first reader, or without one the wires into the first element of the loop.
  void break_loops(const std::vector<NodeId>& members) {
    if (inside_.empty()) {
      inside_.resize(graph_.nodes.size(), 0);
      index_.resize(graph_.nodes.size(), 0);
      low_.resize(graph_.nodes.size(), 0);
    }
    std::vector<std::vector<NodeId>> work{members};
    while (!work.empty()) {
      const std::vector<NodeId> set = std::move(work.back());
      work.pop_back();
      for (std::vector<NodeId>& loop : loops_in(set)) {
        break_loop(loop);
        work.push_back(std::move(loop));
      }
    }
  }

  void break_loop(const std::vector<NodeId>& loop) {
    ++stamp_;
    for (NodeId n : loop) inside_[n] = stamp_;
    if (std::none_of(loop.begin(), loop.end(), [&](NodeId n) { return can_hold(n); })) {
      report_loop(*std::min_element(loop.begin(), loop.end()));
      // An error: no order is right, and looking for one loop after the other would take a large net forever.
      for (NodeId n : loop) {
        for_each_wire(n, [&](Wire& wire) { wire.feedback = wire.feedback || inside_[wire.from.node] == stamp_; });
      }
      return;
    }
    const auto from_variable = [&](const Wire& wire) {
      return !wire.feedback && inside_[wire.from.node] == stamp_ &&
             (graph_.element(wire.from.node).kind == ElementKind::kInOutVariable ||
              is_delay(graph_.element(wire.from.node)));
    };
    NodeId first = kNoNode;
    NodeId first_reader = kNoNode;
    for (NodeId n : loop) {
      if (first == kNoNode || key(n) < key(first)) first = n;
      bool reads = false;
      for_each_wire(n, [&](const Wire& wire) { reads = reads || from_variable(wire); });
      if (reads && (first_reader == kNoNode || key(n) < key(first_reader))) first_reader = n;
    }
    const NodeId target = first_reader != kNoNode ? first_reader : first;
    for_each_wire(target, [&](Wire& wire) {
      if (first_reader != kNoNode ? from_variable(wire) : inside_[wire.from.node] == stamp_) wire.feedback = true;
    });
  }

  /// Tarjan's strongly connected components with more than one node (or a wire to itself), without recursion.
  std::vector<std::vector<NodeId>> loops_in(const std::vector<NodeId>& set) {
    std::vector<std::vector<NodeId>> loops;
    ++stamp_;
    const std::uint32_t mine = stamp_;
    for (NodeId n : set) {
      inside_[n] = mine;
      index_[n] = 0;
    }
    struct Frame {
      NodeId node;
      std::vector<NodeId> feeders;
      std::size_t next = 0;
    };
    std::vector<NodeId> open;
    std::vector<Frame> stack;
    std::uint32_t counter = 0;
    const auto enter = [&](NodeId n) {
      index_[n] = low_[n] = ++counter;
      open.push_back(n);
      Frame frame{n, {}, 0};
      for_each_wire(n, [&](const Wire& wire) {
        if (!wire.feedback && inside_[wire.from.node] == mine && !placed_[wire.from.node]) {
          frame.feeders.push_back(wire.from.node);
        }
      });
      stack.push_back(std::move(frame));
    };
    for (NodeId start : set) {
      if (index_[start] != 0) continue;
      enter(start);
      while (!stack.empty()) {
        Frame& frame = stack.back();
        if (frame.next < frame.feeders.size()) {
          const NodeId to = frame.feeders[frame.next++];
          if (index_[to] == 0) {
            enter(to);
          } else if (inside_[to] == mine) {
            low_[frame.node] = std::min(low_[frame.node], index_[to]);
          }
          continue;
        }
        const NodeId n = frame.node;
        const bool self = std::find(frame.feeders.begin(), frame.feeders.end(), n) != frame.feeders.end();
        stack.pop_back();
        if (!stack.empty()) low_[stack.back().node] = std::min(low_[stack.back().node], low_[n]);
        if (low_[n] == index_[n]) {
          std::vector<NodeId> component;
          NodeId member = kNoNode;
          do {
            member = open.back();
            open.pop_back();
            inside_[member] = 0;  // closed: later low links must not reach it
            component.push_back(member);
          } while (member != n);
          if (component.size() > 1 || self) loops.push_back(std::move(component));
        }
      }
    }
    return loops;
  }

  Graph& graph_;
  std::string_view pou_;
  core::Diagnostics& diagnostics_;
  bool positioned_ = false;
  Sequence sequence_;
  std::vector<bool> placed_;
  std::vector<bool> pulling_;
  std::vector<std::uint32_t> network_of_;
  std::vector<NodeId> parent_;
  std::vector<NodeId> networks_;              // root node of each network, in execution order
  std::vector<std::vector<NodeId>> members_;  // nodes of each network
  std::vector<std::uint32_t> inside_, index_, low_;
  std::uint32_t stamp_ = 0;
};

}  // namespace

bool has_effect(const Element& element) {
  switch (element.kind) {
    case ElementKind::kContact:
    case ElementKind::kInVariable:
    case ElementKind::kConnector:
    case ElementKind::kContinuation:
    case ElementKind::kLeftRail:
    case ElementKind::kRightRail:
      return false;
    default:
      return true;
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
  }
  return "";
}

Sequence order(Graph& graph, core::Order rule, std::string_view pou, core::Diagnostics& diagnostics) {
  return Orderer(graph, pou, diagnostics).run(rule);
}

}  // namespace plc::fbd
