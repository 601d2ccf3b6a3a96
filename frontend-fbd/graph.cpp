#include "frontend-fbd/graph.h"

#include <algorithm>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/text.h"
#include "frontend-fbd/closed_branches.h"
#include "frontend-fbd/ports.h"

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

/// Elements that take no wire: what would come by it, nobody reads.
bool has_input(ElementKind kind) {
  return kind != ElementKind::kInVariable && kind != ElementKind::kLeftRail && kind != ElementKind::kLabel;
}

/// Elements of which the first input counts.
bool has_one_input(ElementKind kind) {
  return kind == ElementKind::kOutVariable || kind == ElementKind::kInOutVariable || kind == ElementKind::kConnector ||
         kind == ElementKind::kJump || kind == ElementKind::kReturn;
}

class Resolver {
 public:
  Resolver(Graph& graph, std::string_view pou, core::Diagnostics& diagnostics, ir::Builder* types)
      : graph_(graph), body_(*graph.body), pou_(pou), diagnostics_(diagnostics), types_(types) {
    by_id_.reserve(body_.elements.size());
    for (NodeId i = 0; i < body_.elements.size(); ++i) {
      const Element& element = body_.elements[i];
      by_id_.emplace(element.at.local_id, i);
      if (element.kind == ElementKind::kConnector) {
        const auto [it, fresh] = connectors_.emplace(element.text, i);
        if (!fresh) {
          report(Code::P3004, element.at, "connector \"" + element.text + "\" is drawn twice",
                 "give each connector a name of its own");
        }
      }
    }
    for (NodeId i = 0; i < body_.elements.size(); ++i) {
      // Actions have connection points and ids of their own; elements win.
      for (const plcopen::ActionLink& action : body_.elements[i].actions) {
        if (action.local_id >= 0) by_id_.emplace(action.local_id, i);
      }
    }
    for (const plcopen::ClosedBranch& branch : body_.closed_branches) {
      if (branch.local_id >= 0 && !by_id_.contains(branch.local_id)) marks_.emplace(branch.local_id, &branch);
    }
  }

  void add_input(const Element& element, const Pin& pin) {
    if (!has_input(element.kind)) {
      if (!pin.connections.empty()) {
        report(Code::P3003, pin.at,
               "wire leads to " + std::string(core::element_word(element.kind)) + " " +
                   std::to_string(element.at.local_id) + ", which has no input",
               "the wire is left out; draw it again");
      }
      graph_.inputs.push_back({&pin, static_cast<std::uint32_t>(graph_.wires.size()), 0});
      return;
    }
    if (has_one_input(element.kind) && &pin != element.inputs.data() && !pin.connections.empty()) {
      report(Code::P3013, pin.at,
             std::string(core::element_word(element.kind)) + " " + std::to_string(element.at.local_id) +
                 " has several inputs, and wires at more than the first",
             "wire all to one input, where they are OR of BOOL");
    }
    if (!pin.expression.empty() && !pin.connections.empty()) {
      report(Code::P3013, pin.at,
             "a wire and the text \"" + pin.expression + "\" meet at " +
                 (pin.name.empty() ? "the input" : "pin \"" + pin.name + "\"") + " of a " +
                 std::string(core::element_word(element.kind)),
             "which of them is meant cannot be told: delete the text or the wire");
    }
    Input input{&pin, static_cast<std::uint32_t>(graph_.wires.size()), 0};
    add_wires(element, pin, graph_.wires);
    input.wire_count = static_cast<std::uint32_t>(graph_.wires.size()) - input.first_wire;
    graph_.inputs.push_back(input);
  }

  void add_continuation(const Element& element) {
    static const Pin kContinuationPin{};
    Input input{&kContinuationPin, static_cast<std::uint32_t>(graph_.wires.size()), 0};
    const auto it = connectors_.find(element.text);
    if (it == connectors_.end()) {
      report(Code::P3005, element.at,
             "continuation \"" + element.text + "\" has no connector of that name in this body",
             "draw the connector, or correct the name");
    } else {
      graph_.wires.push_back({{OutRef::Kind::kFlow, 0, it->second}, element.at, false});
      input.wire_count = 1;
    }
    graph_.inputs.push_back(input);
  }

