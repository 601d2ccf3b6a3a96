#include <algorithm>
#include <map>
#include <numeric>
#include <utility>

#include "core/text.h"
#include "drawings/sheet.h"
#include "frontend-fbd/graph.h"

namespace plc::drawings {
namespace {

using bytecode::DrawnEdge;
using bytecode::DrawnModifiers;
using bytecode::DrawnStorage;
using fbd::OutRef;
using plcopen::Element;
using plcopen::Pin;

DrawnModifiers modifiers_of(bool negated, plcopen::Edge edge, plcopen::Storage storage) {
  DrawnModifiers out;
  out.negated = negated;
  out.edge = edge == plcopen::Edge::kRising    ? DrawnEdge::kRising
             : edge == plcopen::Edge::kFalling ? DrawnEdge::kFalling
                                               : DrawnEdge::kNone;
  out.storage = storage == plcopen::Storage::kSet     ? DrawnStorage::kSet
                : storage == plcopen::Storage::kReset ? DrawnStorage::kReset
                                                      : DrawnStorage::kNone;
  return out;
}

class SheetReader {
 public:
  SheetReader(const plcopen::Body& body, bool has_plane) : body_(body) { sheet_.placed = has_plane; }

  Sheet read() {
    for (const Element& e : body_.elements) add_element(e);
    add_wires(graph_body());
    number_networks();
    for (const plcopen::DrawnComment& comment : body_.comments) {
      sheet_.comments.push_back(
          {comment.text, 0, comment.place.x, comment.place.y, std::max(comment.width, 0), std::max(comment.height, 0)});
      const auto below = numbers_.lower_bound(comment.network);
      sheet_.comment_networks.push_back(comment.network == 0      ? 0
                                        : below == numbers_.end() ? networks_ + 1
                                                                  : below->second);
    }
    return std::move(sheet_);
  }

 private:
  // ---- elements ----

  void add_element(const Element& e) {
    DrawnElement& out = sheet_.elements.emplace_back();
    sheet_.pin_places.emplace_back();
    out.kind = e.kind;
    out.local_id = e.at.local_id;
    out.line = e.at.line;
    out.column = e.at.column;
    out.network = e.network;
    out.text = e.text;
    out.instance = e.instance_name;
    out.code = e.code;
    out.x = e.x;
    out.y = e.y;
    out.width = std::max(e.width, 0);
    out.height = std::max(e.height, 0);
    sheet_.placed = sheet_.placed && e.has_position;
    if (e.kind != ElementKind::kInOutVariable) out.modifiers = modifiers_of(e.negated, e.edge, e.storage);
    if (e.chart) add_chart_part(out, *e.chart);
    for (const plcopen::ActionLink& action : e.actions) {
      const bool named = !action.name.empty();
      out.actions.push_back({action.qualifier.empty() ? "N" : action.qualifier, named ? action.name : action.text,
                             action.duration, action.indicator, action.at.line, action.at.column});
    }
    if (e.kind == ElementKind::kActionBlock) out.text.clear();
    const bool chart = in_chart(e.kind);
    std::uint16_t number = 0;
    for (const auto* pins : {&e.inputs, &e.in_outs}) {
      for (const Pin& pin : *pins) add_pin(out, pin, false, chart ? kNoPin : number++);
    }
    if (const Pin* const condition = wired_condition(e)) add_pin(out, *condition, false, 0);
    number = 0;
    for (const auto* pins : {&e.outputs, &e.in_outs}) {
      for (const Pin& pin : *pins) add_pin(out, pin, true, chart ? kNoPin : number++);
    }
    if (e.kind == ElementKind::kInOutVariable) {
      for (DrawnPin& pin : out.pins) {
        pin.modifiers = pin.output ? modifiers_of(e.negated_out, e.edge_out, e.storage_out)
                                   : modifiers_of(e.negated, e.edge, e.storage);
      }
    }
  }

  [[nodiscard]] bool in_chart(ElementKind kind) const {
    return body_.language == plcopen::Language::kSfc && is_chart_element(kind);
  }

  static void add_chart_part(DrawnElement& out, const plcopen::ChartPart& part) {
    out.initial = part.initial;
    out.priority = part.priority;
    if (out.kind == ElementKind::kTransition) {
      const bool made = part.reference.starts_with('#');  // a condition with a body of its own
      out.text = !part.text.empty() ? part.text : made ? std::string() : part.reference;
      if (part.negated && !out.text.empty()) out.text = "NOT (" + out.text + ")";
    }
    const auto own = [&](const char* when, const std::string& name) {
      if (!name.empty()) out.actions.push_back({when, name, {}, {}, 0, 0});
    };
    own("entry", part.entry);
    own("main", part.main);
    own("exit", part.exit);
  }

