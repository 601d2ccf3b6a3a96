// Variables, connectors, jumps, labels and returns of a drawn body. Blocks are in lower_block.cpp.
#include <string>

#include "frontend-fbd/drawing.h"
#include "frontend-st/text.h"

namespace plc::fbd {

using core::Code;
using core::ElementKind;
using ir::Operand;
using ir::PlaceId;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Element;
using plcopen::Storage;

namespace {

bool has_output(ElementKind kind) {
  return kind != ElementKind::kRightRail && kind != ElementKind::kJump && kind != ElementKind::kReturn &&
         kind != ElementKind::kLabel;
}

}  // namespace

void Drawing::lower_element(NodeId node) {
  builder_.set_source(element(node).at);
  switch (element(node).kind) {
    case ElementKind::kBlock:
      return lower_block(node);
    case ElementKind::kInVariable:
      return lower_in_variable(node);
    case ElementKind::kOutVariable:
      return lower_out_variable(node);
    case ElementKind::kInOutVariable:
      return lower_in_out_variable(node);
    case ElementKind::kConnector:
    case ElementKind::kContinuation:
      return lower_passage(node);
    case ElementKind::kJump:
      return lower_jump(node);
    case ElementKind::kLabel:
      return lower_label(node);
    case ElementKind::kReturn:
      return lower_return(node);
    default:
      report(Code::P9001, node,
             std::string("a reader let pass a ") + std::string(core::element_word(element(node).kind)) +
                 " in a body drawn in LD or FBD");
  }
}

void Drawing::lower_in_variable(NodeId node) {
  const Element& e = element(node);
  const OutRef out{OutRef::Kind::kFlow, 0, node};
  if (e.text.empty()) return publish_poison(out);  // nothing assigned: its wires are left out
  // What only feeds missing blocks may name values of missing types; the block is reported, that is enough.
  if (has_reader(out) && !feeds_known_[node]) return publish_poison(out);
  const auto operand =
      st::lower_expression(e.text, e.text_at, builder_, computes(e) ? expected_type(out) : std::nullopt);
  if (!operand) return publish_poison(out);
  note_read(*operand, node);
  builder_.probe(key_of(node), *operand);
  if (!e.negated && e.edge == Edge::kNone && e.storage == Storage::kNone) return publish(out, *operand);
  const auto value = bool_to_modify(*operand, e.at, "inVariable \"" + e.text + "\"");
  if (!value) return publish_poison(out);
  publish(out, modify(*value, e.negated, e.edge, e.storage, e.text));
}

void Drawing::lower_out_variable(NodeId node) {
  const Element& e = element(node);
  const OutRef out{OutRef::Kind::kFlow, 0, node};
  const auto own = inputs(node);
  const Incoming in = own.empty() ? Incoming{} : read(own[0]);
  if (e.text.empty() && !in.is_value()) return publish_poison(out);  // neither wire nor variable
  if (in.state == Incoming::State::kUnconnected) {
    report(Code::P3022, node, "outVariable \"" + e.text + "\" is not connected",
           "it keeps its value; wire it, or delete it");
    builder_.pou().partial = true;
    return publish_poison(out);
  }
  if (!in.is_value()) return publish_poison(out);
  if (!e.text.empty()) {
    const auto place =
        write(e.text, e.text_at, in, {e.negated, e.edge, e.storage}, "outVariable \"" + e.text + "\"", node);
    if (place) builder_.probe(key_of(node), *place);
  }
  if (has_reader(out)) publish(out, in.operand);
}

std::optional<PlaceId> Drawing::write(const std::string& text, const core::SourceRef& at, const Incoming& in,
                                      const Modifiers& modifiers, const std::string& what, NodeId node) {
  // What an EN that was FALSE left out must not be written: the variable keeps its value (IEC 61131-3:2013, 6.6.1.7).
  ir::LabelId skip;
  if (in.executed.valid()) {
    skip = builder_.new_label();
    builder_.jump_if_not(in.executed, skip);
  }
  const auto place = st::lower_place(text, at, builder_, true);
  if (place) {
    if (modifiers.negated || modifiers.edge != Edge::kNone || modifiers.storage != Storage::kNone) {
      if (builder_.type_of(*place) != ir::kBoolType) {
        report(Code::P3023, node,
               what + " has a modifier but type " + builder_.module().types.name_of(builder_.type_of(*place)),
               "negation, edges and storage need BOOL");
      } else if (const auto value = builder_.convert(in.operand, ir::kBoolType, what)) {
        write_bool(*place, modify(*value, modifiers.negated, modifiers.edge, Storage::kNone, text), modifiers.storage);
      }
    } else {
      builder_.assign(*place, in.operand, what);
    }
    note_write(*place, node, false);
  }
  if (skip.valid()) builder_.bind(skip);
  return place;
}

void Drawing::write_targets(NodeId node) {
  const Element& e = element(node);
  for (const auto& [out, pin] : targets(node)) {
    const std::string of = e.kind == ElementKind::kBlock ? "output \"" + pin->name + "\" of " + e.text
                                                         : "the output of a " + std::string(core::element_word(e.kind));
    if (!has_output(e.kind)) {
      report(Code::P3003, node, "variable \"" + pin->target + "\" is drawn at " + of + ", which has none",
             "it is not written; delete it");
      continue;
    }
    if (is_left_side(out, *pin)) continue;
    const Incoming in = read_slot(out, pin->target_at);
    if (in.is_value()) write(pin->target, pin->target_at, in, {}, "variable \"" + pin->target + "\" at " + of, node);
  }
}

bool Drawing::is_left_side(const OutRef& out, const plcopen::Pin& pin) {
  if (pin.name.empty() || !st::is_variable_text(pin.target)) return false;
  for (const Input& input : inputs(out.node)) {
    if (!core::iequals(input.pin->name, pin.name)) continue;
    const auto left = input.wire_count == 1 ? place_of_source(graph_.wires[input.first_wire].from)
                      : st::is_variable_text(input.pin->expression)
                          ? st::lower_place(input.pin->expression, input.pin->at, builder_, true)
                          : std::nullopt;
    if (left && st::lower_place(pin.target, pin.target_at, builder_, true) == left) return true;
  }
  return false;
}

void Drawing::lower_in_out_variable(NodeId node) {
  const Element& e = element(node);
  const OutRef out{OutRef::Kind::kFlow, 0, node};
  const auto own = inputs(node);
  const Incoming in = own.empty() ? Incoming{} : read(own[0]);
  if (in.state == Incoming::State::kPoison) return publish_poison(out);
  const bool writes = in.is_value();
  const auto place = st::lower_place(e.text, e.text_at, builder_, writes);
  if (!place) return publish_poison(out);
  const std::string what = "inOutVariable \"" + e.text + "\"";
  const bool is_bool = builder_.type_of(*place) == ir::kBoolType;
  const bool modified = e.negated || e.negated_out || e.edge != Edge::kNone || e.edge_out != Edge::kNone ||
                        e.storage != Storage::kNone || e.storage_out != Storage::kNone;
  if (modified && !is_bool) {
    report(Code::P3023, node,
           what + " has a modifier but type " + builder_.module().types.name_of(builder_.type_of(*place)),
           "negation, edges and storage need BOOL");
    return publish_poison(out);
  }
  if (writes) {
    ir::LabelId skip;
    if (in.executed.valid()) {
      skip = builder_.new_label();
      builder_.jump_if_not(in.executed, skip);
    }
    if (modified) {
      if (const auto value = builder_.convert(in.operand, ir::kBoolType, what)) {
        write_bool(*place, modify(*value, e.negated, e.edge, Storage::kNone, e.text), e.storage);
      }
    } else {
      builder_.assign(*place, in.operand, what);
    }
    if (skip.valid()) builder_.bind(skip);
    note_write(*place, node, false);
  }
  builder_.probe(key_of(node), *place);
  if (!has_reader(out)) return;
  const ValueId value = builder_.load(*place);
  publish(out, is_bool ? modify(value, e.negated_out, e.edge_out, e.storage_out, e.text) : value);
}

void Drawing::lower_passage(NodeId node) {
  const OutRef out{OutRef::Kind::kFlow, 0, node};
  const auto own = inputs(node);
  const Incoming in = own.empty() ? Incoming{} : read(own[0]);
  // A continuation without connector was reported when the drawing was read.
  if (in.state == Incoming::State::kUnconnected && element(node).kind == ElementKind::kConnector) {
    report(Code::P3014, node, "connector \"" + element(node).text + "\" is not connected",
           "wire its input, or delete it with its continuations");
  }
  if (!in.is_value()) return publish_poison(out);
  if (in.operand.kind == Operand::Kind::kValue) return publish(out, in.operand.value, in.executed);
  publish(out, in.operand);
}

bool Drawing::refuse_modifiers(NodeId node) {
  const Element& e = element(node);
  if (!e.negated && e.edge == Edge::kNone && e.storage == Storage::kNone) return false;
  const std::string_view word = core::element_word(e.kind);
  report(Code::P3014, node, std::string(word) + " has a negation, an edge or a storage, and is not connected",
         "wire it, or delete what is modified: a " + std::string(word) + " without a wire is always taken");
  return true;
}

void Drawing::lower_jump(NodeId node) {
  const Element& e = element(node);
  const auto own = inputs(node);
  const auto [it, fresh] = labels_.try_emplace(e.text);
  if (fresh) {
    it->second.label = builder_.new_label();
    it->second.first_jump = node;
  }
  if (own.empty() || own[0].wire_count == 0) {
    if (refuse_modifiers(node)) return;
    builder_.probe_reached(key_of(node));
    return builder_.jump(it->second.label);
  }
  if (const auto flow = read_bool(own[0], node)) {
    const ValueId condition = modify(*flow, e.negated, e.edge, e.storage, "jump");
    builder_.probe(key_of(node), condition);
    builder_.jump_if(condition, it->second.label);
  }
}

void Drawing::lower_label(NodeId node) {
  const Element& e = element(node);
  const auto [it, fresh] = labels_.try_emplace(e.text);
  if (fresh) {
    it->second.label = builder_.new_label();
    it->second.first_jump = node;
  }
  if (it->second.bound) {
    return report(Code::P3015, node, "label \"" + e.text + "\" is drawn twice in this body",
                  "give each label a name of its own");
  }
  it->second.bound = true;
  builder_.bind(it->second.label);
}

void Drawing::lower_return(NodeId node) {
  const auto own = inputs(node);
  if (own.empty() || own[0].wire_count == 0) {
    if (refuse_modifiers(node)) return;
    builder_.probe_reached(key_of(node));
    return builder_.ret();
  }
  const auto flow = read_bool(own[0], node);
  if (!flow) return;
  const plcopen::Element& e = element(node);
  const ValueId condition = modify(*flow, e.negated, e.edge, e.storage, "return");
  builder_.probe(key_of(node), condition);
  const ir::LabelId skip = builder_.new_label();
  builder_.jump_if_not(condition, skip);
  builder_.ret();
  builder_.bind(skip);
}

}  // namespace plc::fbd