  /// The type name of a block without the namespace of a library, and not as a symbol.
  void resolve_type(NodeId node) {
    if (types_ == nullptr || body_.elements[node].has_code) return;
    const std::string_view name = type_name(*types_, body_.elements[node].text);
    if (name != body_.elements[node].text) own(node).text = std::string(name);
  }

  /// Nodes stand for the elements that were completed.
  void take_completed() {
    for (const auto& [n, element] : completed_) {
      Node& node = graph_.nodes[n];
      node.element = element;
      for (std::uint32_t k = 0; k < node.input_count; ++k) {
        const std::size_t inputs = element->inputs.size();
        graph_.inputs[node.first_input + k].pin = k < inputs ? &element->inputs[k] : &element->in_outs[k - inputs];
      }
    }
  }

  std::vector<BranchWires> short_circuits() {
    static const Element kJoin = [] {
      Element join;
      join.kind = ElementKind::kCoil;  // asks for power flow
      return join;
    }();
    std::vector<BranchWires> branches;
    for (const plcopen::ClosedBranch& branch : body_.closed_branches) {
      if (!branch.short_circuit) continue;
      BranchWires& wires = branches.emplace_back();
      add_wires(kJoin, branch.input, wires.input);
      for (const Pin& line : branch.lines) add_wires(kJoin, line, wires.lines.emplace_back());
    }
    return branches;
  }

 private:
  void report(Code code, const core::SourceRef& at, std::string message, std::string help) {
    diagnostics_.report(code, at, pou_, std::move(message), std::move(help));
  }

  [[nodiscard]] const Element& element(NodeId node) const {
    const auto it = completed_.find(node);
    return it == completed_.end() ? body_.elements[node] : *it->second;
  }

  Element& own(NodeId node) {
    Element*& element = completed_[node];
    if (element == nullptr) element = &graph_.completed.emplace_back(body_.elements[node]);
    return *element;
  }

  void add_output(NodeId node, std::string_view name) {
    Pin& pin = own(node).outputs.emplace_back();
    pin.name = std::string(name);
    pin.at = body_.elements[node].at;
    pin.has_point_out = true;
  }

  /// The drawn output or in-out of that name.
  std::optional<OutRef> drawn_output(NodeId from, std::string_view name) const {
    const Element& block = element(from);
    for (std::size_t i = 0; i < block.outputs.size(); ++i) {
      if (core::iequals(block.outputs[i].name, name)) {
        return OutRef{is_eno_name(name) ? OutRef::Kind::kEno : OutRef::Kind::kPin, static_cast<std::uint16_t>(i), from};
      }
    }
    for (std::size_t i = 0; i < block.in_outs.size(); ++i) {
      if (core::iequals(block.in_outs[i].name, name)) {
        return OutRef{OutRef::Kind::kInOut, static_cast<std::uint16_t>(i), from};
      }
    }
    if (is_eno_name(name)) return OutRef{OutRef::Kind::kEno, 0, from};
    return std::nullopt;
  }

  /// Adds what the export leaves out: all outputs where none are drawn, else the one that the wire names.
  void complete(NodeId from, std::string_view name, const std::optional<std::vector<Port>>& known) {
    const Element& block = element(from);
    if (types_ == nullptr || block.has_code) return;
    const bool none = block.outputs.empty();
    if (!known) {  // the block is not known, and said so
      if (!name.empty()) add_output(from, name);
      return;
    }
    for (const Port& port : *known) {
      if (none && port.direction == stdlib::Direction::kOutput && !is_eno_name(port.name)) {
        add_output(from, is_named(port, name) ? name : port.name);
      } else if (is_named(port, name)) {
        add_output(from, name);
      }
    }
  }

