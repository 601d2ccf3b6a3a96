// Calls: function POUs, standard functions, function block instances; arguments by position or by name, EN and ENO.
#include <algorithm>

#include "core/text.h"
#include "frontend-st/foreign.h"
#include "frontend-st/lowering.h"
#include "frontend-st/static_type.h"
#include "frontend-st/suggestions.h"
#include "ir/queues.h"
#include "ir/reach.h"
#include "stdlib/specials.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::Role;
using ir::TypeKind;
using ir::TypeRef;
using ir::ValueId;

namespace {
std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }
}  // namespace

// EN and ENO are given by name alone, whether a POU declares them or not.
bool Lowering::Parameter::has_place() const {
  if (type != ir::kBoolType) return true;
  return !(role == Role::kInput && core::iequals(name, "EN")) && !(role == Role::kOutput && core::iequals(name, "ENO"));
}

std::vector<Lowering::Parameter> Lowering::parameters_of_pou(std::uint32_t pou) {
  std::vector<Parameter> out;
  const std::vector<ir::Variable>& variables = builder_.module().pous[pou].variables;
  for (std::uint32_t i = 0; i < variables.size(); ++i) {
    const ir::Variable& v = variables[i];
    if (v.role != Role::kInput && v.role != Role::kOutput && v.role != Role::kInOut && v.role != Role::kQueue) continue;
    const TypeRef type = v.role == Role::kInOut ? types()[v.type].element : v.type;
    out.push_back({v.name, v.role, i, type, {}});
  }
  return out;
}

std::vector<Lowering::Parameter> Lowering::parameters_of_block(const stdlib::BlockSpec& block) {
  std::vector<Parameter> out;
  for (std::uint32_t i = 0; i < block.fields.size(); ++i) {
    const stdlib::Field& field = block.fields[i];
    Role role = Role::kInput;
    switch (field.direction) {
      case stdlib::Direction::kInput:
        break;
      case stdlib::Direction::kOutput:
        role = Role::kOutput;
        break;
      case stdlib::Direction::kInOut:
        role = Role::kInOut;
        break;
      case stdlib::Direction::kState:
        continue;
    }
    out.push_back({std::string(field.name), role, i, ir::ref_of(field.type), std::string(field.alias)});
  }
  return out;
}

