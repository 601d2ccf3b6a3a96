// Random expressions of a wanted type. Rules that decide types and order: docs/guides/statements.md.
#include <fmt/format.h>

#include <algorithm>

#include "tests/programs/generator.h"

namespace plc::programs {

std::string Generator::cased(const std::string& name) {
  if (!random_.chance(8)) return name;
  std::string out = name;
  for (char& c : out) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  return out;
}

const Type* Generator::any_int() { return elementary_[1 + random_.below(8)]; }

// ---- pieces -------------------------------------------------------------------------------------------------------

namespace {
std::string inside(const Expr& e, int least) { return e.power < least ? "(" + e.st + ")" : e.st; }
}  // namespace

Expr Generator::binary(const Type& result, const char* op, Power power, const std::string& function, const Expr& a,
                       const Expr& b) {
  Expr out;
  out.type = &result;
  out.power = power;
  out.st = fmt::format("{} {} {}", inside(a, power), op, inside(b, power + 1));
  out.pre = a.pre + b.pre;
  out.constant = a.constant && b.constant;
  out.c = temp(result, fmt::format("{}({}, {})", function, a.c, b.c), out.pre);
  return out;
}

Expr Generator::prefix(const Type& result, const char* op, const std::string& function, const Expr& a) {
  Expr out;
  out.type = &result;
  out.power = kUnary;
  out.st = op + inside(a, kUnary);
  out.constant = a.constant;
  out.pre = a.pre;
  out.c = temp(result, fmt::format("{}({})", function, a.c), out.pre);
  return out;
}

Expr Generator::call(const Type& result, const std::string& name, const std::string& function,
                     const std::vector<Expr>& arguments, const std::vector<std::string>& pins) {
  Expr out;
  out.type = &result;
  const bool named = !pins.empty() && random_.chance(20);
  std::string st, c;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const char* comma = i == 0 ? "" : ", ";
    st += comma + (named ? pins[i] + " := " : "") + arguments[i].st;
    c += comma + arguments[i].c;
    out.pre += arguments[i].pre;
    out.constant = (i == 0 || out.constant) && arguments[i].constant;
  }
  out.st = fmt::format("{}({})", cased(name), st);
  out.c = temp(result, fmt::format("{}({})", function, c), out.pre);
  return out;
}

/// Implicit widening (figure 12 of the standard): the value stays, the type grows.
Expr Generator::widened(Expr from, const Type& to) {
  if (from.type == &to || from.untyped) return from;
  from.subrange = nullptr;
  from.c = temp(to, fmt::format("({}){}", to.c, from.c), from.pre);
  from.type = &to;
  return from;
}

const Type* Generator::narrower(const Type& type) {
  std::vector<const Type*> out;
  for (const Type* from : elementary_) {
    const bool shorter = from->bits < type.bits;
    bool fits = false;
    switch (type.kind) {
      case Kind::kSigned:
        fits = from->is_int() && shorter;
        break;
      case Kind::kUnsigned:
        fits = from->kind == Kind::kUnsigned && shorter;
        break;
      case Kind::kBits:
        fits = (from->kind == Kind::kBits && shorter) || from->kind == Kind::kBool;
        break;
      case Kind::kReal:
        fits = (from->is_int() || from->kind == Kind::kReal) && shorter && from->bits <= type.bits / 2;
        break;
      case Kind::kDuration:
      case Kind::kDate:
      case Kind::kTod:
      case Kind::kDt:
        fits = type.is_long && !from->is_long && from->kind == type.kind;
        break;
      default:
        break;
    }
    if (fits) out.push_back(from);
  }
  return out.empty() ? nullptr : random_.pick(out);
}

Expr Generator::typed(const Type& type, int depth) {
  for (int i = 0; i < 4; ++i) {
    Expr out = value(type, depth);
    if (!out.untyped) return out;
  }
  return type.kind == Kind::kReal ? real_literal(type, false) : integer_literal(type, edge_value(type), false);
}

