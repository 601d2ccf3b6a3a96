// Blocks of a drawn body: standard functions, functions and function blocks of the project, standard function blocks,
// EXECUTE boxes; EN and ENO around all of them.
#include <algorithm>
#include <string>
#include <utility>

#include "core/text.h"
#include "frontend-fbd/drawing.h"
#include "frontend-fbd/ports.h"
#include "frontend-st/text.h"
#include "ir/generic.h"
#include "ir/queues.h"
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
  std::optional<ValueId> enable{};  ///< EN, when wired
  ir::LabelId skip{};               ///< behind the body, when EN is wired
  bool watch_events = false;        ///< ENO depends on events
  PlaceId eno_place{};              ///< ENO across the skipped body

  BlockLowering(Drawing& drawing, NodeId n) : d(drawing), node(n), e(drawing.element(n)), b(drawing.builder_) {}

  [[nodiscard]] std::string title() const {
    return e.instance_name.empty() ? e.text : e.text + " \"" + e.instance_name + "\"";
  }

  // ---- EN and ENO ----

  /// Reads EN. False when its wire is poisoned.
  bool read_enable() {
    for (const Input& input : d.inputs(node)) {
      if (!is_enable_name(input.pin->name)) continue;
      const Incoming in = d.read(input);
      if (in.state == Incoming::State::kPoison) return false;
      if (!in.is_value()) continue;  // unconnected EN is TRUE
      const auto value = b.convert(in.operand, ir::kBoolType, "input \"EN\" of " + title());
      if (!value) return false;
      enable = *value;
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
    if (skip.valid()) b.bind(skip);
  }

  void publish_eno() {
    if (!d.has_reader(eno())) return;
    const ValueId value = watch_events ? b.load(eno_place) : enable ? *enable : b.constant_bool(true);
    d.publish(eno(), value);
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (is_eno_name(e.outputs[i].name)) d.publish({OutRef::Kind::kPin, i, node}, value);
    }
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
    const bool modified = p.negated || p.edge != Edge::kNone || p.storage != Storage::kNone;
    if (!modified || b.type_of(value) == ir::kBoolType) return true;
    b.report(Code::P3023, e.at,
             "output \"" + p.name + "\" of " + title() + " has a modifier but type " +
                 b.module().types.name_of(b.type_of(value)),
             "negation, edges and storage need BOOL");
    return false;
  }

  /// Publishes output `pin`, its modifiers applied. `executed` = EN, so that outVariables keep their values.
  void publish_output(std::uint16_t pin, ValueId value) {
    const plcopen::Pin& p = e.outputs[pin];
    if (p.negated || p.edge != Edge::kNone || p.storage != Storage::kNone) {
      if (!modifiers_fit(pin, value)) return d.publish_poison({OutRef::Kind::kPin, pin, node});
      value = d.modify(value, p.negated, p.edge, p.storage, p.name);
    }
    d.publish({OutRef::Kind::kPin, pin, node}, value, enable.value_or(ValueId{}));
  }

  [[nodiscard]] bool output_wanted(std::uint16_t pin) const {
    const plcopen::Pin& p = e.outputs[pin];
    return !is_eno_name(p.name) &&
           (d.has_reader({OutRef::Kind::kPin, pin, node}) || p.edge != Edge::kNone || p.storage != Storage::kNone);
  }

  /// A value computed inside the guarded part as seen behind it: with EN it lives in memory and keeps while EN is
  /// FALSE.
  PlaceId keep(ValueId value, std::string_view pin) {
    const PlaceId place =
        b.variable(b.hidden("kept." + std::to_string(e.at.local_id) + "." + std::string(pin), b.type_of(value)));
    b.assign(place, Operand::of(value, e.at), "output of " + title());
    return place;
  }

  // ---- function blocks ----

  void lower_instance(PlaceId instance) {
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
    good = all_in_outs_wired(ports, in_outs) && good;
    for (const auto& [port, place] : in_outs) {
      if (port->queue) good = ir::connect_queue(b, instance, port->index, place, e.at, name_of(*port)) && good;
    }
    if (!good) return poison();

    open(false);
    for (const auto& [port, place] : in_outs) {
      if (!port->queue) b.store(b.field(instance, port->index), b.make_ref(place));
    }
    for (const Assignment& a : assignments) {
      b.assign_input(instance, a.port->index, a.in.operand,
                     "input \"" + std::string(a.port->name) + "\" of " + title());
    }
    b.run(instance);
    close();

    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (!output_wanted(i)) continue;
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
    if (input.wire_count > 0) warn_of_place(*port, pin, "input");
    return port;
  }

  /// The output port of a drawn pin. Nothing, and reported, when its place is beyond the last one.
  const Port* output_port(const std::vector<Port>& ports, std::uint16_t pin) {
    const plcopen::Pin& drawn = e.outputs[pin];
    const Port* port = find_port(ports, Direction::kOutput, drawn.name, output_position(e, pin));
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

  std::optional<PlaceId> in_out_place(const Input& input, const Port& port) {
    const std::string what = name_of(port);
    std::optional<PlaceId> place;
    if (input.wire_count == 1) place = d.place_behind(d.graph().wires[input.first_wire].from);
    if (input.wire_count == 0 && !input.pin->expression.empty()) {
      place = st::lower_place(input.pin->expression, input.pin->at, b, true);
    }
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

  // ---- functions ----

  /// The function made from a generic one for the arrays that are wired to it. Nothing, and reported, when they do not
  /// fit.
  std::optional<std::uint32_t> function_for(std::uint32_t pou_index) {
    const auto ports = ports_of_function(b.module(), b.module().pous[pou_index]);
    std::vector<ir::OpenArgument> open;
    std::size_t position = 0;
    std::size_t wanted = 0;
    for (const Port& port : ports) wanted += b.module().types[port.type].open ? 1 : 0;
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      const Port* port = named_in_out(ports, input);
      if (port == nullptr) port = find_port(ports, Direction::kInput, input.pin->name, position++);
      if (port == nullptr || !b.module().types[port->type].open) continue;
      const Incoming in = d.read(input);
      if (in.state == Incoming::State::kPoison) return std::nullopt;
      if (!in.is_value() || in.operand.kind != Operand::Kind::kValue) continue;
      const ir::TypeRef type = b.type_of(in.operand.value);
      if (!ir::fits_open(b.module().types, port->type, type)) {
        b.report(Code::P3007, input.pin->at,
                 "\"" + std::string(port->name) + "\" of " + title() + " has type " +
                     b.module().types.name_of(port->type) + ", what is wired to it has type " +
                     b.module().types.name_of(type),
                 "the elements and the number of dimensions are those of the declaration");
        return std::nullopt;
      }
      open.push_back({port->index, type});
    }
    if (open.size() != wanted) {
      b.report(Code::P3010, e.at, title() + " has inputs ARRAY [*] that are not wired to an array",
               "an ARRAY [*] has no value of its own: wire it");
      return std::nullopt;
    }
    std::sort(open.begin(), open.end(), [](const auto& x, const auto& y) { return x.variable < y.variable; });
    const auto made = ir::specialize(b.module(), pou_index, open);
    if (!made) b.report(Code::P5001, e.at, title() + " " + std::string(ir::kTooManyMade));
    return made;
  }

  /// LOWER_BOUND and UPPER_BOUND: an array and the number of a dimension.
  void lower_array_bound(ir::ArrayBound bound) {
    std::vector<Incoming> in;
    bool good = read_enable();
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      in.push_back(d.read(input));
      good = good && in.back().is_value();
    }
    if (good && (in.size() != 2 || in[0].operand.kind != Operand::Kind::kValue)) {
      b.report(Code::P3010, e.at, title() + " needs an array and the number of a dimension",
               "wire ARR to an array variable and DIM to a number");
      good = false;
    }
    std::optional<Operand> result;
    if (good) result = ir::array_bound(b, bound, b.type_of(in[0].operand.value), in[1].operand, e.at);
    if (!result) return poison();
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (!output_wanted(i)) continue;
      const auto value = b.settle(*result, d.expected_type({OutRef::Kind::kPin, i, node}));
      if (!value) return poison();
      publish_output(i, *value);
    }
    publish_eno();
  }

  /// QUEUE_PUT and its like: the function made for the queue that is wired to QUEUE.
  void lower_queue_function(ir::QueueFunction function) {
    Port queue{"QUEUE", {}, Direction::kInOut, 0, {}, true};
    std::optional<PlaceId> place;
    for (const Input& input : d.inputs(node)) {
      if (!is_named(queue, input.pin->name)) continue;
      place = in_out_place(input, queue);
      if (!place) return poison();
    }
    if (!place) {
      b.report(Code::P3012, e.at, name_of(queue) + " is not drawn", "wire it to the global array that is the queue");
      return poison();
    }
    const auto made = ir::queue_function(b, function, *place, e.at, name_of(queue));
    if (!made) return poison();
    lower_function_pou(*made);
  }

  void lower_function_pou(std::uint32_t pou_index) {
    if (b.module().pous[pou_index].generic) {
      const auto made = function_for(pou_index);
      if (!made) return poison();
      pou_index = *made;
    }
    const ir::Pou& callee = b.module().pous[pou_index];
    if (!callee.refused.empty()) return poison();  // its pins are not all known
    const auto ports = ports_of_function(b.module(), callee);
    std::vector<ir::CallArg> args;
    std::vector<std::pair<const Port*, PlaceId>> in_outs;
    struct Waiting {
      const Port* port;
      Incoming in;
    };
    std::vector<Waiting> waiting;
    bool good = read_enable();
    std::size_t position = 0;
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      const Port* port = named_in_out(ports, input);
      if (port == nullptr) port = input_port(ports, input, position++);
      if (port == nullptr) {
        good = false;
      } else if (port->direction == Direction::kInOut) {
        const auto place = in_out_place(input, *port);
        if (place) in_outs.emplace_back(port, *place);
        good = good && place.has_value();
      } else {
        Incoming in = d.read(input);
        good = good && in.state != Incoming::State::kPoison;
        if (in.is_value()) waiting.push_back({port, std::move(in)});  // an unconnected pin takes its default
      }
    }
    good = all_in_outs_wired(ports, in_outs) && good;
    if (!good) return poison();

    open(true);
    for (const Waiting& w : waiting) {
      const auto value =
          b.convert(w.in.operand, w.port->type, "input \"" + std::string(w.port->name) + "\" of " + title());
      if (!value) good = false;
      if (value) args.push_back({ir::CallArg::Kind::kInput, w.port->index, *value, {}});
    }
    for (const auto& [port, place] : in_outs) {
      if (!port->queue) args.push_back({ir::CallArg::Kind::kInOut, port->index, b.make_ref(place), {}});
    }
    std::vector<std::pair<std::uint16_t, PlaceId>> outputs;
    std::optional<std::uint16_t> result_pin;
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (!output_wanted(i)) continue;
      const Port* port = output_port(ports, i);
      if (port == nullptr) {
        good = false;
      } else if (callee.variables[port->index].role == ir::Role::kReturnValue) {
        result_pin = i;  // editors call it OUT, or nothing
      } else {
        warn_of_place(*port, e.outputs[i], "output");
        const PlaceId place =
            b.variable(b.hidden("out." + std::to_string(e.at.local_id) + "." + std::string(port->name), port->type));
        args.push_back({ir::CallArg::Kind::kOutput, port->index, {}, place});
        outputs.emplace_back(i, place);
      }
    }
    ValueId result = b.call_pou(pou_index, args);
    if (result_pin && result.valid() && enable) outputs.emplace_back(*result_pin, keep(result, callee.name));
    close();
    if (!good) return poison();
    if (result_pin && result.valid() && !enable) publish_output(*result_pin, result);
    for (const auto& [pin, place] : outputs) publish_output(pin, b.load(place));
    publish_in_outs(ports, in_outs);
    publish_eno();
  }

  /// SPLIT_DATE and its like: the input once, then one function of it for each output that is read.
  void lower_bundle(const stdlib::BundleSpec& bundle) {
    const auto ports = ports_of_bundle(bundle);
    bool good = read_enable();
    std::optional<Operand> given;
    std::size_t position = 0;
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      if (input_port(ports, input, position++) == nullptr) {
        good = false;
        continue;
      }
      Incoming in = d.read(input);
      good = good && in.state != Incoming::State::kPoison;
      if (in.is_value()) given = std::move(in.operand);
    }
    const std::string in_name = "input \"" + std::string(bundle.input.name) + "\" of " + title();
    if (good && !given) {
      b.report(Code::P3010, e.at, in_name + " is not connected",
               "a function needs all its inputs: wire it, or give it a constant");
      good = false;
    }
    if (!good) return poison();

    open(false);
    const auto value = b.convert(*given, ports[0].type, in_name);
    if (!value) {
      close();
      return poison();
    }
    const Operand argument = Operand::of(*value, e.at);
    std::vector<std::pair<std::uint16_t, ValueId>> results;
    std::vector<std::pair<std::uint16_t, PlaceId>> kept;
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (!output_wanted(i)) continue;
      const Port* port = output_port(ports, i);
      if (port == nullptr) {
        good = false;
        continue;
      }
      warn_of_place(*port, e.outputs[i], "output");
      const auto result = b.call(bundle.outputs[port->index]->name, std::span(&argument, 1), e.at);
      if (!result) {
        good = false;
      } else if (enable) {
        kept.emplace_back(i, keep(*result, port->name));
      } else {
        results.emplace_back(i, *result);
      }
    }
    close();
    if (!good) return poison();
    for (const auto& [pin, result] : results) publish_output(pin, result);
    for (const auto& [pin, place] : kept) publish_output(pin, b.load(place));
    publish_eno();
  }

  /// DELAY: a register. It shows what entered last before this scan, to readers in front of it (feedback wires) as to
  /// those behind it, and whether EN is TRUE or not.
  void lower_delay() {
    if (b.pou().kind == ir::PouKind::kFunction) {
      b.report(Code::P3026, e.at, "DELAY is drawn in a function", "functions keep nothing: make it a function block");
      return poison();
    }
    const std::vector<Port> ports = {{stdlib::kDrawnInput, {}, Direction::kInput, 0, {}},
                                     {stdlib::kDrawnOutput, {}, Direction::kOutput, 0, {}}};
    bool good = read_enable();
    std::optional<Incoming> in;
    std::size_t position = 0;
    for (const Input& input : d.inputs(node)) {
      if (is_enable_name(input.pin->name)) continue;
      if (input_port(ports, input, position++) == nullptr) {
        good = false;
      } else {
        in = d.read(input);
      }
    }
    std::optional<std::uint16_t> pin;
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (is_eno_name(e.outputs[i].name)) continue;
      good = output_port(ports, i) != nullptr && good;
      pin = i;
    }
    if (good && (!in || in->state == Incoming::State::kUnconnected)) {
      b.report(Code::P3010, e.at, "input of DELAY is not connected", "wire what it is to delay by one scan");
    }
    if (!good || !pin || !in || !in->is_value()) return poison();

    const OutRef out{OutRef::Kind::kPin, *pin, node};
    std::optional<ir::TypeRef> type = d.infer_type(out, 0);
    if (!type && in->operand.kind == Operand::Kind::kValue) type = b.type_of(in->operand.value);
    if (!type) {
      const auto literal = b.settle(in->operand);
      if (!literal) return poison();
      type = b.type_of(*literal);
    }
    const std::uint32_t kept = d.keep_for_feedback(out, *type);
    const PlaceId memory = b.variable(kept);
    const ValueId value = b.load(memory);
    if (!modifiers_fit(*pin, value)) return poison();
    // What modifies the output is done to what enters, so that feedback wires carry it: to the FALSE before the first
    // scan, too.
    const plcopen::Pin& p = e.outputs[*pin];
    if (p.negated) b.pou().variables[kept].initial = {{{}, {ir::kBoolType, 1, {}}}};
    open(false);
    if (b.type_of(value) == ir::kBoolType) {
      const auto flow = b.convert(in->operand, ir::kBoolType, "input of DELAY");
      good = flow.has_value();
      if (flow) b.store(memory, d.modify(*flow, p.negated, p.edge, p.storage, p.name));
    } else {
      good = b.assign(memory, in->operand, "input of DELAY");
    }
    close();
    if (!good) return poison();
    Drawing::Slot& slot = d.slots_[d.slot_index(out)];
    slot.value = value;
    slot.state = Drawing::Slot::State::kValue;
    publish_eno();
  }

  void lower_standard_function() {
    const auto candidates = stdlib::overloads_named(e.text);
    const stdlib::FunctionSpec& spec = *candidates[0].spec;
    std::vector<Operand> operands;
    std::vector<std::string> pins;
    bool good = read_enable();
    std::size_t drawn = 0;
    std::vector<std::pair<std::size_t, const Input*>> order;  // parameter position, input
    for (const Input& input : d.inputs(node)) {
      if (!is_enable_name(input.pin->name)) order.emplace_back(drawn++, &input);
    }
    place_by_name(spec, order);
    for (const auto& [position, input] : order) {
      Incoming in = d.read(*input);
      if (in.state == Incoming::State::kPoison) {
        good = false;
      } else if (in.is_value()) {
        operands.push_back(std::move(in.operand));
        pins.push_back(input->pin->name.empty() ? stdlib::pin_name(spec, position) : input->pin->name);
      } else if (!spec.extensible || order.size() <= spec.param_count) {
        b.report(Code::P3010, input->pin->at, "input \"" + input->pin->name + "\" of " + title() + " is not connected",
                 "a function needs all its inputs: wire it, or give it a constant");
        good = false;
      }  // else: an extensible function takes the pins that are wired
    }
    if (good && operands.size() < spec.param_count) {
      b.report(Code::P3010, e.at,
               title() + " needs " + std::to_string(spec.param_count) + " inputs, " + std::to_string(operands.size()) +
                   " are connected",
               "draw and wire the missing inputs");
      good = false;
    }
    if (!good) return poison();
    const bool may_event = std::any_of(candidates.begin(), candidates.end(),
                                       [](const stdlib::Overload& o) { return !o.spec->events.empty(); });
    std::optional<std::uint16_t> result_pin;
    for (std::uint16_t i = 0; i < e.outputs.size() && !result_pin; ++i) {
      if (!is_eno_name(e.outputs[i].name)) result_pin = i;
    }
    open(may_event);
    numbers_from_bool(operands, pins);
    const bool literals =
        std::any_of(operands.begin(), operands.end(), [](const Operand& o) { return o.kind != Operand::Kind::kValue; });
    const bool asks = result_pin && (literals || stdlib::result_is_open(spec));
    const auto expected = asks ? d.expected_type({OutRef::Kind::kPin, *result_pin, node}) : std::nullopt;
    const auto result = b.call(e.text, operands, e.at, expected, pins);
    std::optional<PlaceId> kept;
    if (result && enable && result_pin && output_wanted(*result_pin)) kept = keep(*result, "OUT");
    close();
    if (!result) return poison();
    if (result_pin) {
      if (kept) {
        publish_output(*result_pin, b.load(*kept));
      } else if (!enable) {
        publish_output(*result_pin, *result);
      }
    }
    publish_eno();
  }

  /// Drawn pins go to the parameters they name, if all names are known and different; else by position.
  static void place_by_name(const stdlib::FunctionSpec& spec,
                            std::vector<std::pair<std::size_t, const Input*>>& order) {
    if (order.size() > stdlib::kMaxArguments) return;  // refused by the call
    std::vector<std::pair<std::size_t, const Input*>> named;
    for (const auto& [position, input] : order) {
      for (std::size_t i = 0; i < order.size(); ++i) {
        if (!core::iequals(stdlib::pin_name(spec, i), input->pin->name)) continue;
        named.emplace_back(i, input);
        break;
      }
    }
    std::sort(named.begin(), named.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
    const bool distinct = std::adjacent_find(named.begin(), named.end(), [](const auto& x, const auto& y) {
                            return x.first == y.first;
                          }) == named.end();
    if (named.size() == order.size() && distinct) order = std::move(named);
  }

  /// Real projects wire BOOL into EQ, ADD and the like next to integers: FALSE counts as 0, TRUE as 1, with a warning.
  void numbers_from_bool(std::vector<Operand>& operands, const std::vector<std::string>& pins) {
    std::optional<core::TypeId> number;
    bool has_bool = false;
    for (const Operand& o : operands) {
      if (o.kind != Operand::Kind::kValue) continue;
      const auto type = b.module().types.elementary_of(b.type_of(o.value));
      if (type && core::in_category(*type, core::kAnyNum)) {
        if (!number || stdlib::widens(*number, *type)) number = type;
      }
      has_bool = has_bool || type == core::TypeId::kBool;
    }
    if (!number || !has_bool) return;
    std::vector<stdlib::Arg> args;
    for (const Operand& o : operands) {
      stdlib::Arg arg;
      if (o.kind == Operand::Kind::kValue) {
        const auto type = b.module().types.elementary_of(b.type_of(o.value));
        if (!type) return;
        arg.type = *type;
      } else {
        arg.kind =
            o.kind == Operand::Kind::kIntLiteral ? stdlib::Arg::Kind::kIntLiteral : stdlib::Arg::Kind::kRealLiteral;
        arg.int_value = o.int_value;
        arg.int_is_unsigned = o.int_is_unsigned;
      }
      args.push_back(arg);
    }
    if (stdlib::resolve(e.text, args).status != stdlib::Resolution::Status::kNoMatch) return;
    for (std::size_t i = 0; i < operands.size(); ++i) {
      if (operands[i].kind != Operand::Kind::kValue || b.type_of(operands[i].value) != ir::kBoolType) continue;
      const std::string conversion = "BOOL_TO_" + std::string(core::name_of(*number));
      const auto value = b.call(conversion, std::span(&operands[i], 1), e.at);
      if (!value) return;
      b.report(Code::P3019, e.at,
               "input \"" + pins[i] + "\" of " + title() + " is BOOL, other inputs are " +
                   std::string(core::name_of(*number)),
               "read as 0 and 1; draw a " + conversion + " block to say so");
      operands[i].value = *value;
    }
  }

  // ---- EXECUTE boxes ----

  void lower_execute() {
    if (!read_enable()) return poison();
    open(true);
    const bool good = st::lower_statements(e.code, e.code_at, b);
    close();
    if (!good) return poison();
    publish_eno();
    const ValueId value = d.has_reader(eno()) || !watch_events ? (watch_events ? b.load(eno_place)
                                                                  : enable     ? *enable
                                                                               : b.constant_bool(true))
                                                               : b.constant_bool(true);
    for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
      if (d.has_reader({OutRef::Kind::kPin, i, node})) d.publish({OutRef::Kind::kPin, i, node}, value);
    }
  }

  // ---- what the block is ----

  void lower() {
    if (e.has_code) return lower_execute();
    if (d.is_missing(e)) return missing();
    ir::Module& module = b.module();
    const auto pou = module.pou_by_name.find(e.text);
    const bool is_function = pou != module.pou_by_name.end() && module.pous[pou->second].kind == ir::PouKind::kFunction;
    const bool is_block = (pou != module.pou_by_name.end() && !is_function) || stdlib::block_named(e.text) != nullptr;
    if (is_function) return lower_function_pou(pou->second);
    if (is_block) return lower_block_instance();
    if (is_delay(e)) return lower_delay();
    if (const auto bound = ir::array_bound_named(e.text)) return lower_array_bound(*bound);
    if (const auto queue = ir::queue_function_named(e.text)) return lower_queue_function(*queue);
    if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(e.text)) return lower_bundle(*bundle);
    lower_standard_function();
  }

  void lower_block_instance() {
    if (e.instance_name.empty()) {
      b.report(Code::P3009, e.at, "function block " + e.text + " has no instance name",
               "declare a variable of type " + e.text + " and put its name above the block");
      return poison();
    }
    const auto instance = st::lower_place(e.instance_name, e.at, b, false);
    if (!instance) return poison();
    const auto wanted = b.module().types.find(e.text);
    const ir::TypeRef found = b.type_of(*instance);
    if (!wanted || *wanted != found) {
      if (b.module().types[found].stub) return poison();
      b.report(Code::P3024, e.at,
               "block is a " + e.text + ", but \"" + e.instance_name + "\" is declared as " +
                   b.module().types.name_of(found),
               "declare the instance with the type of the block");
      return poison();
    }
    const ir::Type& type = b.module().types[found];
    if (type.kind == ir::TypeKind::kPou && !b.module().pous[type.pou].refused.empty()) return poison();
    lower_instance(*instance);
  }

  void missing() {
    if (e.text.empty()) return poison();  // the reader said so
    const std::string supply =
        "it is neither in this file nor in the standard library: export it with the project, or load the library that "
        "has it";
    if (d.options_.stub_missing) {
      b.pou().partial = true;
      b.report(Code::P3020, e.at, "block " + title() + " is missing and replaced by a stub that does nothing", supply);
    } else {
      b.report(Code::P3008, e.at, "block " + title() + " is not known",
               supply + "; --stub-missing runs the rest without it");
    }
    poison();
  }
};

void Drawing::lower_block(NodeId node) { BlockLowering(*this, node).lower(); }

}  // namespace plc::fbd