Lowering::Arguments Lowering::bind_arguments(NodeId call, const std::vector<Parameter>& parameters,
                                             std::string_view callee, bool is_block) {
  Arguments out;
  std::vector<bool> taken(parameters.size(), false);
  // Without names all parameters but EN and ENO are given in the order of their declaration, outputs too (IEC
  // 61131-3:2013, 6.6.1.4.2); shorter calls leave the outputs out.
  std::size_t unnamed = 0;
  std::size_t given = 0;
  for (NodeId id = node(call).b; id != kNoNode; id = node(id).next) {
    if (node(id).argument == ArgumentKind::kPositional) ++unnamed;
    ++given;
  }
  const auto inputs =
      static_cast<std::size_t>(std::count_if(parameters.begin(), parameters.end(), [](const Parameter& p) {
        return p.role != Role::kOutput && p.has_place();
      }));
  const bool with_outputs = unnamed > inputs;
  const bool some_named = unnamed != given;
  bool named_seen = false;
  std::size_t position = 0;
  const auto refuse = [&](NodeId argument, std::string message, std::string help = {}) {
    report(Code::P4010, at(argument), std::move(message), std::move(help));
    out.fine = false;
  };
  for (NodeId id = node(call).b; id != kNoNode; id = node(id).next) {
    const Node& argument = node(id);
    if (argument.argument == ArgumentKind::kPositional) {
      // "Start = Start" for "Start := Start" would give its truth value to the first parameter.
      const Node& written = node(argument.a);
      const bool equals = written.kind == NodeKind::kBinary && written.op == Operator::kEqual &&
                          node(written.a).kind == NodeKind::kName && !text(argument.a).starts_with('(');
      if (equals && (is_block || some_named) &&
          std::any_of(parameters.begin(), parameters.end(),
                      [&](const Parameter& p) { return core::iequals(p.name, name_text(written.a)); })) {
        const std::string parameter(name_text(written.a));
        refuse(id, quoted(text(argument.a)) + " compares, and is no argument for " + quoted(parameter),
               "write " + parameter + " := ..; put a comparison that is meant in parentheses");
        ++position;
        continue;
      }
      if (named_seen) {
        refuse(id, "an argument without name follows arguments with names", "name all arguments or none");
        continue;
      }
      const auto is_passed = [&](const Parameter& p) {
        return !p.has_place() || (!with_outputs && p.role == Role::kOutput);
      };
      while (position < parameters.size() && is_passed(parameters[position])) ++position;
      if (position == parameters.size()) {
        refuse(id, "call of " + std::string(callee) + " has more arguments than it has parameters");
        continue;
      }
      taken[position] = true;
      out.bound.push_back({static_cast<std::uint32_t>(position++), id});
      continue;
    }
    named_seen = true;
    const std::string_view name = name_text(id);
    const bool is_input = argument.argument == ArgumentKind::kInput;
    std::size_t found = parameters.size();
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      if (core::iequals(parameters[i].name, name)) found = i;
      if (found == parameters.size() && !parameters[i].alias.empty() && core::iequals(parameters[i].alias, name))
        found = i;
    }
    if (!is_block && found != parameters.size() && !core::iequals(parameters[found].name, name)) {
      report(Code::P4347, at(id),
             quoted(name) + " of " + std::string(callee) + " is " + quoted(parameters[found].name) + " in the standard",
             "write " + parameters[found].name + " := ..");
    }
    if (found == parameters.size()) {
      if (is_input && core::iequals(name, "EN")) {
        out.en = argument.a;
        continue;
      }
      if (!is_input && core::iequals(name, "ENO")) {
        out.eno = argument.a == kNoNode ? kNoNode : id;
        continue;
      }
      Guess guess(name);
      for (const Parameter& p : parameters) guess.offer(p.name);
      std::string help = guess.help();
      const bool own = builder_.module().pou_by_name.find(callee) != builder_.module().pou_by_name.end();
      if (help.empty() && !own && (stdlib::block_named(callee) != nullptr || stdlib::is_function(callee))) {
        help = "it is the library's (plc lib " + std::string(callee) + "); one of your own joins with --lib FILE";
      }
      refuse(id, std::string(callee) + " has no parameter " + quoted(name), std::move(help));
      continue;
    }
    if (is_input == (parameters[found].role == Role::kOutput)) {
      refuse(id, quoted(name) + " of " + std::string(callee) + (is_input ? " is an output" : " is not an output"),
             is_input ? "outputs are taken with =>" : "inputs are given with :=");
      continue;
    }
    if (taken[found]) {
      refuse(id, quoted(name) + " of " + std::string(callee) + " is given twice");
      continue;
    }
    taken[found] = true;
    if (argument.a != kNoNode) out.bound.push_back({static_cast<std::uint32_t>(found), id});
  }
  return out;
}

// The handle of a variable given to an in-out; `known` when its place was looked up before.
std::optional<ValueId> Lowering::in_out(NodeId written, const Parameter& parameter, std::string_view callee,
                                        std::optional<PlaceId> known) {
  const auto where = known ? known : place(written, true);
  if (!where) return std::nullopt;
  const std::string what = "in-out " + quoted(parameter.name) + " of " + std::string(callee);
  if (builder_.is_part(*where)) {
    report(Code::P4010, at(written), what + " needs a whole variable, " + quoted(text(written)) + " is a part of one",
           "copy the part to a variable of its own");
    return std::nullopt;
  }
  if (builder_.type_of(*where) != parameter.type) {
    report(Code::P4010, at(written),
           what + " needs a variable of type " + types().name_of(parameter.type) + ", " + quoted(text(written)) +
               " is " + types().name_of(builder_.type_of(*where)),
           "in-outs take variables of exactly their type");
    return std::nullopt;
  }
  return builder_.make_ref(*where);
}

bool Lowering::all_in_outs_given(NodeId call, const std::vector<Parameter>& parameters, const Arguments& arguments,
                                 std::string_view callee) {
  if (!arguments.fine) return false;
  std::vector<bool> given(parameters.size(), false);
  for (const Bound& bound : arguments.bound) given[bound.parameter] = true;
  bool fine = true;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    if (given[i] || (parameters[i].role != Role::kInOut && parameters[i].role != Role::kQueue)) continue;
    report(Code::P4010, at(call),
           "in-out " + quoted(parameters[i].name) + " of " + std::string(callee) + " is not given");
    fine = false;
  }
  return fine;
}

std::optional<ValueId> Lowering::condition(NodeId id, std::string_view what) {
  const auto given = value(id, ir::kBoolType);
  if (!given) return std::nullopt;
  return builder_.convert(*given, ir::kBoolType, what);
}