/// Beside an operand of `type`: a narrower one is widened, a literal takes the type.
Expr Generator::operand_of(const Type& type, int depth, bool may_be_untyped) {
  if (random_.chance(20)) {
    if (const Type* from = narrower(type)) return widened(typed(*from, depth), type);
  }
  return may_be_untyped ? value(type, depth) : typed(type, depth);
}

Expr Generator::assignable(const Type& type, int depth) {
  const Type& plain = type.plain();
  Expr out = operand_of(plain, depth, true);
  if (type.kind == Kind::kString) {
    out.c = temp(type, fmt::format("str_fit({}, {})", out.c, type.capacity), out.pre);
  } else if (type.kind == Kind::kSubrange && out.subrange != &type) {
    if (out.constant) out = integer_literal(type, edge_value(type), true);
    out.c = temp(type, fmt::format("range_{}({}, {}, {})", plain.c, type.lower, out.c, type.upper), out.pre);
  }
  out.type = &type;
  return out;
}

// ---- by kind ------------------------------------------------------------------------------------------------------

Expr Generator::value(const Type& asked, int depth) {
  const Type& type = asked.kind == Kind::kString ? (asked.is_long ? *wstring_ : *string_) : asked.plain();
  if (random_.chance(depth <= 0 ? 75 : 25)) {
    if (const auto found = place(type, Use::kRead, depth - 1)) return load(*found);
  }
  if (depth <= 0 || random_.chance(10)) {
    if (type.is_scalar()) return literal(type, true);
  }
  if (random_.chance(8)) {
    if (auto made = user_call(type, depth - 1)) return *made;
  }
  switch (type.kind) {
    case Kind::kBool:
      return boolean(depth);
    case Kind::kSigned:
    case Kind::kUnsigned:
      return integer(type, depth);
    case Kind::kBits:
      return bit_string(type, depth);
    case Kind::kReal:
      return real(type, depth);
    case Kind::kDuration:
      return duration(type, depth);
    case Kind::kDate:
    case Kind::kTod:
    case Kind::kDt:
      return date(type, depth);
    case Kind::kString:
      return text(type, depth);
    default:
      if (const auto found = place(type, Use::kRead, depth - 1)) return load(*found);
      return literal(type, true);
  }
}

Expr Generator::comparison(int depth) {
  struct Comparison {
    const char* op;
    const char* function;
    Power power;
  };
  static constexpr Comparison kAll[] = {{"=", "eq", kEqual},     {"<>", "ne", kEqual},   {"<", "lt", kRelation},
                                        {"<=", "le", kRelation}, {">", "gt", kRelation}, {">=", "ge", kRelation}};
  const Type& scalar = random_scalar();
  const Type& type = scalar.kind == Kind::kRef ? *int_ : scalar.plain();
  const Comparison& how = kAll[random_.below(type.kind == Kind::kEnum ? 2 : 6)];
  const bool is_text = type.kind == Kind::kString;
  const Expr a = operand_of(type, depth - 1, false);
  const Expr b = operand_of(type, depth - 1, true);
  return binary(*bool_, how.op, how.power, fmt::format("{}_{}", how.function, is_text ? "str" : type.c), a, b);
}

Expr Generator::boolean(int depth) {
  const auto both = [&](const char* op, Power power, const char* function) {
    const Expr a = value(*bool_, depth - 1);
    return binary(*bool_, op, power, function, a, value(*bool_, depth - 1));
  };
  switch (random_.below(11)) {
    case 10: {
      const bool is_and = random_.chance(50);
      const Expr a = value(*bool_, depth - 1);
      const Expr b = value(*bool_, depth - 1);
      Expr out = binary(*bool_, is_and ? "AND_THEN" : "OR_ELSE", is_and ? kAnd : kOr, "", a, b);
      out.pre = a.pre;
      out.c = temp(*bool_, a.c, out.pre);
      out.pre += fmt::format("if ({}{}) {{\n{}{} = {};\n}}\n", is_and ? "" : "!", out.c, b.pre, out.c, b.c);
      return out;
    }
    case 0:
      return prefix(*bool_, "NOT ", "not_bool", typed(*bool_, depth - 1));
    case 1:
      return both(random_.chance(70) ? "AND" : "&", kAnd, "and_u8");
    case 2:
      return both("OR", kOr, "or_u8");
    case 3:
      return both("XOR", kXor, "xor_u8");
    case 4:
      return selection(*bool_, depth);
    case 5:
      if (auto bit = partial_read(*bool_, depth - 1)) return *bit;
      return comparison(depth);
    case 6:
      return converted(*bool_, depth);
    default:
      return comparison(depth);
  }
}

