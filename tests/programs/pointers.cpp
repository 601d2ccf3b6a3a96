// Pointers: into variables of numbers, moved by bytes, read and written as any other number, in and out of their
// object.
#include <fmt/format.h>

#include "tests/programs/generator.h"

namespace plc::programs {

namespace {

/// Numbers that lie as many bytes as C has them; BOOLs and what has limits would be brought back into their range.
bool is_number(const Type& type) {
  return type.is_int() || type.kind == Kind::kReal || (type.kind == Kind::kBits && type.bits >= 8);
}
const Type& element_of(const Type& type) { return type.kind == Kind::kArray ? element_of(*type.base) : type; }

}  // namespace

void Generator::make_pointer_types() {
  for (const Type* number : elementary_) {
    if (!is_number(*number)) continue;
    Type pointer;
    pointer.kind = Kind::kPointer;
    pointer.st = "POINTER TO " + number->st;
    pointer.c = "ptr";
    pointer.base = number;
    pointers_.push_back(add(std::move(pointer)));
  }
}

Visible Generator::some_pointer() {
  std::vector<Visible> known;
  for (const Visible& visible : scope_) {
    if (visible.type->kind == Kind::kPointer) known.push_back(visible);
  }
  if (!known.empty() && !random_.chance(30 / static_cast<unsigned>(known.size()))) return random_.pick(known);
  Variable variable;
  variable.name = fresh("q");
  variable.type = random_.pick(pointers_);
  add_variable(variable);
  return scope_.back();
}

Stmt Generator::pointer_statement() {
  const Visible pointer = some_pointer();
  const Type& target = *pointer.type->base;
  const unsigned bytes = target.bits / 8;
  switch (random_.below(8)) {
    case 0:
    case 1: {
      std::vector<Visible> objects;
      for (const Visible& visible : scope_) {
        const bool lasts = visible.stable || pou_->kind == PouKind::kFunction;
        if (visible.writable && !visible.checked && lasts && is_number(element_of(*visible.type))) {
          objects.push_back(visible);
        }
      }
      if (objects.empty()) return assignment();
      const Visible& object = random_.pick(objects);
      const Type& element = element_of(*object.type);
      const std::int64_t by = random_.chance(50) ? 0 : random_.between(-2, 12);
      const int real = element.kind == Kind::kReal ? static_cast<int>(element.bits / 8) : 0;
      return simple(
          fmt::format("{} := ADR({}){};", pointer.st, object.st, by == 0 ? "" : fmt::format(" + ({})", by)),
          fmt::format("{} = (ptr){{(u8*)&{}, sizeof {}, {}, {}}};\n", pointer.c, object.c, object.c, by, real));
    }
    case 2: {
      const Visible other = some_pointer();
      return simple(fmt::format("{} := {};", pointer.st, other.st), fmt::format("{} = {};\n", pointer.c, other.c));
    }
    case 3: {
      const Type& number = *any_int();
      const Expr by = random_.chance(60) ? integer_literal(*dint_, random_.between(-4, 9), true) : typed(number, 1);
      const bool back = random_.chance(30);
      return simple(
          fmt::format("{0} := {0} {1} ({2});", pointer.st, back ? "-" : "+", by.st),
          by.pre + fmt::format("{0}.at = (i64)((u64){0}.at {1} (u64)(i64){2});\n", pointer.c, back ? "-" : "+", by.c));
    }
    case 4: {
      const auto to = place(*bool_, Use::kWrite, 2);
      if (!to || to->type != bool_) return assignment();
      return simple(fmt::format("{} := {} = 0;", to->st, pointer.st),
                    to->pre + store(*to, fmt::format("(u8)ptr_null({})", pointer.c)));
    }
    case 5:
    case 6: {
      const auto to = place(target, Use::kExact, 2);
      if (!to) return assignment();
      const std::int64_t index = random_.between(-1, 3);
      const bool indexed = random_.chance(40);
      return simple(
          fmt::format("{} := {};", to->st, indexed ? fmt::format("{}[{}]", pointer.st, index) : pointer.st + "^"),
          to->pre +
              store(*to, fmt::format("ptr_get_{}(ptr_by({}, {}))", target.c, pointer.c, indexed ? index * bytes : 0)));
    }
    default: {
      const std::int64_t index = random_.between(-1, 3);
      const bool indexed = random_.chance(40);
      const Expr from = assignable(target, 2);
      return simple(
          fmt::format("{} := {};", indexed ? fmt::format("{}[{}]", pointer.st, index) : pointer.st + "^", from.st),
          from.pre + fmt::format("ptr_put_{}(ptr_by({}, {}), {});\n", target.c, pointer.c, indexed ? index * bytes : 0,
                                 from.c));
    }
  }
}

}  // namespace plc::programs