// Stores `value` where an output argument points.
bool Lowering::deliver(NodeId argument, ValueId value) {
  const NodeId target = node(argument).a;
  const auto where = place(target, true);
  if (!where) return stub_used_;
  Operand given = operand(value, argument);
  given.text = std::string(name_text(argument));
  if (node(argument).argument == ArgumentKind::kNegatedOutput) {
    const auto inverted = builder_.call("NOT", std::span(&given, 1), at(argument));
    if (!inverted) return false;
    given.value = *inverted;
  }
  return builder_.assign(*where, given, "variable " + quoted(text(target)));
}

void Lowering::report_unknown_function(NodeId id, std::string_view name) {
  if (builder_.is_broken(name, at(id))) return;
  for (const stdlib::SpecialSpec& special : stdlib::specials()) {
    if (special.drawn_only && core::iequals(special.name, name)) {
      return report(Code::P4009, at(id), quoted(special.name) + " is a block of drawings only",
                    "a variable has the value of the scan before until it is assigned");
    }
  }
  if (const std::optional<Foreign> foreign = foreign_word(name)) {
    return report(Code::P4066, at(id), core::uppered(name) + ": " + std::string(foreign->what) + " is not supported",
                  std::string(foreign->help));
  }
  std::string help = function_meant(builder_.module(), builder_.pou(), name);
  if (!supplier_of(name).empty()) help = supply_help(name, "FUNCTION " + std::string(name) + " : T");
  report(Code::P4009, at(id), "there is no function " + quoted(name), std::move(help));
}

std::optional<Operand> Lowering::call(NodeId id, Expected expected, bool as_statement) {
  const NodeId callee = node(id).a;
  if (node(callee).kind != NodeKind::kName) {
    report(Code::P4009, at(id), quoted(text(callee)) + " is not the name of a function",
           "call a function block instance as a statement of its own and read its outputs");
    return std::nullopt;
  }
  const std::string_view name = name_text(callee);
  ir::Module& module = builder_.module();
  const auto pou = module.pou_by_name.find(name);
  if (pou != module.pou_by_name.end() && module.pous[pou->second].kind == ir::PouKind::kFunction) {
    return call_function(id, pou->second, as_statement);
  }
  if (const auto bound = ir::array_bound_named(name)) return call_array_bound(id, *bound);
  if (const auto function = ir::queue_function_named(name)) return call_queue(id, *function, as_statement);
  // A variable called like a standard function ("Limit", "Max") does not hide it where it is called.
  if (!stdlib::overloads_named(name).empty()) return call_standard(id, name, expected);
  if (const stdlib::BundleSpec* bundle = stdlib::bundle_named(name)) return call_bundle(id, *bundle, as_statement);
  const Named named = find_name(module, builder_.pou(), name);
  if (named.kind == Named::Kind::kRefused) return std::nullopt;
  if (named.is_place()) {
    report(Code::P4009, at(id), quoted(name) + " is a variable and is called in an expression",
           "call function block instances as a statement of their own and read " + std::string(name) + ".<output>");
    return std::nullopt;
  }
  if (core::iequals(name, "REF") || core::iequals(name, "ADR")) return take_reference(id);
  if (core::iequals(name, "SIZEOF")) return call_sizeof(id);
  if ((core::iequals(name, "TIME") || core::iequals(name, "LTIME")) && node(id).b == kNoNode) return call_uptime(id);
  if (const auto type = types().find(name)) {
    const TypeKind kind = types()[*type].kind;
    if (kind == TypeKind::kPou && module.pous[types()[*type].pou].kind == ir::PouKind::kProgram) {
      report(Code::P4009, at(id), quoted(name) + " is a program and gives no value",
             "call it as a statement of its own and read " + std::string(name) + ".<output>");
      return std::nullopt;
    }
    if (kind == TypeKind::kBlock || kind == TypeKind::kPou) {
      report(Code::P4009, at(id), quoted(name) + " is a function block, and calling it needs an instance",
             "declare a variable of type " + std::string(name) + " and call that");
      return std::nullopt;
    }
  }
  if (builder_.pou().actions.contains(std::string(name))) {
    report(Code::P4009, at(id), quoted(name) + " is an action and gives no value",
           "call it as a statement of its own and read the variables that it writes");
    return std::nullopt;
  }
  if (module.options.stub_missing) {
    warn_stub(at(id), "function " + quoted(name));
    stub_used_ = false;
    return stub_value(id, expected);
  }
  report_unknown_function(id, name);
  return std::nullopt;
}