Expr Generator::integer(const Type& type, int depth) {
  const auto left = [&] { return operand_of(type, depth - 1, false); };
  const auto right = [&] { return operand_of(type, depth - 1, true); };
  // One operand of exactly this type decides it; the other may be narrower.
  const auto both = [&](const char* op, Power power, const std::string& name) {
    if (random_.chance(50)) {
      const Expr a = typed(type, depth - 1);
      return binary(type, op, power, name + type.c, a, right());
    }
    const Expr a = left();
    return binary(type, op, power, name + type.c, a, typed(type, depth - 1));
  };
  if (random_.chance(6)) return mixed(type, depth);
  switch (random_.below(12)) {
    case 0:
    case 1:
      return both("+", kSum, "add_");
    case 2:
      return both("-", kSum, "sub_");
    case 3:
      return both("*", kProduct, "mul_");
    case 4:
      return both("/", kProduct, "div_");
    case 5:
      return both("MOD", kProduct, "mod_");
    case 6:
      if (type.kind == Kind::kSigned) return prefix(type, "-", "neg_" + type.c, typed(type, depth - 1));
      return both("+", kSum, "add_");
    case 7:
      return call(type, "ABS", "abs_" + type.c, {typed(type, depth - 1)});
    case 8:
      return selection(type, depth);
    case 9:
      if (&type == int_) {
        if (random_.chance(50)) {
          return call(type, "LEN", "str_len", {value(*string_, depth - 1)});
        }
        return call(type, "FIND", "str_find", {value(*string_, depth - 1), value(*string_, depth - 1)}, {"IN1", "IN2"});
      }
      return converted(type, depth);
    default:
      return converted(type, depth);
  }
}

Expr Generator::bit_string(const Type& type, int depth) {
  const auto both = [&](const char* op, Power power, const std::string& name) {
    const Expr a = typed(type, depth - 1);
    return binary(type, op, power, name + type.c, a, operand_of(type, depth - 1, true));
  };
  if (random_.chance(6)) return mixed(type, depth);
  switch (random_.below(9)) {
    case 0:
      return both(random_.chance(70) ? "AND" : "&", kAnd, "and_");
    case 1:
      return both("OR", kOr, "or_");
    case 2:
      return both("XOR", kXor, "xor_");
    case 3:
      return prefix(type, "NOT ", "not_" + type.c, typed(type, depth - 1));
    case 4:
    case 5: {
      static const std::vector<std::pair<std::string, std::string>> kShifts = {
          {"SHL", "shl_"}, {"SHR", "shr_"}, {"ROL", "rol_"}, {"ROR", "ror_"}};
      const auto& [name, function] = random_.pick(kShifts);
      const Type& count = *elementary_[1 + random_.below(6)];
      const Expr n = random_.chance(60) ? integer_literal(count, random_.between(0, type.bits + 1), true)
                                        : typed(count, depth - 1);
      return call(type, name, function + type.c, {typed(type, depth - 1), n}, {"IN", "N"});
    }
    case 6:
      return selection(type, depth);
    case 7:
      if (type.bits < 64) {
        if (auto part = partial_read(type, depth - 1)) return *part;
      }
      return both("XOR", kXor, "xor_");
    default:
      return converted(type, depth);
  }
}

