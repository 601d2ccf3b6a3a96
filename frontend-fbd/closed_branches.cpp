#include "frontend-fbd/closed_branches.h"

#include <algorithm>
#include <map>
#include <utility>

namespace plc::fbd {
namespace {

using core::ElementKind;

/// Looks back along wires. Nodes seen in one walk are told from those of others by a stamp.
class Walks {
 public:
  explicit Walks(const Graph& graph) : graph_(graph), outside_(graph.nodes.size(), 0), seen_(graph.nodes.size(), 0) {}

  /// A new branch: everything that feeds `input` is outside of it.
  void begin(const std::vector<Wire>& input) {
    ++branch_;
    walk(input, outside_, branch_);
  }

  /// The blocks between the end of a line and the point where it leaves.
  std::vector<NodeId> blocks_in(const std::vector<Wire>& end) {
    ++line_;
    std::vector<NodeId> blocks;
    for (const NodeId node : walk(end, seen_, line_)) {
      if (graph_.element(node).kind == ElementKind::kBlock) blocks.push_back(node);
    }
    return blocks;
  }

 private:
  std::vector<NodeId> walk(const std::vector<Wire>& from, std::vector<std::uint32_t>& marks, std::uint32_t mark) {
    std::vector<NodeId> reached;
    const auto reach = [&](const Wire& wire) {
      const NodeId node = wire.from.node;
      if (marks[node] == mark || outside_[node] == branch_) return;
      marks[node] = mark;
      reached.push_back(node);
    };
    for (const Wire& wire : from) reach(wire);
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const Node& node = graph_.nodes[reached[i]];
      for (std::uint32_t k = node.first_input; k < node.first_input + node.input_count; ++k) {
        const Input& input = graph_.inputs[k];
        for (std::uint32_t w = 0; w < input.wire_count; ++w) reach(graph_.wires[input.first_wire + w]);
      }
    }
    return reached;
  }

  const Graph& graph_;
  std::vector<std::uint32_t> outside_;  ///< per node: the last branch that it is outside of
  std::vector<std::uint32_t> seen_;     ///< per node: the last line that it was found in
  std::uint32_t branch_ = 0;
  std::uint32_t line_ = 0;
};

}  // namespace

void add_bypasses(Graph& graph, const std::vector<BranchWires>& branches) {
  static const plcopen::Pin kBypass = [] {
    plcopen::Pin pin;
    pin.name = "EN";
    pin.negated = true;
    return pin;
  }();
  std::map<NodeId, std::vector<Wire>> bypasses;
  Walks walks(graph);
  for (const BranchWires& branch : branches) {
    walks.begin(branch.input);
    std::vector<NodeId> boxes;
    std::vector<Wire> free_ends;
    for (const std::vector<Wire>& end : branch.lines) {
      const std::vector<NodeId> blocks = walks.blocks_in(end);
      boxes.insert(boxes.end(), blocks.begin(), blocks.end());
      if (blocks.empty()) free_ends.insert(free_ends.end(), end.begin(), end.end());
    }
    std::sort(boxes.begin(), boxes.end());
    boxes.erase(std::unique(boxes.begin(), boxes.end()), boxes.end());
    if (free_ends.empty()) continue;  // all lines hold boxes: a plain OR
    for (const NodeId box : boxes) {
      auto& wires = bypasses[box];
      wires.insert(wires.end(), free_ends.begin(), free_ends.end());
    }
  }
  if (bypasses.empty()) return;
  // Inputs and wires of a node are together, in the order of the nodes: all move.
  std::vector<Input> inputs;
  std::vector<Wire> wires;
  const auto add = [&](const plcopen::Pin* pin, const Wire* first, std::size_t count) {
    inputs.push_back({pin, static_cast<std::uint32_t>(wires.size()), static_cast<std::uint32_t>(count)});
    wires.insert(wires.end(), first, first + count);
  };
  for (NodeId n = 0; n < graph.nodes.size(); ++n) {
    Node& node = graph.nodes[n];
    const auto first = static_cast<std::uint32_t>(inputs.size());
    for (std::uint32_t k = node.first_input; k < node.first_input + node.input_count; ++k) {
      const Input& input = graph.inputs[k];
      add(input.pin, graph.wires.data() + input.first_wire, input.wire_count);
    }
    if (const auto it = bypasses.find(n); it != bypasses.end()) add(&kBypass, it->second.data(), it->second.size());
    node.first_input = first;
    node.input_count = static_cast<std::uint32_t>(inputs.size()) - first;
  }
  graph.inputs = std::move(inputs);
  graph.wires = std::move(wires);
}

}  // namespace plc::fbd