bool Lowering::is_configuration(PlaceId place) {
  const ir::Body& body = builder_.body();
  for (; body.places[place.index].parent.valid(); place = body.places[place.index].parent) {
    const ir::Place& step = body.places[place.index];
    if (step.kind != ir::Place::Kind::kField) continue;
    const ir::Type& type = types()[builder_.type_of(step.parent)];
    if (type.kind != ir::TypeKind::kPou || builder_.module().pous[type.pou].taskblock == 0) continue;
    if (builder_.module().pous[type.pou].variables[step.index].constant) return true;
  }
  return false;
}

bool Lowering::is_constant(PlaceId place) {
  if (is_configuration(place)) return true;
  const ir::Place& root = ir::root_of(builder_.body(), place);
  const bool own = root.kind == ir::Place::Kind::kInstance || root.kind == ir::Place::Kind::kFrame;
  return (own && builder_.pou().variables[root.index].constant) ||
         (root.kind == ir::Place::Kind::kGlobal && builder_.module().globals[root.index].variable.constant);
}

std::optional<Operand> Lowering::take_reference(NodeId id) {
  const NodeId argument = node(id).b;
  if (argument == kNoNode || node(argument).next != kNoNode || node(argument).argument != ArgumentKind::kPositional) {
    report(Code::P4010, at(id), std::string(name_text(node(id).a)) + " takes one variable");
    return std::nullopt;
  }
  const auto where = place(node(argument).a, false);
  if (!where) return std::nullopt;
  if (builder_.is_part(*where)) {
    report(Code::P4010, at(argument), quoted(text(argument)) + " is a part of a variable and has no reference");
    return std::nullopt;
  }
  if (is_constant(*where)) {
    report(Code::P4007, at(argument), quoted(text(argument)) + " is a constant, which a reference could write",
           "copy it to a variable, and refer to that");
    return std::nullopt;
  }
  return operand(builder_.make_ref(*where), id);
}

// INT_TO_BYTE(TRUNC(x)): the function tells the type where all of its overloads have one, and none that a DINT, which
// an open result is by itself, widens to.
Lowering::Expected Lowering::argument_type(std::string_view name, std::size_t i) {
  const auto overloads = stdlib::overloads_named(name);
  const core::TypeId type = overloads.front().param_type(i);
  const bool one = std::all_of(overloads.begin(), overloads.end(),
                               [&](const stdlib::Overload& o) { return o.param_type(i) == type; });
  const bool is_whole = core::in_category(type, core::kAnyInt | core::kAnyBit) && type != core::TypeId::kBool;
  const bool decides = type == core::TypeId::kDint || !stdlib::widens(core::TypeId::kDint, type);
  return one && is_whole && decides ? Expected(ir::ref_of(type)) : std::nullopt;
}

std::optional<Operand> Lowering::call_standard(NodeId id, std::string_view name, Expected expected) {
  const stdlib::Overload& first = stdlib::overloads_named(name).front();
  const stdlib::FunctionSpec& spec = *first.spec;
  // Room for every argument written: too many of them are builder_.call's to report, which lists what would fit.
  std::size_t count = spec.param_count;
  std::size_t written = 0;
  for (NodeId a = node(id).b; a != kNoNode; a = node(a).next) ++written;
  const bool named = written != 0 && node(node(id).b).argument != ArgumentKind::kPositional;
  if (spec.extensible || !named) count = std::max(count, written);
  std::vector<Parameter> parameters;
  count = std::min(count, stdlib::kMaxArguments);
  for (std::uint32_t i = 0; i < count; ++i) {
    parameters.push_back({stdlib::pin_name(spec, i), Role::kInput, i, {}, std::string(stdlib::pin_alias(spec, i))});
  }
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;

  std::optional<ValueId> enable;
  bool fine = true;
  if (arguments.en != kNoNode) {
    enable = condition(arguments.en, "input \"EN\" of " + std::string(name));
    fine = enable.has_value();
  }
  std::size_t used = 0;
  for (const Bound& b : arguments.bound) used = std::max<std::size_t>(used, b.parameter + 1u);
  std::vector<Operand> operands(used);
  for (Operand& o : operands) o.at = at(id);
  const bool wants_enum = expected && types()[*expected].kind == TypeKind::kEnum;
  const auto lower_arguments = [&] {
    for (const Bound& b : arguments.bound) {
      const auto given = value(node(b.argument).a, wants_enum ? expected : argument_type(name, b.parameter));
      fine = fine && given.has_value();
      if (given) operands[b.parameter] = *given;
    }
    return fine;
  };
  if (!enable && arguments.eno == kNoNode) {
    if (!lower_arguments()) return std::nullopt;
    const auto result = builder_.call(name, operands, at(id), expected_of(name, expected));
    if (!result) return std::nullopt;
    return operand(*result, id);
  }
  if (!fine) return std::nullopt;
  const ir::LabelId skip = builder_.new_label();
  const ir::LabelId done = builder_.new_label();
  if (enable) builder_.jump_if_not(*enable, skip);
  if (!lower_arguments()) return std::nullopt;
  builder_.clear_event();
  const auto result = builder_.call(name, operands, at(id), expected_of(name, expected));
  if (!result) return std::nullopt;
  const std::uint32_t kept = builder_.hidden("en", builder_.type_of(*result));
  const ValueId eno = builder_.eno();
  builder_.store(builder_.variable(kept), *result);
  if (arguments.eno != kNoNode && !deliver(arguments.eno, eno)) return std::nullopt;
  builder_.jump(done);
  builder_.bind(skip);
  if (arguments.eno != kNoNode && enable && !deliver(arguments.eno, builder_.constant_bool(false))) return std::nullopt;
  builder_.bind(done);
  return operand(builder_.load(builder_.variable(kept)), id);
}

