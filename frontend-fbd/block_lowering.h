// BlockLowering: one block of a drawn body while it is lowered; EN and ENO around it, its pins, its instance.
//
// In: a node of the drawing. Out: instructions, and what the block's outputs carry. lower_block.cpp: what the block is;
// lower_function.cpp: functions of all kinds, DELAY. Does not belong here: order, wires (drawing.h).
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.h"
#include "frontend-fbd/drawing.h"
#include "frontend-fbd/ports.h"
#include "frontend-st/text.h"
#include "ir/generic.h"
#include "ir/queues.h"
#include "ir/reach.h"
#include "stdlib/specials.h"

namespace plc::fbd {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::ValueId;
using plcopen::Edge;
using plcopen::Element;
using plcopen::Storage;
using stdlib::Direction;

/// One block while it is lowered.
struct BlockLowering {
  Drawing& d;
  NodeId node;
  const Element& e;
  ir::Builder& b;
  std::optional<ValueId> enable{};   ///< EN, when wired
  ir::LabelId skip{};                ///< after the body, when EN is wired
  bool watch_events = false;         ///< ENO depends on events
  PlaceId eno_place{};               ///< ENO across the skipped body
  std::optional<ValueId> own_eno{};  ///< ENO as the block declares and sets it itself
  /// Where readers after the body find what it computed, with initial values: skipped, each gets its default.
  std::vector<std::pair<PlaceId, std::vector<ir::InitItem>>> defaulted{};
  std::vector<std::pair<std::uint16_t, ValueId>> values{};  ///< of a function, by output pin
  std::vector<std::pair<std::uint16_t, PlaceId>> places{};  ///< the same, where they lie in memory

  BlockLowering(Drawing& drawing, NodeId n) : d(drawing), node(n), e(drawing.element(n)), b(drawing.builder_) {}

  [[nodiscard]] std::string title() const {
    return e.instance_name.empty() ? e.text : e.text + " \"" + e.instance_name + "\"";
  }

  // ---- EN and ENO ----

  /// Reads EN, also that of a closed branch. False when its wire is poisoned.
  bool read_enable() {
    for (const Input& input : d.inputs(node)) {
      if (!is_enable_name(input.pin->name)) continue;
      const Incoming in = d.read(input);
      if (in.state == Incoming::State::kPoison) return false;
      if (!in.is_value()) continue;  // unconnected EN is TRUE
      const auto value = b.convert(in.operand, ir::kBoolType, "input \"EN\" of " + title());
      if (!value) return false;
      enable = enable ? b.logic(ir::Op::kAnd, *enable, *value) : *value;
    }
    return true;
  }

  /// Opens the part that EN guards. `may_event`: ENO also turns FALSE on an event inside.
  void open(bool may_event) {
    watch_events = may_event && d.has_reader(eno());
    if (watch_events) {
      eno_place = b.variable(b.hidden("eno." + std::to_string(e.at.local_id), ir::kBoolType));
      b.store(eno_place, b.constant_bool(false));
    }
    if (enable) {
      skip = b.new_label();
      b.jump_if_not(*enable, skip);
    }
    if (watch_events) b.clear_event();
  }

  void close() {
    if (watch_events) b.store(eno_place, b.eno());
    if (!skip.valid()) return;
    if (defaulted.empty()) return b.bind(skip);
    const ir::LabelId done = b.new_label();
    b.jump(done);
    b.bind(skip);
    for (auto& [place, initial] : defaulted) b.store_default(place, std::move(initial));
    b.bind(done);
  }

  void publish_eno() {
    if (!d.has_reader(eno())) return;
    ValueId value = watch_events ? b.load(eno_place) : enable ? *enable : b.constant_bool(true);
    if (own_eno) value = enable ? b.logic(ir::Op::kAnd, *enable, *own_eno) : *own_eno;
    const auto drawn =
        std::find_if(e.outputs.begin(), e.outputs.end(), [](const auto& pin) { return is_eno_name(pin.name); });
    if (drawn != e.outputs.end()) value = modified(*drawn, value);
    d.publish(eno(), value);
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (is_eno_name(e.outputs[i].name)) d.publish({OutRef::Kind::kPin, i, node}, value);
    }
  }

