// Arguments of calls: parameters of what is called, by position or by name; in-outs, outputs, EN.
#include <algorithm>

#include "core/text.h"
#include "frontend-st/lowering.h"

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
    out.push_back({v.name, v.role, i, type, {}, v.role == Role::kInOut && v.constant});
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
  const std::string what = "in-out " + quoted(parameter.name) + " of " + std::string(callee);
  if (parameter.constant && !known && !names_place(written)) {
    const auto given = value(written, parameter.type);
    return given ? kept_reference(*given, parameter.type, what) : std::nullopt;
  }
  const auto where = known ? known : place(written, !parameter.constant);
  if (!where) return std::nullopt;
  // Which is only read may also be a copy; there are no references to constants.
  const TypeRef type = builder_.type_of(*where);
  const bool other_capacity = type != parameter.type && types()[type].kind == TypeKind::kString;
  if (parameter.constant && (other_capacity || builder_.is_part(*where) || is_constant(*where))) {
    return kept_reference(operand(builder_.load(*where), written), parameter.type, what);
  }
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

// Whether the text names a variable, and no value: of an enumeration, a literal, what a function or an operator gives.
bool Lowering::names_place(NodeId id) {
  switch (node(id).kind) {
    case NodeKind::kMember:
      return !names_enumeration(node(id).a);
    case NodeKind::kName:
      return !is_unresolved_name(id) || find_enum_values(types(), name_text(id), false).empty();
    case NodeKind::kDirect:
    case NodeKind::kBit:
    case NodeKind::kIndex:
    case NodeKind::kDeref:
      return true;
    default:
      return false;
  }
}

// A reference to a variable of `type` that holds the value while a call reads it.
std::optional<ValueId> Lowering::kept_reference(const Operand& given, TypeRef type, const std::string& what) {
  const PlaceId kept = builder_.variable(builder_.hidden("constant", type));
  if (!builder_.assign(kept, given, what)) return std::nullopt;
  return builder_.make_ref(kept);
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
  const auto holds = builder_.convert(*given, ir::kBoolType, what);
  if (holds) builder_.probe(value_key(id), *holds);
  return holds;
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

}  // namespace plc::st
