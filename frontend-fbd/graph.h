// Graph of one drawn body: which output every wire leads from. Built once per body; order and lowering read it.
//
// In: plcopen::Body. Out: nodes (one per element), inputs with their sources, dangling wires reported. Connectors are
// wires: a continuation's source is the connector of its name. Pins that an export leaves out of a block are added as
// the block's type has them. Does not belong here: values, meaning of elements.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "ir/builder.h"
#include "plcopen/project.h"

namespace plc::fbd {

/// Index into Body::elements.
using NodeId = std::uint32_t;
inline constexpr NodeId kNoNode = 0xffffffffu;

/// One output of an element.
struct OutRef {
  enum class Kind : std::uint8_t {
    kFlow,   ///< the only output: rail, contact, coil, in/inOutVariable, continuation
    kPin,    ///< Element::outputs[pin] of a block
    kInOut,  ///< Element::in_outs[pin] of a block, its right side
    kEno,    ///< ENO of a block, drawn or not
  } kind = Kind::kFlow;
  std::uint16_t pin = 0;
  NodeId node = kNoNode;
  friend bool operator==(const OutRef&, const OutRef&) = default;
};

/// One wire as its reader sees it.
struct Wire {
  OutRef from;
  core::SourceRef at;
  bool feedback = false;  ///< set by the order: carries the value of the previous scan
};

/// One input of an element: a connection point or a block pin, with the wires that meet there.
struct Input {
  const plcopen::Pin* pin = nullptr;
  std::uint32_t first_wire = 0;  ///< into Graph::wires
  std::uint32_t wire_count = 0;
};

struct Node {
  const plcopen::Element* element = nullptr;
  std::uint32_t first_input = 0;  ///< into Graph::inputs: the element's inputs, then its in_outs
  std::uint32_t input_count = 0;
};

struct Graph {
  const plcopen::Body* body = nullptr;
  std::vector<Node> nodes;
  std::vector<Input> inputs;
  std::vector<Wire> wires;
  std::deque<plcopen::Element> completed;  ///< elements that the file does not give whole

  [[nodiscard]] const plcopen::Element& element(NodeId node) const { return *nodes[node].element; }
  /// All wires into a node, input by input.
  [[nodiscard]] std::span<const Wire> wires_into(NodeId node) const {
    return {wires.data() + first_wire(node), wire_count(node)};
  }
  [[nodiscard]] std::span<Wire> wires_into(NodeId node) { return {wires.data() + first_wire(node), wire_count(node)}; }

 private:
  [[nodiscard]] std::uint32_t first_wire(NodeId node) const {
    const Node& n = nodes[node];
    return n.input_count == 0 ? 0 : inputs[n.first_input].first_wire;
  }
  [[nodiscard]] std::uint32_t wire_count(NodeId node) const {
    const Node& n = nodes[node];
    if (n.input_count == 0) return 0;
    const Input& last = inputs[n.first_input + n.input_count - 1];
    return last.first_wire + last.wire_count - first_wire(node);
  }
};

/// Resolves all wires. Wires to elements that do not exist are left out with a warning (P3001). A wire that names no
/// output of its block is ENO where power flow is asked for, without one the first BOOL output, else the first output,
/// with a warning (P3002). `types` knows the pins of blocks; without it, as for the order alone, only drawn pins count.
/// Boxes in a closed branch with short-circuit evaluation get an EN more, from the lines that bypass them
/// (closed_branches.h).
Graph build_graph(const plcopen::Body& body, std::string_view pou, core::Diagnostics& diagnostics,
                  ir::Builder* types = nullptr);

/// True for EN and ENO in any letter case.
bool is_enable_name(std::string_view pin);
bool is_eno_name(std::string_view pin);

}  // namespace plc::fbd
