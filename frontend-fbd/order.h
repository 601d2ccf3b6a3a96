// Execution order of a drawn body (docs/guides/execution-order.md). Explicit, printable, switchable.
//
// In: a Graph. Out: the sequence of nodes, the wires that are feedback (marked in the Graph), and why each node is
// where it is. Does not belong here: values, types.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "core/options.h"
#include "frontend-fbd/graph.h"

namespace plc::fbd {

/// Why an element executes where it does.
enum class Reason : std::uint8_t {
  kExecutionOrderId,  ///< executionOrderId, ascending
  kFeedsOrdered,      ///< pulled before an element with an executionOrderId that it feeds
  kPosition,          ///< top to bottom, left to right, among what data flow allows
  kDataFlow,          ///< drawn higher than its predecessor, but fed by it (or by something after it)
  kDocument,          ///< document order: no positions, or --order=document
  kFeedback,          ///< first of a loop: its wires from the loop carry the values of the previous scan
  kForReader,         ///< reads only: evaluated for Step::with, the first that asks for its value
  kWithBlock,         ///< an output: written right after Step::with, the block (the last one) that feeds it
};
std::string_view reason_text(Reason reason);

struct Step {
  NodeId node = kNoNode;
  std::uint32_t network = 0;  ///< 1-based number of the network, in execution order
  Reason reason = Reason::kPosition;
  NodeId with = kNoNode;  ///< of kForReader and kWithBlock
};

struct Sequence {
  std::vector<Step> steps;  ///< every node once
  std::uint32_t network_count = 0;
};

/// True for elements that do nothing by themselves: contacts, inVariables, inOutVariables without a wire, connectors.
/// They have no place of their own, unless an executionOrderId gives them one: they are read for who needs them.
bool only_passes_on(const Graph& graph, NodeId node);

/// True for a DELAY block: its output is what its input was in the previous scan, so it opens every loop through it.
bool is_delay(const plcopen::Element& element);

/// Orders all nodes by the given rule and marks feedback wires in `graph`. Loops without a block or an inOutVariable
/// are errors (P3006).
Sequence order(Graph& graph, core::Order rule, std::string_view pou, core::Diagnostics& diagnostics);

}  // namespace plc::fbd
