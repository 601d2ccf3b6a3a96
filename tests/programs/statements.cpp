// Random statements. Loops are bounded by construction; what a call would cost decides whether it is made.
#include <fmt/format.h>

#include <algorithm>

#include "tests/programs/generator.h"

namespace plc::programs {

Stmt Generator::simple(const std::string& st, const std::string& c) const {
  Stmt out;
  out.parts.push_back({st + "\n", "{ ++executed;\n" + c + "}\n", {}, false});
  return out;
}

std::vector<Stmt> Generator::statements(int depth, int count) {
  std::vector<Stmt> out;
  for (int i = 0; i < count; ++i) out.push_back(statement(depth));
  return out;
}

Stmt Generator::statement(int depth) {
  pou_->cost += factor_;
  if (!loops_.empty() && random_.chance(4)) {
    const bool leave = random_.chance(50);
    return simple(leave ? "EXIT;" : "CONTINUE;", fmt::format("goto {}_{};\n", leave ? "leave" : "next", loops_.back()));
  }
  switch (random_.below(23)) {
    case 0:
    case 1:
    case 2:
      if (depth > 0) return if_chain(depth - 1);
      break;
    case 3:
      if (depth > 0) return case_of(depth - 1);
      break;
    case 4:
    case 5:
      if (depth > 0 && affordable(20)) return for_loop(depth - 1);
      break;
    case 6:
      if (depth > 0 && affordable(20)) return bounded_loop(depth - 1);
      break;
    case 7:
    case 8:
      return function_call();
    case 9:
    case 10:
    case 11:
      return block_call();
    case 12:
      return partial_write();
    case 13:
      return reference_assignment();
    case 14:
      return eno_call();
    case 20:
    case 21:
    case 22:
      return pointer_statement();
    case 15:
      if (random_.chance(5) && loops_.empty()) return simple("RETURN;", "goto done;\n");
      break;
    default:
      break;
  }
  return assignment();
}

Stmt Generator::assignment() {
  const Type* type = &random_type();
  std::optional<Place> to;
  for (int i = 0; i < 5 && !to; ++i, type = &random_type()) {
    if (type->kind == Kind::kRef || holds_instance(*type)) continue;
    to = place(type->plain(), Use::kWrite, 2);
  }
  if (!to) return simple(";", "");
  // The place on the left, indices included, is found before the right side is computed.
  if (to->type->is_scalar()) {
    const Expr from = assignable(*to->type, 3);
    return simple(fmt::format("{} := {};", to->st, from.st), to->pre + from.pre + store(*to, from.c));
  }
  if (random_.chance(30)) {
    if (const auto made = user_call(*to->type, 2)) {
      return simple(fmt::format("{} := {};", to->st, made->st), to->pre + made->pre + store(*to, made->c));
    }
  }
  const auto from = place(*to->type, Use::kRead, 2);
  if (!from) return simple(";", "");
  const Expr whole = load(*from);
  return simple(fmt::format("{} := {};", to->st, whole.st), to->pre + whole.pre + store(*to, whole.c));
}

Stmt Generator::partial_write() {
  const Type& of = *elementary_[1 + random_.below(12)];
  const auto to = place(of, Use::kWrite, 2);
  if (!to || to->type != &of) return assignment();
  const unsigned widths[] = {1, 1, 8, 16, 32};
  unsigned width = widths[random_.below(5)];
  if (width >= of.bits) width = 1;
  const Type* part = bool_;
  for (const Type* type : elementary_) {
    if (type->kind == Kind::kBits && type->bits == width) part = type;
  }
  const Expr from = assignable(*part, 2);
  const auto index = random_.below(of.bits / width);
  const char letter = width == 1 ? 'X' : width == 8 ? 'B' : width == 16 ? 'W' : 'D';
  const std::string suffix =
      width == 1 && random_.chance(50) ? fmt::format("{}", index) : fmt::format("%{}{}", letter, index);
  const Expr old = load({to->type, to->st, "", to->c, to->checked, true});
  return simple(fmt::format("{}.{} := {};", to->st, suffix, from.st),
                to->pre + from.pre + old.pre +
                    store(*to, fmt::format("put_u{}({}, {}, {}, {})", of.bits, old.c, index * width, width, from.c)));
}

Stmt Generator::reference_assignment() {
  std::vector<const Type*> references;
  for (const Type* type : scalars_) {
    if (type->kind == Kind::kRef) references.push_back(type);
  }
  const Type& type = *random_.pick(references);
  const auto to = place(type, Use::kExact, 2);
  if (!to) return assignment();
  if (random_.chance(60) && pou_->kind != PouKind::kFunction) {
    if (const auto target = place(*type.base, Use::kRefer, 2)) {
      return simple(fmt::format("{} := REF({});", to->st, target->st),
                    to->pre + target->pre + store(*to, address(*target)));
    }
  }
  const Expr from = value(type, 1);
  return simple(fmt::format("{} := {};", to->st, from.st), to->pre + from.pre + store(*to, from.c));
}

Stmt Generator::if_chain(int depth) {
  Stmt out;
  const double factor = factor_;
  const int parts = static_cast<int>(random_.between(1, 3));
  std::string close = "}\n";
  for (int i = 0; i < parts; ++i) {
    const Expr condition = value(*bool_, 3);
    const std::string c = fmt::format("{}if ({}) {{\n", condition.pre, condition.c);
    if (i == 0) {
      out.parts.push_back({fmt::format("IF {} THEN\n", condition.st), "{ ++executed;\n" + c, {}, false});
    } else {
      out.parts.push_back({fmt::format("ELSIF {} THEN\n", condition.st), "} else {\n" + c, {}, false});
      close += "}\n";
    }
    factor_ = factor / 2;
    out.parts.push_back({"", "", statements(depth, static_cast<int>(random_.between(1, 3))), true});
    factor_ = factor;
  }
  if (random_.chance(50)) {
    out.parts.push_back({"ELSE\n", "} else {\n", {}, false});
    factor_ = factor / 2;
    out.parts.push_back({"", "", statements(depth, static_cast<int>(random_.between(1, 3))), true});
    factor_ = factor;
  }
  out.parts.push_back({"END_IF;\n", "}\n" + close, {}, false});
  return out;
}

Stmt Generator::case_of(int depth) {
  Stmt out;
  const Type* type = any_int();
  std::vector<const Type*> enums;
  for (const Type* scalar : scalars_) {
    if (scalar->kind == Kind::kEnum) enums.push_back(scalar);
  }
  const bool by_name = random_.chance(35);
  if (by_name) type = random_.pick(enums);
  Expr selector = typed(*type, 2);
  if (!by_name && random_.chance(70) && type->bits > 8) {
    selector = binary(*type, "MOD", kProduct, "mod_" + type->c, selector, integer_literal(*type, 20, true));
  }
  out.parts.push_back({fmt::format("CASE {} OF\n", selector.st), "{ ++executed;\n" + selector.pre, {}, false});
  const double factor = factor_;
  factor_ = factor / 3;
  std::int64_t next = type->kind == Kind::kSigned ? -random_.between(0, 10) : 0;
  std::size_t name = 0;
  std::string keyword = "if";
  for (int i = static_cast<int>(random_.between(1, 5)); i > 0; --i) {
    std::string labels, condition;
    for (int k = static_cast<int>(random_.between(1, 3)); k > 0; --k) {
      const char* comma = labels.empty() ? "" : ", ";
      const char* alternative = labels.empty() ? "" : " || ";
      if (by_name) {
        if (name == type->values.size()) break;
        const auto& [label, number] = type->values[name++];
        // Two names may stand for one number: a label that is there already would never be reached.
        bool repeated = false;
        for (std::size_t j = 0; j + 1 < name; ++j) repeated = repeated || type->values[j].second == number;
        if (repeated) continue;
        labels += comma + (label == "Shared" || random_.chance(40) ? type->st + "#" + label : label);
        condition += fmt::format("{}{} == {}", alternative, selector.c, number);
        continue;
      }
      next += random_.between(0, 2);
      const std::int64_t last = random_.chance(30) ? next + random_.between(1, 5) : next;
      const Expr low = integer_literal(*type, next, true);
      const Expr high = integer_literal(*type, last, true);
      labels += comma + low.st + (last > next ? ".." + high.st : "");
      condition += fmt::format("{}({} >= {} && {} <= {})", alternative, selector.c, low.c, selector.c, high.c);
      next = last + 1;
    }
    if (labels.empty()) continue;
    out.parts.push_back({labels + ":\n", fmt::format("{} ({}) {{\n", keyword, condition), {}, false});
    out.parts.push_back({"", "", statements(depth, static_cast<int>(random_.between(1, 2))), true});
    keyword = "} else if";
  }
  if (random_.chance(60)) {
    out.parts.push_back({"ELSE\n", "} else {\n", {}, false});
    out.parts.push_back({"", "", statements(depth, 1), true});
  }
  factor_ = factor;
  out.parts.push_back({"END_CASE;\n", "}\n}\n", {}, false});
  return out;
}

Stmt Generator::for_loop(int depth) {
  Stmt out;
  const Type& type = *any_int();
  Variable control;
  control.name = fresh("k");
  control.type = &type;
  add_variable(control);
  scope_.back().writable = false;
  const std::string variable = scope_.back().c;
  const bool is_signed = type.kind == Kind::kSigned;
  const bool down = is_signed && random_.chance(40);
  std::int64_t low = is_signed ? random_.between(-10, 3) : random_.between(0, 5);
  std::int64_t high = low + random_.between(-1, 9);
  if (!is_signed && high < 0) high = 0;
  if (type.bits < 64 && random_.chance(15)) {  // up to the limit of the type, where the count cannot go on
    const std::int64_t greatest = (std::int64_t{1} << (type.bits - (is_signed ? 1 : 0))) - 1;
    high = down ? random_.between(0, 9) - greatest - 1 : greatest;
    low = down ? -greatest - 1 : greatest - random_.between(0, 9);
  }
  const auto bound = [&](std::int64_t at, std::int64_t least, std::int64_t most) {
    if (random_.chance(60) || least > most) return integer_literal(type, at, true);
    const Expr a = integer_literal(type, least, false);
    const Expr b = typed(type, 1);
    return call(type, "LIMIT", "limit_" + type.c, {a, b, integer_literal(type, most, false)});
  };
  // All three are computed once, in this order, before the variable is set.
  const Expr from = bound(down ? high : low, low, high);
  const Expr to = bound(down ? low : high, low, high);
  std::optional<Expr> by;
  if (down || random_.chance(40)) {
    const std::int64_t step = random_.between(1, 4);
    by = down ? bound(-step, -4, -1) : bound(step, 1, 4);
  }
  const int id = ++names_;
  const double factor = factor_;
  factor_ *= static_cast<double>(std::max<std::int64_t>(high - low + 1, 1));
  const std::string head = fmt::format("const {0} to = {1}, by = {2};\nfor ({3} = {4}; {3} {5} to;) {{\n", type.c, to.c,
                                       by ? by->c : "1", variable, from.c, down ? ">=" : "<=");
  out.parts.push_back(
      {fmt::format("FOR {} := {} TO {}{} DO\n", control.name, from.st, to.st, by ? " BY " + by->st : ""),
       "{ ++executed;\n" + from.pre + to.pre + (by ? by->pre : "") + head,
       {},
       false});
  loops_.push_back(id);
  out.parts.push_back({"", "", statements(depth, static_cast<int>(random_.between(1, 3))), true});
  loops_.pop_back();
  factor_ = factor;
  // The loop is over where counting wraps; the variable has wrapped.
  const std::string foot = fmt::format(
      "next_{0}:;\nconst __int128 further = (__int128){1} + by;\n{1} = ({2})further;\nif ({1} != further) break;\n}}\n"
      "leave_{0}:;\n}}\n",
      id, variable, type.c);
  out.parts.push_back({"END_FOR;\n", foot, {}, false});
  return out;
}

Stmt Generator::bounded_loop(int depth) {
  Stmt out;
  Variable guard;
  guard.name = fresh("n");
  guard.type = dint_;
  add_variable(guard);
  scope_.back().writable = false;
  const std::string c = scope_.back().c;
  const std::int64_t most = random_.between(1, 12);
  const double factor = factor_;
  const int id = ++names_;
  const bool is_while = random_.chance(50);
  factor_ *= static_cast<double>(most);
  const Expr condition = value(*bool_, 2);
  const auto body = [&] {
    loops_.push_back(id);
    out.parts.push_back({"", "", statements(depth, static_cast<int>(random_.between(1, 3))), true});
    loops_.pop_back();
  };
  const std::string held = condition.power < (is_while ? kAnd : kOr + 1) ? "(" + condition.st + ")" : condition.st;
  if (is_while) {
    out.parts.push_back(
        {fmt::format("{0} := 0;\nWHILE {1} AND {0} < {2} DO\n{0} := {0} + 1;\n", guard.name, held, most),
         fmt::format(
             "{{ ++executed;\n{0} = 0;\nfor (;;) {{\n{1}if (!({2} & ({0} < {3}))) break;\n++executed; {0} += 1;\n", c,
             condition.pre, condition.c, most),
         {},
         false});
    body();
    out.parts.push_back({"END_WHILE;\n", fmt::format("next_{0}:;\n}}\nleave_{0}:;\n}}\n", id), {}, false});
  } else {
    out.parts.push_back({fmt::format("{0} := 0;\nREPEAT\n{0} := {0} + 1;\n", guard.name),
                         fmt::format("{{ ++executed;\n{0} = 0;\nfor (;;) {{\n++executed; {0} += 1;\n{{\n", c),
                         {},
                         false});
    body();
    out.parts.push_back({fmt::format("UNTIL {} OR {} >= {} END_REPEAT;\n", held, guard.name, most),
                         fmt::format("}}\nnext_{0}:;\n{1}if ({2} | ({3} >= {4})) break;\n}}\nleave_{0}:;\n}}\n", id,
                                     condition.pre, condition.c, c, most),
                         {},
                         false});
  }
  factor_ = factor;
  return out;
}

// ---- calls --------------------------------------------------------------------------------------------------------

std::optional<Generator::Call> Generator::arguments(const Pou& callee, int depth, bool with_outputs, bool positional,
                                                    const std::string& instance) {
  Call out;
  for (const Variable& parameter : callee.variables) {
    const char* comma = out.st.empty() ? "" : ", ";
    const std::string name = positional ? "" : cased(parameter.name) + " := ";
    switch (parameter.role) {
      case Role::kInput: {
        const bool left_out = !positional && random_.chance(20);
        std::string given;
        if (left_out) {
          if (!instance.empty()) continue;
          given = fmt::format("t{}", ++temps_);
          out.pre += fmt::format("{} {};\n", parameter.type->c, given) + initialisation(parameter, given);
        } else {
          Expr value;
          if (parameter.type->kind == Kind::kString && instance.empty()) {
            // Cut when the call takes it: the event is one of the call.
            value = typed(*parameter.type, depth);
            value.c = fmt::format("str_fit({}, {})", value.c, parameter.type->capacity);
          } else if (parameter.type->is_scalar()) {
            value = assignable(*parameter.type, depth);
          } else {
            const auto whole = place(*parameter.type, Use::kRead, depth);
            if (!whole) return std::nullopt;
            value = load(*whole);
          }
          out.st += comma + name + value.st;
          out.pre += value.pre;
          given = value.c;
        }
        if (instance.empty()) {
          out.c += (out.c.empty() ? "" : ", ") + given;
        } else {
          out.pre += fmt::format("if ({0}) {0}->{1} = {2}; else ev = 1;\n", instance, parameter.name, given);
        }
        break;
      }
      case Role::kInOut: {
        const auto where = place(*parameter.type, Use::kExact, depth);
        if (!where) return std::nullopt;
        out.st += comma + name + where->st;
        out.pre += where->pre;
        if (instance.empty()) {
          const std::string handle = fmt::format("p{}", ++temps_);
          out.pre += fmt::format("{}* {} = {};\n", parameter.type->c, handle, address(*where));
          out.c += (out.c.empty() ? "" : ", ") + handle;
        } else {
          out.pre += fmt::format("if ({0}) {0}->{1} = {2}; else ev = 1;\n", instance, parameter.name, address(*where));
        }
        break;
      }
      case Role::kOutput: {
        std::string source = fmt::format("{}->{}", instance, parameter.name);
        if (instance.empty()) {
          source = fmt::format("t{}", ++temps_);
          out.pre += fmt::format("{} {};\n", parameter.type->c, source);
          out.c += (out.c.empty() ? "&" : ", &") + source;
        }
        if (!with_outputs || positional || random_.chance(40)) break;
        const auto to = place(*parameter.type, Use::kExact, 1);
        if (!to) break;
        const bool negated = parameter.type == bool_ && random_.chance(30);
        const std::string inverse = negated ? "1 ^ " : "";
        out.st += fmt::format("{}{}{} => {}", comma, negated ? "NOT " : "", cased(parameter.name), to->st);
        if (instance.empty()) {
          out.after += to->pre + store(*to, inverse + source);
        } else {
          const Expr taken = load(
              {parameter.type, "", "", fmt::format("({0} ? &{0}->{1} : 0)", instance, parameter.name), true, true});
          std::string pre = taken.pre;
          out.after += to->pre + pre + store(*to, inverse + taken.c);
        }
        break;
      }
      default:
        break;
    }
  }
  return out;
}

std::optional<Expr> Generator::user_call(const Type& result, int depth) {
  std::vector<const Pou*> fitting;
  for (const auto& pou : program_.pous) {
    if (pou->kind != PouKind::kFunction || pou.get() == pou_ || !affordable(pou->cost)) continue;
    if (pou->result == &result) fitting.push_back(pou.get());
  }
  if (fitting.empty()) return std::nullopt;
  const Pou& callee = *random_.pick(fitting);
  const auto made = arguments(callee, std::min(depth, 1), true, random_.chance(50), "");
  if (!made) return std::nullopt;
  pou_->cost += factor_ * callee.cost;
  Expr out;
  out.type = &result;
  out.st = fmt::format("{}({})", cased(callee.name), made->st);
  out.pre = made->pre;
  out.c = temp(result, fmt::format("{}({})", callee.name, made->c), out.pre);
  out.pre += made->after;
  return out;
}

Stmt Generator::function_call() {
  std::vector<const Pou*> fitting;
  for (const auto& pou : program_.pous) {
    if (pou->kind == PouKind::kFunction && pou.get() != pou_ && affordable(pou->cost)) fitting.push_back(pou.get());
  }
  if (fitting.empty()) return assignment();
  const Pou& callee = *random_.pick(fitting);
  const auto made = arguments(callee, 2, true, false, "");
  if (!made) return assignment();
  pou_->cost += factor_ * callee.cost;
  const char* comma = made->st.empty() ? "" : ", ";
  const auto eno = random_.chance(30) ? place(*bool_, Use::kWrite, 1) : std::nullopt;
  const bool enabled = random_.chance(25);
  // ENO tells of events in this call alone; those before it stay what they were for a call around this one.
  std::string run = made->pre + "const u8 before = ev; ev = 0;\n" + fmt::format("{}({});\n", callee.name, made->c) +
                    "const u8 eno = !ev; ev |= before;\n" + made->after;
  std::string st = made->st;
  std::string otherwise;
  if (eno) {
    st += fmt::format("{}ENO => {}", comma, eno->st);
    run += eno->pre + store(*eno, "eno");
    otherwise = eno->pre + store(*eno, "0");
  }
  if (!enabled) return simple(fmt::format("{}({});", callee.name, st), run);
  const Expr en = value(*bool_, 2);
  return simple(fmt::format("{}(EN := {}{}{});", callee.name, en.st, st.empty() ? "" : ", ", st),
                fmt::format("{}if ({}) {{\n{}}} else {{\n{}}}\n", en.pre, en.c, run, otherwise));
}

Stmt Generator::block_call() {
  std::vector<const Pou*> fitting;
  for (const auto& pou : program_.pous) {
    if (pou->kind != PouKind::kBlock || pou.get() == pou_ || !affordable(pou->cost)) continue;
    fitting.push_back(pou.get());
  }
  if (fitting.empty()) return assignment();
  const Pou& callee = *random_.pick(fitting);
  const auto instance = place(*callee.instance, Use::kExact, 2);
  if (!instance) return assignment();
  const std::string handle = fmt::format("p{}", ++temps_);
  std::string pre = instance->pre + fmt::format("{}* {} = {};\n", callee.instance->c, handle, address(*instance));
  const auto made = arguments(callee, 2, true, false, handle);
  if (!made) return assignment();
  pou_->cost += factor_ * callee.cost;
  return simple(fmt::format("{}({});", instance->st, made->st),
                pre + made->pre + fmt::format("if ({0}) {1}({0}); else ev = 1;\n", handle, callee.name) + made->after);
}

// x := DIV(IN1 := a, IN2 := b, ENO => fine): events of a standard function.
Stmt Generator::eno_call() {
  const Type& type = *any_int();
  const auto to = place(type, Use::kWrite, 2);
  if (!to || to->type != &type) return assignment();
  const Expr a = typed(type, 2);
  const Expr b = typed(type, 2);
  const auto eno = place(*bool_, Use::kWrite, 1);
  if (!eno) return assignment();
  return simple(
      fmt::format("{} := DIV(IN1 := {}, IN2 := {}, ENO => {});", to->st, a.st, b.st, eno->st),
      fmt::format("{}{}{}const u8 before = ev; ev = 0;\nconst {} result = div_{}({}, {});\nconst u8 eno = !ev; ev |= "
                  "before;\n{}{}{}",
                  to->pre, a.pre, b.pre, type.c, type.c, a.c, b.c, eno->pre, store(*eno, "eno"), store(*to, "result")));
}

}  // namespace plc::programs