  static const Pin* wired_condition(const Element& e) {
    return e.chart && !e.chart->condition.connections.empty() ? &e.chart->condition : nullptr;
  }

  void add_pin(DrawnElement& out, const Pin& pin, bool output, std::uint16_t number) {
    DrawnPin& drawn = out.pins.emplace_back();
    drawn.name = is_flow(out.kind) ? std::string() : pin.name;
    drawn.text = output ? pin.target : pin.expression;
    drawn.output = output;
    drawn.pin = number;
    drawn.modifiers = modifiers_of(pin.negated, pin.edge, pin.storage);
    drawn.at = {pin.place.x, pin.place.y};
    sheet_.pin_places.back().push_back(pin.has_place);
  }

  /// Editors write names at the points of elements that have one input and one output.
  static bool is_flow(ElementKind kind) { return kind != ElementKind::kBlock; }

  // ---- wires ----

  /// What the graph is made of: transitions with the wires of their condition as the last input, branches without the
  /// inputs that their evaluation adds.
  const plcopen::Body& graph_body() {
    const bool conditions = std::any_of(body_.elements.begin(), body_.elements.end(),
                                        [](const Element& e) { return wired_condition(e) != nullptr; });
    const bool bypasses = std::any_of(body_.closed_branches.begin(), body_.closed_branches.end(),
                                      [](const plcopen::ClosedBranch& branch) { return branch.short_circuit; });
    if (!conditions && !bypasses) return body_;
    copy_ = body_;
    for (plcopen::ClosedBranch& branch : copy_.closed_branches) branch.short_circuit = false;
    for (Element& e : copy_.elements) {
      if (const Pin* const condition = wired_condition(e)) e.inputs.push_back(*condition);
    }
    return copy_;
  }

  void add_wires(const plcopen::Body& body) {
    core::Diagnostics quiet;
    const fbd::Graph graph = fbd::build_graph(body, {}, quiet);
    sheet_.wires.reserve(graph.wires.size());
    for (std::uint32_t node = 0; node < graph.nodes.size(); ++node) {
      if (body.elements[node].kind == ElementKind::kContinuation) continue;
      const fbd::Node& reader = graph.nodes[node];
      for (std::uint32_t input = 0; input < reader.input_count; ++input) {
        const fbd::Input& in = graph.inputs[reader.first_input + input];
        for (std::uint32_t w = in.first_wire; w < in.first_wire + in.wire_count; ++w) {
          add_wire(node, input, *in.pin, graph.wires[w]);
        }
      }
    }
  }

  void add_wire(std::uint32_t to, std::uint32_t input, const Pin& pin, const fbd::Wire& wire) {
    const auto connection = std::find_if(pin.connections.begin(), pin.connections.end(),
                                         [&](const plcopen::Connection& one) { return one.at == wire.at; });
    const bool known = connection != pin.connections.end();
    DrawnWire out;
    out.from = wire.from.node;
    out.from_pin = output_pin(wire.from, known ? connection->formal_parameter : std::string());
    out.to = to;
    out.to_pin = input;
    sheet_.wires.push_back(std::move(out));
    std::vector<DrawnPoint>& line = sheet_.drawn_lines.emplace_back();
    if (!known) return;
    for (auto point = connection->points.rbegin(); point != connection->points.rend(); ++point) {
      line.push_back({point->x, point->y});
    }
  }

  /// The pin that a wire leads from, added where the file does not draw it.
  std::uint32_t output_pin(const OutRef& from, const std::string& name) {
    DrawnElement& e = sheet_.elements[from.node];
    const Element& source = body_.elements[from.node];
    const auto first = static_cast<std::uint32_t>(
        std::find_if(e.pins.begin(), e.pins.end(), [](const DrawnPin& pin) { return pin.output; }) - e.pins.begin());
    const auto named = [&](const std::string& wanted) -> std::uint32_t {
      for (std::uint32_t i = first; i < e.pins.size(); ++i) {
        if (core::iequals(e.pins[i].name, wanted)) return i;
      }
      DrawnPin& pin = e.pins.emplace_back();
      pin.name = wanted;
      pin.output = true;
      pin.pin = source.kind == ElementKind::kBlock || in_chart(source.kind) ? kNoPin : 0;
      sheet_.pin_places[from.node].push_back(false);
      return static_cast<std::uint32_t>(e.pins.size() - 1);
    };
    switch (from.kind) {
      case OutRef::Kind::kFlow:
        return flow_pin(e, first, named);
      case OutRef::Kind::kInOut:
        return static_cast<std::uint32_t>(first + source.outputs.size() + from.pin);
      case OutRef::Kind::kEno:
        return named(name.empty() ? "ENO" : name);
      case OutRef::Kind::kPin:
        break;
    }
    // A function block has its outputs by name, also those that the file does not draw.
    const std::string& drawn = source.outputs[from.pin].name;
    if (!name.empty() && !source.instance_name.empty() && !core::iequals(name, drawn)) return named(name);
    return first + from.pin;
  }

