// Places: variables, members, elements, direct addresses. A plain variable name takes the short way in lower_place.
#include <algorithm>
#include <utility>

#include "core/text.h"
#include "frontend-st/addresses.h"
#include "frontend-st/foreign.h"
#include "frontend-st/lexer.h"
#include "frontend-st/literals.h"
#include "frontend-st/lowering.h"
#include "frontend-st/parser.h"
#include "frontend-st/text.h"

namespace plc::st {

using core::Code;
using ir::Operand;
using ir::PlaceId;
using ir::Role;
using ir::TypeKind;
using ir::TypeRef;

namespace {

std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

/// What keeps `variable` from being written, or empty.
std::string write_obstacle(const ir::Module& module, const ir::Variable& variable) {
  if (variable.step) return "a step, which only its chart changes,";
  const bool external = variable.role == Role::kExternal;
  if (variable.constant || (external && module.globals[variable.global].variable.constant)) return "a constant";
  return {};
}

/// Whether the variable is a REFERENCE TO, or an in-out that is one.
bool stands_for_another(ir::Builder& builder, const ir::Variable& variable) {
  const ir::TypeTable& types = builder.module().types;
  const ir::Type& type = types[variable.type];
  return type.implicit || (variable.role == Role::kInOut && types[type.element].implicit);
}

/// Notes under which name a place at an address is written.
void note_written(ir::Builder& builder, const Named& named, std::string_view name, const core::SourceRef& at) {
  if (named.kind == Named::Kind::kGlobal) return builder.note_written_name(named.index, name, at);
  const ir::Variable& variable = builder.pou().variables[named.index];
  if (variable.role == Role::kExternal) builder.note_written_name(variable.global, variable.name, at);
}

}  // namespace

bool Lowering::is_step(PlaceId place) {
  const ir::Place& one = builder_.body().places[place.index];
  return one.kind == ir::Place::Kind::kInstance && builder_.pou().variables[one.index].step;
}

bool Lowering::check_writable(const ir::Variable& variable, const core::SourceRef& where) {
  const std::string obstacle = write_obstacle(builder_.module(), variable);
  if (!obstacle.empty()) {
    report(Code::P4007, where, quoted(variable.name) + " is " + obstacle + " and is written here");
    return false;
  }
  // Widespread libraries do it, and every tool takes it: an input is the POU's own copy.
  if (variable.role == Role::kInput) {
    report(Code::P4073, where, quoted(variable.name) + " is an input of this POU and is written here",
           "the caller's variable keeps its value; a local variable would say so");
  }
  return true;
}

void Lowering::report_unknown_name(NodeId id) {
  std::string_view name = name_text(id);
  const bool only_globals = name.starts_with('.');
  if (only_globals) name.remove_prefix(1);
  if (builder_.is_broken(name, at(id))) return;
  const ir::Module& module = builder_.module();
  std::string lists;
  std::string first;
  for (const ir::Global& global : module.globals) {
    if (global.list.empty() || !core::iequals(global.variable.name, name)) continue;
    if (first.empty()) first = global.list + "." + global.variable.name;
    lists += (lists.empty() ? "" : " and ") + global.list;
  }
  if (!first.empty()) {
    const std::string_view what = lists.find(' ') == std::string::npos ? "list " : "lists ";
    report(Code::P4011, at(id), quoted(name) + " is declared in the " + std::string(what) + lists, "write " + first);
    return;
  }
  Guess guess(name);
  // After the thousandth error no message is kept.
  if (builder_.diagnostics().error_count() < core::Diagnostics::kMaxKept) {
    if (!only_globals) {
      for (const ir::Variable& variable : builder_.pou().variables) guess.offer(variable.name);
    }
    for (const ir::Global& global : module.globals) guess.offer(global.variable.name);
    if (only_globals) {
      report(Code::P4004, at(id), "there is no global variable " + quoted(name), guess.help());
      return;
    }
    for (const TypeRef type : types().enumerations()) {
      for (const ir::EnumMember& member : types()[type].members) guess.offer(member.name);
    }
  }
  if (const auto type = types().find(name)) {
    report(Code::P4004, at(id), quoted(name) + " is a type, not a variable",
           "declare a variable of this type and name it here");
    return;
  }
  if (builder_.pou().actions.contains(std::string(name))) {
    report(Code::P4004, at(id), quoted(name) + " is an action, not a variable",
           "call it as a statement of its own: " + std::string(name) + "();");
    return;
  }
  if (module.pou_by_name.find(name) != module.pou_by_name.end()) {
    report(Code::P4004, at(id), quoted(name) + " is a POU, not a variable", "a function is called with parentheses");
    return;
  }
  if (stdlib::is_function(name)) {
    report(Code::P4004, at(id), quoted(name) + " is a function, not a variable",
           "a function is called with parentheses");
    return;
  }
  if (const std::optional<Foreign> foreign = foreign_word(name)) {
    report(Code::P4066, at(id), core::uppered(name) + ": " + std::string(foreign->what) + " is not supported",
           std::string(foreign->help));
    return;
  }
  std::string help = guess.help();
  if (!supplier_of(name).empty()) help = supply_help(name, "VAR_GLOBAL " + std::string(name) + " : T; END_VAR");
  report(Code::P4004, at(id), "there is no variable " + quoted(name), std::move(help));
}

// "GVL.x" where the list exists and the variable does not.
bool Lowering::report_unknown_in_list(NodeId root, NodeId member) {
  const std::string_view list = name_text(root);
  if (builder_.is_broken(name_text(member), at(root))) return true;
  Guess guess(name_text(member));
  bool found = false;
  for (const ir::Global& global : builder_.module().globals) {
    if (!core::iequals(global.list, list)) continue;
    found = true;
    guess.offer(global.variable.name);
  }
  if (!found) return false;
  report(Code::P4004, at(root), "list " + quoted(list) + " has no variable " + quoted(name_text(member)), guess.help());
  return true;
}

std::optional<PlaceId> Lowering::direct_place(NodeId id, bool for_writing) {
  std::string problem;
  const std::string_view written = name_text(id);
  const auto address = parse_address(written, problem);
  if (!address || address->unlocated) {
    report(Code::P4023, at(id), "address " + quoted(written) + ": " + (address ? "names no place" : problem),
           "write it like %IX0.0, %QW3 or %MD10");
    return std::nullopt;
  }
  ir::Module& module = builder_.module();
  const std::string normal = address->text();
  const auto known = module.global_by_name.find(normal);
  if (known != module.global_by_name.end()) {
    if (for_writing) builder_.note_written_name(known->second, normal, at(id));
    return builder_.global(known->second);
  }
  if (builder_.pou().test) {
    report(Code::P7902, at(id), "the project has no variable at " + normal,
           "tests write and read addresses that the project declares or uses");
    return std::nullopt;
  }
  ir::Global global;
  global.variable.name = normal;
  global.variable.type = ir::ref_of(address->type());
  global.variable.address = normal;
  global.variable.at = at(id);
  const auto index = static_cast<std::uint32_t>(module.globals.size());
  module.globals.push_back(std::move(global));
  module.global_by_name.emplace(normal, index);
  if (for_writing) builder_.note_written_name(index, normal, at(id));
  return builder_.global(index);
}

std::optional<PlaceId> Lowering::root_place(NodeId id, bool for_writing) {
  const Named named = find_name(builder_.module(), builder_.pou(), name_text(id));
  if (!named.is_place()) {
    if (named.kind != Named::Kind::kNothing) return std::nullopt;
    if (builder_.pou().test) {
      const auto& programs = builder_.module().bench->programs;
      const auto mirror = programs.find(name_text(id));
      if (mirror != programs.end()) return builder_.global(mirror->second);
    }
    if (const auto program = find_program(builder_.module(), name_text(id))) return program_place(id, *program);
    report_unknown_name(id);
    return std::nullopt;
  }
  const bool local = named.kind == Named::Kind::kVariable;
  const ir::Variable& variable =
      local ? builder_.pou().variables[named.index] : builder_.module().globals[named.index].variable;
  std::string_view name = name_text(id);
  if (name.starts_with('.')) {
    name.remove_prefix(1);
    const bool hidden = builder_.pou().by_name.find(name) != builder_.pou().by_name.end();
    report(Code::P4351, at(id), "the dot before " + quoted(name) + " says that it is the global variable",
           (hidden ? "give the variable of this POU another name, and write " : "write ") + std::string(name));
  }
  if (for_writing && !types()[variable.type].implicit) {
    if (!check_writable(variable, at(id))) return std::nullopt;
    note_written(builder_, named, name, at(id));
  }
  return local ? builder_.variable(named.index) : builder_.global(named.index);
}

std::optional<PlaceId> Lowering::member_place(PlaceId parent, NodeId id, bool for_writing) {
  if (const auto variable = program_variable(parent, id, for_writing)) return variable->place;
  std::string_view name = name_text(id);
  const TypeRef parent_type = builder_.type_of(parent);
  // CODESYS reads the next marking of a step by _x, which is x while its actions run.
  if (is_step(parent) && (core::iequals(name, "_x") || core::iequals(name, "_t"))) name.remove_prefix(1);
  const auto found = builder_.member(parent, name);
  if (found) {
    const ir::Place place = builder_.body().places[found->index];
    const ir::Type& type = types()[parent_type];
    bool output = false;
    bool in_out = false;
    if (type.kind == TypeKind::kBlock) {
      output = type.block->fields[place.index].direction == stdlib::Direction::kOutput;
    } else if (type.kind == TypeKind::kPou) {
      const Role role = builder_.module().pous[type.pou].variables[place.index].role;
      output = role == Role::kOutput;
      in_out = role == Role::kInOut;
      if (for_writing && is_configuration(*found)) {
        report(
            Code::P4007, name_at(id),
            quoted(text(id)) + " is a configuration port of " + types().name_of(parent_type) + " and is written here",
            "it takes a constant where the instance is declared or called; what changes while it runs is an input");
        return std::nullopt;
      }
    }
    if (output && for_writing && !builder_.pou().test) {
      report(Code::P4007, name_at(id),
             quoted(text(id)) + " is an output of " + types().name_of(parent_type) + " and is written here",
             "outputs are written by the block itself");
      return std::nullopt;
    }
    return in_out ? builder_.deref(builder_.load(*found)) : *found;
  }
  if (has_parts(parent_type)) {
    if (const auto bit = bit_constant(id)) return constant_bit_place(parent, id, *bit);
  }
  const ir::Type& type = types()[parent_type];
  if (type.stub) {
    warn_stub(name_at(id), quoted(builder_.describe(parent)) + " of type " + types().name_of(parent_type));
    return std::nullopt;
  }
  Guess guess(name);
  std::string help;
  switch (type.kind) {
    case TypeKind::kStruct:
      for (const ir::TypeField& field : type.fields) guess.offer(field.name);
      break;
    case TypeKind::kBlock:
      for (const stdlib::Field& field : type.block->fields) {
        if (field.direction != stdlib::Direction::kState) guess.offer(field.name);
      }
      break;
    case TypeKind::kPou: {
      const ir::Pou& pou = builder_.module().pous[type.pou];
      if (pou.stub) {
        warn_stub(name_at(id), quoted(builder_.describe(parent)) + " of type " + types().name_of(parent_type));
        return std::nullopt;
      }
      if (pou.refused.contains(name)) return std::nullopt;
      for (const ir::Variable& variable : pou.variables) {
        if (variable.role == Role::kInput || variable.role == Role::kOutput || variable.role == Role::kInOut) {
          guess.offer(variable.name);
        }
      }
      if (pou.actions.contains(std::string(name))) {
        help = quoted(name) + " is an action: call it as a statement of its own, " + std::string(text(id)) + "();";
      }
      for (const auto& [action, index] : pou.actions) guess.offer(action);
      if (const ir::Variable* const inner = pou.find(name)) {
        help = inner->step ? "a step is known in its own POU alone: assign " + std::string(name) + ".X to a VAR_OUTPUT"
                           : "only inputs, outputs and in-outs are seen from outside: make it a VAR_OUTPUT";
      }
      break;
    }
    case TypeKind::kUnion:
      for (const ir::TypeField& field : type.fields) guess.offer(field.name);
      break;
    case TypeKind::kReference:
    case TypeKind::kPointer:
      help = "write ^ to reach what it leads to";
      break;
    default:
      break;
  }
  if (help.empty()) help = guess.help();
  report(
      Code::P4005, name_at(id),
      quoted(text(node(id).a)) + " has type " + types().name_of(parent_type) + ", which has no member " + quoted(name),
      help);
  return std::nullopt;
}

std::optional<PlaceId> Lowering::element_place(PlaceId array, NodeId index) {
  const TypeRef array_ref = builder_.type_of(array);
  if (types()[array_ref].kind == TypeKind::kString) return character_place(array, index);
  if (types()[array_ref].kind != TypeKind::kArray) {
    report(Code::P4008, at(index),
           "index into " + quoted(builder_.describe(array)) + ", which has type " + types().name_of(array_ref),
           "give as many indices as the array has dimensions");
    return std::nullopt;
  }
  const std::int64_t lower = types()[array_ref].lower;
  const std::int64_t upper = types()[array_ref].upper;
  const auto given = index_of(index, core::kAnyInt | core::kAnyBit);
  if (!given) return std::nullopt;
  if (!given->known) return builder_.element_at(array, given->value);
  if (*given->known < lower || *given->known > upper) {
    // Of an ARRAY [*] other calls may have the element, and this one may never come here.
    if (ir::is_given_array(builder_.module(), builder_.pou(), array_ref)) {
      const auto position = value(index, ir::ref_of(core::TypeId::kLint));
      const auto number =
          position ? builder_.convert(*position, ir::ref_of(core::TypeId::kLint), "an index") : std::nullopt;
      return number ? std::optional(builder_.element_at(array, *number)) : std::nullopt;
    }
    report(Code::P4008, at(index), "index " + std::string(text(index)) + " is outside of " + types().name_of(array_ref),
           "indices go from " + std::to_string(lower) + " to " + std::to_string(upper));
    return std::nullopt;
  }
  return builder_.element(array, static_cast<std::uint32_t>(*given->known - lower));
}

// s[2]: the second character of a string (IEC 61131-3:2013, 6.4.2.2).
std::optional<PlaceId> Lowering::character_place(PlaceId string, NodeId index) {
  const auto given = index_of(index, core::kAnyInt | core::kAnyBit);
  if (!given) return std::nullopt;
  if (!given->known) {
    const core::TypeId type_given = *types().elementary_of(builder_.type_of(given->value));
    if (!core::in_category(type_given, core::kAnyBit)) return builder_.character(string, given->value);
    const auto number =
        builder_.convert(operand(given->value, index), ir::ref_of(stdlib::unsigned_of(type_given)), "a position");
    return number ? std::optional(builder_.character(string, *number)) : std::nullopt;
  }
  const TypeRef type = builder_.type_of(string);
  const std::uint16_t capacity = types()[type].capacity;
  if (*given->known < 1 || *given->known > capacity) {
    report(Code::P4008, at(index), "position " + std::string(text(index)) + " is outside of " + types().name_of(type),
           "positions go from 1 to " + std::to_string(capacity));
    return std::nullopt;
  }
  ir::Constant position;
  position.type = ir::ref_of(core::TypeId::kInt);
  position.bits = static_cast<std::uint64_t>(*given->known);
  return builder_.character(string, builder_.constant(position));
}

std::optional<Lowering::Index> Lowering::index_of(NodeId index, std::uint16_t categories) {
  const auto given = value(index, std::nullopt);
  if (!given) return std::nullopt;
  if (given->kind == Operand::Kind::kIntLiteral) {
    return Index{given->int_is_unsigned ? INT64_MAX : given->int_value, {}};
  }
  if (given->kind == Operand::Kind::kValue) {
    const auto type = types().elementary_of(builder_.type_of(given->value));
    if (type && core::in_category(*type, categories) && *type != core::TypeId::kBool) {
      const ir::Inst& inst = builder_.body().insts[given->value.index];
      if (inst.op != ir::Op::kConst) return Index{std::nullopt, given->value};
      return Index{signed_value(builder_.body().constants[inst.a].bits, core::rep_of(*type)), given->value};
    }
  }
  report(Code::P4008, at(index), "index " + quoted(text(index)) + " is not an integer");
  return std::nullopt;
}

std::optional<PlaceId> Lowering::index_place(PlaceId array, NodeId id) {
  if (types()[builder_.type_of(array)].kind == TypeKind::kPointer) return pointer_element(array, node(id).b);
  std::optional<PlaceId> where = array;
  for (NodeId index = node(id).b; where && index != kNoNode; index = node(index).next) {
    const bool character = types()[builder_.type_of(*where)].kind == TypeKind::kString;
    if (character && (index != node(id).b || node(index).next != kNoNode)) {
      report(Code::P4008, at(index), quoted(text(index)) + " is one index too many",
             "a character of a string has brackets of its own: s[1][2]");
      return std::nullopt;
    }
    where = element_place(*where, index);
  }
  return where;
}

std::optional<PlaceId> Lowering::place(NodeId id, bool for_writing) {
  stub_used_ = false;
  const bool keep = std::exchange(keep_reference_, false);
  std::vector<NodeId> path;
  NodeId root = id;
  for (;;) {
    const NodeKind kind = node(root).kind;
    const bool part = kind == NodeKind::kBit && root == id;  // nothing follows a part
    if (!part && kind != NodeKind::kMember && kind != NodeKind::kIndex && kind != NodeKind::kDeref) break;
    path.push_back(root);
    root = node(root).a;
  }
  std::optional<PlaceId> where;
  // Only the last block on the way, and what comes after the last ^, decides whether writing is allowed.
  bool checked_root = for_writing;
  for (NodeId step : path) checked_root = checked_root && node(step).kind != NodeKind::kDeref;
  if (node(root).kind == NodeKind::kDirect) {
    where = direct_place(root, checked_root);
  } else if (node(root).kind == NodeKind::kCall && ((!path.empty() && !for_writing) || gives_reference(root))) {
    where = result_place(root, keep && path.empty());
  } else if (node(root).kind != NodeKind::kName) {
    report(Code::P4006, at(root), quoted(text(root)) + " is not a variable",
           for_writing ? "a value goes to a variable, or to an element, a member or a bit of one" : "");
    return std::nullopt;
  } else {
    if (!path.empty() && node(path.back()).kind == NodeKind::kMember && is_unresolved_name(root)) {
      const std::string qualified = std::string(name_text(root)) + "." + std::string(name_text(path.back()));
      const auto global = builder_.module().global_by_name.find(qualified);
      if (global != builder_.module().global_by_name.end()) {
        const ir::Global& found = builder_.module().globals[global->second];
        if (found.file_prefix && core::iequals(found.variable.name, name_text(path.back()))) {
          report(Code::P4351, at(root),
                 quoted(name_text(root)) + " is the name of a file, and is written before " +
                     quoted(found.variable.name) + " as if it named a list",
                 "write " + found.variable.name);
        }
        if (checked_root && !check_writable(builder_.module().globals[global->second].variable, at(root)))
          return std::nullopt;
        if (checked_root) builder_.note_written_name(global->second, name_text(path.back()), at(root));
        where = builder_.global(global->second);
        path.pop_back();
      }
    }
    if (!where && !path.empty() && is_unresolved_name(root) && report_unknown_in_list(root, path.back()))
      return std::nullopt;
    if (!where) where = root_place(root, checked_root);
  }
  if (where && !(keep && path.empty())) where = follow_implicit(*where);
  const auto last_deref = std::find_if(path.begin(), path.end(), [this](NodeId step) {
    return node(step).kind == NodeKind::kDeref;  // the last one on the way is the first in the list
  });
  const auto deref = static_cast<std::size_t>(last_deref - path.begin());
  for (std::size_t i = path.size(); where && i-- > 0;) {
    const NodeId step = path[i];
    switch (node(step).kind) {
      case NodeKind::kMember:
        where = member_place(*where, step, for_writing && i < deref);
        break;
      case NodeKind::kIndex:
        where = index_place(*where, step);
        break;
      case NodeKind::kBit:
        where = part_place(*where, step);
        break;
      default: {
        const TypeRef type = builder_.type_of(*where);
        if (types()[type].kind != TypeKind::kReference && types()[type].kind != TypeKind::kPointer) {
          report(Code::P4006, at(step),
                 quoted(text(node(step).a)) + " has type " + types().name_of(type) +
                     " and is neither a reference nor a pointer");
          return std::nullopt;
        }
        where = builder_.deref(builder_.load(*where));
      }
    }
    if (where && !(keep && i == 0)) where = follow_implicit(*where);
  }
  return where;
}

// ---- entries --------------------------------------------------------------------------------------------------

std::optional<PlaceId> lower_place(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                                   bool for_writing) {
  const std::string_view plain = core::trimmed(text);
  if (is_identifier(plain)) {
    const Named named = find_name(builder.module(), builder.pou(), plain);
    if (named.kind == Named::Kind::kVariable) {
      const ir::Variable& variable = builder.pou().variables[named.index];
      const bool writable = write_obstacle(builder.module(), variable).empty() && variable.role != Role::kInput;
      if ((!for_writing || writable) && !stands_for_another(builder, variable)) {
        if (for_writing) note_written(builder, named, plain, at);
        return builder.variable(named.index);
      }
    } else if (named.kind == Named::Kind::kGlobal) {
      const ir::Variable& variable = builder.module().globals[named.index].variable;
      if ((!for_writing || !variable.constant) && !stands_for_another(builder, variable)) {
        if (for_writing) note_written(builder, named, plain, at);
        return builder.global(named.index);
      }
    }
  }
  if (text.size() > kMaxTextBytes) {
    builder.report(Code::P4002, at, "the text is longer than " + std::to_string(kMaxTextBytes) + " bytes");
    return std::nullopt;
  }
  const SourceText source(text, at, builder.diagnostics());
  Parser parser(source, builder.diagnostics(), builder.name());
  const NodeId root = parser.parse_expression();
  if (root == kNoNode) return std::nullopt;
  return Lowering(builder, source, parser.ast()).place(root, for_writing);
}

bool is_variable_text(std::string_view text) {
  if (text.size() > kMaxTextBytes) return false;
  const std::string_view plain = core::trimmed(text);
  if (is_identifier(plain)) return !core::iequals(plain, "TRUE") && !core::iequals(plain, "FALSE");
  const SourceText source(text);
  core::Diagnostics ignored;
  Parser parser(source, ignored, {});
  NodeId id = parser.parse_expression();
  if (id == kNoNode) return false;
  const Ast& ast = parser.ast();
  while (ast[id].kind == NodeKind::kMember || ast[id].kind == NodeKind::kIndex || ast[id].kind == NodeKind::kDeref ||
         ast[id].kind == NodeKind::kBit) {
    id = ast[id].a;
  }
  // "(a)" and "a + b" begin elsewhere than their first name, or are no name.
  return (ast[id].kind == NodeKind::kName || ast[id].kind == NodeKind::kDirect) && ast[id].begin == ast[id].name;
}

}  // namespace plc::st
