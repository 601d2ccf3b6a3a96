#include "frontend-fbd/drawing.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/text.h"
#include "frontend-fbd/ports.h"
#include "frontend-st/text.h"
#include "ir/generic.h"
#include "ir/queues.h"

namespace plc::fbd {
namespace {

using core::Code;
using core::ElementKind;
using ir::Op;
using ir::Operand;
using ir::PlaceId;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Storage;

/// Outputs of an element as slots: a block's pins, its in-outs, its ENO; one for everything else.
std::uint32_t slot_count(const plcopen::Element& e) {
  return e.kind == ElementKind::kBlock ? static_cast<std::uint32_t>(e.outputs.size() + e.in_outs.size() + 1) : 1;
}

std::string place_in_list(const core::SourceRef& at) {
  return std::to_string(at.local_id) + " (line " + std::to_string(at.line) + ")";
}

}  // namespace

bool computes(const plcopen::Element& e) {
  return e.kind == ElementKind::kInVariable && e.text.find_first_of("(*/+") != std::string::npos;
}

Drawing::Drawing(ir::Builder& builder, const Graph& graph, const Sequence& sequence,
                 const core::CompileOptions& options)
    : builder_(builder), graph_(graph), sequence_(sequence), options_(options) {
  first_slot_.reserve(graph.nodes.size() + 1);
  std::uint32_t next = 0;
  for (const Node& node : graph.nodes) {
    first_slot_.push_back(next);
    next += slot_count(*node.element);
  }
  first_slot_.push_back(next);
  slots_.resize(next);
  for (const Wire& wire : graph.wires) slots_[slot_index(wire.from)].read = true;
  feeds_known_.resize(graph.nodes.size());
  for (NodeId n = 0; n < graph.nodes.size(); ++n) {
    const plcopen::Element& e = element(n);
    add_targets(n);
    const bool missing = e.kind == ElementKind::kBlock && is_missing(e);
    const Node& node = graph.nodes[n];
    for (std::uint32_t i = node.first_input; i < node.first_input + node.input_count; ++i) {
      for (std::uint32_t w = 0; w < graph.inputs[i].wire_count; ++w) {
        const OutRef& from = graph.wires[graph.inputs[i].first_wire + w].from;
        if (!missing) feeds_known_[from.node] = true;
        // Types spread backwards only into blocks and what is computed in a text: power flow is BOOL anyway.
        const plcopen::Element& source = element(from.node);
        if (source.kind == ElementKind::kBlock || computes(source)) readers_.push_back({slot_index(from), n, i});
      }
    }
  }
  std::stable_sort(readers_.begin(), readers_.end(), [](const Reader& a, const Reader& b) { return a.slot < b.slot; });
}

bool Drawing::is_missing(const plcopen::Element& e) {
  return !e.has_code && !builder_.module().pou_by_name.contains(e.text) && stdlib::block_named(e.text) == nullptr &&
         !stdlib::is_function(e.text) && !is_delay(e) && !ir::array_bound_named(e.text) &&
         !ir::queue_function_named(e.text) && !named_call(builder_, e);
}

void Drawing::add_targets(NodeId node) {
  const plcopen::Element& e = element(node);
  const bool block = e.kind == ElementKind::kBlock;
  const auto add = [&](OutRef::Kind kind, std::size_t i, const plcopen::Pin& pin) {
    if (pin.target.empty()) return;
    targets_.push_back({{kind, static_cast<std::uint16_t>(i), node}, &pin});
    slots_[slot_index(targets_.back().out)].read = true;
    feeds_known_[node] = true;
  };
  for (std::size_t i = 0; i < e.outputs.size(); ++i) {
    const bool eno = block && is_eno_name(e.outputs[i].name);
    add(eno ? OutRef::Kind::kEno : block ? OutRef::Kind::kPin : OutRef::Kind::kFlow, i, e.outputs[i]);
  }
  for (std::size_t i = 0; block && i < e.in_outs.size(); ++i) add(OutRef::Kind::kInOut, i, e.in_outs[i]);
}

std::span<const Drawing::Target> Drawing::targets(NodeId node) const {
  const auto [first, last] =
      std::equal_range(targets_.begin(), targets_.end(), Target{{OutRef::Kind::kFlow, 0, node}, nullptr},
                       [](const Target& a, const Target& b) { return a.out.node < b.out.node; });
  return {first, last};
}

std::span<const Input> Drawing::inputs(NodeId node) const {
  const Node& n = graph_.nodes[node];
  return {graph_.inputs.data() + n.first_input, n.input_count};
}

std::uint32_t Drawing::slot_index(const OutRef& out) const {
  const plcopen::Element& e = graph_.element(out.node);
  switch (out.kind) {
    case OutRef::Kind::kFlow:
      return first_slot_[out.node];
    case OutRef::Kind::kPin:
      return first_slot_[out.node] + out.pin;
    case OutRef::Kind::kInOut:
      return first_slot_[out.node] + static_cast<std::uint32_t>(e.outputs.size()) + out.pin;
    case OutRef::Kind::kEno:
      return first_slot_[out.node + 1] - 1;
  }
  return first_slot_[out.node];
}

bool Drawing::has_reader(const OutRef& out) const { return slots_[slot_index(out)].read; }

void Drawing::report(Code code, NodeId node, std::string message, std::string help) {
  builder_.report(code, element(node).at, std::move(message), std::move(help));
}

std::optional<ValueId> Drawing::evaluate_afresh(NodeId) { return std::nullopt; }

// ---- publishing ---------------------------------------------------------------------------------------------------

void Drawing::publish(const OutRef& out, ValueId value, ValueId executed) {
  Slot& slot = slots_[slot_index(out)];
  slot.state = Slot::State::kValue;
  slot.value = value;
  slot.executed = executed;
  if (builder_.notes_probes() && out.kind != OutRef::Kind::kEno) builder_.probe(key_of(out), value);
  if (slot.kept != kNoKept) {
    const PlaceId kept = builder_.variable(slot.kept);
    if (builder_.type_of(kept) == builder_.type_of(value)) {
      builder_.store(kept, value);
    } else {
      builder_.assign(kept, Operand::of(value, element(out.node).at),
                      "the feedback wire of \"" + element(out.node).text + "\"");
    }
  }
}

void Drawing::publish(const OutRef& out, const Operand& operand) {
  if (operand.kind == Operand::Kind::kValue) return publish(out, operand.value);
  Slot& slot = slots_[slot_index(out)];
  slot.state = Slot::State::kLiteral;
  slot.literal = static_cast<std::uint32_t>(literals_.size());
  literals_.push_back(operand);
}

void Drawing::publish_poison(const OutRef& out) { slots_[slot_index(out)].state = Slot::State::kPoison; }

// ---- reading ------------------------------------------------------------------------------------------------------

Incoming Drawing::read_slot(const OutRef& out, const core::SourceRef& at) {
  const Slot& slot = slots_[slot_index(out)];
  Incoming in;
  in.state = Incoming::State::kValue;
  switch (slot.state) {
    case Slot::State::kPending:
    case Slot::State::kPoison:
      in.state = Incoming::State::kPoison;
      return in;
    case Slot::State::kLiteral:
      in.operand = literals_[slot.literal];
      return in;
    case Slot::State::kValue:
      break;
  }
  in.operand = Operand::of(slot.value, at);
  in.executed = slot.executed;
  return in;
}

Incoming Drawing::read_wire(const Wire& wire) {
  if (wire.feedback) return read_feedback(wire.from);
  Incoming in = read_slot(wire.from, wire.at);
  if (in.operand.kind != Operand::Kind::kValue) return in;
  if (options_.compat == core::Compat::kBeremiz && wire.from.kind == OutRef::Kind::kFlow) {
    if (const auto fresh = evaluate_afresh(wire.from.node)) in.operand.value = *fresh;
  }
  return in;
}

bool Drawing::is_bool(const Operand& operand) {
  return operand.kind == Operand::Kind::kValue && builder_.type_of(operand.value) == ir::kBoolType;
}

ir::ProbeKey Drawing::key_of(const OutRef& out) const {
  const std::size_t before = out.kind == OutRef::Kind::kInOut ? element(out.node).outputs.size() : 0;
  return ir::ProbeKey::of(element(out.node).at, ir::ProbeSide::kOutput, before + out.pin);
}

ir::ProbeKey Drawing::key_of(const Input& input) const {
  const auto index = static_cast<std::uint32_t>(&input - graph_.inputs.data());
  const auto after = std::upper_bound(graph_.nodes.begin(), graph_.nodes.end(), index,
                                      [](std::uint32_t i, const Node& node) { return i < node.first_input; });
  const Node& node = *(after - 1);
  return ir::ProbeKey::of(node.element->at, ir::ProbeSide::kInput, index - node.first_input);
}

Incoming Drawing::read(const Input& input) {
  Incoming in = read_input(input);
  if (builder_.notes_probes() && in.is_value()) builder_.probe(key_of(input), in.operand);
  return in;
}

Incoming Drawing::read_input(const Input& input) {
  const plcopen::Pin& pin = *input.pin;
  Incoming in;
  if (input.wire_count == 1) {
    in = read_wire(graph_.wires[input.first_wire]);
  } else if (input.wire_count > 1) {
    std::optional<ValueId> flow;
    bool typed = true;
    for (std::uint32_t w = 0; w < input.wire_count; ++w) {
      const Wire& wire = graph_.wires[input.first_wire + w];
      const Incoming one = read_wire(wire);
      if (!one.is_value()) continue;
      if (one.operand.kind == Operand::Kind::kValue && builder_.type_of(one.operand.value) != ir::kBoolType) {
        if (typed) {
          builder_.report(Code::P3013, wire.at,
                          "several wires meet at a pin, and one of them has type " +
                              builder_.module().types.name_of(builder_.type_of(one.operand.value)),
                          "wires that meet are OR of BOOL; use a SEL, MUX or ADD block for numbers");
        }
        typed = false;
        continue;
      }
      if (!typed) continue;  // said once for the pin
      const auto value = is_bool(one.operand) ? std::optional(one.operand.value)
                                              : builder_.convert(one.operand, ir::kBoolType, "joined wires");
      if (!value) continue;
      flow = flow ? flows_.parallel(builder_, *flow, *value) : *value;
    }
    in.state = flow && typed ? Incoming::State::kValue : Incoming::State::kPoison;
    if (flow) in.operand = Operand::of(*flow, graph_.wires[input.first_wire].at);
  } else if (!pin.expression.empty()) {
    const auto operand = st::lower_expression(pin.expression, pin.at, builder_);
    in.state = operand ? Incoming::State::kValue : Incoming::State::kPoison;
    if (operand) in.operand = *operand;
  }
  if (!in.is_value() || (!pin.negated && pin.edge == Edge::kNone && pin.storage == Storage::kNone)) return in;
  const std::string what = pin.name.empty() ? "the input" : "pin \"" + pin.name + "\"";
  const auto flow = bool_to_modify(in.operand, pin.at, what);
  if (!flow) {
    in.state = Incoming::State::kPoison;
    return in;
  }
  in.operand =
      Operand::of(modify(*flow, pin.negated, pin.edge, pin.storage, pin.name.empty() ? "pin" : pin.name), pin.at);
  return in;
}

std::optional<ValueId> Drawing::bool_to_modify(const Operand& operand, const core::SourceRef& at,
                                               const std::string& what) {
  if (is_bool(operand)) return operand.value;
  if (operand.kind != Operand::Kind::kValue) {
    return builder_.convert(operand, ir::kBoolType, what + " with a modifier");
  }
  builder_.report(
      Code::P3023, at,
      what + " has a modifier but type " + builder_.module().types.name_of(builder_.type_of(operand.value)),
      "negation, edges and storage need BOOL; a NOT block negates the bits of a BYTE, WORD, DWORD or LWORD");
  return std::nullopt;
}

std::optional<ValueId> Drawing::read_bool(const Input& input, NodeId reader) {
  const Incoming in = read(input);
  if (!in.is_value()) return std::nullopt;
  if (is_bool(in.operand)) return in.operand.value;
  const plcopen::Element& e = element(reader);
  return builder_.convert(in.operand, ir::kBoolType,
                          "power flow into " + std::string(core::element_word(e.kind)) + " \"" + e.text + "\"");
}

std::optional<Drawing::Variable> Drawing::variable_behind(OutRef out) const {
  bool modified = false;
  // In-outs wired to themselves, at once or around, lead to no variable.
  for (std::size_t steps = 0; steps <= graph_.nodes.size(); ++steps) {
    const plcopen::Element& e = element(out.node);
    std::string_view left;  // of a block: the name of the in-out, whose right side is the variable on its left
    const plcopen::Pin* in_out = nullptr;  // the same, where it is drawn as one pin
    switch (e.kind) {
      case ElementKind::kInVariable:
        modified = modified || e.negated || e.edge != Edge::kNone || e.storage != Storage::kNone;
        return Variable{e.text, e.text_at, modified};
      case ElementKind::kInOutVariable:
        modified = modified || e.negated_out || e.edge_out != Edge::kNone || e.storage_out != Storage::kNone;
        return Variable{e.text, e.text_at, modified};
      case ElementKind::kConnector:
      case ElementKind::kContinuation:
        break;
      case ElementKind::kBlock: {
        if (out.kind != OutRef::Kind::kInOut && out.kind != OutRef::Kind::kPin) return std::nullopt;
        const plcopen::Pin& pin = out.kind == OutRef::Kind::kInOut ? e.in_outs[out.pin] : e.outputs[out.pin];
        modified = modified || pin.negated || pin.edge != Edge::kNone || pin.storage != Storage::kNone;
        left = pin.name;
        if (out.kind == OutRef::Kind::kInOut) in_out = &pin;
        break;
      }
      default:
        return std::nullopt;
    }
    const auto own = inputs(out.node);
    const auto input = std::find_if(own.begin(), own.end(), [&](const Input& i) {
      if (i.wire_count != 1 && (i.wire_count != 0 || i.pin->expression.empty())) return false;
      if (in_out != nullptr) return i.pin == in_out;
      return e.kind != ElementKind::kBlock || (!left.empty() && core::iequals(i.pin->name, left));
    });
    if (input == own.end()) return std::nullopt;
    if (input->wire_count == 0) return Variable{input->pin->expression, input->pin->at, modified};
    out = graph_.wires[input->first_wire].from;
  }
  return std::nullopt;
}

std::optional<PlaceId> Drawing::place_of_source(const OutRef& out, bool for_writing) {
  const auto variable = variable_behind(out);
  if (!variable || variable->modified) return std::nullopt;
  if (!st::is_variable_text(variable->text)) return std::nullopt;
  return st::lower_place(variable->text, variable->at, builder_, for_writing);
}

bool Drawing::is_modified_variable(const OutRef& out) const {
  const auto variable = variable_behind(out);
  return variable && variable->modified;
}

// ---- what is read and written ------------------------------------------------------------------------------------

void Drawing::note_write(PlaceId place, NodeId node, bool plain_coil) { writes_.push_back({place, node, plain_coil}); }

void Drawing::note_read(const Operand& operand, NodeId node) {
  if (operand.kind != Operand::Kind::kValue) return;
  const ir::Inst& inst = builder_.body().insts[operand.value.index];
  if (inst.op == Op::kLoad) reads_.push_back({PlaceId{inst.a}, node});
}

// ---- closing the body ---------------------------------------------------------------------------------------------

void Drawing::finish() {
  for (const auto& [name, state] : labels_) {
    if (!state.bound) {
      report(Code::P3015, state.first_jump, "jump to label \"" + name + "\", which is not drawn in this body",
             "draw the label, or correct the name");
      builder_.bind(state.label);  // reported here, not once more by the check of the IR
    }
  }
  warn_double_writes();
  warn_order_of_writes();
  refuse_memory();
  warn_of_edges();
}

void Drawing::warn_double_writes() {
  std::vector<const Write*> coils;
  for (const Write& write : writes_) {
    if (write.plain_coil) coils.push_back(&write);
  }
  std::stable_sort(coils.begin(), coils.end(),
                   [](const Write* a, const Write* b) { return a->place.index < b->place.index; });
  for (std::size_t i = 0, end = 0; i < coils.size(); i = end) {
    std::string list;
    for (end = i; end < coils.size() && coils[end]->place == coils[i]->place; ++end) {
      if (end == i) continue;
      if (end == i + 1) list = place_in_list(element(coils[i]->node).at);
      list += ", " + place_in_list(element(coils[end]->node).at);
    }
    if (end - i < 2) continue;
    const NodeId last = coils[end - 1]->node;
    const std::span<const Write* const> all = std::span(coils).subspan(i, end - i);
    if (warn_coils_of_one_address(all)) continue;
    report(Code::P2002, last,
           "coil \"" + element(last).text + "\" is driven by " + std::to_string(end - i) + " coils: " + list,
           "the last one in execution order wins; join the rungs, or use set and reset coils");
  }
}

// Coils that are drawn for different variables, which have one address: nobody sees that in the drawing.
bool Drawing::warn_coils_of_one_address(std::span<const Write* const> coils) {
  const ir::Place& place = builder_.body().places[coils.front()->place.index];
  const std::string_view first = core::trimmed(element(coils.front()->node).text);
  const bool one_name = std::all_of(coils.begin(), coils.end(), [&](const Write* coil) {
    return core::iequals(core::trimmed(element(coil->node).text), first);
  });
  if (one_name || place.kind != ir::Place::Kind::kGlobal) return false;
  const std::string& address = builder_.module().globals[place.index].variable.address;
  if (address.empty()) return false;
  std::string list;
  for (const Write* coil : coils) {
    list += (list.empty() ? "\"" : ", \"") + element(coil->node).text + "\" " + place_in_list(element(coil->node).at);
  }
  report(Code::P2002, coils.back()->node,
         "variable at " + address + " is driven by " + std::to_string(coils.size()) +
             " coils under several names: " + list,
         "the last one in execution order wins; give each output an address of its own");
  builder_.drop_written_names(place.index);
  return true;
}

void Drawing::warn_order_of_writes() {
  // Where by the drawing everything that acts is in document order, the two rules agree: reading and writing
  // follows. The order of the file says nothing about that of the drawing.
  const bool drawing = options_.order == core::Order::kDrawing;
  std::vector<std::uint32_t> here(graph_.nodes.size(), 0);
  bool same =
      drawing && std::none_of(graph_.wires.begin(), graph_.wires.end(), [](const Wire& wire) { return wire.feedback; });
  NodeId last = 0;
  for (std::uint32_t i = 0; i < sequence_.steps.size(); ++i) {
    const NodeId n = sequence_.steps[i].node;
    here[n] = i;
    if (sequence_.steps[i].reason == Reason::kWithBlock || only_passes_on(graph_, n)) continue;
    same = same && n >= last;
    last = n;
  }
  if (same || writes_.empty()) return;
  Graph other = graph_;
  for (Wire& wire : other.wires) wire.feedback = false;
  core::Diagnostics quiet;
  const Sequence sequence = order(other, drawing ? core::Order::kDocument : core::Order::kDrawing, {}, quiet);
  std::vector<std::uint32_t> there(graph_.nodes.size(), 0);
  for (std::uint32_t i = 0; i < sequence.steps.size(); ++i) there[sequence.steps[i].node] = i;

  struct Access {
    NodeId node;
    bool writes;
  };
  std::map<std::uint32_t, std::vector<Access>> by_place;  // in execution order
  for (const Write& write : writes_) by_place[write.place.index].push_back({write.node, true});
  for (const Read& read : reads_) {
    const auto it = by_place.find(read.place.index);
    if (it != by_place.end()) it->second.push_back({read.node, false});
  }
  for (auto& [place, accesses] : by_place) {
    std::stable_sort(accesses.begin(), accesses.end(),
                     [&](const Access& a, const Access& b) { return here[a.node] < here[b.node]; });
    for (std::size_t i = 0; i + 1 < accesses.size(); ++i) {
      const Access& first = accesses[i];
      const Access& second = accesses[i + 1];
      if ((!first.writes && !second.writes) || first.node == second.node) continue;
      if (there[first.node] <= there[second.node]) continue;
      const auto phrase = [&](const Access& a) {
        return std::string(a.writes ? "written by " : "read by ") +
               std::string(core::element_word(element(a.node).kind)) + " " +
               std::to_string(element(a.node).at.local_id);
      };
      const plcopen::Element& e = element(second.node);
      const std::string name = e.kind == ElementKind::kBlock ? builder_.describe(PlaceId{place}) : e.text;
      report(Code::P3018, second.node,
             "\"" + name + "\" is " + phrase(first) + " and then " + phrase(second) + "; in " +
                 (drawing ? "document" : "drawing") + " order it is the other way round",
             "see `plc explain FILE POU`; choose with --order, or give the elements an executionOrderId");
    }
  }
}

}  // namespace plc::fbd
