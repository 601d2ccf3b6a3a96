#include "convert/expressions.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "convert/literals.h"
#include "frontend-st/lexer.h"
#include "ir/queues.h"

namespace plc::convert {

using ir::Inst;
using ir::Op;
using ir::Place;
using ir::PlaceId;
using ir::TypeKind;

namespace {

struct Operator {
  std::string_view function;
  std::string_view text;
  std::uint8_t binding;  ///< Expressions::Binding
};
// IEC 61131-3:2013, table 71.
constexpr Operator kOperators[] = {
    {"AND", "AND", 3}, {"OR", "OR", 1}, {"XOR", "XOR", 2}, {"EQ", "=", 4},    {"NE", "<>", 4},
    {"LT", "<", 4},    {"GT", ">", 4},  {"LE", "<=", 4},   {"GE", ">=", 4},   {"ADD", "+", 5},
    {"SUB", "-", 5},   {"MUL", "*", 6}, {"DIV", "/", 6},   {"MOD", "MOD", 6},
};

}  // namespace

std::string Expressions::fail(std::string problem) {
  if (problem_.empty()) {
    problem_ = std::move(problem);
    problem_at_ = body_.sources[body_.insts[now_].source];
  }
  return "?";
}

void Expressions::find_eno() {
  for (std::uint32_t i = plan_.first(); i < body_.insts.size(); ++i) {
    if (body_.insts[i].op != Op::kEno) continue;
    const std::uint32_t call = plan_.watched(i);
    now_ = i;
    if (call == BodyPlan::kSeveral) {
      fail("asks for ENO of something that is no single call");
    } else if (call != BodyPlan::kNone) {
      const auto name = added_.temporary(ir::kBoolType);
      if (name) eno_of_call_.emplace(call, *name);
    }
  }
}

std::optional<std::string> Expressions::counter() { return added_.temporary(ir::ref_of(core::TypeId::kInt)); }

// ---- places -------------------------------------------------------------------------------------------------------

std::string Expressions::variable_name(std::uint32_t index) {
  const ir::Variable& variable = owner_.variables[index];
  if (!variable.name.starts_with('#')) {
    if (st::is_identifier(variable.name)) return name_text(variable.name);
    return fail(fmt::format("names \"{}\", which is no name in ST", variable.name));
  }
  for (const auto& [input, edge] : owner_.edges) {
    if (edge == index) return name_text(owner_.variables[input].name);
  }
  const auto name = added_.hidden(index);
  return name ? *name : fail("keeps a value of a type without a name");
}

std::string Expressions::global_name(std::uint32_t index) {
  for (const ir::Variable& variable : owner_.variables) {
    if (variable.role == ir::Role::kExternal && variable.global == index && !variable.name.starts_with('#')) {
      return name_text(variable.name);
    }
  }
  const ir::Global& global = module_.globals[index];
  if (global.variable.name.empty()) return global.variable.address;
  const std::string qualifier = !global.list.empty() ? global.list : std::string();
  const bool hidden = qualifier.empty() && (owner_.by_name.contains(global.variable.name) ||
                                            (module_.global_by_name.contains(global.variable.name) &&
                                             module_.global_by_name.find(global.variable.name)->second != index));
  if (hidden && global.prefix.empty()) {
    return fail(fmt::format("uses the global \"{}\" where another variable has its name", global.variable.name));
  }
  if (hidden) return global.prefix + "." + name_text(global.variable.name);
  return (qualifier.empty() ? qualifier : qualifier + ".") + name_text(global.variable.name);
}

bool Expressions::stands_for_variable(ir::TypeRef type) const { return type.valid() && module_.types[type].implicit; }

std::string Expressions::referred(std::uint32_t reference) {
  const Inst& from = body_.insts[reference];
  if (from.op == Op::kConst) return value(reference).text;
  if (from.op == Op::kMakeRef && plan_.is_inline(reference)) return place(PlaceId{from.a});
  return root_name(Place{Place::Kind::kDeref, reference, {}, {}});
}

std::string Expressions::root_name(const Place& p) {
  switch (p.kind) {
    case Place::Kind::kGlobal:
      return global_name(p.index);
    case Place::Kind::kInstance:
    case Place::Kind::kFrame:
      return variable_name(p.index);
    case Place::Kind::kSelf:
      return owner_.name;
    case Place::Kind::kDeref: {
      const Inst& reference = body_.insts[p.index];
      if (reference.op == Op::kMakeRef && plan_.is_inline(p.index)) return place(PlaceId{reference.a});
      if (reference.op == Op::kLoad) {
        const Place& from = body_.places[reference.a];
        const bool own = from.kind == Place::Kind::kInstance || from.kind == Place::Kind::kFrame;
        if (own && owner_.variables[from.index].role == ir::Role::kInOut) return variable_name(from.index);
        if (stands_for_variable(reference.type)) return place(PlaceId{reference.a});
      }
      return operand(p.index, Binding::kOperand) + "^";
    }
    default:
      return fail("works on a place that has no name in ST");
  }
}

std::string Expressions::place(PlaceId id) {
  const Place& p = body_.places[id.index];
  if (p.kind == Place::Kind::kField) {
    const Place& parent = body_.places[p.parent.index];
    const ir::Type& type = module_.types[parent.type];
    std::string name;
    if (type.kind == TypeKind::kStruct) name = type.fields[p.index].name;
    if (type.kind == TypeKind::kBlock) name = std::string(type.block->fields[p.index].name);
    if (type.kind == TypeKind::kPou) name = module_.pous[type.pou].variables[p.index].name;
    if (name.empty() || name.front() == '#') return fail("works on a part of an instance that has no name");
    return place(p.parent) + "." + name_text(name);
  }
  if (p.kind == Place::Kind::kElement || p.kind == Place::Kind::kElementAt) {
    const ir::Type& type = module_.types[body_.places[p.parent.index].type];
    const std::string index = p.kind == Place::Kind::kElement
                                  ? fmt::format("{}", type.lower + static_cast<std::int64_t>(p.index))
                                  : operand(p.index, Binding::kOr);
    std::string array = place(p.parent);
    const Place::Kind outer = body_.places[p.parent.index].kind;
    const bool further = (outer == Place::Kind::kElement || outer == Place::Kind::kElementAt) && type.name.empty() &&
                         array.ends_with(']');
    if (!further) return array + "[" + index + "]";
    array.pop_back();
    return array + ", " + index + "]";
  }
  return root_name(p);
}

std::string Expressions::part_suffix(ir::TypeRef part, std::uint32_t bit) const {
  const auto rep = module_.types.rep_of(part).value_or(core::Rep::kBool);
  if (rep == core::Rep::kBool) return fmt::format(".{}", bit);
  const std::uint32_t bits = core::rep_bytes(rep) * 8;
  return fmt::format(".%{}{}", bits == 8 ? 'B' : bits == 16 ? 'W' : 'D', bit / bits);
}

// ---- values -------------------------------------------------------------------------------------------------------

const Expressions::Value& Expressions::value(std::uint32_t id) {
  // What may be written where it is used is computed when the use is.
  if (values_[id].text.empty()) values_[id] = compute(id);
  return values_[id];
}

std::string Expressions::operand(std::uint32_t id, Binding binding, std::string_view op) {
  const Value& v = value(id);
  if (v.binding > binding || (v.binding == binding && !op.empty() && v.op == op)) return v.text;
  return v.binding == Binding::kOperand ? v.text : "(" + v.text + ")";
}

std::string Expressions::condition(std::uint32_t id, bool negate) {
  return negate ? "NOT " + operand(id, Binding::kNot) : value(id).text;
}

Expressions::Value Expressions::binary(std::string_view op, Binding binding, std::uint32_t a, std::uint32_t b) {
  // A rail is TRUE.
  const Inst& left = body_.insts[a];
  if (op == "AND" && left.op == Op::kConst && left.type == ir::kBoolType && body_.constants[left.a].bits != 0) {
    return value(b);
  }
  // Operators of one kind are applied from left to right, comparisons are not joined.
  const bool joins = binding != Binding::kCompare;
  return {operand(a, binding, joins ? op : std::string_view()) + " " + std::string(op) + " " + operand(b, binding),
          binding, op};
}

std::string Expressions::extract(const Inst& inst) {
  const Inst& word = body_.insts[inst.a];
  if (word.op == Op::kLoad && plan_.is_inline(inst.a)) return place(PlaceId{word.a}) + part_suffix(inst.type, inst.b);
  const Value& kept = value(inst.a);
  if (!st::is_identifier(kept.text)) return fail("takes bits out of a value that is no variable");
  return kept.text + part_suffix(inst.type, inst.b);
}

Expressions::Value Expressions::compute(std::uint32_t i) {
  const Inst& inst = body_.insts[i];
  switch (inst.op) {
    case Op::kConst: {
      const auto text = literal_text(module_.types, body_.constants[inst.a]);
      return {text ? *text : fail("has a constant without a literal"), Binding::kOperand, {}};
    }
    case Op::kLoad:
      // Its name is what it refers to.
      if (stands_for_variable(inst.type)) return {fail("takes a REFERENCE TO as it is"), Binding::kOperand, {}};
      return {place(PlaceId{inst.a}), Binding::kOperand, {}};
    case Op::kAnd:
      return binary("AND", Binding::kAnd, inst.a, inst.b);
    case Op::kOr:
      return binary("OR", Binding::kOr, inst.a, inst.b);
    case Op::kXor:
      return binary("XOR", Binding::kXor, inst.a, inst.b);
    case Op::kNot:
      return {"NOT " + operand(inst.a, Binding::kNot), Binding::kNot, {}};
    case Op::kCall:
      return call(i);
    case Op::kCallPou:
      return call_pou(i);
    case Op::kMakeRef:
      return {"REF(" + place(PlaceId{inst.a}) + ")", Binding::kOperand, {}};
    case Op::kAddress:
      return {"ADR(" + place(PlaceId{inst.a}) + ")", Binding::kOperand, {}};
    case Op::kPointerRef:
    case Op::kPointerTo32:
    case Op::kPointerFrom32:
      return {fail("makes a number or a reference of a pointer"), Binding::kOperand, {}};
    case Op::kSameRef:
      return binary("=", Binding::kCompare, inst.a, inst.b);
    case Op::kExtract:
      return {extract(inst), Binding::kOperand, {}};
    case Op::kRange:
      return value(inst.a);
    case Op::kEno: {
      const auto known = eno_of_call_.find(plan_.watched(i));
      return {known == eno_of_call_.end() ? "TRUE" : known->second, Binding::kOperand, {}};
    }
    default:
      return {fail("changes bits of a value that is no variable"), Binding::kOperand, {}};
  }
}

Expressions::Value Expressions::call(std::uint32_t i) {
  const Inst& inst = body_.insts[i];
  const stdlib::Overload& overload = *body_.functions[inst.a];
  const auto argument = [&](std::uint32_t n) { return body_.args[inst.b + n].index; };
  const auto eno = eno_of_call_.find(i);
  const auto* const known = std::find_if(std::begin(kOperators), std::end(kOperators), [&](const Operator& row) {
    return overload.name == row.function && inst.count == 2;
  });
  // Sums of durations and dates are functions with names of their own in the standard.
  const bool plain =
      overload.spec->t_categories != 0 &&
      (core::in_category(overload.t, core::kAnyNum | core::kAnyBit) || overload.result_type() == core::TypeId::kBool);
  if (known != std::end(kOperators) && plain && eno == eno_of_call_.end()) {
    return binary(known->text, static_cast<Binding>(known->binding), argument(0), argument(1));
  }
  if (overload.name == "NOT" && eno == eno_of_call_.end()) {
    return {"NOT " + operand(argument(0), Binding::kNot), Binding::kNot, {}};
  }
  std::string text(overload.name);
  text += "(";
  for (std::uint32_t n = 0; n < inst.count; ++n) {
    if (n != 0) text += ", ";
    if (eno != eno_of_call_.end()) text += std::string(stdlib::pin_name(*overload.spec, n)) + " := ";
    text += value(argument(n)).text;
  }
  if (eno != eno_of_call_.end()) text += (inst.count != 0 ? ", ENO => " : "ENO => ") + eno->second;
  return {text + ")", Binding::kOperand, {}};
}

Expressions::Value Expressions::call_pou(std::uint32_t i) {
  const Inst& inst = body_.insts[i];
  const ir::Pou& callee = module_.pous[inst.a];
  const ir::Pou& declared = callee.made_from == ir::Pou::kDeclared ? callee : module_.pous[callee.made_from];
  // What is kept of it would be a variable with this name, and no reference.
  if (stands_for_variable(inst.type) && plan_.uses(i) != 0) {
    return {fail(fmt::format("calls \"{}\", which gives a REFERENCE TO", declared.name)), Binding::kOperand, {}};
  }
  std::string text = declared.name + "(";
  bool first = true;
  const auto add = [&](const std::string& argument) {
    text += (first ? "" : ", ") + argument;
    first = false;
  };
  if (callee.queue_call) {
    text = callee.name.substr(0, callee.name.find(' ')) + "(";
    add("QUEUE := " + global_name(callee.queue_call->global));
  }
  for (std::uint32_t n = 0; n < inst.count; ++n) {
    const ir::CallArg& arg = body_.call_args[inst.b + n];
    const std::string name = name_text(callee.variables[arg.variable].name);
    if (arg.kind == ir::CallArg::Kind::kOutput) {
      add(name + " => " + place(arg.place));
    } else if (arg.kind == ir::CallArg::Kind::kInput) {
      const bool variable = stands_for_variable(callee.variables[arg.variable].type);
      add(name + " := " + (variable ? referred(arg.value.index) : value(arg.value.index).text));
    } else {
      const Inst& reference = body_.insts[arg.value.index];
      std::string target;
      if (reference.op == Op::kMakeRef && plan_.is_inline(arg.value.index)) {
        target = place(PlaceId{reference.a});
      } else if (reference.op == Op::kLoad && plan_.is_inline(arg.value.index)) {
        target = root_name(Place{Place::Kind::kDeref, arg.value.index, {}, {}});
      } else {
        target = value(arg.value.index).text + "^";
      }
      add(name + " := " + target);
    }
  }
  return {text + ")", Binding::kOperand, {}};
}

// ---- statements ---------------------------------------------------------------------------------------------------

void Expressions::keep(std::uint32_t i, const Value& made, std::vector<std::string>& out) {
  if (!problem_.empty()) return;
  if (stands_for_variable(body_.insts[i].type)) {
    fail("keeps a REFERENCE TO");
    return;
  }
  const auto name = added_.temporary(body_.insts[i].type);
  if (!name) {
    fail("has a value of a type without a name");
    return;
  }
  out.push_back(*name + " := " + made.text + ";");
  values_[i] = {*name, Binding::kOperand, {}};
}

/// SPLIT_DATE(IN := d, MONTH => m): one output of a function of several.
void Expressions::keep_output(std::uint32_t i, std::vector<std::string>& out) {
  const Inst& inst = body_.insts[i];
  const stdlib::Overload& overload = *body_.functions[inst.a];
  const std::size_t dot = overload.name.find('.');
  const auto name = added_.temporary(inst.type);
  if (!name) {
    fail("has a value of a type without a name");
    return;
  }
  std::string text(overload.name.substr(0, dot));
  text += "(";
  for (std::uint32_t n = 0; n < inst.count; ++n) {
    text += stdlib::pin_name(*overload.spec, n) + " := " + value(body_.args[inst.b + n].index).text + ", ";
  }
  out.push_back(text + std::string(overload.name.substr(dot + 1)) + " => " + *name + ");");
  values_[i] = {*name, Binding::kOperand, {}};
}

void Expressions::store(std::uint32_t i, std::vector<std::string>& out) {
  const Inst& inst = body_.insts[i];
  const Inst& from = body_.insts[inst.b];
  // w.3 := x is a word whose part is replaced.
  if (from.op == Op::kInsert && plan_.uses(inst.b) == 1) {
    const Inst& word = body_.insts[from.a];
    if (word.op == Op::kLoad && word.a == inst.a && plan_.is_inline(from.a)) {
      out.push_back(place(PlaceId{inst.a}) + part_suffix(body_.insts[from.b].type, from.count) +
                    " := " + value(from.b).text + ";");
      return;
    }
  }
  if (stands_for_variable(body_.places[inst.a].type)) {
    if (plan_.chain(i) > 1) fail("stores one reference several times");
    const std::string given = referred(inst.b);
    out.push_back(place(PlaceId{inst.a}) + " REF= " + given + ";");
    return;
  }
  const std::uint32_t count = std::max<std::uint32_t>(plan_.chain(i), 1);
  std::string text;
  for (std::uint32_t n = count; n-- > 0;) text += place(PlaceId{body_.insts[i + n].a}) + " := ";
  out.push_back(text + value(inst.b).text + ";");
}

void Expressions::run(std::uint32_t i, std::vector<std::string>& out) {
  const Inst& inst = body_.insts[i];
  const Place& instance = body_.places[inst.a];
  const ir::Type& run_type = module_.types[instance.type];
  if (run_type.kind == TypeKind::kPou && module_.pous[run_type.pou].taskblock != 0) {
    for (const ir::Variable& port : module_.pous[run_type.pou].variables) {
      if (port.role == ir::Role::kInput && port.constant) {
        fail("runs a taskblock with a configuration");
        return;
      }
    }
  }
  std::string text;
  if (inst.b != 0) {
    const ir::Pou& action = module_.pous[inst.b - 1];
    const std::string name = action.name.substr(action.name.rfind('.') + 1);
    text = instance.kind == Place::Kind::kSelf ? name : place(PlaceId{inst.a}) + "." + name;
  } else {
    text = place(PlaceId{inst.a});
  }
  text += "(";
  bool first = true;
  for (const std::uint32_t at : arguments_[i]) {
    const Inst& argument = body_.insts[at];
    const Place& field = body_.places[argument.a];
    const ir::Type& type = module_.types[instance.type];
    const bool block = type.kind == TypeKind::kBlock;
    const std::string name =
        block ? std::string(type.block->fields[field.index].name) : module_.pous[type.pou].variables[field.index].name;
    const Inst& from = body_.insts[argument.b];
    const bool in_out = !block && module_.pous[type.pou].variables[field.index].role == ir::Role::kInOut;
    std::string given;
    if (in_out && from.op == Op::kMakeRef && plan_.is_inline(argument.b)) {
      given = place(PlaceId{from.a});
    } else if (!block && stands_for_variable(module_.pous[type.pou].variables[field.index].type)) {
      given = referred(argument.b);
    } else if (in_out) {
      given = root_name(Place{Place::Kind::kDeref, argument.b, {}, {}});
    } else {
      given = value(argument.b).text;
    }
    text += (first ? "" : ", ") + name_text(name) + " := " + given;
    first = false;
  }
  arguments_.erase(i);
  for (const ir::QueuePort& port : pou_.queue_ports) {
    if (port.instance.index != inst.a) continue;
    text += (first ? "" : ", ") + module_.pous[run_type.pou].variables[port.variable].name +
            " := " + global_name(port.global);
    first = false;
  }
  out.push_back(text + ");");
}

std::vector<std::string> Expressions::statements(std::uint32_t i) {
  std::vector<std::string> out;
  const Inst& inst = body_.insts[i];
  now_ = i;
  switch (inst.op) {
    case Op::kStore:
      if (plan_.in_chain(i)) break;
      if (plan_.run_of(i) != 0) {
        arguments_[plan_.run_of(i)].push_back(i);
      } else {
        store(i, out);
      }
      break;
    case Op::kCopy:
      out.push_back(place(PlaceId{inst.a}) + " := " + place(PlaceId{inst.b}) + ";");
      break;
    case Op::kRun:
      run(i, out);
      break;
    case Op::kCallPou:
      if (!inst.type.valid() || plan_.uses(i) == 0) {
        out.push_back(compute(i).text + ";");
      } else if (!plan_.is_inline(i)) {
        keep(i, compute(i), out);
      }
      break;
    case Op::kClearEvent:
      break;
    case Op::kEno:
    case Op::kConst:
      break;
    case Op::kInsert: {
      if (plan_.is_unwanted(i)) break;
      // The store that follows writes it, or a variable of its own takes the word.
      const bool stored = plan_.uses(i) == 1 && plan_.is_inline(i) && body_.insts[inst.a].op == Op::kLoad &&
                          i + 1 < body_.insts.size() && body_.insts[i + 1].op == Op::kStore &&
                          body_.insts[i + 1].b == i && body_.insts[i + 1].a == body_.insts[inst.a].a;
      if (stored) break;
      keep(i, value(inst.a), out);
      if (!out.empty()) {
        out.push_back(values_[i].text + part_suffix(body_.insts[inst.b].type, inst.count) +
                      " := " + value(inst.b).text + ";");
      }
      break;
    }
    default:
      if (plan_.is_inline(i)) break;
      // What nobody wants does nothing, but a call may be counted.
      if (plan_.is_unwanted(i)) break;
      if (inst.op == Op::kCall && body_.functions[inst.a]->name.find('.') != std::string_view::npos) {
        keep_output(i, out);
        break;
      }
      keep(i, compute(i), out);
      break;
  }
  return out;
}

}  // namespace plc::convert
