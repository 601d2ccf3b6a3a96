// Feedback wires and the types that spread through wires: forward from what feeds a block, backward from its readers.
#include <algorithm>

#include "frontend-fbd/drawing.h"
#include "frontend-fbd/ports.h"
#include "frontend-st/text.h"

namespace plc::fbd {
namespace {

using core::Code;
using core::ElementKind;
using ir::Operand;
using ir::PlaceId;
using ir::TypeRef;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Storage;
using stdlib::Direction;

constexpr unsigned kMaxDepth = 64;
/// Outputs looked at for one question: in crossing loops the number of paths doubles with every block.
constexpr unsigned kMaxSteps = 1000;

/// Whether all overloads, which a typed name (SHL_WORD) may have left of many, have one type at this place.
template <class TypeOf>
bool agree(std::span<const stdlib::Overload> candidates, TypeOf type_of) {
  return std::all_of(candidates.begin(), candidates.end(),
                     [&](const stdlib::Overload& o) { return type_of(o) == type_of(candidates[0]); });
}

}  // namespace

std::uint32_t Drawing::keep_for_feedback(const OutRef& out, TypeRef type) {
  Slot& slot = slots_[slot_index(out)];
  if (slot.kept == kNoKept) {
    slot.kept = builder_.hidden("feedback." + std::to_string(element(out.node).at.local_id), type);
    builder_.pou().variables[slot.kept].initial = before_first_scan(out, type);
    if (builder_.pou().kind == ir::PouKind::kFunction) {
      report(Code::P3026, out.node,
             "a feedback wire from \"" + element(out.node).text +
                 "\" is drawn in a function, which keeps nothing from call to call",
             "make it a function block");
    }
  }
  return slot.kept;
}

/// What a wire carries before the first scan: what the output begins with by its declaration; negated, the opposite.
std::vector<ir::InitItem> Drawing::before_first_scan(const OutRef& out, TypeRef type) {
  const plcopen::Element& e = element(out.node);
  if (e.kind != ElementKind::kBlock || out.kind == OutRef::Kind::kInOut) return {};
  std::vector<ir::InitItem> begins;
  std::size_t pin = out.pin;
  if (out.kind == OutRef::Kind::kEno) {
    const auto eno =
        std::find_if(e.outputs.begin(), e.outputs.end(), [](const auto& p) { return is_eno_name(p.name); });
    pin = static_cast<std::size_t>(eno - e.outputs.begin());
  } else if (pin < e.outputs.size()) {
    begins = initial_of_output(builder_, e, pin, type);
  }
  if (pin >= e.outputs.size()) return {};
  const plcopen::Pin& drawn = e.outputs[pin];
  // There is no edge before the first scan, and nothing that is stored.
  if (drawn.edge != Edge::kNone || drawn.storage != Storage::kNone) return {};
  if (!drawn.negated || type != ir::kBoolType) return begins;
  if (!begins.empty() && begins.back().value.bits != 0) return {};
  return {{{}, {ir::kBoolType, 1, {}}}};
}

Incoming Drawing::read_feedback(const OutRef& out) {
  Incoming in;
  const plcopen::Element& e = element(out.node);
  std::optional<PlaceId> place;
  if (e.kind == ElementKind::kInOutVariable) {
    place = st::lower_place(e.text, e.text_at, builder_, false);
    if (!place) {
      in.state = Incoming::State::kPoison;
      return in;
    }
  } else if (e.kind == ElementKind::kBlock && out.kind == OutRef::Kind::kPin && out.pin < e.outputs.size() &&
             !e.outputs[out.pin].negated && e.outputs[out.pin].edge == Edge::kNone &&
             e.outputs[out.pin].storage == Storage::kNone) {
    place = instance_output(builder_, e, out.pin);  // outputs of instances are memory already
  }
  if (!place) {
    const std::uint32_t known = slots_[slot_index(out)].kept;
    const auto type = known != kNoKept ? std::optional(builder_.pou().variables[known].type) : infer_type(out, 0);
    if (!type) {
      report(Code::P3007, out.node, "type of the feedback wire from \"" + e.text + "\" cannot be told",
             "give the loop a variable: an inOutVariable, or an outVariable read by an inVariable");
      in.state = Incoming::State::kPoison;
      return in;
    }
    place = builder_.variable(keep_for_feedback(out, *type));
  }
  ValueId value = builder_.load(*place);
  if (e.kind == ElementKind::kInOutVariable && e.negated_out && builder_.type_of(value) == ir::kBoolType) {
    value = builder_.not_(value);
  }
  in.state = Incoming::State::kValue;
  in.operand = Operand::of(value, e.at);
  return in;
}

/// Type of the variable or expression an element names, told without lowering anything for good.
std::optional<TypeRef> Drawing::type_of_text(const std::string& text, const core::SourceRef& at) {
  if (const ir::Variable* v = builder_.pou().find(text)) {
    return v->role == ir::Role::kInOut ? builder_.module().types[v->type].element : v->type;
  }
  core::Diagnostics quiet;
  ir::Body saved = builder_.body();
  std::optional<TypeRef> type;
  {
    ir::Builder probe(builder_.module(), builder_.pou_index(), quiet);
    const auto operand = st::lower_expression(text, at, probe);
    if (operand && operand->kind == Operand::Kind::kValue) type = probe.type_of(operand->value);
  }
  builder_.body() = std::move(saved);
  return type;
}

/// Type that an output will have, told from what feeds its block; failing that, from what reads it.
std::optional<TypeRef> Drawing::infer_type(const OutRef& out, unsigned depth) {
  if (depth == 0) {
    type_steps_ = 0;
    expected_seen_.clear();
  }
  if (depth > kMaxDepth || ++type_steps_ > kMaxSteps) return std::nullopt;
  const plcopen::Element& e = element(out.node);
  switch (e.kind) {
    case ElementKind::kContact:
    case ElementKind::kCoil:
    case ElementKind::kActionBlock:
    case ElementKind::kLeftRail:
      return ir::kBoolType;
    case ElementKind::kInVariable:
    case ElementKind::kInOutVariable:
      return type_of_text(e.text, e.text_at);
    case ElementKind::kConnector:
    case ElementKind::kContinuation:
      for (const Input& input : inputs(out.node)) {
        if (const auto type = type_of_input(out.node, input, depth)) return type;
      }
      return std::nullopt;
    case ElementKind::kBlock:
      break;
    default:
      return std::nullopt;
  }
  if (out.kind == OutRef::Kind::kEno) return ir::kBoolType;
  if (const auto ports = ports_of_block(builder_, e)) {
    const bool in_out = out.kind == OutRef::Kind::kInOut;
    const Port* port =
        in_out ? find_port(*ports, Direction::kInOut, e.in_outs[out.pin].name, out.pin)
               : find_port(*ports, Direction::kOutput, e.outputs[out.pin].name, output_position(e, out.pin));
    const bool known = port != nullptr && port->type.valid() && !builder_.module().types[port->type].open;
    return known ? std::optional(port->type) : std::nullopt;
  }
  if (out.kind == OutRef::Kind::kInOut) return std::nullopt;  // standard functions have none
  const auto candidates = stdlib::overloads_named(e.text);
  std::optional<TypeRef> widest;
  if (!candidates.empty()) {
    const stdlib::FunctionSpec& spec = *candidates[0].spec;
    const core::TypeId result = candidates[0].result_type();
    if (spec.result.kind == stdlib::ParamType::Kind::kFixed ||
        agree(candidates, [](const stdlib::Overload& o) { return o.result_type(); })) {
      return ir::ref_of(result);
    }
    std::size_t index = 0;
    for (const Input& input : inputs(out.node)) {
      if (is_enable_name(input.pin->name)) continue;
      const auto& param = spec.params[std::min<std::size_t>(index++, spec.param_count - 1u)];
      if (param.type.kind != spec.result.kind) continue;
      const auto type = type_of_input(out.node, input, depth);
      const auto own = type ? builder_.module().types.elementary_of(*type) : std::nullopt;
      const auto best = widest ? builder_.module().types.elementary_of(*widest) : std::nullopt;
      if (own && (!best || stdlib::widens(*best, *own))) widest = type;
    }
  } else if (is_delay(e)) {
    for (const Input& input : inputs(out.node)) {
      if (!widest && !is_enable_name(input.pin->name)) widest = type_of_input(out.node, input, depth);
    }
  }
  return widest ? widest : expected_type(out, depth + 1);
}

/// Type of what is wired to an input, if a wire from elsewhere tells it.
std::optional<TypeRef> Drawing::type_of_input(NodeId node, const Input& input, unsigned depth) {
  for (std::uint32_t w = 0; w < input.wire_count; ++w) {
    const Wire& wire = graph_.wires[input.first_wire + w];
    if (wire.from.node == node) continue;
    const Slot& slot = slots_[slot_index(wire.from)];
    if (slot.state == Slot::State::kValue) return builder_.type_of(slot.value);
    if (slot.kept != kNoKept) return builder_.pou().variables[slot.kept].type;
    if (slot.state == Slot::State::kPending) {
      if (const auto type = infer_type(wire.from, depth + 1)) return type;
    }
  }
  return std::nullopt;
}

std::optional<TypeRef> Drawing::expected_type(const OutRef& out, unsigned depth) {
  if (depth == 0) {
    type_steps_ = 0;
    expected_seen_.clear();
  }
  // Seen before on another path: what it told, or nothing if it is being asked or told nothing.
  if (depth > kMaxDepth) return std::nullopt;
  const auto [seen, fresh] = expected_seen_.emplace(slot_index(out), std::nullopt);
  if (!fresh) return seen->second;
  const auto found = expected_by_readers(out, depth);
  expected_seen_[slot_index(out)] = found;
  return found;
}

std::optional<TypeRef> Drawing::expected_by_readers(const OutRef& out, unsigned depth) {
  for (const Target& target : targets(out.node)) {
    if (target.out != out) continue;
    if (const auto type = type_of_text(target.pin->target, target.pin->target_at)) return type;
  }
  const std::uint32_t slot = slot_index(out);
  auto it = std::lower_bound(readers_.begin(), readers_.end(), slot,
                             [](const Reader& r, std::uint32_t s) { return r.slot < s; });
  for (; it != readers_.end() && it->slot == slot; ++it) {
    if (it->node == out.node) continue;
    const plcopen::Element& reader = element(it->node);
    const plcopen::Pin& pin = *graph_.inputs[it->input].pin;
    switch (reader.kind) {
      case ElementKind::kOutVariable:
      case ElementKind::kInOutVariable:
        if (const auto type = type_of_text(reader.text, reader.text_at)) return type;
        break;
      case ElementKind::kContact:
      case ElementKind::kCoil:
      case ElementKind::kActionBlock:
      case ElementKind::kJump:
      case ElementKind::kReturn:
        return ir::kBoolType;
      case ElementKind::kBlock: {
        if (is_enable_name(pin.name)) return ir::kBoolType;
        if (const auto type = type_of_pin(builder_, reader, pin)) return type;
        const auto candidates = stdlib::overloads_named(reader.text);
        if (candidates.empty() || builder_.module().pou_by_name.contains(reader.text)) break;
        // A generic function hands its own expectation on: what its result is to be, this argument is, too.
        const stdlib::FunctionSpec& spec = *candidates[0].spec;
        const std::size_t position = input_position(reader, pin);
        const auto& param = spec.params[std::min<std::size_t>(position, spec.param_count - 1u)];
        if (param.type.kind == stdlib::ParamType::Kind::kFixed) return ir::ref_of(param.type.fixed);
        const auto type_here = [&](const stdlib::Overload& o) { return o.param_type(position); };
        if (agree(candidates, type_here)) return ir::ref_of(type_here(candidates[0]));
        if (param.type.kind != spec.result.kind) break;
        for (std::uint16_t i = 0; i < reader.outputs.size(); ++i) {
          if (is_eno_name(reader.outputs[i].name)) continue;
          if (const auto type = expected_type({OutRef::Kind::kPin, i, it->node}, depth + 1)) return type;
        }
        break;
      }
      default:
        break;
    }
  }
  return std::nullopt;
}

}  // namespace plc::fbd