// LOWER_BOUND(array, dimension), UPPER_BOUND(array, dimension).
std::optional<Operand> Lowering::call_array_bound(NodeId id, ir::ArrayBound bound) {
  const std::vector<Parameter> parameters{{"ARR", Role::kInput, 0, {}, {}}, {"DIM", Role::kInput, 1, {}, {}}};
  const std::string name(name_text(node(id).a));
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;
  if (arguments.bound.size() != parameters.size() || arguments.en != kNoNode || arguments.eno != kNoNode) {
    report(Code::P4010, at(id), name + " takes an array and the number of a dimension",
           "write " + name + "(values, 1)");
    return std::nullopt;
  }
  const Bound& first = arguments.bound[arguments.bound[0].parameter == 0 ? 0 : 1];
  const Bound& second = arguments.bound[arguments.bound[0].parameter == 0 ? 1 : 0];
  const auto array = place(node(first.argument).a, false);
  const auto dimension = value(node(second.argument).a, std::nullopt);
  if (!array || !dimension) return std::nullopt;
  auto result = ir::array_bound(builder_, bound, builder_.type_of(*array), *dimension, at(id));
  if (result) result->text = std::string(text(id));
  return result;
}

// QUEUE_PUT(queue, value), QUEUE_GET(queue, OUT => value), QUEUE_COUNT(queue), QUEUE_SPACE(queue): calls of the
// function that is made for this queue.
std::optional<Operand> Lowering::call_queue(NodeId id, ir::QueueFunction function, bool as_statement) {
  NodeId queue = kNoNode;
  for (NodeId argument = node(id).b; argument != kNoNode && queue == kNoNode; argument = node(argument).next) {
    const bool named = node(argument).argument != ArgumentKind::kPositional;
    if (!named || core::iequals(name_text(argument), "QUEUE")) queue = argument;
  }
  const std::string what = "in-out \"QUEUE\" of " + std::string(name_text(node(id).a));
  if (queue == kNoNode) {
    report(Code::P4010, at(id), what + " is not given", "name the global array that is the queue");
    return std::nullopt;
  }
  const auto where = place(node(queue).a, true);
  if (!where) return std::nullopt;
  const auto made = ir::queue_function(builder_, function, *where, at(queue), what);
  if (!made) return std::nullopt;
  return call_function(id, *made, as_statement);
}

