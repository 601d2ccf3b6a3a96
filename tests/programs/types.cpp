// Random types, literals in every form, initial values.
#include <fmt/format.h>

#include <cmath>

#include "tests/programs/generator.h"

namespace plc::programs {
namespace {

constexpr std::int64_t kMs = 1'000'000, kSecond = 1000 * kMs, kDay = 86'400 * kSecond;

std::int64_t days_from_civil(std::int64_t y, unsigned m, unsigned d) {
  std::int64_t days = 0;
  const auto leap = [](std::int64_t year) { return (year % 4 == 0 && year % 100 != 0) || year % 400 == 0; };
  for (std::int64_t year = 1970; year < y; ++year) days += leap(year) ? 366 : 365;
  constexpr unsigned kLengths[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  for (unsigned month = 1; month < m; ++month) days += kLengths[month - 1] + (month == 2 && leap(y) ? 1 : 0);
  return days + d - 1;
}

std::string c_integer(std::int64_t value, const std::string& type) {
  return fmt::format("({})0x{:x}ull", type, static_cast<std::uint64_t>(value));
}

/// "1_000": underscores between digits.
std::string with_underscores(std::string digits, Random& random) {
  for (std::size_t i = digits.size(); i-- > 1;) {
    if (random.chance(12)) digits.insert(i, "_");
  }
  return digits;
}

std::string based(std::uint64_t value, Random& random) {
  switch (random.below(4)) {
    case 0:
      return "2#" + with_underscores(fmt::format("{:b}", value), random);
    case 1:
      return "8#" + with_underscores(fmt::format("{:o}", value), random);
    case 2:
      return "16#" + with_underscores(fmt::format("{:x}", value), random);
    default:
      return "16#" + with_underscores(fmt::format("{:X}", value), random);
  }
}

}  // namespace

const Type* Generator::add(Type type) {
  program_.types.push_back(std::make_unique<Type>(std::move(type)));
  return program_.types.back().get();
}

const Type* Generator::elementary(std::string st, std::string c, Kind kind, unsigned bits, bool is_long) {
  Type type;
  type.st = std::move(st);
  type.c = std::move(c);
  type.kind = kind;
  type.bits = bits;
  type.is_long = is_long;
  const Type* added = add(std::move(type));
  elementary_.push_back(added);
  scalars_.push_back(added);
  return added;
}

const Type* Generator::string_type(bool wide) {
  Type type;
  type.kind = Kind::kString;
  type.is_long = wide;
  type.c = "str";
  type.capacity = random_.chance(30) ? 80 : static_cast<std::uint16_t>(random_.between(1, 30));
  const std::string name = wide ? "WSTRING" : "STRING";
  type.st = type.capacity == 80 && random_.chance(70) ? name : fmt::format("{}[{}]", name, type.capacity);
  return add(std::move(type));
}

const Type* Generator::array_of(const Type& element, unsigned dimensions) {
  Type type;
  type.kind = Kind::kArray;
  type.st = fresh("Arr");
  type.c = type.st;
  type.base = &element;
  std::string bounds, sizes;
  for (unsigned i = 0; i < dimensions; ++i) {
    const std::int64_t lower = random_.chance(50) ? 0 : random_.between(-3, 10);
    const std::int64_t upper = lower + random_.between(dimensions == 3 ? 0 : 1, dimensions == 1 ? 7 : 3);
    type.bounds.emplace_back(lower, upper);
    bounds += fmt::format("{}{}..{}", i == 0 ? "" : ", ", lower, upper);
    sizes += fmt::format("[{}]", upper - lower + 1);
  }
  type.declaration_st = fmt::format("{} : ARRAY[{}] OF {};\n", type.st, bounds, element.st);
  type.declaration_c = fmt::format("typedef struct {{ {} e{}; }} {};\nstatic void init_{}({}* p) {{\n", element.c,
                                   sizes, type.c, type.c, type.c);
  std::string at = "p->e", ends;
  for (unsigned i = 0; i < dimensions; ++i) {
    const auto [lower, upper] = type.bounds[i];
    type.declaration_c += fmt::format("for (int i{} = 0; i{} <= {}; ++i{}) {{\n", i, i, upper - lower, i);
    at += fmt::format("[i{}]", i);
    ends += "}";
  }
  type.declaration_c += initialisation(element, at) + ends + "}\n";
  const Type* added = add(std::move(type));
  aggregates_.push_back(added);
  return added;
}

const Type* Generator::structure(const std::vector<const Type*>& members, const char* prefix) {
  Type type;
  type.kind = Kind::kStruct;
  type.st = fresh(prefix);
  type.c = type.st;
  type.declaration_st = type.st + " : STRUCT\n";
  type.declaration_c = "typedef struct {\n";
  std::string init;
  for (const Type* member : members) {
    Variable variable;
    variable.name = fresh("m");
    variable.type = member;
    if (random_.chance(30)) initial_value(variable);
    type.declaration_st += fmt::format("  {} : {}{};\n", variable.name, member->st,
                                       variable.initial_st.empty() ? "" : " := " + variable.initial_st);
    type.declaration_c += fmt::format("{} {};\n", member->c, variable.name);
    init += initialisation(variable, "p->" + variable.name);
    type.members.push_back(std::move(variable));
  }
  type.declaration_st += "END_STRUCT;\n";
  type.declaration_c += fmt::format("}} {};\nstatic void init_{}({}* p) {{\n{}}}\n", type.c, type.c, type.c, init);
  const Type* added = add(std::move(type));
  aggregates_.push_back(added);
  return added;
}

void Generator::make_types() {
  bool_ = elementary("BOOL", "u8", Kind::kBool, 8);
  elementary("SINT", "i8", Kind::kSigned, 8);
  int_ = elementary("INT", "i16", Kind::kSigned, 16);
  dint_ = elementary("DINT", "i32", Kind::kSigned, 32);
  elementary("LINT", "i64", Kind::kSigned, 64);
  elementary("USINT", "u8", Kind::kUnsigned, 8);
  elementary("UINT", "u16", Kind::kUnsigned, 16);
  elementary("UDINT", "u32", Kind::kUnsigned, 32);
  elementary("ULINT", "u64", Kind::kUnsigned, 64);
  elementary("BYTE", "u8", Kind::kBits, 8);
  elementary("WORD", "u16", Kind::kBits, 16);
  elementary("DWORD", "u32", Kind::kBits, 32);
  elementary("LWORD", "u64", Kind::kBits, 64);
  real_ = elementary("REAL", "f32", Kind::kReal, 32);
  lreal_ = elementary("LREAL", "f64", Kind::kReal, 64);
  time_ = elementary("TIME", "i64", Kind::kDuration, 64);
  ltime_ = elementary("LTIME", "i64", Kind::kDuration, 64, true);
  elementary("DATE", "i64", Kind::kDate, 64);
  elementary("LDATE", "i64", Kind::kDate, 64, true);
  elementary("TIME_OF_DAY", "i64", Kind::kTod, 64);
  elementary("LTIME_OF_DAY", "i64", Kind::kTod, 64, true);
  elementary("DATE_AND_TIME", "i64", Kind::kDt, 64);
  elementary("LDATE_AND_TIME", "i64", Kind::kDt, 64, true);
  make_pointer_types();
  for (int i = 0; i < 3; ++i) scalars_.push_back(string_type(false));
  scalars_.push_back(string_type(true));
  // What STRING and WSTRING functions return: longer than any argument.
  Type unlimited;
  unlimited.kind = Kind::kString;
  unlimited.c = "str";
  unlimited.capacity = 500;
  unlimited.st = "STRING[500]";
  string_ = add(unlimited);
  unlimited.is_long = true;
  unlimited.st = "WSTRING[500]";
  wstring_ = add(unlimited);

  for (int i = 0; i < 2; ++i) {
    Type type;
    type.kind = Kind::kEnum;
    type.st = fresh("Enum");
    type.base = i == 0 ? int_ : elementary_[1 + random_.below(8)];
    type.c = type.base->c;
    type.bits = type.base->bits;
    std::int64_t next = 0;
    std::string list;
    const int count = static_cast<int>(random_.between(2, 6));
    for (int k = 0; k < count; ++k) {
      const bool given = i == 1 && random_.chance(40);
      if (given) next += random_.between(0, 9);
      // Two enumerations may share a name: Type#Name tells them apart.
      type.values.emplace_back(k == 0 ? "Shared" : fresh("E"), next);
      list +=
          fmt::format("{}{}{}", k == 0 ? "" : ", ", type.values.back().first, given ? fmt::format(" := {}", next) : "");
      ++next;
    }
    type.initial = type.values[0].second;
    std::string initial;
    if (random_.chance(50)) {
      const auto& [name, number] = random_.pick(type.values);
      initial = " := " + name;
      type.initial = number;
    }
    type.declaration_st = fmt::format("{} : {}({}){};\n", type.st, i == 0 ? "" : type.base->st + " ", list, initial);
    scalars_.push_back(add(std::move(type)));
  }
  for (int i = 0; i < 2; ++i) {
    Type type;
    type.kind = Kind::kSubrange;
    type.st = fresh("Range");
    type.base = elementary_[1 + random_.below(8)];
    type.c = type.base->c;
    type.bits = type.base->bits;
    // 0 lies within: a bad index reads zeros.
    type.lower = type.base->kind == Kind::kUnsigned ? 0 : random_.between(-100, 0);
    type.upper = random_.between(1, 120);
    type.initial = type.lower;
    std::string initial;
    if (random_.chance(50)) {
      type.initial = random_.between(type.lower, type.upper);
      initial = fmt::format(" := {}", type.initial);
    }
    type.declaration_st = fmt::format("{} : {}({}..{}){};\n", type.st, type.base->st, type.lower, type.upper, initial);
    scalars_.push_back(add(std::move(type)));
  }
  for (int i = 0; i < 3; ++i) {
    Type type;
    type.kind = Kind::kRef;
    type.base = &random_scalar();
    type.st = fresh("Ref");
    type.c = type.base->c + "*";
    type.declaration_st = fmt::format("{} : REF_TO {};\n", type.st, type.base->st);
    scalars_.push_back(add(std::move(type)));
  }
  for (int i = 0; i < 3; ++i) array_of(random_scalar(), static_cast<unsigned>(i + 1));
  for (int i = 0; i < 3; ++i) {
    std::vector<const Type*> members;
    for (std::int64_t k = random_.between(2, 5); k > 0; --k) members.push_back(&random_type());
    structure(members, "Struct");
  }
  array_of(*aggregates_.back(), 1);
  Type type;
  type.kind = Kind::kRef;
  type.base = random_.pick(aggregates_);
  type.st = fresh("Ref");
  type.c = type.base->c + "*";
  type.declaration_st = fmt::format("{} : REF_TO {};\n", type.st, type.base->st);
  scalars_.push_back(add(std::move(type)));
}

const Type& Generator::random_scalar() { return *random_.pick(scalars_); }
const Type& Generator::random_type() {
  return random_.chance(70) || aggregates_.empty() ? random_scalar() : *random_.pick(aggregates_);
}

// ---- literals ---------------------------------------------------------------------------------------------------

std::int64_t Generator::edge_value(const Type& type) {
  if (type.kind == Kind::kSubrange) return random_.between(type.lower, type.upper);
  const bool is_signed = type.kind == Kind::kSigned;
  const unsigned width = type.bits - (is_signed ? 1 : 0);
  const std::uint64_t greatest = ~0ull >> (64 - width);
  switch (random_.below(10)) {
    case 0:
      return static_cast<std::int64_t>(greatest);
    case 1:
      return is_signed ? -static_cast<std::int64_t>(greatest) - 1 : 0;
    case 2:
      return static_cast<std::int64_t>(random_.bits() & greatest);
    case 3:
      return static_cast<std::int64_t>((1ull << random_.below(width)) & greatest);
    case 4:
      return is_signed ? -random_.between(1, 100) : random_.between(1, 100);
    default:
      return random_.between(0, 10);
  }
}

Expr Generator::integer_literal(const Type& type, std::int64_t value, bool may_be_untyped) {
  Expr out;
  out.constant = true;
  out.type = &type.plain();
  const Type& plain = type.plain();
  out.c = c_integer(value, plain.c);
  const bool negative = plain.kind == Kind::kSigned && value < 0;
  const std::uint64_t magnitude = negative ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  const std::string digits = !negative && random_.chance(plain.kind == Kind::kBits ? 70 : 20)
                                 ? based(magnitude, random_)
                                 : with_underscores(fmt::format("{}", magnitude), random_);
  out.untyped = may_be_untyped && random_.chance(70);
  out.power = negative && out.untyped ? kUnary : kPrimary;
  out.st = fmt::format("{}{}{}", out.untyped ? "" : plain.st + "#", negative ? "-" : "", digits);
  return out;
}

Expr Generator::real_literal(const Type& type, bool may_be_untyped) {
  Expr out;
  out.constant = true;
  out.type = &type;
  std::string digits;
  if (random_.chance(10)) {
    digits = fmt::format("{}.0", random_.below(4));
  } else {
    digits = fmt::format("{}.{}", random_.below(random_.chance(70) ? 100 : 100000), random_.below(1000));
  }
  std::string exponent;
  if (random_.chance(25)) exponent = fmt::format("E{}{}", random_.pick<std::string>({"", "+", "-"}), random_.below(25));
  const bool negative = random_.chance(20);
  out.untyped = may_be_untyped && random_.chance(70);
  out.power = negative && out.untyped ? kUnary : kPrimary;
  out.c = fmt::format("({}{}{}{})", negative ? "-" : "", digits, exponent, type.bits == 32 ? "f" : "");
  const std::size_t point = digits.find('.');
  out.st = fmt::format("{}{}{}.{}{}", out.untyped ? "" : type.st + "#", negative ? "-" : "",
                       with_underscores(digits.substr(0, point), random_),
                       with_underscores(digits.substr(point + 1), random_), exponent);
  return out;
}

Expr Generator::duration_literal(const Type& type) {
  struct Unit {
    const char* name;
    std::int64_t ns;
    std::int64_t most;
  };
  constexpr Unit kUnits[] = {{"d", kDay, 30},  {"h", 3600 * kSecond, 23}, {"m", 60 * kSecond, 59}, {"s", kSecond, 59},
                             {"ms", kMs, 999}, {"us", 1000, 999},         {"ns", 1, 999}};
  std::int64_t total = 0;
  std::string text;
  const std::size_t first = random_.below(7);
  const std::size_t last = std::min<std::size_t>(6, first + random_.below(3));
  for (std::size_t i = first; i <= last; ++i) {
    if (i != first && random_.chance(30)) continue;
    const std::int64_t n = random_.between(0, i == first ? 2 * kUnits[i].most : kUnits[i].most);
    total += n * kUnits[i].ns;
    if (!text.empty() && random_.chance(30)) text += "_";
    text += fmt::format("{}{}", n, kUnits[i].name);
  }
  if (last < 6 && random_.chance(20)) {  // T#1.5h
    const std::int64_t n = random_.between(0, 99);
    total = n * kUnits[last].ns + kUnits[last].ns / 10 * 5;
    text = fmt::format("{}.5{}", n, kUnits[last].name);
  }
  const bool negative = random_.chance(20);
  if (negative) total = -total;
  const std::vector<std::string> prefixes =
      type.is_long ? std::vector<std::string>{"LTIME#", "LT#", "lt#"} : std::vector<std::string>{"T#", "TIME#", "t#"};
  Expr out;
  out.constant = true;
  out.type = &type;
  out.st = random_.pick(prefixes) + (negative ? "-" : "") + text;
  out.c = c_integer(total, "i64");
  return out;
}

Expr Generator::date_literal(const Type& type) {
  const std::int64_t year = random_.between(1970, 2100);
  const auto month = static_cast<unsigned>(random_.between(1, 12));
  const auto day = static_cast<unsigned>(random_.between(1, 28));
  const std::int64_t h = random_.between(0, 23), m = random_.between(0, 59), s = random_.between(0, 59);
  const std::int64_t ms = random_.chance(40) ? random_.between(0, 999) : -1;
  const std::string date = fmt::format("{:04}-{:02}-{:02}", year, month, day);
  const std::string time = fmt::format("{:02}:{:02}:{:02}{}", h, m, s, ms < 0 ? "" : fmt::format(".{:03}", ms));
  const std::int64_t in_day = ((h * 60 + m) * 60 + s) * kSecond + std::max<std::int64_t>(ms, 0) * kMs;
  const std::int64_t midnight = days_from_civil(year, month, day) * kDay;
  const bool brief = random_.chance(50);
  const std::string l = type.is_long ? "L" : "";
  Expr out;
  out.constant = true;
  out.type = &type;
  switch (type.kind) {
    case Kind::kDate:
      out.st = l + (brief ? "D#" : "DATE#") + date;
      out.c = c_integer(midnight, "i64");
      break;
    case Kind::kTod:
      out.st = l + (brief ? "TOD#" : "TIME_OF_DAY#") + time;
      out.c = c_integer(in_day, "i64");
      break;
    default:
      out.st = l + (brief ? "DT#" : "DATE_AND_TIME#") + date + "-" + time;
      out.c = c_integer(midnight + in_day, "i64");
  }
  return out;
}

Expr Generator::string_literal(const Type& type) {
  const char quote = type.is_long ? '"' : '\'';
  std::string st(1, quote), units;
  const std::size_t length = random_.below(std::min<std::size_t>(type.capacity, 12) + 1);
  for (std::size_t i = 0; i < length; ++i) {
    unsigned code = static_cast<unsigned>(random_.chance(80) ? random_.between('a', 'e') : random_.between(' ', '~'));
    if (random_.chance(4)) code = static_cast<unsigned>(random_.between(1, type.is_long ? 0xffff : 0xff));
    const auto c = static_cast<char>(code);
    if (code < ' ' || code > '~') {
      st += type.is_long ? fmt::format("${:04X}", code) : fmt::format("${:02X}", code);
    } else if (c == '$' || c == quote) {
      st += std::string("$") + c;
    } else {
      st += c;
    }
    units += fmt::format("{}{}", units.empty() ? "" : ",", code);
  }
  Expr out;
  out.constant = true;
  out.type = type.is_long ? wstring_ : string_;
  out.st = st + quote;
  out.c = length == 0 ? "(str){0}" : fmt::format("str_of({}, (const u16[]){{{}}})", length, units);
  return out;
}

Expr Generator::enum_literal(const Type& type) {
  const auto& [name, number] = random_.pick(type.values);
  Expr out;
  out.constant = true;
  out.type = &type;
  out.st = name == "Shared" || random_.chance(50) ? type.st + "#" + name : name;
  out.c = c_integer(number, type.c);
  return out;
}

Expr Generator::literal(const Type& type, bool may_be_untyped) {
  Expr out;
  out.constant = true;
  switch (type.kind) {
    case Kind::kBool: {
      const bool on = random_.chance(50);
      out.type = &type;
      out.st = random_.chance(80) ? (on ? "TRUE" : "FALSE") : (on ? "BOOL#1" : "BOOL#0");
      out.c = on ? "(u8)1" : "(u8)0";
      return out;
    }
    case Kind::kReal:
      return real_literal(type, may_be_untyped);
    case Kind::kDuration:
      return duration_literal(type);
    case Kind::kDate:
    case Kind::kTod:
    case Kind::kDt:
      return date_literal(type);
    case Kind::kString:
      return string_literal(type);
    case Kind::kEnum:
      return enum_literal(type);
    case Kind::kRef:
      out.type = &type;
      out.st = "NULL";
      out.c = "0";
      return out;
    default:
      return integer_literal(type, edge_value(type), may_be_untyped);
  }
}

// ---- initial values -----------------------------------------------------------------------------------------------

std::optional<std::pair<std::string, std::string>> Generator::initial_of(const Type& type, const std::string& place) {
  switch (type.kind) {
    case Kind::kRef:
    case Kind::kPointer:
    case Kind::kBlock:
      return std::nullopt;
    case Kind::kArray: {
      if (type.bounds.size() > 1) return std::nullopt;
      std::string st, c;
      std::int64_t at = 0;
      const std::int64_t count = type.bounds[0].second - type.bounds[0].first + 1;
      while (at < count && (at == 0 || random_.chance(80))) {
        const std::int64_t times = type.base->is_scalar() && random_.chance(25) ? random_.between(1, count - at) : 1;
        const auto one = initial_of(*type.base, "%");
        if (!one) return std::nullopt;
        st += fmt::format("{}{}", st.empty() ? "" : ", ",
                          times > 1 ? fmt::format("{}({})", times, one->first) : one->first);
        for (std::int64_t i = 0; i < times; ++i, ++at) {
          std::string text = one->second;
          const std::string element = fmt::format("{}.e[{}]", place, at);
          for (std::size_t k = text.find('%'); k != std::string::npos; k = text.find('%', k + element.size())) {
            text.replace(k, 1, element);
          }
          c += text;
        }
      }
      return std::pair("[" + st + "]", c);
    }
    case Kind::kStruct: {
      std::string st, c;
      for (const Variable& member : type.members) {
        if (!random_.chance(60)) continue;
        const auto one = initial_of(*member.type, place + "." + member.name);
        if (!one) continue;
        st += fmt::format("{}{} := {}", st.empty() ? "" : ", ", member.name, one->first);
        c += one->second;
      }
      if (st.empty()) return std::nullopt;
      return std::pair("(" + st + ")", c);
    }
    default: {
      const Expr value = literal(type, true);
      if (type.kind == Kind::kString) return std::pair(value.st, fmt::format("{} = {};\n", place, value.c));
      return std::pair(value.st, fmt::format("{} = {};\n", place, value.c));
    }
  }
}

void Generator::initial_value(Variable& variable) {
  const auto made = initial_of(*variable.type, "@");
  if (!made) return;
  variable.initial_st = made->first;
  variable.initial_c = made->second;
}

bool holds_instance(const Type& type) {
  if (type.kind == Kind::kBlock) return true;
  if (type.kind == Kind::kArray) return holds_instance(*type.base);
  for (const Variable& member : type.members) {
    if (type.kind == Kind::kStruct && holds_instance(*member.type)) return true;
  }
  return false;
}

std::string initialisation(const Type& type, const std::string& place) {
  switch (type.kind) {
    case Kind::kArray:
    case Kind::kStruct:
    case Kind::kBlock:
      return fmt::format("init_{}(&{});\n", type.c, place);
    case Kind::kEnum:
    case Kind::kSubrange:
      return fmt::format("{} = {};\n", place, c_integer(type.initial, type.c));
    case Kind::kString:
      return fmt::format("memset(&{}, 0, sizeof(str));\n", place);
    case Kind::kPointer:
      return fmt::format("memset(&{}, 0, sizeof(ptr));\n", place);
    default:
      return fmt::format("{} = 0;\n", place);
  }
}

std::string initialisation(const Variable& variable, const std::string& place) {
  std::string out = initialisation(*variable.type, place);
  for (std::size_t i = 0; i < variable.initial_c.size(); ++i) {
    if (variable.initial_c[i] == '@') {
      out += place;
    } else {
      out += variable.initial_c[i];
    }
  }
  return out;
}

}  // namespace plc::programs