Expr Generator::mixed(const Type& type, int depth) {
  struct Operation {
    const char* op;
    const char* function;
    Power power;
    bool logic;
  };
  static constexpr Operation kAll[] = {{"+", "add", kSum, false},       {"-", "sub", kSum, false},
                                       {"*", "mul", kProduct, false},   {"/", "div", kProduct, false},
                                       {"MOD", "mod", kProduct, false}, {"AND", "and", kAnd, true},
                                       {"OR", "or", kOr, true},         {"XOR", "xor", kXor, true}};
  const Operation& how = kAll[random_.below(8)];
  // Arithmetic has a bit string, logic an integer: what the standard knows is made elsewhere.
  const Type& one = how.logic ? *any_int() : *elementary_[9 + random_.below(4)];
  const Type& other = *elementary_[1 + random_.below(12)];
  const bool swaps = random_.chance(50);
  const Type& first = swaps ? other : one;
  const Type& second = swaps ? one : other;
  const bool is_signed = first.kind == Kind::kSigned || second.kind == Kind::kSigned;
  const unsigned bits = std::max(first.bits, second.bits);
  Expr a = typed(first, depth - 1);
  Expr b = typed(second, depth - 1);
  // Logic is of the bits of the longer one, and its result has a sign where one of them has.
  const std::string computed = how.logic ? "u64" : is_signed || bits < 32 ? "i64" : bits == 32 ? "u32" : "u64";
  const std::string meant = how.logic ? fmt::format("({}{})", is_signed ? "i" : "u", bits) : std::string();
  Expr out;
  out.type = &type;
  out.power = kPrimary;
  out.constant = a.constant && b.constant;
  out.pre = a.pre + b.pre;
  out.st = fmt::format("TO_{}({} {} {})", type.st, inside(a, how.power), how.op, inside(b, how.power + 1));
  out.c = temp(
      type,
      fmt::format("({}){}{}_{}(({}){}, ({}){})", type.c, meant, how.function, computed, computed, a.c, computed, b.c),
      out.pre);
  return out;
}

Expr Generator::real(const Type& type, int depth) {
  const auto both = [&](const char* op, Power power, const std::string& name) {
    const Expr a = typed(type, depth - 1);
    return binary(type, op, power, name + type.c, a, operand_of(type, depth - 1, true));
  };
  switch (random_.below(10)) {
    case 0:
    case 1:
      return both("+", kSum, "add_");
    case 2:
      return both("-", kSum, "sub_");
    case 3:
      return both("*", kProduct, "mul_");
    case 4:
      return both("/", kProduct, "div_");
    case 5: {
      const Type& exponent = random_.chance(50) ? type : *dint_;
      const Expr a = typed(type, depth - 1);
      const Expr b = typed(exponent, depth - 1);
      if (random_.chance(50)) return binary(type, "**", kPower, "expt_" + type.c, a, b);
      return call(type, "EXPT", "expt_" + type.c, {a, b});
    }
    case 6: {
      static const std::vector<std::pair<std::string, std::string>> kFunctions = {
          {"ABS", "abs_"},   {"SQRT", "sqrt_"}, {"SIN", "sin_"}, {"COS", "cos_"},
          {"ATAN", "atan_"}, {"EXP", "exp_"},   {"LN", "ln_"}};
      const auto& [name, function] = random_.pick(kFunctions);
      return call(type, name, function + type.c, {typed(type, depth - 1)});
    }
    case 7:
      return random_.chance(50) ? prefix(type, "-", "neg_" + type.c, typed(type, depth - 1)) : selection(type, depth);
    default:
      return converted(type, depth);
  }
}