// Looks at the arrays that a call of a generic function passes, and gives the function made for them. What was lowered
// for that is kept in `given`, by argument.
std::optional<std::uint32_t> Lowering::function_for(NodeId id, std::uint32_t pou, const Arguments& arguments,
                                                    const std::vector<Parameter>& parameters, Given& given) {
  std::vector<ir::OpenArgument> open;
  bool fine = true;
  for (std::uint32_t p = 0; p < parameters.size(); ++p) {
    const Parameter& parameter = parameters[p];
    if (!types()[parameter.type].open) continue;
    const auto bound =
        std::find_if(arguments.bound.begin(), arguments.bound.end(), [&](const Bound& b) { return b.parameter == p; });
    const std::string what = quoted(parameter.name) + " of " + builder_.module().pous[pou].name;
    if (bound == arguments.bound.end()) {
      report(Code::P4010, at(id), what + " is not given", "an ARRAY [*] has no value of its own");
      fine = false;
      continue;
    }
    const NodeId written = node(bound->argument).a;
    TypeRef type{};
    if (parameter.role == Role::kInOut) {
      const auto where = place(written, true);
      if (where) given.places.emplace(bound->argument, *where);
      if (where) type = builder_.type_of(*where);
    } else {
      const auto operand_given = value(written, std::nullopt);
      if (operand_given) given.values.emplace(bound->argument, *operand_given);
      if (operand_given && operand_given->kind == Operand::Kind::kValue) type = builder_.type_of(operand_given->value);
      if (operand_given && !type.valid()) type = ir::kBoolType;
    }
    fine = fine && type.valid();
    if (!type.valid()) continue;
    if (!ir::fits_open(types(), parameter.type, type)) {
      report(Code::P4010, at(written),
             what + " needs " + types().name_of(parameter.type) + ", " + quoted(text(written)) + " is " +
                 types().name_of(type),
             "the elements and the number of dimensions are those of the declaration");
      fine = false;
      continue;
    }
    open.push_back({parameter.index, type});
  }
  if (!fine) return std::nullopt;
  const auto made = ir::specialize(builder_.module(), pou, open);
  if (!made)
    report(Code::P5001, at(id), quoted(builder_.module().pous[pou].name) + " " + std::string(ir::kTooManyMade));
  return made;
}

// SPLIT_DATE(IN := d, YEAR => y): all outputs are computed before the first is delivered, whose variable may be read by
// the place of another.
std::optional<Operand> Lowering::call_bundle(NodeId id, const stdlib::BundleSpec& bundle, bool as_statement) {
  const std::string name(bundle.name);
  if (!as_statement) {
    report(Code::P4009, at(id), "function " + quoted(name) + " has no result to use in an expression",
           "call it as a statement of its own and take its outputs with =>");
    return std::nullopt;
  }
  std::vector<Parameter> parameters{
      {std::string(bundle.input.name), Role::kInput, 0, ir::ref_of(bundle.input.type.fixed), {}}};
  for (std::uint32_t i = 0; i < bundle.outputs.size(); ++i) {
    const stdlib::FunctionSpec& output = *bundle.outputs[i];
    parameters.push_back({std::string(stdlib::output_name(output)),
                          Role::kOutput,
                          i,
                          ir::ref_of(stdlib::usual_output_type(output)),
                          {}});
  }
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  if (!arguments.fine) return std::nullopt;
  std::optional<ValueId> enable;
  ir::LabelId skip{};
  ir::LabelId done{};
  if (arguments.en != kNoNode) {
    enable = condition(arguments.en, "input \"EN\" of " + name);
    if (!enable) return std::nullopt;
    skip = builder_.new_label();
    done = builder_.new_label();
    builder_.jump_if_not(*enable, skip);
  }
  Operand given;
  given.at = at(id);
  for (const Bound& bound : arguments.bound) {
    if (parameters[bound.parameter].role != Role::kInput) continue;
    const auto written = value(node(bound.argument).a, parameters[0].type);
    if (!written) return std::nullopt;
    given = *written;
  }
  const auto input = builder_.convert(given, parameters[0].type, "input " + quoted(parameters[0].name) + " of " + name);
  if (!input) return std::nullopt;
  if (arguments.eno != kNoNode) builder_.clear_event();
  const Operand argument = operand(*input, id);
  std::vector<std::pair<NodeId, ValueId>> deliveries;
  for (const Bound& bound : arguments.bound) {
    const Parameter& parameter = parameters[bound.parameter];
    if (parameter.role != Role::kOutput) continue;
    const stdlib::FunctionSpec& output = *bundle.outputs[parameter.index];
    TypeRef type = parameter.type;
    const auto target = static_type(ast_, source_, node(bound.argument).a, builder_.module(), &builder_.pou());
    const auto wanted = target ? types().elementary_of(*target) : std::nullopt;
    if (wanted && stdlib::output_takes(output, *wanted)) type = ir::ref_of(*wanted);
    const auto result = builder_.call(output.name, std::span(&argument, 1), at(id), type);
    if (!result) return std::nullopt;
    deliveries.emplace_back(bound.argument, *result);
  }
  std::optional<ValueId> eno;
  if (arguments.eno != kNoNode) eno = builder_.eno();
  bool fine = true;
  for (const auto& [target, result] : deliveries) fine = deliver(target, result) && fine;
  if (eno) fine = deliver(arguments.eno, *eno) && fine;
  if (enable) {
    builder_.jump(done);
    builder_.bind(skip);
    if (eno) fine = deliver(arguments.eno, builder_.constant_bool(false)) && fine;
    builder_.bind(done);
  }
  if (!fine) return std::nullopt;
  return Operand{};
}

