// A diagram as the tests of this folder draw and run it: through fbd::Drawing alone, without the ladder on top.
#pragma once

#include <string>

#include "frontend-fbd/drawing.h"
#include "frontend-fbd/graph.h"
#include "frontend-fbd/order.h"
#include "tests/support/drawn.h"

namespace plc::test {

inline bool lower_diagram(const plcopen::Pou& pou, ir::Module& module, std::uint32_t index,
                          core::Diagnostics& diagnostics) {
  const std::string name = module.pous[index].name;
  ir::Builder builder(module, index, diagnostics);
  st::lower_prologue(builder);
  for (const plcopen::Body& body : pou.bodies) {
    fbd::Graph graph = fbd::build_graph(body, name, diagnostics, &builder);
    const fbd::Sequence sequence = fbd::order(graph, module.options.order, name, diagnostics);
    fbd::Drawing drawing(builder, graph, sequence, module.options);
    for (const fbd::Step& step : sequence.steps) {
      drawing.lower_element(step.node);
      drawing.write_targets(step.node);
    }
    drawing.finish();
  }
  const bool good = diagnostics.error_count() == 0;
  module.pous[index].compiled = good;
  return good;
}

struct Diagram : Drawn {
  Diagram(const std::string& variables, const Sketch& body, const std::string& others = "")
      : Drawn(lower_diagram, variables, body, others) {}
};

}  // namespace plc::test
