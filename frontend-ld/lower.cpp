#include "frontend-ld/lower.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "frontend-fbd/drawing.h"
#include "frontend-fbd/graph.h"
#include "frontend-ld/action_block.h"
#include "frontend-st/text.h"

namespace plc::ld {
namespace {

using core::Code;
using core::ElementKind;
using fbd::Graph;
using fbd::NodeId;
using fbd::OutRef;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Element;
using plcopen::Storage;

/// Adds power flow to a drawing: left rails are TRUE, contacts AND, joined wires OR, coils are transparent.
class Ladder final : public fbd::Drawing {
 public:
  using Drawing::Drawing;

  void set_sink(const ConditionSink& sink) { sink_ = sink; }

  void lower(const fbd::Step& step) {
    const NodeId node = step.node;
    if (step.network != rung_ && !is_rail(node)) {
      rung_ = step.network;
      const auto site = builder().cover_site(ir::CoverKind::kRung, element(node).at, element(node).text, rung_);
      builder().cover(site, 0);
    }
    lower_by_kind(node);
    write_targets(node);
  }

  void lower_by_kind(NodeId node) {
    switch (element(node).kind) {
      case ElementKind::kLeftRail:
        builder().set_source(element(node).at);
        return publish(flow_of(node), builder().constant_bool(true));
      case ElementKind::kRightRail:
        return;  // only closes the picture
      case ElementKind::kContact:
        return lower_contact(node);
      case ElementKind::kCoil:
        return lower_coil(node);
      case ElementKind::kActionBlock:
        return lower_action_block(node);
      case ElementKind::kTransition:
        builder().set_source(element(node).at);
        return sink_(element(node), is_connected(node) ? power_into(node, false) : std::nullopt);
      default:
        return lower_element(node);
    }
  }

  /// Beremiz writes the expression of a contact anew for each coil it feeds; edges keep their one evaluation there too.
  std::optional<ValueId> evaluate_afresh(NodeId node) override {
    const Element& e = element(node);
    if ((e.edge != Edge::kNone && !e.negated) || e.storage != Storage::kNone) return std::nullopt;
    if (e.kind == ElementKind::kContact) {
      const auto flow = power_into(node, false);
      const auto state = contact_state(node);
      if (!flow || !state) return std::nullopt;
      return flows().series(builder(), *flow, *state);
    }
    if (e.kind == ElementKind::kCoil) return power_into(node, false);
    if (e.kind == ElementKind::kInVariable && !e.negated) {
      const auto operand = st::lower_expression(e.text, e.text_at, builder());
      if (operand && operand->kind == ir::Operand::Kind::kValue) return operand->value;
    }
    return std::nullopt;
  }

 private:
  static OutRef flow_of(NodeId node) { return {OutRef::Kind::kFlow, 0, node}; }

  [[nodiscard]] bool is_rail(NodeId node) const {
    return element(node).kind == ElementKind::kLeftRail || element(node).kind == ElementKind::kRightRail;
  }

  [[nodiscard]] bool is_connected(NodeId node) const {
    return std::any_of(inputs(node).begin(), inputs(node).end(),
                       [](const fbd::Input& i) { return i.wire_count != 0 || !i.pin->expression.empty(); });
  }

  /// Power arriving at the connection points of a contact or coil; nothing when unconnected or poisoned.
  std::optional<ValueId> power_into(NodeId node, bool warn) {
    if (!is_connected(node)) {
      if (warn) {
        const Element& e = element(node);
        const std::string name = e.kind == ElementKind::kActionBlock ? action_summary(e) : e.text;
        report(Code::P2001, node, std::string(core::element_word(e.kind)) + " \"" + name + "\" is not connected",
               "it does nothing; wire it to a left power rail, or delete it");
        builder().pou().partial = true;
      }
      return std::nullopt;
    }
    std::optional<ValueId> flow;
    for (const fbd::Input& input : inputs(node)) {
      const auto one = read_bool(input, node);
      if (one) flow = flow ? flows().parallel(builder(), *flow, *one) : *one;
    }
    return flow;
  }

