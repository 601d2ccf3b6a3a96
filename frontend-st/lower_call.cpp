// Calls by name: which function it is; function POUs and instances of blocks, with EN and ENO.
#include <algorithm>

#include "core/text.h"
#include "frontend-st/any_types.h"
#include "frontend-st/foreign.h"
#include "frontend-st/lowering.h"
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

/// A method of a block is an error of its own only where the block is read and has none of this name.
std::optional<Operand> Lowering::call_method(NodeId id, Expected expected) {
  const NodeId callee = node(id).a;
  const bool of_a_name = node(callee).kind == NodeKind::kMember && node(node(callee).a).kind == NodeKind::kName;
  if (node(callee).kind == NodeKind::kMember && !(of_a_name && is_unresolved_name(node(callee).a))) {
    const auto owner = place(node(callee).a, false);
    if (!owner) return stub_used_ ? std::optional(stub_value(id, expected)) : std::nullopt;
    const ir::Type& type = types()[builder_.type_of(*owner)];
    const ir::Pou* const pou = type.kind == TypeKind::kPou ? &builder_.module().pous[type.pou] : nullptr;
    if (type.stub || (pou != nullptr && pou->stub)) {
      warn_stub(at(id), quoted(builder_.describe(*owner)) + " of type " + types().name_of(builder_.type_of(*owner)));
      stub_used_ = false;
      return stub_value(id, expected);
    }
    if (pou != nullptr && pou->refused.contains(name_text(callee))) return std::nullopt;
  }
  report(Code::P4009, at(id), quoted(text(callee)) + " is not the name of a function",
         "call a function block instance as a statement of its own and read its outputs");
  return std::nullopt;
}

std::optional<Operand> Lowering::call(NodeId id, Expected expected, bool as_statement) {
  const NodeId callee = node(id).a;
  if (node(callee).kind != NodeKind::kName) return call_method(id, expected);
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
  if (core::iequals(name, "REF") || core::iequals(name, "ADR")) return take_reference(id, expected);
  if (core::iequals(name, "__ISVALIDREF")) return call_is_valid_ref(id);
  if (core::iequals(name, "SIZEOF")) return call_sizeof(id);
  if ((core::iequals(name, "TIME") || core::iequals(name, "LTIME")) && node(id).b == kNoNode) return call_uptime(id);
  if (node(id).b == kNoNode) {
    if (auto time = call_sys_time(id, name)) return time;
  }
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
  if (own && builder_.pou().variables[root.index].step) return true;
  return (own && builder_.pou().variables[root.index].constant) ||
         (root.kind == ir::Place::Kind::kGlobal && builder_.module().globals[root.index].variable.constant);
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
    if (parameter.role == Role::kInOut && (!parameter.constant || names_place(written))) {
      const auto where = place(written, !parameter.constant);
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
      if (types()[parameter.type].implicit) {
        const auto bound_to = bound_reference(written, parameter.type, quoted(parameter.name) + " of " + name);
        fine = fine && bound_to;
        if (!bound_to) continue;
        arg.value = *bound_to;
        args.push_back(arg);
        continue;
      }
      if (any_input(types(), parameter.type)) {
        const auto made = described(written, parameter.type, quoted(parameter.name) + " of " + name);
        fine = fine && made;
        if (!made) continue;
        arg.value = builder_.load(*made);
        args.push_back(arg);
        continue;
      }
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
      const auto kept = given.values.find(bound.argument);
      const auto handle =
          kept != given.values.end()
              ? kept_reference(kept->second, parameter.type, "in-out " + quoted(parameter.name) + " of " + name)
              : in_out(written, parameter, name,
                       known != given.places.end() ? std::optional(known->second) : std::nullopt);
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
    if (parameter.role == Role::kInput && types()[parameter.type].implicit) {
      const auto bound_to = bound_reference(written, parameter.type, quoted(parameter.name) + " of " + name);
      fine = fine && bound_to;
      if (bound_to) builder_.store(builder_.field(*instance, parameter.index), *bound_to);
    } else if (parameter.role == Role::kInput && any_input(types(), parameter.type)) {
      const auto made = described(written, parameter.type, quoted(parameter.name) + " of " + name);
      fine = fine && made;
      if (made) builder_.copy(builder_.field(*instance, parameter.index), *made);
    } else if (parameter.role == Role::kInput) {
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
