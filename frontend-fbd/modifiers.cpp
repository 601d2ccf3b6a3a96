// Negation, edges and storage of contacts, coils, variables and pins (docs/guides/execution-order.md, "Negation, edge,
// storage").
#include <string>

#include "frontend-fbd/drawing.h"

namespace plc::fbd {

using core::Code;
using ir::Op;
using ir::PlaceId;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Element;
using plcopen::Storage;

ValueId Drawing::edge_of(ValueId value, Edge edge, std::string_view hint) {
  if (edge == Edge::kNone) return value;
  // The memory starts FALSE: a rising edge can happen in the first scan, a falling one cannot, unless it is that of the
  // F_TRIG that Beremiz makes of it, which remembers the opposite (docs/guides/first-scan.md).
  const PlaceId memory = builder_.variable(builder_.hidden(std::string("edge.") + std::string(hint), ir::kBoolType));
  const bool trigger = edge == Edge::kFalling && options_.compat == core::Compat::kBeremiz;
  if (trigger) value = builder_.not_(value);
  const ValueId before = builder_.load(memory);
  const ValueId result = edge == Edge::kRising || trigger ? builder_.logic(Op::kAnd, value, builder_.not_(before))
                                                          : builder_.logic(Op::kAnd, builder_.not_(value), before);
  builder_.store(memory, value);
  return result;
}

ValueId Drawing::modify(ValueId value, bool negated, Edge edge, Storage storage, std::string_view hint) {
  if (negated) value = builder_.not_(value);
  if (!negated || options_.compat != core::Compat::kBeremiz) value = edge_of(value, edge, hint);
  if (storage == Storage::kNone) return value;
  const PlaceId latch = builder_.variable(builder_.hidden(std::string("latch.") + std::string(hint), ir::kBoolType));
  write_bool(latch, value, storage);
  return builder_.load(latch);
}

void Drawing::write_bool(PlaceId place, ValueId value, Storage storage) {
  switch (storage) {
    case Storage::kNone:
      builder_.store(place, value);
      return;
    case Storage::kSet:
      builder_.store(place, builder_.logic(Op::kOr, builder_.load(place), value));
      return;
    case Storage::kReset:
      builder_.store(place, builder_.logic(Op::kAnd, builder_.load(place), builder_.not_(value)));
      return;
  }
}

void Drawing::refuse_memory() {
  if (builder_.pou().kind != ir::PouKind::kFunction) return;
  for (NodeId n = 0; n < graph_.nodes.size(); ++n) {
    const Element& e = element(n);
    // What a coil or outVariable sets and resets is the variable itself.
    const bool writes = e.kind == core::ElementKind::kCoil || e.kind == core::ElementKind::kOutVariable ||
                        e.kind == core::ElementKind::kInOutVariable;
    const auto refuse = [&](Edge edge, Storage storage, const core::SourceRef& at, const std::string& what) {
      if (edge == Edge::kNone && storage == Storage::kNone) return;
      builder_.report(Code::P3026, at,
                      what + (edge != Edge::kNone ? " has an edge" : " has a storage") +
                          " and is drawn in a function, which keeps nothing from call to call",
                      "make it a function block");
    };
    const std::string own = std::string(core::element_word(e.kind)) + " \"" + e.text + "\"";
    refuse(e.edge, writes ? Storage::kNone : e.storage, e.at, own);
    refuse(e.edge_out, e.storage_out, e.at, own);
    for (const auto* pins : {&e.inputs, &e.outputs}) {
      for (const plcopen::Pin& pin : *pins) {
        refuse(pin.edge, pin.storage, pin.at, "pin \"" + pin.name + "\" of " + e.text);
      }
    }
  }
}

void Drawing::warn_of_edges() {
  const bool beremiz = options_.compat == core::Compat::kBeremiz;
  core::SourceRef falling;  // the first
  std::string first;
  std::size_t count = 0;
  const auto check = [&](bool negated, Edge edge, const core::SourceRef& at, const auto& what) {
    if (edge == Edge::kNone) return;
    if (edge == Edge::kFalling && !negated && count++ == 0) {
      falling = at;
      first = what();
    }
    if (!negated) return;
    const std::string rising = edge == Edge::kRising ? "rising" : "falling";
    builder_.report(
        Code::P3027, at, what() + " has negation and a " + rising + " edge",
        beremiz ? "the edge is left out, as Beremiz does; keep one of the two"
                : "taken as the " + rising + " edge of the negated value; other tools leave the edge out, or " +
                      "negate it: draw a " + (edge == Edge::kRising ? "falling" : "rising") + " edge without negation");
  };
  for (const Node& node : graph_.nodes) {
    const Element& e = *node.element;
    const auto own = [&] { return std::string(core::element_word(e.kind)) + " \"" + e.text + "\""; };
    check(e.negated, e.edge, e.at, own);
    check(e.negated_out, e.edge_out, e.at, own);
    const auto check_pins = [&](const std::vector<plcopen::Pin>& pins) {
      for (const plcopen::Pin& pin : pins) {
        check(pin.negated, pin.edge, pin.at, [&] {
          return "pin \"" + pin.name + "\" of " + e.text +
                 (e.instance_name.empty() ? "" : " \"" + e.instance_name + "\"");
        });
      }
    };
    check_pins(e.inputs);
    check_pins(e.outputs);
  }
  // The standard has such contacts: who wants nothing but the standard is not told.
  if (count == 0 || beremiz || options_.strict) return;
  builder_.report(Code::P3028, falling,
                  "falling edge of " + first + (count > 1 ? " and " + std::to_string(count - 1) + " more" : "") +
                      ": there is none in the first scan; OpenPLC and Beremiz have one where the value is FALSE then",
                  "--compat=beremiz has it, too");
}

}  // namespace plc::fbd