  static bool has_modifiers(const plcopen::Pin& p) {
    return p.negated || p.edge != Edge::kNone || p.storage != Storage::kNone;
  }

  /// A BOOL with the modifiers of its pin.
  ValueId modified(const plcopen::Pin& p, ValueId value) {
    return has_modifiers(p) ? d.modify(value, p.negated, p.edge, p.storage, p.name) : value;
  }

  [[nodiscard]] OutRef eno() const { return {OutRef::Kind::kEno, 0, node}; }

  void poison() {
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) d.publish_poison({OutRef::Kind::kPin, i, node});
    for (std::uint16_t i = 0; i < e.in_outs.size(); ++i) d.publish_poison({OutRef::Kind::kInOut, i, node});
    d.publish_poison(eno());
  }

  /// False, and reported, when output `pin` has modifiers and `value` is not BOOL.
  bool modifiers_fit(std::uint16_t pin, ValueId value) {
    const plcopen::Pin& p = e.outputs[pin];
    if (!has_modifiers(p) || b.type_of(value) == ir::kBoolType) return true;
    b.report(Code::P3023, e.at,
             "output \"" + p.name + "\" of " + title() + " has a modifier but type " +
                 b.module().types.name_of(b.type_of(value)),
             "negation, edges and storage need BOOL");
    return false;
  }

  /// Publishes output `pin`, its modifiers applied. `executed` = EN, so that outVariables keep their values.
  void publish_output(std::uint16_t pin, ValueId value) {
    if (!modifiers_fit(pin, value)) return d.publish_poison({OutRef::Kind::kPin, pin, node});
    d.publish({OutRef::Kind::kPin, pin, node}, modified(e.outputs[pin], value), enable.value_or(ValueId{}));
  }

  [[nodiscard]] bool output_wanted(std::uint16_t pin) const {
    const plcopen::Pin& p = e.outputs[pin];
    return !is_eno_name(p.name) &&
           (d.has_reader({OutRef::Kind::kPin, pin, node}) || p.edge != Edge::kNone || p.storage != Storage::kNone);
  }

  /// The place where readers find output `pin` of a function: its value, or the default where EN was FALSE.
  PlaceId place_of_output(std::uint16_t pin, const std::string& name, ir::TypeRef type,
                          std::vector<ir::InitItem> initial = {}) {
    const PlaceId place = b.variable(b.hidden("out." + std::to_string(e.at.local_id) + "." + name, type));
    defaulted.emplace_back(place, std::move(initial));
    places.emplace_back(pin, place);
    return place;
  }

  /// A function's value for output `pin`, computed inside the guarded part.
  void take(std::uint16_t pin, ValueId value, std::vector<ir::InitItem> initial = {}) {
    if (!enable) return values.emplace_back(pin, value), void();
    const PlaceId place = place_of_output(pin, e.outputs[pin].name, b.type_of(value), std::move(initial));
    b.assign(place, Operand::of(value, e.at), "output of " + title());
  }

  void publish_taken() {
    for (const auto& [pin, value] : values) publish_output(pin, value);
    for (const auto& [pin, place] : places) publish_output(pin, b.load(place));
  }

  // ---- function blocks ----

  /// `action`: runs this action of the instance instead of its body.
  void lower_instance(PlaceId instance, std::uint32_t action = ir::Pou::kDeclared) {
    const auto ports = ports_of(b.module(), b.type_of(instance));
    struct Assignment {
      const Port* port;
      const plcopen::Pin* pin;
      Incoming in;
    };
    std::vector<Assignment> assignments;
    std::vector<std::pair<const Port*, PlaceId>> in_outs;
    std::size_t position = 0;
    bool good = read_enable();
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      const Port* port = named_in_out(ports, input);
      if (port == nullptr) port = input_port(ports, input, position++);
      if (port == nullptr) {
        good = false;
      } else if (port->direction == Direction::kInOut) {
        if (const auto place = in_out_place(input, *port)) {
          in_outs.emplace_back(port, *place);
        } else {
          good = false;
        }
      } else {
        Incoming in = d.read(input);
        if (in.is_value()) assignments.push_back({port, input.pin, std::move(in)});
      }
    }
    const bool whole = action == ir::Pou::kDeclared;
    // What an action does not get is as the last call of the instance left it.
    good = (!whole || all_in_outs_wired(ports, in_outs)) && good;
    for (const auto& [port, place] : in_outs) {
      if (port->queue) good = ir::connect_queue(b, instance, port->index, place, e.at, name_of(*port)) && good;
    }
    if (!good) return poison();

    // A declared EN is an input: the body looks at it, and sets ENO.
    const Port* const own_en = declared_enable(ports);
    const Port* const eno_port = declared_eno(ports);
    if (own_en == nullptr) open(false);
    if (own_en != nullptr) b.store(b.field(instance, own_en->index), enable ? *enable : b.constant_bool(true));
    for (const auto& [port, place] : in_outs) {
      if (!port->queue) b.store(b.field(instance, port->index), b.make_ref(place));
    }
    for (const Assignment& a : assignments) {
      b.assign_input(instance, a.port->index, a.in.operand,
                     "input \"" + std::string(a.port->name) + "\" of " + title());
    }
    whole ? b.run(instance) : b.run_action(instance, action);
    if (eno_port != nullptr) defaulted.emplace_back(b.field(instance, eno_port->index), std::vector<ir::InitItem>{});
    close();
    if (eno_port != nullptr) own_eno = b.load(b.field(instance, eno_port->index));

    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (!output_wanted(i)) {
        probe_unwired(ports, instance, i);
        continue;
      }
      const Port* port = find_port(ports, Direction::kInOut, e.outputs[i].name, ports.size());
      if (port == nullptr) port = output_port(ports, i);
      if (port != nullptr) warn_of_place(*port, e.outputs[i], "output");
      if (port == nullptr) {
        d.publish_poison({OutRef::Kind::kPin, i, node});
      } else if (port->direction == Direction::kInOut) {
        publish_output(i, b.load(wired_to(in_outs, port)));
      } else {
        publish_output(i, b.load(b.field(instance, port->index)));
      }
    }
    publish_in_outs(ports, in_outs);
    publish_eno();
  }

  /// What an output has that no wire leads from is in the instance all the same.
  void probe_unwired(const std::vector<Port>& ports, PlaceId instance, std::uint16_t pin) {
    const plcopen::Pin& drawn = e.outputs[pin];
    if (!b.notes_probes() || is_eno_name(drawn.name)) return;
    const Port* const port = find_port(ports, Direction::kOutput, drawn.name, output_position(e, pin));
    if (port == nullptr || drawn.negated) return;
    b.probe(d.key_of(OutRef{OutRef::Kind::kPin, pin, node}), b.field(instance, port->index));
  }

  /// The input port of a drawn pin. Nothing, and reported, when its place is beyond the last one or another pin has it.
  const Port* input_port(const std::vector<Port>& ports, const Input& input, std::size_t position) {
    const plcopen::Pin& pin = *input.pin;
    const Port* port = find_port(ports, Direction::kInput, pin.name, position);
    const bool named = port != nullptr && is_named(*port, pin.name);
    const auto drawn = std::find_if(e.inputs.begin(), e.inputs.end(), [&](const auto& p) { return &p == &pin; });
    const bool taken = port != nullptr && std::any_of(e.inputs.begin(), named ? drawn : e.inputs.end(),
                                                      [&](const auto& p) { return is_named(*port, p.name); });
    if (taken && named) {
      b.report(Code::P3011, pin.at, "input \"" + pin.name + "\" of " + title() + " is drawn twice",
               "delete one of the pins");
      return nullptr;
    }
    if (port == nullptr || taken) {
      b.report(Code::P3011, pin.at, title() + " has no input \"" + pin.name + "\"",
               "inputs are " + list(ports, Direction::kInput));
      return nullptr;
    }
    if (input.wire_count > 0 || !pin.expression.empty()) warn_of_place(*port, pin, "input");
    return port;
  }

  /// The output port of a drawn pin. Nothing, and reported, when its place is beyond the last one or another pin has
  /// it.
  const Port* output_port(const std::vector<Port>& ports, std::uint16_t pin) {
    const plcopen::Pin& drawn = e.outputs[pin];
    const Port* port = find_port(ports, Direction::kOutput, drawn.name, output_position(e, pin));
    const bool taken =
        port != nullptr && !drawn.name.empty() && !is_named(*port, drawn.name) &&
        std::any_of(e.outputs.begin(), e.outputs.end(), [&](const auto& p) { return is_named(*port, p.name); });
    if (taken) port = nullptr;
    if (port == nullptr) {
      b.report(Code::P3011, drawn.at, title() + " has no output \"" + drawn.name + "\"",
               "outputs are " + list(ports, Direction::kOutput));
    }
    return port;
  }

  void warn_of_place(const Port& port, const plcopen::Pin& pin, const std::string& what) {
    if (pin.name.empty() || is_named(port, pin.name)) return;
    b.report(Code::P3025, pin.at,
             title() + " has no " + what + " \"" + pin.name + "\"; by its place it is read as \"" +
                 std::string(port.name) + "\"",
             "the block was changed after it was drawn, or the name is mistyped: correct the pin");
  }

  [[nodiscard]] const Port* named_in_out(const std::vector<Port>& ports, const Input& input) const {
    for (const Port& port : ports) {
      if (port.direction == Direction::kInOut && core::iequals(port.name, input.pin->name)) return &port;
    }
    const bool drawn_as_in_out = input.pin >= e.in_outs.data() && input.pin < e.in_outs.data() + e.in_outs.size();
    if (!drawn_as_in_out) return nullptr;
    return find_port(ports, Direction::kInOut, {}, static_cast<std::size_t>(input.pin - e.in_outs.data()));
  }

  [[nodiscard]] std::string name_of(const Port& port) const {
    return "in-out \"" + std::string(port.name) + "\" of " + title();
  }

  /// The variable that is wired to an in-out, or is written at it. Nothing when there is none.
  std::optional<PlaceId> drawn_place(const Input& input, bool for_writing) {
    if (input.wire_count == 1) return d.place_of_source(d.graph().wires[input.first_wire].from, for_writing);
    if (input.wire_count != 0 || input.pin->expression.empty()) return std::nullopt;
    if (!for_writing && !st::is_variable_text(input.pin->expression)) return std::nullopt;
    return st::lower_place(input.pin->expression, input.pin->at, b, for_writing);
  }

  /// There are no references to constants.
  bool is_constant(PlaceId place) {
    const ir::Place& root = ir::root_of(b.body(), place);
    if (root.kind == ir::Place::Kind::kGlobal) return b.module().globals[root.index].variable.constant;
    if (root.kind != ir::Place::Kind::kInstance && root.kind != ir::Place::Kind::kFrame) return false;
    const ir::Variable& variable = b.pou().variables[root.index];
    return variable.constant || variable.step;
  }

  /// For an in-out that is only read: the variable itself where it is large, and a copy of what arrives elsewhere.
  std::optional<PlaceId> constant_place(const Input& input, const Port& port) {
    if (!b.module().types.rep_of(port.type) && !has_modifiers(*input.pin)) {
      const auto place = drawn_place(input, false);
      if (place && b.type_of(*place) == port.type && !b.is_part(*place) && !is_constant(*place)) return place;
    }
    const Incoming in = d.read(input);
    if (in.state == Incoming::State::kUnconnected) {
      b.report(Code::P3012, input.pin->at, name_of(port) + " is not wired", "wire it to a variable or a constant");
    }
    if (!in.is_value()) return std::nullopt;
    const PlaceId kept = b.variable(b.hidden("constant", port.type));
    return b.assign(kept, in.operand, name_of(port)) ? std::optional(kept) : std::nullopt;
  }

  std::optional<PlaceId> in_out_place(const Input& input, const Port& port) {
    if (port.constant) return constant_place(input, port);
    const std::string what = name_of(port);
    const bool at_pin = has_modifiers(*input.pin);
    if (at_pin || (input.wire_count == 1 && d.is_modified_variable(d.graph().wires[input.first_wire].from))) {
      b.report(Code::P3012, input.pin->at,
               what + (at_pin ? " has" : " is wired to a variable with") + " a negation, an edge or a storage",
               "an in-out is the variable itself: negate what is read from it");
      return std::nullopt;
    }
    const std::optional<PlaceId> place = drawn_place(input, true);
    if (!place) {
      b.report(Code::P3012, input.pin->at, what + " is not wired to a variable",
               "an in-out works on a variable of the caller: wire an inVariable or inOutVariable that names one");
      return std::nullopt;
    }
    if (b.is_part(*place)) {
      b.report(Code::P3012, input.pin->at, what + " is wired to a part of a variable",
               "copy the part to a variable of its own");
      return std::nullopt;
    }
    if (port.queue) return place;  // its own check follows
    if (b.type_of(*place) != port.type) {
      b.report(Code::P3007, input.pin->at,
               what + " has type " + b.module().types.name_of(port.type) + ", the variable wired to it has type " +
                   b.module().types.name_of(b.type_of(*place)),
               "an in-out needs a variable of exactly its type");
      return std::nullopt;
    }
    return place;
  }

  bool all_in_outs_wired(const std::vector<Port>& ports, const std::vector<std::pair<const Port*, PlaceId>>& wired) {
    bool good = true;
    for (const Port& port : ports) {
      if (port.direction != Direction::kInOut) continue;
      if (std::any_of(wired.begin(), wired.end(), [&](const auto& w) { return w.first == &port; })) continue;
      if (std::any_of(d.inputs(node).begin(), d.inputs(node).end(),
                      [&](const Input& input) { return named_in_out(ports, input) == &port; })) {
        continue;  // drawn and reported already
      }
      b.report(Code::P3012, e.at, "in-out \"" + std::string(port.name) + "\" of " + title() + " is not drawn",
               "wire it to a variable of type " + b.module().types.name_of(port.type));
      good = false;
    }
    return good;
  }

  static PlaceId wired_to(const std::vector<std::pair<const Port*, PlaceId>>& wired, const Port* port) {
    for (const auto& [p, place] : wired) {
      if (p == port) return place;
    }
    return {};
  }

  void publish_in_outs(const std::vector<Port>& ports, const std::vector<std::pair<const Port*, PlaceId>>& wired) {
    for (std::uint16_t i = 0; i < e.in_outs.size(); ++i) {
      const OutRef out{OutRef::Kind::kInOut, i, node};
      if (!d.has_reader(out)) continue;
      const Port* port = find_port(ports, Direction::kInOut, e.in_outs[i].name, i);
      const PlaceId place = wired_to(wired, port);
      if (place.valid() && port->queue) continue;  // who reads the right side finds the queue on the left
      if (place.valid()) {
        d.publish(out, b.load(place), enable.value_or(ValueId{}));
      } else {
        d.publish_poison(out);
      }
    }
  }

  static std::string list(const std::vector<Port>& ports, Direction direction) {
    std::string out;
    for (const Port& port : ports) {
      if (port.direction != direction) continue;
      out += (out.empty() ? "" : ", ") + std::string(port.name);
    }
    return out.empty() ? "none" : out;
  }

  // ---- functions (lower_function.cpp) ----

  /// The function made from a generic one for the arrays that are wired to it. Nothing, and reported, when they do not
  /// fit.
  std::optional<std::uint32_t> function_for(std::uint32_t pou_index);
  /// LOWER_BOUND and UPPER_BOUND: an array and the number of a dimension.
  void lower_array_bound(ir::ArrayBound bound);
  /// QUEUE_PUT and its like: the function made for the queue that is wired to QUEUE.
  void lower_queue_function(ir::QueueFunction function);
  void lower_function_pou(std::uint32_t pou_index);
  /// SPLIT_DATE and its like: the input once, then one function of it for each output that is read.
  void lower_bundle(const stdlib::BundleSpec& bundle);
  /// DELAY: a register. It shows what entered last before this scan, to readers before it (feedback wires) as to
  /// those after it, and whether EN is TRUE or not.
  void lower_delay();
  void lower_standard_function();
  /// True when the function gives a BOOL for these operands.
  bool is_power(std::span<const stdlib::Overload> candidates, const std::vector<Operand>& operands);
  /// Drawn pins go to the parameters they name, the others to those that are left, in the order of the drawing. False,
  /// and reported, when two pins have one name.
  bool place_by_name(const stdlib::FunctionSpec& spec, std::vector<std::pair<std::size_t, const Input*>>& order);

  // ---- EXECUTE boxes, and what the block is (lower_block.cpp) ----

  void lower_execute();
  void lower();
  void lower_block_instance();
  void lower_named(const NamedCall& call);
  void missing();
};

}  // namespace plc::fbd
