// Closed branches of CODESYS with short-circuit evaluation (docs/guides/drawn-blocks.md): boxes in their lines are not
// executed while a line without a box is TRUE.
//
// In: a Graph whose wires are resolved, and the marks of the body. Out: for each of these boxes an input more, a
// negated EN that reads the ends of the lines without a box: so the order puts those lines first, and lowering treats
// the box like any other under EN. Does not belong here: wires of the drawing (graph.cpp).
#pragma once

#include <vector>

#include "frontend-fbd/graph.h"

namespace plc::fbd {

/// One closed branch, its ends resolved.
struct BranchWires {
  std::vector<Wire> input;               ///< where its lines leave
  std::vector<std::vector<Wire>> lines;  ///< the end of each line
};

void add_bypasses(Graph& graph, const std::vector<BranchWires>& branches);

}  // namespace plc::fbd
