#include "frontend-fbd/graph.h"

#include <string>
#include <unordered_map>

#include "core/text.h"

namespace plc::fbd {
namespace {

using core::Code;
using core::ElementKind;
using plcopen::Element;
using plcopen::Pin;

/// Elements whose input asks for power flow: a nameless wire from a block means its ENO there.
bool wants_power(const Element& reader, const Pin& pin) {
  switch (reader.kind) {
    case ElementKind::kContact:
    case ElementKind::kCoil:
    case ElementKind::kActionBlock:
    case ElementKind::kRightRail:
    case ElementKind::kJump:
    case ElementKind::kReturn:
      return true;
    default:
      return is_enable_name(pin.name);
  }
}

struct Resolver {
  const plcopen::Body& body;
  std::string_view pou;
  core::Diagnostics& diagnostics;
  std::unordered_map<std::int64_t, NodeId> by_id{};
  std::unordered_map<std::string, NodeId, core::NameHash, core::NameEqual> connectors{};

  OutRef block_output(const Element& reader, const Pin& pin, const plcopen::Connection& connection, NodeId from) const {
    const Element& block = body.elements[from];
    const std::string& name = connection.formal_parameter;
    if (!name.empty()) {
      for (std::size_t i = 0; i < block.outputs.size(); ++i) {
        if (core::iequals(block.outputs[i].name, name)) {
          return {is_eno_name(name) ? OutRef::Kind::kEno : OutRef::Kind::kPin, static_cast<std::uint16_t>(i), from};
        }
      }
      for (std::size_t i = 0; i < block.in_outs.size(); ++i) {
        if (core::iequals(block.in_outs[i].name, name))
          return {OutRef::Kind::kInOut, static_cast<std::uint16_t>(i), from};
      }
      if (is_eno_name(name)) return {OutRef::Kind::kEno, 0, from};
    }
    std::size_t plain = 0;
    std::size_t plain_index = 0;
    bool has_eno = false;
    for (std::size_t i = 0; i < block.outputs.size(); ++i) {
      if (is_eno_name(block.outputs[i].name)) {
        has_eno = true;
      } else if (plain++ == 0) {
        plain_index = i;
      }
    }
    const bool power = wants_power(reader, pin);
    if (plain == 1 && !(power && has_eno)) {
      return {OutRef::Kind::kPin, static_cast<std::uint16_t>(plain_index), from};
    }
    if (!name.empty() || plain > 1) {
      diagnostics.report(Code::P3002, connection.at, pou,
                         name.empty()
                             ? "wire from block " + block.text + " names none of its outputs"
                             : "wire names output \"" + name + "\", which block " + block.text + " does not have",
                         power ? "read as ENO (or the first output without one); name the pin in formalParameter"
                               : "read as the first output; name the pin in formalParameter");
    }
    if ((power && has_eno) || plain == 0) return {OutRef::Kind::kEno, 0, from};
    return {OutRef::Kind::kPin, static_cast<std::uint16_t>(plain_index), from};
  }

  void add_input(Graph& graph, const Element& element, const Pin& pin) const {
    Input input{&pin, static_cast<std::uint32_t>(graph.wires.size()), 0};
    for (const plcopen::Connection& connection : pin.connections) {
      if (connection.refused) continue;
      const auto it = by_id.find(connection.ref_local_id);
      if (it == by_id.end()) {
        diagnostics.report(
            Code::P3001, connection.at, pou,
            "wire comes from localId " + std::to_string(connection.ref_local_id) + ", which is not drawn in this body",
            "the wire is left out; draw it again");
        continue;
      }
      const ElementKind kind = body.elements[it->second].kind;
      OutRef from{OutRef::Kind::kFlow, 0, it->second};
      if (kind == ElementKind::kBlock) {
        from = block_output(element, pin, connection, it->second);
      } else if (kind == ElementKind::kOutVariable || kind == ElementKind::kRightRail || kind == ElementKind::kJump ||
                 kind == ElementKind::kReturn || kind == ElementKind::kLabel || kind == ElementKind::kConnector) {
        if (kind != ElementKind::kOutVariable && kind != ElementKind::kConnector) {
          diagnostics.report(Code::P3003, connection.at, pou,
                             "wire comes from " + std::string(core::element_word(kind)) + " " +
                                 std::to_string(connection.ref_local_id) + ", which has no output",
                             "the wire is left out; draw it again");
          continue;
        }
      }
      graph.wires.push_back({from, connection.at, false});
    }
    input.wire_count = static_cast<std::uint32_t>(graph.wires.size()) - input.first_wire;
    graph.inputs.push_back(input);
  }
};

}  // namespace

bool is_enable_name(std::string_view pin) { return core::iequals(pin, "EN"); }
bool is_eno_name(std::string_view pin) { return core::iequals(pin, "ENO"); }

Graph build_graph(const plcopen::Body& body, std::string_view pou, core::Diagnostics& diagnostics) {
  static const Pin kContinuationPin{};
  Graph graph;
  graph.body = &body;
  graph.nodes.reserve(body.elements.size());
  graph.inputs.reserve(body.elements.size() * 2);
  graph.wires.reserve(body.elements.size() * 2);
  Resolver resolver{body, pou, diagnostics};
  resolver.by_id.reserve(body.elements.size());
  for (NodeId i = 0; i < body.elements.size(); ++i) {
    const Element& element = body.elements[i];
    resolver.by_id.emplace(element.at.local_id, i);
    if (element.kind == ElementKind::kConnector) {
      const auto [it, fresh] = resolver.connectors.emplace(element.text, i);
      if (!fresh) {
        diagnostics.report(Code::P3004, element.at, pou, "connector \"" + element.text + "\" is drawn twice",
                           "give each connector a name of its own");
      }
    }
  }
  for (NodeId i = 0; i < body.elements.size(); ++i) {
    // Actions have connection points and ids of their own; elements win.
    for (const plcopen::ActionLink& action : body.elements[i].actions) {
      if (action.local_id >= 0) resolver.by_id.emplace(action.local_id, i);
    }
  }
  for (NodeId i = 0; i < body.elements.size(); ++i) {
    const Element& element = body.elements[i];
    Node node{&element, static_cast<std::uint32_t>(graph.inputs.size()), 0};
    if (element.kind == ElementKind::kContinuation) {
      Input input{&kContinuationPin, static_cast<std::uint32_t>(graph.wires.size()), 0};
      const auto it = resolver.connectors.find(element.text);
      if (it == resolver.connectors.end()) {
        diagnostics.report(Code::P3005, element.at, pou,
                           "continuation \"" + element.text + "\" has no connector of that name in this body",
                           "draw the connector, or correct the name");
      } else {
        graph.wires.push_back({{OutRef::Kind::kFlow, 0, it->second}, element.at, false});
        input.wire_count = 1;
      }
      graph.inputs.push_back(input);
    } else {
      for (const Pin& pin : element.inputs) resolver.add_input(graph, element, pin);
      for (const Pin& pin : element.in_outs) resolver.add_input(graph, element, pin);
    }
    node.input_count = static_cast<std::uint32_t>(graph.inputs.size()) - node.first_input;
    graph.nodes.push_back(node);
  }
  return graph;
}

}  // namespace plc::fbd