std::optional<Operand> Lowering::call_function(NodeId id, std::uint32_t pou, bool as_statement) {
  if (!builder_.use_pou(pou, at(id))) return std::nullopt;
  if (!builder_.module().pous[pou].refused.empty()) return std::nullopt;  // its parameters are not all known
  const std::string name = builder_.module().pous[pou].name;
  const TypeRef result_type = builder_.module().pous[pou].return_type;
  std::vector<Parameter> parameters = parameters_of_pou(pou);
  if (!result_type.valid() && !as_statement) {
    report(Code::P4009, at(id), "function " + quoted(name) + " has no result to use in an expression");
    return std::nullopt;
  }
  if (builder_.module().pous[pou].stub) {
    warn_stub(at(id), "function " + quoted(name));
    return stub_value(id, result_type.valid() ? Expected(result_type) : std::nullopt);
  }
  const Arguments arguments = bind_arguments(id, parameters, name, false);
  bool fine = arguments.fine;
  std::optional<ValueId> enable;
  const bool bracketed = arguments.en != kNoNode || arguments.eno != kNoNode;
  const ir::LabelId skip = bracketed ? builder_.new_label() : ir::LabelId{};
  const ir::LabelId done = bracketed ? builder_.new_label() : ir::LabelId{};
  if (arguments.en != kNoNode) {
    enable = condition(arguments.en, "input \"EN\" of " + name);
    fine = fine && enable.has_value();
    if (enable) builder_.jump_if_not(*enable, skip);
  }
  Given given;
  if (fine && builder_.module().pous[pou].generic) {
    const auto made = function_for(id, pou, arguments, parameters, given);
    if (!made) return std::nullopt;
    pou = *made;
    parameters = parameters_of_pou(pou);
  }
  std::vector<ir::CallArg> args;
  std::vector<std::pair<NodeId, std::uint32_t>>
      deliveries;  ///< outputs whose target has another type: argument, hidden variable
  for (const Bound& bound : arguments.bound) {
    const Parameter& parameter = parameters[bound.parameter];
    const NodeId written = node(bound.argument).a;
    ir::CallArg arg;
    arg.variable = parameter.index;
    if (parameter.role == Role::kInput) {
      const auto known = given.values.find(bound.argument);
      const auto operand_given =
          known != given.values.end() ? std::optional(known->second) : value(written, parameter.type);
      const auto converted = operand_given ? builder_.convert(*operand_given, parameter.type,
                                                              "input " + quoted(parameter.name) + " of " + name)
                                           : std::nullopt;
      if (!converted) {
        fine = false;
        continue;
      }
      arg.kind = ir::CallArg::Kind::kInput;
      arg.value = *converted;
    } else if (parameter.role == Role::kQueue) {
      continue;  // the function is made for it
    } else if (parameter.role == Role::kInOut) {
      const auto known = given.places.find(bound.argument);
      const auto handle =
          in_out(written, parameter, name, known != given.places.end() ? std::optional(known->second) : std::nullopt);
      if (!handle) {
        fine = false;
        continue;
      }
      arg.kind = ir::CallArg::Kind::kInOut;
      arg.value = *handle;
    } else {
      arg.kind = ir::CallArg::Kind::kOutput;
      const std::uint32_t kept = builder_.hidden("out", parameter.type);
      arg.place = builder_.variable(kept);
      deliveries.emplace_back(bound.argument, kept);
    }
    args.push_back(arg);
  }
  fine = all_in_outs_given(id, parameters, arguments, name) && fine;
  if (!fine) return std::nullopt;
  if (bracketed) builder_.clear_event();
  const ValueId result = builder_.call_pou(pou, args);
  const std::optional<ValueId> eno = bracketed ? std::optional(builder_.eno()) : std::nullopt;
  std::optional<std::uint32_t> kept;
  if (bracketed && result_type.valid()) {
    kept = builder_.hidden("en", result_type);
    builder_.store(builder_.variable(*kept), result);
  }
  for (const auto& [argument, variable] : deliveries) {
    fine = deliver(argument, builder_.load(builder_.variable(variable))) && fine;
  }
  if (bracketed) {
    if (arguments.eno != kNoNode) fine = deliver(arguments.eno, *eno) && fine;
    builder_.jump(done);
    builder_.bind(skip);
    if (arguments.eno != kNoNode && enable) fine = deliver(arguments.eno, builder_.constant_bool(false)) && fine;
    builder_.bind(done);
  }
  if (!fine) return std::nullopt;
  if (!result_type.valid()) return Operand{};
  return operand(kept ? builder_.load(builder_.variable(*kept)) : result, id);
}