  /// State of the contact's variable: its value, negation, edge and storage, evaluated whether there is power or not.
  std::optional<ValueId> contact_state(NodeId node) {
    const Element& e = element(node);
    if (e.text.empty()) {
      report(Code::P3014, node, "contact names no variable", "write the variable above the contact");
      return std::nullopt;
    }
    const auto operand = st::lower_expression(e.text, e.text_at, builder(), ir::kBoolType);
    if (!operand) return std::nullopt;
    note_read(*operand, node);
    if (operand->kind == ir::Operand::Kind::kValue && builder().type_of(operand->value) != ir::kBoolType) {
      report(Code::P2003, node,
             "contact \"" + e.text + "\" has type " +
                 builder().module().types.name_of(builder().type_of(operand->value)) + ", a contact is BOOL",
             "compare the value with a block, or test one bit of it");
      return std::nullopt;
    }
    const auto value = is_bool(*operand) ? std::optional(operand->value)
                                         : builder().convert(*operand, ir::kBoolType, "contact \"" + e.text + "\"");
    if (!value) return std::nullopt;
    const ValueId state = modify(*value, e.negated, e.edge, e.storage, e.text);
    builder().probe(key_of(node), state);
    return state;
  }

  void lower_contact(NodeId node) {
    builder().set_source(element(node).at);
    if (!is_connected(node)) {
      power_into(node, true);
      return publish(flow_of(node), builder().constant_bool(false));
    }
    const auto state = contact_state(node);
    const auto flow = power_into(node, true);
    if (!state || !flow) return publish_poison(flow_of(node));
    const Element& e = element(node);
    if (const auto site = builder().cover_site(ir::CoverKind::kContact, e.at, e.text, rung_)) {
      builder().cover(site, 0, builder().logic(ir::Op::kAnd, *flow, *state));
      builder().cover(site, 1, builder().logic(ir::Op::kAnd, *flow, builder().not_(*state)));
    }
    publish(flow_of(node), flows().series(builder(), *flow, *state));
  }

  void lower_coil(NodeId node) {
    const Element& e = element(node);
    builder().set_source(e.at);
    if (!is_connected(node)) {
      power_into(node, true);
      return publish(flow_of(node), builder().constant_bool(false));
    }
    const auto flow = power_into(node, true);
    if (!flow) return publish_poison(flow_of(node));
    publish(flow_of(node), *flow);  // a coil is transparent: the flow after it is the flow before it
    if (const auto site = builder().cover_site(ir::CoverKind::kCoil, e.at, e.text, rung_)) {
      builder().cover(site, 0, *flow);
      builder().cover(site, 1, builder().not_(*flow));
    }
    if (e.text.empty()) {
      return report(Code::P3014, node, "coil names no variable", "write the variable above the coil");
    }
    const auto place = st::lower_place(e.text, e.text_at, builder(), true);
    if (!place) return;
    if (builder().type_of(*place) != ir::kBoolType) {
      return report(Code::P2003, node,
                    "coil \"" + e.text + "\" has type " + builder().module().types.name_of(builder().type_of(*place)) +
                        ", a coil is BOOL",
                    "use an outVariable at the output of a block for numbers");
    }
    const ValueId value = modify(*flow, e.negated, e.edge, Storage::kNone, e.text);
    write_bool(*place, value, e.storage);
    builder().probe(key_of(node), *place);
    note_write(*place, node, e.storage == Storage::kNone);
  }

  void lower_action_block(NodeId node) {
    builder().set_source(element(node).at);
    const auto flow = power_into(node, true);
    if (!is_connected(node)) return publish(flow_of(node), builder().constant_bool(false));
    if (!flow) return publish_poison(flow_of(node));
    publish(flow_of(node), *flow);  // transparent like a coil, also to wires from its actions
    actions_.lower(node, *flow);
  }