  template <class Named>
  static std::uint32_t flow_pin(const DrawnElement& e, std::uint32_t first, const Named& named) {
    return first < e.pins.size() ? first : named(std::string());
  }

  // ---- networks ----

  /// Numbers from 1, in the order in which the drawing shows them: groups of the file, and what wires connect. Rails
  /// and what a chart is made of connect nothing and have none.
  void number_networks() {
    std::vector<DrawnElement>& elements = sheet_.elements;
    const auto apart = [&](std::uint32_t i) { return is_rail(elements[i].kind) || in_chart(elements[i].kind); };
    const bool given = std::any_of(elements.begin(), elements.end(), [](const auto& e) { return e.network != 0; });
    std::vector<std::uint32_t> root(elements.size());
    std::iota(root.begin(), root.end(), 0u);
    const auto find = [&](std::uint32_t i) {
      while (root[i] != i) i = root[i] = root[root[i]];
      return i;
    };
    if (given) {
      std::map<std::uint32_t, std::uint32_t> first;
      for (std::uint32_t i = 0; i < elements.size(); ++i) {
        if (!apart(i)) root[i] = first.try_emplace(elements[i].network, i).first->second;
      }
    }
    for (const DrawnWire& wire : sheet_.wires) {
      if (apart(wire.from) || apart(wire.to)) continue;
      const std::uint32_t a = find(wire.from), b = find(wire.to);
      root[std::max(a, b)] = std::min(a, b);
    }
    // Where each is, by its topmost and then leftmost element.
    std::map<std::uint32_t, std::pair<std::int32_t, std::int32_t>> corner;
    for (std::uint32_t i = 0; i < elements.size(); ++i) {
      if (apart(i)) continue;
      const std::pair at = sheet_.placed && !given ? std::pair(elements[i].y, elements[i].x) : std::pair(0, 0);
      const auto [known, fresh] = corner.try_emplace(find(i), at);
      if (!fresh) known->second = std::min(known->second, at);
    }
    std::vector<std::uint32_t> order;
    for (const auto& [first, at] : corner) order.push_back(first);
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return corner[a] < corner[b]; });
    networks_ = static_cast<std::uint32_t>(order.size());
    std::vector<std::uint32_t> number(elements.size(), 0);
    for (std::uint32_t n = 0; n < order.size(); ++n) number[order[n]] = n + 1;
    for (std::uint32_t i = 0; i < elements.size(); ++i) {
      if (given && !apart(i)) numbers_.try_emplace(elements[i].network, number[find(i)]);
      elements[i].network = apart(i) ? 0 : number[find(i)];
    }
  }

  const plcopen::Body& body_;
  plcopen::Body copy_;
  std::uint32_t networks_ = 0;
  std::map<std::uint32_t, std::uint32_t> numbers_;  ///< of networks, by those of the file
  Sheet sheet_;
};

}  // namespace

bool is_rail(ElementKind kind) { return kind == ElementKind::kLeftRail || kind == ElementKind::kRightRail; }

bool is_bar(ElementKind kind) {
  return kind == ElementKind::kSelectionDivergence || kind == ElementKind::kSelectionConvergence ||
         kind == ElementKind::kSimultaneousDivergence || kind == ElementKind::kSimultaneousConvergence;
}

bool is_chart_element(ElementKind kind) {
  return is_bar(kind) || kind == ElementKind::kStep || kind == ElementKind::kMacroStep ||
         kind == ElementKind::kJumpStep || kind == ElementKind::kTransition || kind == ElementKind::kActionBlock;
}

Sheet read_sheet(const plcopen::Body& body, bool has_plane) { return SheetReader(body, has_plane).read(); }

}  // namespace plc::drawings