  std::optional<std::vector<Port>> known_outputs(NodeId node) {
    if (types_ == nullptr || element(node).has_code) return std::nullopt;
    return outputs_of(*types_, element(node));
  }

  /// The drawn result of a function, whatever its pin is called: the first that no other output has the name of.
  std::optional<OutRef> drawn_result(NodeId from, const std::vector<Port>& known) const {
    const Element& block = element(from);
    for (std::size_t i = 0; i < block.outputs.size(); ++i) {
      const std::string& pin = block.outputs[i].name;
      const bool other = std::any_of(known.begin() + 1, known.end(), [&](const Port& p) { return is_named(p, pin); });
      if (!other && !is_eno_name(pin)) return OutRef{OutRef::Kind::kPin, static_cast<std::uint16_t>(i), from};
    }
    return std::nullopt;
  }

  /// The output that a wire names: drawn, or as the type has it. Editors call the result of a function OUT.
  std::optional<OutRef> named_output(NodeId from, std::string_view name) {
    if (const auto drawn = drawn_output(from, name)) return drawn;
    const auto known = known_outputs(from);
    const bool result =
        known && !known->empty() && known->front().result &&
        (is_named(known->front(), name) || core::iequals(name, "OUT")) &&
        std::none_of(known->begin() + 1, known->end(), [&](const Port& port) { return is_named(port, name); });
    if (result) {
      if (const auto drawn = drawn_result(from, *known)) return drawn;
    }
    complete(from, name, known);
    if (const auto drawn = drawn_output(from, name)) return drawn;
    return result ? drawn_result(from, *known) : std::nullopt;
  }

  /// True for a name, of no drawn output, at a function block that has several outputs: any of them may be meant.
  /// Functions and blocks of one output are read by that, whatever the file calls it.
  bool is_foreign(NodeId node, std::string_view name) {
    const auto known = name.empty() ? std::nullopt : known_outputs(node);
    if (!known || std::any_of(known->begin(), known->end(), [](const Port& port) { return port.result; })) return false;
    return std::count_if(known->begin(), known->end(),
                         [](const Port& port) { return port.direction == stdlib::Direction::kOutput; }) > 1;
  }