Expr Generator::duration(const Type& type, int depth) {
  const Expr a = typed(type, depth - 1);
  switch (random_.below(9)) {
    case 0:
      return binary(type, "+", kSum, "add_i64", a, operand_of(type, depth - 1, true));
    case 1:
      return binary(type, "-", kSum, "sub_i64", a, operand_of(type, depth - 1, true));
    case 2: {
      const Expr b = typed(*any_int(), depth - 1);
      return binary(type, "*", kProduct, "mul_i64", a, b);
    }
    case 3: {
      const Type& by = *any_int();
      return binary(type, "/", kProduct, by.kind == Kind::kUnsigned ? "time_div_u64" : "div_i64", a,
                    typed(by, depth - 1));
    }
    case 4: {
      const Expr b = typed(random_.chance(50) ? *real_ : *lreal_, depth - 1);
      return random_.chance(50) ? binary(type, "*", kProduct, "time_mul_real", a, b)
                                : binary(type, "/", kProduct, "time_div_real", a, b);
    }
    case 5:
      return prefix(type, "-", "neg_i64", a);
    case 6:
      return selection(type, depth);
    case 7: {
      const Type& from = *elementary_[1 + random_.below(14)];
      const bool is_real = from.kind == Kind::kReal;
      return call(type, fmt::format("{}_TO_{}", from.st, type.st),
                  type.is_long ? (is_real ? "real_to_i64" : "(i64)")
                  : is_real    ? "time_of_real"
                               : "time_of",
                  {typed(from, depth - 1)});
    }
    default: {
      // DATE, TOD and DT differ by a duration of their length.
      static constexpr Kind kKinds[] = {Kind::kDate, Kind::kTod, Kind::kDt};
      const Kind kind = kKinds[random_.below(3)];
      for (const Type* of : elementary_) {
        if (of->kind != kind || of->is_long != type.is_long) continue;
        const Expr x = typed(*of, depth - 1);
        return binary(type, "-", kSum, "sub_i64", x, typed(*of, depth - 1));
      }
      return a;
    }
  }
}

Expr Generator::date(const Type& type, int depth) {
  if (type.kind == Kind::kDate || random_.chance(40)) return selection(type, depth);
  const Type& by = type.is_long ? *ltime_ : *time_;
  const bool later = random_.chance(50);
  const Expr a = typed(type, depth - 1);
  const Expr b = typed(by, depth - 1);
  const char* function = type.kind == Kind::kTod ? (later ? "tod_add" : "tod_sub") : (later ? "add_i64" : "sub_i64");
  return binary(type, later ? "+" : "-", kSum, function, a, b);
}

Expr Generator::text(const Type& type, int depth) {
  // A growing string would outgrow what the translation has room for: only one argument may be a longer expression.
  const auto brief = [&] {
    if (const auto found = place(type, Use::kRead, 0)) return load(*found);
    return literal(type, true);
  };
  const auto number = [&] {
    const Type& of = *any_int();
    Expr n = typed(of, depth - 2);
    if (of.kind == Kind::kUnsigned && of.bits == 64) {
      n.c = temp(of, fmt::format("{0} > INT64_MAX ? INT64_MAX : {0}", n.c), n.pre);
    }
    return n;
  };
  const auto small = [&] { return integer_literal(*int_, random_.between(random_.chance(20) ? -1 : 0, 9), true); };
  const auto count = [&] { return random_.chance(70) ? small() : number(); };
  const Expr a = depth > 1 ? value(type, depth - 2) : brief();
  // The number of counts of one call is of one type: a literal takes that of the other.
  switch (random_.below(10)) {
    case 0:
      return call(type, "LEFT", "str_left", {a, count()}, {"IN", "L"});
    case 1:
      return call(type, "RIGHT", "str_right", {a, count()}, {"IN", "L"});
    case 2: {
      const Expr n = small();
      return call(type, "MID", "str_mid", {a, n, small()}, {"IN", "L", "P"});
    }
    case 3:
    case 4:
      return call(type, "CONCAT", "str_join", {brief(), brief()}, {"IN1", "IN2"});
    case 5: {
      const Expr b = brief();
      return call(type, "INSERT", "str_insert", {brief(), b, count()}, {"IN1", "IN2", "P"});
    }
    case 6: {
      const Expr n = small();
      return call(type, "DELETE", "str_delete", {a, n, small()}, {"IN", "L", "P"});
    }
    case 7: {
      const Expr x = brief();
      const Expr b = brief();
      const Expr n = small();
      return call(type, "REPLACE", "str_replace", {x, b, n, small()}, {"IN1", "IN2", "L", "P"});
    }
    case 8: {
      const Type& of = *any_int();
      const Expr n = typed(of, depth - 1);
      const std::string name = fmt::format("{}_TO_{}", of.st, type.is_long ? "WSTRING" : "STRING");
      return call(type, name, of.kind == Kind::kUnsigned ? "str_of_unsigned" : "str_of_signed", {n});
    }
    default:
      return selection(type, depth);
  }
}

