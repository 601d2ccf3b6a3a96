// Random places: a variable in reach, members, indices (some out of range), references followed.
#include <fmt/format.h>

#include "tests/programs/generator.h"

namespace plc::programs {
namespace {

constexpr int kDeepest = 4;

bool is_string(const Type& type) { return type.kind == Kind::kString; }

bool fits(const Type& type, const Type& wanted, bool exact) {
  if (exact) return &type == &wanted;
  if (is_string(wanted)) return is_string(type) && type.is_long == wanted.is_long;
  return &type.plain() == &wanted;
}

}  // namespace

// Literals, results and variables of one kind of string are one type in expressions, whatever their capacity.
bool Generator::reaches(const Type& from, const Type& wanted, Use use, int depth) const {
  const bool exact = use == Use::kExact || use == Use::kRefer;
  if (fits(from, wanted, exact) && (from.kind != Kind::kBlock || exact)) return true;
  if (depth == kDeepest) return false;
  switch (from.kind) {
    case Kind::kArray:
    case Kind::kRef:
      return reaches(*from.base, wanted, use, depth + 1);
    case Kind::kStruct:
      for (const Variable& member : from.members) {
        if (reaches(*member.type, wanted, use, depth + 1)) return true;
      }
      return false;
    case Kind::kBlock:
      if (exact) return false;
      for (const Variable& member : from.members) {
        const bool seen = member.role == Role::kInput || (member.role == Role::kOutput && use == Use::kRead);
        if (seen && reaches(*member.type, wanted, use, depth + 1)) return true;
      }
      return false;
    default:
      return false;
  }
}

void Generator::step(Place& place, const Type& wanted, Use use, int depth) {
  const Type& type = *place.type;
  switch (type.kind) {
    case Kind::kArray: {
      // All indices first, as they are written, then one step per dimension.
      std::string list, condition, element = "e";
      for (std::size_t i = 0; i < type.bounds.size(); ++i) {
        const auto [lower, upper] = type.bounds[i];
        const Type& of = *any_int();
        Expr index;
        if (depth > 0 && random_.chance(65)) index = typed(of, depth - 1);
        // The compiler refuses an index outside when it knows it.
        if (index.st.empty() || index.constant) {
          index = integer_literal(*dint_, random_.between(lower, upper), true);
        } else {
          const bool tame = random_.chance(85);
          if (tame && of.bits > 8) {
            // Within the bounds: MOD keeps the sign, so ABS comes first.
            const Expr span = integer_literal(of, upper - lower + 1, true);
            const Expr base = integer_literal(of, std::max<std::int64_t>(lower, 0), true);
            Expr magnitude = call(of, "ABS", "abs_" + of.c, {index});
            index = binary(of, "MOD", kProduct, "mod_" + of.c, magnitude, span);
            index = binary(of, "+", kSum, "add_" + of.c, index, base);
          }
          const std::string wide =
              of.kind == Kind::kUnsigned && of.bits == 64
                  ? fmt::format("({0} <= INT64_MAX && (i64){0} >= {1} && (i64){0} <= {2})", index.c, lower, upper)
                  : fmt::format("((i64){0} >= {1} && (i64){0} <= {2})", index.c, lower, upper);
          condition += (condition.empty() ? "" : " && ") + wide;
        }
        place.pre += index.pre;
        list += (i == 0 ? "" : random_.chance(50) ? "," : ", ") + index.st;
        element += fmt::format("[(i64){} - ({})]", index.c, lower);
      }
      place.st += "[" + list + "]";
      if (condition.empty() && !place.checked) {
        place.c += "." + element;
      } else {
        const std::string name = fmt::format("p{}", ++temps_);
        const std::string array = place.checked ? place.c + "->" : place.c + ".";
        const std::string inside = condition.empty() ? "1" : condition;
        // A bad index is an event where it is applied; nothing more happens on a place that is none already.
        place.pre += fmt::format("{}* {} = {}({}) ? &{}{} : (ev = 1, ({}*)0);\n", type.base->c, name,
                                 place.checked ? "(" + place.c + ") && " : "", inside, array, element, type.base->c);
        place.c = name;
        place.checked = true;
      }
      place.type = type.base;
      return;
    }
    case Kind::kRef: {
      place.st += "^";
      const std::string name = fmt::format("p{}", ++temps_);
      if (place.checked) {
        place.pre += fmt::format("{} {} = {} ? *{} : (ev = 1, ({})0);\n", type.c, name, place.c, place.c, type.c);
      } else {
        place.pre += fmt::format("{} {} = {};\n", type.c, name, place.c);
      }
      place.c = name;
      place.checked = true;
      place.stable = true;
      place.type = type.base;
      return;
    }
    default: {
      std::vector<const Variable*> fitting;
      for (const Variable& member : type.members) {
        const bool seen = type.kind == Kind::kStruct || member.role == Role::kInput ||
                          (member.role == Role::kOutput && use == Use::kRead);
        if (seen && reaches(*member.type, wanted, use, 1)) fitting.push_back(&member);
      }
      const Variable& member = *random_.pick(fitting);
      place.st += "." + cased(member.name);
      if (place.checked) {
        // To name a part of what a null reference does not refer to is an event already.
        const std::string name = fmt::format("p{}", ++temps_);
        place.pre += fmt::format("{0}* {1} = {2} ? &{2}->{3} : (ev = 1, ({0}*)0);\n", member.type->c, name, place.c,
                                 member.name);
        place.c = name;
      } else {
        place.c += "." + member.name;
      }
      place.type = member.type;
    }
  }
}

std::optional<Place> Generator::place(const Type& wanted, Use use, int depth) {
  std::vector<const Visible*> fitting;
  for (const Visible& visible : scope_) {
    if (use != Use::kRead && !visible.writable && visible.type->kind != Kind::kRef) continue;
    if (use == Use::kRefer && !visible.stable && visible.type->kind != Kind::kRef) continue;
    if (!visible.writable && use != Use::kRead && visible.type == &wanted) continue;
    if (reaches(*visible.type, wanted, use)) fitting.push_back(&visible);
  }
  if (fitting.empty()) return std::nullopt;
  const Visible& root = *random_.pick(fitting);
  Place out;
  out.type = root.type;
  out.st = cased(root.st);
  out.c = root.c;
  out.checked = root.checked;
  out.stable = root.stable;
  const bool exact = use == Use::kExact || use == Use::kRefer;
  for (int i = 0; i <= kDeepest; ++i) {
    const bool here = fits(*out.type, wanted, exact) && (out.type->kind != Kind::kBlock || exact);
    if (here) {
      // A value that also holds what is wanted deeper inside is as good as the deeper one.
      return out;
    }
    if (!reaches(*out.type, wanted, use, i)) return std::nullopt;
    step(out, wanted, use, depth);
  }
  return std::nullopt;
}

std::string Generator::temp(const Type& type, const std::string& value, std::string& pre) {
  const std::string name = fmt::format("t{}", ++temps_);
  pre += fmt::format("{} {} = {};\n", type.c, name, value);
  return name;
}

Expr Generator::load(const Place& place) {
  Expr out;
  out.type = &place.type->plain();
  if (place.type->kind == Kind::kString) out.type = place.type->is_long ? wstring_ : string_;
  if (place.type->kind == Kind::kSubrange) out.subrange = place.type;
  out.st = place.st;
  out.pre = place.pre;
  const std::string name = fmt::format("t{}", ++temps_);
  if (place.checked) {
    out.pre += fmt::format("{} {}; if ({}) {} = *{}; else {{ memset(&{}, 0, sizeof {}); ev = 1; }}\n", place.type->c,
                           name, place.c, name, place.c, name, name);
  } else {
    out.pre += fmt::format("{} {} = {};\n", place.type->c, name, place.c);
  }
  out.c = name;
  return out;
}

std::string Generator::store(const Place& place, const std::string& value) const {
  if (place.checked) return fmt::format("if ({0}) *{0} = {1}; else ev = 1;\n", place.c, value);
  return fmt::format("{} = {};\n", place.c, value);
}

std::string Generator::address(const Place& place) const { return place.checked ? place.c : "&" + place.c; }

}  // namespace plc::programs