// instance(IN := x, Q => y);
bool Lowering::call_block(NodeId id, std::optional<std::uint32_t> action) {
  const NodeId callee = node(id).a;
  const bool own = action && node(callee).kind == NodeKind::kName;
  const auto instance = own ? std::optional(builder_.self()) : place(action ? node(callee).a : callee, false);
  if (!instance) return stub_used_;
  if (action && builder_.module().pous[*action].stub) {
    warn_stub(at(id), "action " + quoted(text(callee)));
    return true;
  }
  const TypeRef type = builder_.type_of(*instance);
  const ir::Type copy = types()[type];
  if (copy.stub || (copy.kind == TypeKind::kPou && builder_.module().pous[copy.pou].stub)) {
    warn_stub(at(id), quoted(text(callee)) + " of type " + types().name_of(type));
    return true;
  }
  if (copy.kind != TypeKind::kBlock && copy.kind != TypeKind::kPou) {
    report(Code::P4009, at(id), quoted(text(callee)) + " has type " + types().name_of(type) + " and cannot be called");
    return false;
  }
  if (is_constant(*instance)) {
    report(Code::P4007, at(id), quoted(text(callee)) + " is a constant and is called here");
    return false;
  }
  const bool is_pou = copy.kind == TypeKind::kPou;
  if (is_pou && !builder_.module().pous[copy.pou].refused.empty()) return false;  // its parameters are not all known
  const std::vector<Parameter> parameters = is_pou ? parameters_of_pou(copy.pou) : parameters_of_block(*copy.block);
  const std::string name = action ? builder_.module().pous[*action].name : types().name_of(type);
  const Arguments arguments = bind_arguments(id, parameters, name, true);
  bool fine = arguments.fine;
  const bool bracketed = arguments.en != kNoNode;
  const ir::LabelId skip = bracketed ? builder_.new_label() : ir::LabelId{};
  std::optional<ValueId> enable;
  if (bracketed) {
    enable = condition(arguments.en, "input \"EN\" of " + name);
    if (!enable) return false;
    builder_.jump_if_not(*enable, skip);
  }
  for (const Bound& bound : arguments.bound) {
    const Parameter& parameter = parameters[bound.parameter];
    const NodeId written = node(bound.argument).a;
    if (parameter.role == Role::kInput) {
      const auto given = value(written, parameter.type);
      fine = given &&
             builder_.assign_input(*instance, parameter.index, *given,
                                   "input " + quoted(parameter.name) + " of " + name) &&
             fine;
    } else if (parameter.role == Role::kInOut) {
      const auto handle = in_out(written, parameter, name);
      fine = fine && handle;
      if (handle) builder_.store(builder_.field(*instance, parameter.index), *handle);
    } else if (parameter.role == Role::kQueue) {
      const auto queue = place(written, true);
      fine = queue &&
             ir::connect_queue(builder_, *instance, parameter.index, *queue, at(written),
                               "in-out " + quoted(parameter.name) + " of " + name) &&
             fine;
    }
  }
  // What an action does not get is as the last call of the instance left it.
  fine = (action || all_in_outs_given(id, parameters, arguments, name)) && fine;
  if (!fine) return false;
  const bool asks = arguments.eno != kNoNode;
  if (asks) builder_.clear_event();
  action ? builder_.run_action(*instance, *action) : builder_.run(*instance);
  const ValueId eno = asks ? builder_.eno() : ValueId{};
  for (const Bound& bound : arguments.bound) {
    const Parameter& parameter = parameters[bound.parameter];
    if (parameter.role != Role::kOutput) continue;
    fine = deliver(bound.argument, builder_.load(builder_.field(*instance, parameter.index))) && fine;
  }
  if (asks) fine = deliver(arguments.eno, eno) && fine;
  if (bracketed && asks) {
    const ir::LabelId done = builder_.new_label();
    builder_.jump(done);
    builder_.bind(skip);
    fine = deliver(arguments.eno, builder_.constant_bool(false)) && fine;
    builder_.bind(done);
  } else if (bracketed) {
    builder_.bind(skip);
  }
  return fine;
}

}  // namespace plc::st
