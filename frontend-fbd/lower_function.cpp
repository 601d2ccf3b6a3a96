// Functions in drawings: standard ones, those of the project, of queues, with several outputs; array bounds; DELAY.
#include <charconv>

#include "frontend-fbd/block_lowering.h"

namespace plc::fbd {

std::optional<std::uint32_t> BlockLowering::function_for(std::uint32_t pou_index) {
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

void BlockLowering::lower_array_bound(ir::ArrayBound bound) {
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
  if (!good) return poison();
  open(false);
  const auto result = ir::array_bound(b, bound, b.type_of(in[0].operand.value), in[1].operand, e.at);
  for (std::uint16_t i = 0; result && good && i < e.outputs.size(); ++i) {
    if (!output_wanted(i)) continue;
    const auto value = b.settle(*result, d.expected_type({OutRef::Kind::kPin, i, node}));
    good = value.has_value();
    if (value) take(i, *value);
  }
  close();
  if (!result || !good) return poison();
  publish_taken();
  publish_eno();
}

void BlockLowering::lower_queue_function(ir::QueueFunction function) {
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

void BlockLowering::lower_function_pou(std::uint32_t pou_index) {
  if (b.module().pous[pou_index].generic) {
    const auto made = function_for(pou_index);
    if (!made) return poison();
    pou_index = *made;
  }
  if (!b.use_pou(pou_index, e.at)) return poison();
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

  const Port* const eno_port = declared_eno(ports);
  open(eno_port == nullptr);
  if (const Port* const own_en = declared_enable(ports)) {
    args.push_back({ir::CallArg::Kind::kInput, own_en->index, b.constant_bool(true), {}});
  }
  for (const Waiting& w : waiting) {
    const auto value =
        b.convert(w.in.operand, w.port->type, "input \"" + std::string(w.port->name) + "\" of " + title());
    if (!value) good = false;
    if (value) args.push_back({ir::CallArg::Kind::kInput, w.port->index, *value, {}});
  }
  for (const auto& [port, place] : in_outs) {
    if (!port->queue) args.push_back({ir::CallArg::Kind::kInOut, port->index, b.make_ref(place), {}});
  }
  std::optional<std::uint16_t> result_pin;
  const auto initial_of = [&](const Port& port) { return b.module().pous[pou_index].variables[port.index].initial; };
  std::optional<Port> result_port;
  for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
    if (!output_wanted(i)) continue;
    const Port* port = output_port(ports, i);
    if (port == nullptr) {
      good = false;
    } else if (port->result) {
      result_pin = i;  // editors call it OUT, or nothing
      result_port = *port;
    } else {
      warn_of_place(*port, e.outputs[i], "output");
      const PlaceId place = place_of_output(i, std::string(port->name), port->type, initial_of(*port));
      args.push_back({ir::CallArg::Kind::kOutput, port->index, {}, place});
    }
  }
  std::optional<PlaceId> eno_out;
  if (eno_port != nullptr && d.has_reader(eno())) {
    eno_out = b.variable(b.hidden("eno." + std::to_string(e.at.local_id), ir::kBoolType));
    args.push_back({ir::CallArg::Kind::kOutput, eno_port->index, {}, *eno_out});
    defaulted.emplace_back(*eno_out, std::vector<ir::InitItem>{});
  }
  const ValueId result = b.call_pou(pou_index, args);
  if (result_pin && result.valid()) take(*result_pin, result, initial_of(*result_port));
  close();
  if (!good) return poison();
  if (eno_out) own_eno = b.load(*eno_out);
  publish_taken();
  publish_in_outs(ports, in_outs);
  publish_eno();
}

void BlockLowering::lower_bundle(const stdlib::BundleSpec& bundle) {
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

  open(std::any_of(bundle.outputs.begin(), bundle.outputs.end(),
                   [](const stdlib::FunctionSpec* output) { return !output->events.empty(); }));
  const auto value = b.convert(*given, ports[0].type, in_name);
  if (!value) {
    close();
    return poison();
  }
  const Operand argument = Operand::of(*value, e.at);
  for (std::uint16_t i = 0; i < e.outputs.size(); ++i) {
    if (!output_wanted(i)) continue;
    const Port* port = output_port(ports, i);
    if (port == nullptr) {
      good = false;
      continue;
    }
    warn_of_place(*port, e.outputs[i], "output");
    const stdlib::FunctionSpec& output = *bundle.outputs[port->index];
    const auto target = d.expected_type({OutRef::Kind::kPin, i, node});
    const auto wanted = target ? b.module().types.elementary_of(*target) : std::nullopt;
    const ir::TypeRef type = wanted && stdlib::output_takes(output, *wanted) ? ir::ref_of(*wanted) : port->type;
    const auto result = b.call(output.name, std::span(&argument, 1), e.at, type);
    if (!result) {
      good = false;
    } else {
      take(i, *result);
    }
  }
  close();
  if (!good) return poison();
  publish_taken();
  publish_eno();
}

void BlockLowering::lower_delay() {
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
  b.probe(d.key_of(out), value);
  publish_eno();
}

void BlockLowering::lower_standard_function() {
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
  good = place_by_name(spec, order) && good;
  const auto not_connected = [&](const Input& input) {
    b.report(Code::P3010, input.pin->at, "input \"" + input.pin->name + "\" of " + title() + " is not connected",
             "a function needs all its inputs: wire it, or give it a constant");
    good = false;
  };
  // An extensible function takes the pins that are wired; MUX counts them, so that none may be missing before another.
  const bool counts = spec.name == "MUX";
  const Input* gap = nullptr;
  for (const auto& [position, input] : order) {
    Incoming in = d.read(*input);
    if (in.state == Incoming::State::kPoison) {
      good = false;
    } else if (in.is_value()) {
      if (counts && gap != nullptr) not_connected(*std::exchange(gap, nullptr));
      operands.push_back(std::move(in.operand));
      pins.push_back(input->pin->name.empty() ? stdlib::pin_name(spec, position) : input->pin->name);
    } else if (!spec.extensible || order.size() <= spec.param_count) {
      not_connected(*input);
    } else if (gap == nullptr) {
      gap = input;
    }
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
  // Power through a compare box is AND with EN: nothing to jump around.
  const bool gate = enable && !may_event && is_power(candidates, operands);
  if (!gate) open(may_event);
  const bool literals =
      std::any_of(operands.begin(), operands.end(), [](const Operand& o) { return o.kind != Operand::Kind::kValue; });
  const bool power = spec.name == "EXPT";  // an integer, where one is needed
  const bool asks = result_pin && (literals || power || stdlib::result_is_open(spec));
  const auto expected = asks ? d.expected_type({OutRef::Kind::kPin, *result_pin, node}) : std::nullopt;
  const auto result = b.call(e.text, operands, e.at, expected, pins);
  if (!result) {
    if (!gate) close();
    return poison();
  }
  if (gate) {
    if (result_pin) publish_output(*result_pin, b.logic(ir::Op::kAnd, *enable, *result));
    return publish_eno();
  }
  if (result_pin && (!enable || output_wanted(*result_pin))) take(*result_pin, *result);
  close();
  publish_taken();
  publish_eno();
}

bool BlockLowering::is_power(std::span<const stdlib::Overload> candidates, const std::vector<Operand>& operands) {
  const stdlib::FunctionSpec& spec = *candidates[0].spec;
  if (spec.result.kind == stdlib::ParamType::Kind::kFixed) return spec.result.fixed == core::TypeId::kBool;
  for (std::size_t i = 0; i < operands.size(); ++i) {
    const auto& param = spec.params[std::min<std::size_t>(i, spec.param_count - 1u)];
    if (param.type.kind == spec.result.kind && !d.is_bool(operands[i])) return false;
  }
  return true;
}

namespace {

/// In1, In2 .. as CODESYS counts the pins of all operators, or In2, In3 .. with EN before them: a count, no names.
bool are_counted(const std::vector<std::pair<std::size_t, const Input*>>& order) {
  std::size_t first = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::string_view name = order[i].second->pin->name;
    if (name.size() < 3 || !core::iequals(name.substr(0, 2), "IN")) return false;
    std::size_t number = 0;
    const auto [end, error] = std::from_chars(name.data() + 2, name.data() + name.size(), number);
    if (error != std::errc() || end != name.data() + name.size()) return false;
    if (i == 0) first = number;
    if (number != first + i) return false;
  }
  return first == 1 || first == 2;
}

}  // namespace

bool BlockLowering::place_by_name(const stdlib::FunctionSpec& spec,
                                  std::vector<std::pair<std::size_t, const Input*>>& order) {
  if (order.size() < spec.param_count || order.size() > stdlib::kMaxArguments) return true;  // refused later
  std::vector<const Input*> at(order.size(), nullptr);                                       // by parameter
  std::vector<const Input*> unnamed;
  bool moved = false;
  const Input* twice = nullptr;
  for (const auto& [position, input] : order) {
    std::size_t i = 0;
    for (; i < order.size(); ++i) {
      const std::string_view alias = stdlib::pin_alias(spec, i);
      const bool other = !alias.empty() && core::iequals(alias, input->pin->name);
      if (other || core::iequals(stdlib::pin_name(spec, i), input->pin->name)) break;
    }
    if (i == order.size()) {
      unnamed.push_back(input);
    } else if (at[i] != nullptr) {
      twice = input;
    } else {
      at[i] = input;
      moved = moved || i != position;
    }
  }
  if (are_counted(order) && !unnamed.empty()) return true;
  if (twice != nullptr) {
    b.report(Code::P3011, twice->pin->at, "input \"" + twice->pin->name + "\" of " + title() + " is drawn twice",
             "delete one of the pins");
    return false;
  }
  if (!moved) return true;
  // What has no name of the function is left for the places that no other pin names.
  auto next = unnamed.begin();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool named = at[i] != nullptr;
    if (!named) at[i] = *next++;
    order[i] = {i, at[i]};
    if (named || at[i]->pin->name.empty()) continue;
    b.report(Code::P3025, at[i]->pin->at,
             title() + " has no input \"" + at[i]->pin->name + "\"; beside the pins with names it is read as \"" +
                 stdlib::pin_name(spec, i) + "\"",
             "correct the name of the pin");
  }
  return true;
}

}  // namespace plc::fbd