  /// The first drawn output that is BOOL by the type of a function block; `first` where none is known to be.
  std::size_t first_bool(NodeId from, std::size_t first) {
    const auto known = known_outputs(from);
    if (!known || std::any_of(known->begin(), known->end(), [](const Port& port) { return port.result; })) return first;
    const std::vector<Pin>& outputs = element(from).outputs;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const Port* port = find_port(*known, stdlib::Direction::kOutput, outputs[i].name, known->size());
      if (port != nullptr && port->type == ir::kBoolType) return i;
    }
    return first;
  }

  OutRef block_output(const Element& reader, const Pin& pin, const plcopen::Connection& connection, NodeId from) {
    const std::string& name = connection.formal_parameter;
    if (name.empty()) {
      if (element(from).outputs.empty()) complete(from, name, known_outputs(from));
    } else if (const auto named = named_output(from, name)) {
      return *named;
    }
    const Element& block = element(from);
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
    if (plain == 1 && !(power && has_eno) && !is_foreign(from, name)) {
      return {OutRef::Kind::kPin, static_cast<std::uint16_t>(plain_index), from};
    }
    if (!name.empty() || plain > 1) {
      report(Code::P3002, connection.at,
             name.empty() ? "wire from block " + block.text + " names none of its outputs"
                          : "wire names output \"" + name + "\", which block " + block.text + " does not have",
             power ? "read as ENO, without one as the first BOOL output; name the pin in formalParameter"
                   : "read as the first output; name the pin in formalParameter");
    }
    if ((power && has_eno) || plain == 0) return {OutRef::Kind::kEno, 0, from};
    if (power) plain_index = first_bool(from, plain_index);
    return {OutRef::Kind::kPin, static_cast<std::uint16_t>(plain_index), from};
  }

  void add_wires(const Element& reader, const Pin& pin, std::vector<Wire>& out) {
    // A wire from the mark of a closed branch comes from all its lines; each mark is looked at once.
    std::vector<const plcopen::ClosedBranch*> marks;
    add_wires(reader, pin, out, marks);
    for (std::size_t i = 0; i < marks.size(); ++i) {
      for (const Pin& line : marks[i]->lines) add_wires(reader, line, out, marks);
    }
  }

  void add_wires(const Element& reader, const Pin& pin, std::vector<Wire>& out,
                 std::vector<const plcopen::ClosedBranch*>& marks) {
    for (const plcopen::Connection& connection : pin.connections) {
      if (connection.refused) continue;
      const auto it = by_id_.find(connection.ref_local_id);
      if (it == by_id_.end()) {
        if (const auto mark = marks_.find(connection.ref_local_id); mark != marks_.end()) {
          if (std::find(marks.begin(), marks.end(), mark->second) == marks.end()) marks.push_back(mark->second);
          continue;
        }
        report(
            Code::P3001, connection.at,
            "wire comes from localId " + std::to_string(connection.ref_local_id) + ", which is not drawn in this body",
            "the wire is left out; draw it again");
        continue;
      }
      const ElementKind kind = body_.elements[it->second].kind;
      OutRef from{OutRef::Kind::kFlow, 0, it->second};
      if (kind == ElementKind::kBlock) {
        from = block_output(reader, pin, connection, it->second);
      } else if (kind == ElementKind::kInVariable && body_.elements[it->second].text.empty()) {
        continue;  // nothing assigned: not connected
      } else if (kind == ElementKind::kRightRail || kind == ElementKind::kJump || kind == ElementKind::kReturn ||
                 kind == ElementKind::kLabel) {
        report(Code::P3003, connection.at,
               "wire comes from " + std::string(core::element_word(kind)) + " " +
                   std::to_string(connection.ref_local_id) + ", which has no output",
               "the wire is left out; draw it again");
        continue;
      }
      out.push_back({from, connection.at, false});
    }
  }

  Graph& graph_;
  const plcopen::Body& body_;
  std::string_view pou_;
  core::Diagnostics& diagnostics_;
  ir::Builder* types_;
  std::unordered_map<std::int64_t, NodeId> by_id_;
  std::unordered_map<std::int64_t, const plcopen::ClosedBranch*> marks_;
  std::unordered_map<std::string, NodeId, core::NameHash, core::NameEqual> connectors_;
  std::unordered_map<NodeId, Element*> completed_;  ///< into Graph::completed
};

}  // namespace

bool is_enable_name(std::string_view pin) { return core::iequals(pin, "EN"); }
bool is_eno_name(std::string_view pin) { return core::iequals(pin, "ENO"); }

Graph build_graph(const plcopen::Body& body, std::string_view pou, core::Diagnostics& diagnostics, ir::Builder* types) {
  Graph graph;
  graph.body = &body;
  graph.nodes.reserve(body.elements.size());
  graph.inputs.reserve(body.elements.size() * 2);
  graph.wires.reserve(body.elements.size() * 2);
  Resolver resolver(graph, pou, diagnostics, types);
  for (NodeId i = 0; i < body.elements.size(); ++i) {
    if (body.elements[i].kind == ElementKind::kBlock) resolver.resolve_type(i);
  }
  for (const Element& element : body.elements) {
    Node node{&element, static_cast<std::uint32_t>(graph.inputs.size()), 0};
    if (element.kind == ElementKind::kContinuation) {
      resolver.add_continuation(element);
    } else {
      for (const Pin& pin : element.inputs) resolver.add_input(element, pin);
      for (const Pin& pin : element.in_outs) resolver.add_input(element, pin);
    }
    node.input_count = static_cast<std::uint32_t>(graph.inputs.size()) - node.first_input;
    graph.nodes.push_back(node);
  }
  const std::vector<BranchWires> branches = resolver.short_circuits();
  resolver.take_completed();
  if (!branches.empty()) add_bypasses(graph, branches);
  return graph;
}

}  // namespace plc::fbd
