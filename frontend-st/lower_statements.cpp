// Statements: assignments, calls, IF, RETURN; entries for whole bodies and for the texts of EXECUTE boxes.
#include <algorithm>

#include "frontend-st/choosing.h"
#include "frontend-st/lowering.h"
#include "frontend-st/parser.h"
#include "frontend-st/static_type.h"
#include "frontend-st/text.h"

namespace plc::st {

using core::Code;
using ir::TypeKind;

bool Lowering::assign(NodeId id) {
  const Node n = node(id);
  if (n.op == Operator::kBind && node(n.b).kind != NodeKind::kAssign) return bind_reference(id);
  if (n.op != Operator::kNone || (n.b != kNoNode && node(n.b).kind == NodeKind::kAssign)) return assign_chain(id);
  const auto where = place(n.a, true);
  const bool target_is_stub = !where && stub_used_;
  // The right side is read even if the left one is wrong: its errors are its own.
  const auto given = value(n.b, where ? std::optional(builder_.type_of(*where)) : std::nullopt);
  if (target_is_stub) return given.has_value();
  if (!where || !given) return false;
  if (types()[builder_.type_of(*where)].stub) {
    warn_stub(at(n.a), '"' + std::string(text(n.a)) + "\" of type " + types().name_of(builder_.type_of(*where)));
    return true;
  }
  if (!builder_.assign(*where, *given, "variable \"" + std::string(text(n.a)) + '"')) return false;
  probe_written(n.a, *where, *given);
  return true;
}

void Lowering::probe_written(NodeId id, ir::PlaceId where, const ir::Operand& given) {
  if (!builder_.notes_probes()) return;
  // What is written is in the variable; where only the running program finds that, it is what was given.
  const ir::Body& body = builder_.body();
  for (ir::PlaceId place = where; place.valid(); place = body.places[place.index].parent) {
    const ir::Place::Kind kind = body.places[place.index].kind;
    if (kind == ir::Place::Kind::kInstance || kind == ir::Place::Kind::kFrame || kind == ir::Place::Kind::kGlobal ||
        kind == ir::Place::Kind::kField || kind == ir::Place::Kind::kElement) {
      continue;
    }
    return builder_.probe(value_key(id), given);
  }
  builder_.probe(value_key(id), where);
}

// a := b := c: the value at the end goes to each of the variables, the last one first, and is read once.
bool Lowering::assign_chain(NodeId id) {
  std::vector<NodeId> steps;
  NodeId last = id;
  for (; node(last).kind == NodeKind::kAssign; last = node(last).b) steps.push_back(last);
  if (steps.size() > 1) {
    report(Code::P4355, at(id), "one assignment has " + std::to_string(steps.size()) + " variables",
           "write an assignment for each");
  }
  const auto target = static_type(ast_, source_, node(steps.back()).a, builder_.module(), &builder_.pou());
  const auto given = value(last, node(steps.back()).op == Operator::kNone ? target : ir::kBoolType);
  bool fine = given.has_value();
  for (; !steps.empty(); steps.pop_back()) {
    const NodeId step = steps.back();
    const auto where = place(node(step).a, true);
    if (!where) {
      fine = stub_used_ && fine;
    } else if (given && node(step).op != Operator::kNone) {
      fine = set_or_reset(step, *where, *given) && fine;
    } else if (given) {
      fine = builder_.assign(*where, *given, "variable \"" + std::string(text(node(step).a)) + '"') && fine;
    }
    if (where && given && fine) probe_written(node(step).a, *where, *given);
  }
  return fine;
}

bool Lowering::set_or_reset(NodeId id, ir::PlaceId where, const ir::Operand& given) {
  if (node(id).op == Operator::kBind) {
    report(Code::P4208, at(id), "REF= is part of an assignment to several variables", "write an assignment for each");
    return false;
  }
  const bool set = node(id).op == Operator::kSet;
  const std::string sign = set ? "S=" : "R=";
  report(Code::P4348, at(id), sign + " is not in the standard",
         set ? "write IF .. THEN x := TRUE; END_IF" : "write IF .. THEN x := FALSE; END_IF");
  if (builder_.type_of(where) != ir::kBoolType) {
    report(Code::P4101, at(id),
           sign + " needs a variable of type BOOL, \"" + std::string(text(node(id).a)) + "\" is " +
               types().name_of(builder_.type_of(where)));
    return false;
  }
  const auto condition = builder_.convert(given, ir::kBoolType, "condition of " + sign);
  if (!condition) return false;
  const ir::ValueId before = builder_.load(where);
  builder_.store(where, set ? builder_.logic(ir::Op::kOr, before, *condition)
                            : builder_.logic(ir::Op::kAnd, before, builder_.not_(*condition)));
  return true;
}

bool Lowering::if_chain(NodeId id) {
  const ir::LabelId end = builder_.new_label();
  bool fine = true;
  for (NodeId part = id; part != kNoNode; part = node(part).c) {
    if (node(part).kind == NodeKind::kElse) {
      cover_branch(part, "ELSE");
      fine = statements(node(part).b) && fine;
      break;
    }
    builder_.set_source(at(part));
    const auto taken = condition(node(part).a, "condition of IF");
    const ir::LabelId next = builder_.new_label();
    if (taken) builder_.jump_if_not(*taken, next);
    fine = taken.has_value() && fine;
    cover_branch(part, part == id ? "IF" : "ELSIF");
    fine = statements(node(part).b) && fine;
    const bool last = node(part).c == kNoNode;
    if (!last || covered()) builder_.jump(end);
    builder_.bind(next);
    if (last) cover_branch(id, "none of IF");
  }
  builder_.bind(end);
  return fine;
}

bool Lowering::covered() { return builder_.module().coverage.has_value() && !builder_.pou().test; }

// The word and the condition or labels after it are its text; what has none (ELSE) is the word alone.
void Lowering::cover_branch(NodeId id, std::string_view word) {
  if (!covered()) return;
  const bool headed = word != "ELSE" && node(id).a != kNoNode;
  const std::string head = headed ? " " + std::string(text(node(id).a)) : "";
  builder_.cover(builder_.cover_site(ir::CoverKind::kBranch, at(id), std::string(word) + head), 0);
}

bool Lowering::is_standard_call(NodeId callee) {
  if (!stdlib::is_function(name_text(callee))) return false;
  const Named named = find_name(builder_.module(), builder_.pou(), name_text(callee));
  if (!named.is_place()) return named.kind == Named::Kind::kNothing;
  const ir::TypeRef type = named.kind == Named::Kind::kVariable ? builder_.pou().variables[named.index].type
                                                                : builder_.module().globals[named.index].variable.type;
  return types().rep_of(type).has_value();
}

bool Lowering::names_instance(NodeId callee) {
  const Named named = find_name(builder_.module(), builder_.pou(), name_text(callee));
  if (!named.is_place()) return false;
  const bool local = named.kind == Named::Kind::kVariable;
  const ir::Variable& variable =
      local ? builder_.pou().variables[named.index] : builder_.module().globals[named.index].variable;
  const bool followed = (local && variable.role == ir::Role::kInOut) || types()[variable.type].implicit;
  const ir::TypeKind kind = types()[followed ? types()[variable.type].element : variable.type].kind;
  return kind == ir::TypeKind::kBlock || kind == ir::TypeKind::kPou;
}

bool Lowering::call_statement(NodeId call_id) {
  const NodeId callee = node(call_id).a;
  if (builder_.pou().test && node(callee).kind == NodeKind::kName) {
    if (const ir::TestCallInfo* const known = ir::test_call_named(name_text(callee))) return test_call(call_id, *known);
  }
  if (const auto action = find_action(builder_.module(), builder_.pou(), text(callee))) {
    return call_block(call_id, action->action);
  }
  const bool program = is_unresolved_name(callee) && find_program(builder_.module(), name_text(callee));
  if (program) return call_block(call_id);
  if (node(call_id).name != node(call_id).name_end) {
    const bool at_end = node(call_id).name >= source_.text().size();
    report(
        Code::P4001, name_at(call_id),
        at_end ? "the text ends where \":=\" or \"(\" should follow" : "found \";\" where \":=\" or \"(\" is expected");
    return false;
  }
  if (node(callee).kind == NodeKind::kName) {
    const ir::Module& module = builder_.module();
    const auto pou = module.pou_by_name.find(name_text(callee));
    const bool function = pou != module.pou_by_name.end() && module.pous[pou->second].kind == ir::PouKind::kFunction;
    // An instance hides a function of its name.
    if ((function && !names_instance(callee)) || is_unresolved_name(callee) || is_standard_call(callee))
      return call(call_id, std::nullopt, true).has_value();
  }
  return call_block(call_id);
}

bool Lowering::statement(NodeId id) {
  builder_.set_source(at(id));
  builder_.probe_reached(ir::ProbeKey::text(at(id), ir::ProbeSide::kWhole));
  in_statement_ = true;
  switch (node(id).kind) {
    case NodeKind::kAssign:
      return assign(id);
    case NodeKind::kCallStatement:
      return call_statement(node(id).a);
    case NodeKind::kIf:
      return if_chain(id);
    case NodeKind::kCase:
      return case_of(id);
    case NodeKind::kFor:
      return for_loop(id);
    case NodeKind::kWhile:
      return while_loop(id);
    case NodeKind::kRepeat:
      return repeat_loop(id);
    case NodeKind::kExit:
    case NodeKind::kContinue:
      return leave_loop(id);
    case NodeKind::kReturn:
      builder_.ret();
      return true;
    default:
      return false;
  }
}

bool Lowering::statements(NodeId first) {
  bool fine = true;
  for (NodeId id = first; id != kNoNode; id = node(id).next) fine = statement(id) && fine;
  return fine;
}

bool check_syntax(std::string_view text, const core::SourceRef& at, std::string_view pou,
                  core::Diagnostics& diagnostics) {
  const SourceText source(text, at, diagnostics);
  Parser parser(source, diagnostics, pou);
  while (parser.next_statement() != kNoNode) {
  }
  return !parser.failed();
}

bool lower_statements(std::string_view text, const core::SourceRef& at, ir::Builder& builder,
                      const std::vector<std::string>* defines) {
  if (text.size() > kMaxTextBytes) {
    builder.report(Code::P4002, at, "the text is longer than " + std::to_string(kMaxTextBytes) + " bytes");
    return false;
  }
  const SourceText whole(text, at, builder.diagnostics());
  const ChosenText chosen = choose(whole, builder, defines);
  const SourceText source(chosen.text(), at, builder.diagnostics());
  Parser parser(source, builder.diagnostics(), builder.name());
  Lowering lowering(builder, source, parser.ast());
  bool lowered = true;
  for (NodeId one = parser.next_statement(); one != kNoNode; one = parser.next_statement()) {
    lowered = lowering.statements(one) && lowered;
  }
  builder.set_source(at);
  return lowered && chosen.fine() && !parser.failed();
}

namespace {

/// EN and ENO that the POU declares itself.
void lower_declared_enable(ir::Builder& builder) {
  const auto declared = [&](std::string_view name, ir::Role role) -> std::optional<ir::PlaceId> {
    const auto it = builder.pou().by_name.find(name);
    if (it == builder.pou().by_name.end()) return std::nullopt;
    const ir::Variable& variable = builder.pou().variables[it->second];
    if (variable.role != role || variable.type != ir::kBoolType) return std::nullopt;
    return builder.variable(it->second);
  };
  const auto en = declared("EN", ir::Role::kInput);
  const auto eno = declared("ENO", ir::Role::kOutput);
  if (en && eno) builder.store(*eno, builder.load(*en));
  if (eno && !en) builder.store(*eno, builder.constant_bool(true));
  if (!en) return;
  const ir::LabelId enabled = builder.new_label();
  builder.jump_if(builder.load(*en), enabled);
  builder.ret();
  builder.bind(enabled);
}

}  // namespace

void lower_prologue(ir::Builder& builder) {
  const bool action = builder.module().pous[builder.pou_index()].owner != ir::Pou::kDeclared;
  if (!action) lower_declared_enable(builder);
  const auto make = [&](std::uint32_t index) {
    const std::vector<ir::ReferenceInit> references = builder.pou().variables[index].references;
    for (const ir::ReferenceInit& one : references) {
      builder.set_source(one.at);
      ir::PlaceId where = builder.variable(index);
      for (const std::uint32_t step : one.path) {
        const bool array = builder.module().types[builder.type_of(where)].kind == TypeKind::kArray;
        where = array ? builder.element(where, step) : builder.field(where, step);
      }
      if (builder.module().types[builder.type_of(where)].implicit) {
        lower_binding(where, one.text, one.at, builder);
        continue;
      }
      const auto given = lower_expression(one.text, one.at, builder, builder.type_of(where));
      const std::string& name = builder.pou().variables[index].name;
      if (given) builder.assign(where, *given, "initial value of \"" + name + '"');
    }
  };
  std::vector<std::uint32_t> once;
  for (std::uint32_t i = 0; i < builder.pou().variables.size(); ++i) {
    const ir::Variable& variable = builder.pou().variables[i];
    if (variable.references.empty()) continue;
    if (!variable.in_frame && variable.role != ir::Role::kTemp) {
      once.push_back(i);
    } else if (!action) {
      make(i);
    }
  }
  if (once.empty()) return;
  // The body and the actions of a POU share the mark.
  const std::vector<ir::Variable>& all = builder.pou().variables;
  const auto known = std::find_if(all.begin(), all.end(), [](const auto& v) { return v.name.starts_with("#refs."); });
  const ir::PlaceId made = builder.variable(known == all.end() ? builder.hidden("refs", ir::kBoolType)
                                                               : static_cast<std::uint32_t>(known - all.begin()));
  const ir::LabelId after = builder.new_label();
  builder.jump_if(builder.load(made), after);
  for (const std::uint32_t index : once) make(index);
  builder.store(made, builder.constant_bool(true));
  builder.bind(after);
}

bool lower_body(const plcopen::Pou& pou, ir::Module& module, std::uint32_t pou_index, core::Diagnostics& diagnostics) {
  const std::size_t errors_before = diagnostics.error_count();
  ir::Builder builder(module, pou_index, diagnostics);
  lower_prologue(builder);
  bool good = diagnostics.error_count() == errors_before;
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language != plcopen::Language::kSt) continue;
    good = lower_statements(body.text, body.text_at.line != 0 ? body.text_at : body.at, builder, body.defines.get()) &&
           good;
  }
  module.pous[pou_index].compiled = good;
  return good;
}

}  // namespace plc::st
