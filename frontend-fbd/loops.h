// Loops: which wires of a network carry the value of the previous scan so that the others have an order.
//
// In: a Graph, the nodes of one network that have no place yet. Out: Wire::feedback. Does not belong here: the order.
#pragma once

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "frontend-fbd/graph.h"

namespace plc::fbd {

/// y, x, document order: what decides among elements that are free to run.
using PlaceKey = std::tuple<std::int32_t, std::int32_t, NodeId>;

/// True for an element that keeps a value from scan to scan: a loop without one is an error.
bool can_hold(const plcopen::Element& element);

class Loops {
 public:
  /// What the loops are looked for in, and what is known of its nodes; all of it must outlive this object.
  struct Drawn {
    Graph& graph;
    const std::vector<bool>& placed;     ///< wires from these are no part of a loop
    const std::vector<bool>& waits;      ///< runs with what feeds it, or with what it feeds: never first of a loop
    const std::vector<PlaceKey>& key;    ///< per node
    std::function<void(NodeId)> report;  ///< a loop without anything that holds a value, by its first node
  };
  explicit Loops(Drawn drawn);

  /// Marks feedback wires until the members' wires form no loop: in each loop the wires from an inOutVariable or DELAY
  /// into its first reader, or without one the wires on which the loop reaches its first element, where they leave the
  /// element that feeds them (contacts and connectors between are read in this scan).
  void open(const std::vector<NodeId>& members);

 private:
  void open_one(const std::vector<NodeId>& loop);
  void cut_into(NodeId target);
  std::vector<std::vector<NodeId>> loops_in(const std::vector<NodeId>& set);

  Drawn d_;
  std::vector<std::uint32_t> inside_, index_, low_;
  std::uint32_t stamp_ = 0;
};

}  // namespace plc::fbd
