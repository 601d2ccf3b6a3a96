#include "frontend-fbd/loops.h"

#include <algorithm>
#include <utility>

#include "frontend-fbd/order.h"

namespace plc::fbd {

using core::ElementKind;

bool can_hold(const plcopen::Element& element) {
  return element.kind == ElementKind::kBlock || element.kind == ElementKind::kInOutVariable;
}

Loops::Loops(Drawn drawn)
    : d_(std::move(drawn)),
      inside_(d_.graph.nodes.size(), 0),
      index_(d_.graph.nodes.size(), 0),
      low_(d_.graph.nodes.size(), 0) {}

void Loops::open(const std::vector<NodeId>& members) {
  std::vector<std::vector<NodeId>> work{members};
  while (!work.empty()) {
    const std::vector<NodeId> set = std::move(work.back());
    work.pop_back();
    for (std::vector<NodeId>& loop : loops_in(set)) {
      open_one(loop);
      work.push_back(std::move(loop));
    }
  }
}

void Loops::open_one(const std::vector<NodeId>& loop) {
  Graph& graph = d_.graph;
  ++stamp_;
  for (NodeId n : loop) inside_[n] = stamp_;
  if (std::none_of(loop.begin(), loop.end(), [&](NodeId n) { return can_hold(graph.element(n)); })) {
    d_.report(*std::min_element(loop.begin(), loop.end()));
    // An error: no order is right, and looking for one loop after the other would take a large net forever.
    for (NodeId n : loop) {
      for (Wire& wire : graph.wires_into(n)) wire.feedback = wire.feedback || inside_[wire.from.node] == stamp_;
    }
    return;
  }
  const auto from_variable = [&](const Wire& wire) {
    const plcopen::Element& source = graph.element(wire.from.node);
    return !wire.feedback && inside_[wire.from.node] == stamp_ &&
           (source.kind == ElementKind::kInOutVariable || is_delay(source));
  };
  NodeId first = kNoNode;
  NodeId first_reader = kNoNode;
  for (NodeId n : loop) {
    if (!d_.waits[n] && (first == kNoNode || d_.key[n] < d_.key[first])) first = n;
    const auto wires = graph.wires_into(n);
    if (std::any_of(wires.begin(), wires.end(), from_variable) &&
        (first_reader == kNoNode || d_.key[n] < d_.key[first_reader])) {
      first_reader = n;
    }
  }
  if (first_reader == kNoNode) return cut_into(first);
  for (Wire& wire : graph.wires_into(first_reader)) {
    if (from_variable(wire)) wire.feedback = true;
  }
}

/// The wires of the loop that end at `target`, or at the contacts and connectors through which it reaches `target`.
void Loops::cut_into(NodeId target) {
  std::vector<NodeId> open{target};
  inside_[target] = stamp_ - 1;  // visited; no wire of the loop comes from here but one to itself
  while (!open.empty()) {
    const NodeId n = open.back();
    open.pop_back();
    for (Wire& wire : d_.graph.wires_into(n)) {
      const NodeId from = wire.from.node;
      if (from == target) {
        wire.feedback = true;
      } else if (inside_[from] == stamp_) {
        if (!only_passes_on(d_.graph, from)) {
          wire.feedback = true;
        } else {
          inside_[from] = stamp_ - 1;
          open.push_back(from);
        }
      }
    }
  }
}

/// Tarjan's strongly connected components with more than one node (or a wire to itself), without recursion.
std::vector<std::vector<NodeId>> Loops::loops_in(const std::vector<NodeId>& set) {
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
    for (const Wire& wire : d_.graph.wires_into(n)) {
      if (!wire.feedback && inside_[wire.from.node] == mine && !d_.placed[wire.from.node]) {
        frame.feeders.push_back(wire.from.node);
      }
    }
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

}  // namespace plc::fbd