  ActionBlocks actions_{*this};
  ConditionSink sink_;
  std::uint32_t rung_ = 0;  ///< network of the element that is lowered
};

bool draws_something(const plcopen::Body& body) {
  return std::any_of(body.elements.begin(), body.elements.end(), [](const Element& e) {
    return e.kind != ElementKind::kLeftRail && e.kind != ElementKind::kRightRail && e.kind != ElementKind::kNone;
  });
}

/// True when the body, from instruction `first` on, writes something a user can see, runs a block or jumps.
bool does_something(ir::Builder& builder, std::size_t first) {
  const ir::Module& module = builder.module();
  const std::uint32_t pou_index = builder.pou_index();
  const ir::Pou& pou = module.pous[pou_index];
  const ir::Pou& owner = module.owner_of(pou);
  const auto transition = module.transitions.find(pou_index);
  const std::optional<std::uint32_t> result =
      transition == module.transitions.end() ? std::nullopt : std::optional(transition->second.result);
  const auto visible = [&](std::uint32_t place) {
    const ir::Place* p = &pou.body.places[place];
    while (p->parent.valid()) p = &pou.body.places[p->parent.index];
    const bool own = p->kind == ir::Place::Kind::kInstance || p->kind == ir::Place::Kind::kFrame;
    return !own || owner.variables[p->index].role != ir::Role::kHidden || p->index == result;
  };
  const auto begin = pou.body.insts.begin() + static_cast<std::ptrdiff_t>(first);
  return std::any_of(begin, pou.body.insts.end(), [&](const ir::Inst& inst) {
    switch (inst.op) {
      case ir::Op::kStore:
      case ir::Op::kCopy:
        return visible(inst.a);
      case ir::Op::kRun:
      case ir::Op::kCallPou:
      case ir::Op::kLabel:
      case ir::Op::kJump:
      case ir::Op::kJumpIf:
      case ir::Op::kJumpIfNot:
      case ir::Op::kReturn:
        return true;
      default:
        return false;
    }
  });
}

}  // namespace

void lower_drawing(const plcopen::Body& body, ir::Builder& builder, Worksheets& all) {
  const std::size_t first = builder.body().insts.size();
  const std::string name = builder.name();
  const core::CompileOptions options = builder.module().options;
  Graph graph = fbd::build_graph(body, name, builder.diagnostics(), &builder);
  const fbd::Sequence sequence = fbd::order(graph, options.order, name, builder.diagnostics());
  Ladder ladder(builder, graph, sequence, options);
  for (const fbd::Step& step : sequence.steps) ladder.lower(step);
  ladder.finish();
  all.drawn = all.drawn || draws_something(body);
  all.connected = all.connected && !graph.wires.empty();
  all.effective = all.effective || does_something(builder, first);
}

void warn_of_idle(const plcopen::Pou& pou, const Worksheets& all, ir::Builder& builder) {
  const std::string name = builder.name();
  if (!all.drawn) {
    builder.report(Code::P3017, pou.at, "body of " + name + " draws nothing: it compiles to nothing");
  } else if (!all.effective) {
    builder.report(Code::P3016, pou.at,
                   "body of " + name + " draws elements, but none of them writes a variable or runs a block",
                   all.connected ? "wire the blocks to coils, outVariables or function blocks"
                                 : "nothing is wired: connect the elements");
  }
}

bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  ir::Builder builder(module, pou_index, diagnostics);
  st::lower_prologue(builder);
  Worksheets all;
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language != plcopen::Language::kLd && body.language != plcopen::Language::kFbd) continue;
    lower_drawing(body, builder, all);
  }
  const bool good = diagnostics.error_count() == errors_before;
  if (good) warn_of_idle(pou, all, builder);
  module.pous[pou_index].compiled = good;
  return good;
}

void lower_conditions(const plcopen::Body& body, ir::Builder& builder, const ConditionSink& sink) {
  const std::string name = builder.name();
  Graph graph = fbd::build_graph(body, name, builder.diagnostics(), &builder);
  const core::CompileOptions options = builder.module().options;
  const fbd::Sequence sequence = fbd::order(graph, options.order, name, builder.diagnostics());
  Ladder ladder(builder, graph, sequence, options);
  ladder.set_sink(sink);
  for (const fbd::Step& step : sequence.steps) ladder.lower(step);
  ladder.finish();
}

std::vector<OrderLine> explain_order(const plcopen::Body& body, core::Order rule) {
  core::Diagnostics quiet;
  Graph graph = fbd::build_graph(body, {}, quiet);
  const fbd::Sequence sequence = fbd::order(graph, rule, {}, quiet);
  std::vector<OrderLine> lines;
  lines.reserve(sequence.steps.size());
  for (const fbd::Step& step : sequence.steps) {
    const Element& e = graph.element(step.node);
    OrderLine line{step.network, e.at, e.text, step.reason, {}, {}};
    if (step.with != fbd::kNoNode) line.with = graph.element(step.with).at;
    if (!e.instance_name.empty()) line.text += " " + e.instance_name;
    if (e.kind == ElementKind::kActionBlock) line.text = action_summary(e);
    for (const auto* pins : {&e.outputs, &e.in_outs}) {
      for (const plcopen::Pin& pin : *pins) {
        if (!pin.target.empty()) line.text += ", " + pin.name + " => " + pin.target;
      }
    }
    const fbd::Node& node = graph.nodes[step.node];
    for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
      const fbd::Input& input = graph.inputs[i];
      for (std::uint32_t w = 0; w < input.wire_count; ++w) {
        const fbd::Wire& wire = graph.wires[input.first_wire + w];
        if (wire.feedback) line.feedback_from.push_back(graph.element(wire.from.node).at.local_id);
      }
    }
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace plc::ld