Expr Generator::selection(const Type& type, int depth) {
  const bool is_text = type.kind == Kind::kString;
  const std::string suffix = is_text ? "str" : type.c;
  const auto next = [&] { return typed(type, is_text ? 0 : depth - 1); };
  if (type.kind == Kind::kEnum) return literal(type, true);
  switch (random_.below(type.kind == Kind::kBool ? 2 : 5)) {
    case 0:
    case 1: {
      const Expr g = value(*bool_, depth - 1);
      const Expr a = next();
      return call(type, "SEL", "sel_" + suffix, {g, a, next()}, {"G", "IN0", "IN1"});
    }
    case 2: {
      const Expr a = next();
      return call(type, "MAX", "max_" + suffix, {a, next()}, {"IN1", "IN2"});
    }
    case 3: {
      const Expr a = next();
      return call(type, "MIN", "min_" + suffix, {a, next()}, {"IN1", "IN2"});
    }
    default: {
      if (is_text) return call(type, "MAX", "max_" + suffix, {next(), next()});
      const Expr a = next();
      const Expr b = next();
      return call(type, "LIMIT", "limit_" + suffix, {a, b, next()}, {"MN", "IN", "MX"});
    }
  }
}

/// word.3, word.%X3, dword.%B1 of a variable.
std::optional<Expr> Generator::partial_read(const Type& type, int depth) {
  const unsigned width = type.kind == Kind::kBool ? 1 : type.bits;
  std::vector<const Type*> wider;
  for (const Type* of : elementary_) {
    if ((of->kind == Kind::kBits || of->is_int()) && of->bits > width) wider.push_back(of);
  }
  const Type& of = *random_.pick(wider);
  const auto found = place(of, Use::kRead, depth);
  if (!found || found->type != &of) return std::nullopt;
  Expr out = load(*found);
  const auto index = random_.below(of.bits / width);
  const char letter = width == 1 ? 'X' : width == 8 ? 'B' : width == 16 ? 'W' : 'D';
  out.st += width == 1 && random_.chance(50) ? fmt::format(".{}", index) : fmt::format(".%{}{}", letter, index);
  out.c = temp(type, fmt::format("({})get_u{}({}, {}, {})", type.c, of.bits, out.c, index * width, width), out.pre);
  out.type = &type;
  return out;
}

/// X_TO_Y and TRUNC.
Expr Generator::converted(const Type& type, int depth) {
  const Type* from = elementary_[random_.below(17)];  // up to LTIME
  if (from == &type || (from->kind == Kind::kDuration && type.kind == Kind::kDuration))
    from = real_->bits == type.bits ? dint_ : real_;
  if (from == &type) from = lreal_;
  const Expr a = typed(*from, depth - 1);
  const std::string name =
      random_.chance(80) ? fmt::format("{}_TO_{}", from->st, type.st) : fmt::format("TO_{}", type.st);
  std::string function = fmt::format("({})", type.c);
  if (from->kind == Kind::kReal) {
    if (type.is_int() && random_.chance(25))
      return call(type, fmt::format("TRUNC_{}", type.st), "trunc_to_" + type.c, {a});
    if (type.kind == Kind::kBool) {
      function = "real_to_bool";
    } else if (type.kind != Kind::kReal) {
      function = "real_to_" + type.c;
    } else {
      function = "real_to_" + type.c;
    }
  } else if (type.kind == Kind::kBool) {
    function = "0 != ";
  } else if (from->kind == Kind::kDuration && !from->is_long) {
    function = type.kind == Kind::kReal ? "time_to_" + type.c : fmt::format("({})ms_of", type.c);
  }
  return call(type, name, function, {a});
}

}  // namespace plc::programs
