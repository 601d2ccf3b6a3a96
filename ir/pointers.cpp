#include "ir/pointers.h"

#include <fmt/format.h>

#include <array>

namespace plc::ir {

using core::Code;
using stdlib::Overload;

namespace {

constexpr TypeRef kUlintType = ref_of(TypeId::kUlint);
constexpr TypeRef kLintType = ref_of(TypeId::kLint);

const Type& type_of(Builder& builder, ValueId value) { return builder.module().types[builder.type_of(value)]; }

const Overload& overload(std::string_view function, TypeId type) {
  return *stdlib::overload_with_key(fmt::format("{}:{}", function, core::name_of(type)));
}

ValueId constant(Builder& builder, TypeRef type, std::uint64_t bits) { return builder.constant({type, bits, {}}); }

/// The bits of `value`, which has 64, as a value of another type with as many.
ValueId with_type(Builder& builder, ValueId value, TypeRef type) {
  const std::array both = {value, constant(builder, kUlintType, 0)};
  return builder.call_overload(overload("ADD", TypeId::kUlint), both, type);
}

bool has_64_bits(TypeId id) {
  return id == TypeId::kUlint || id == TypeId::kLint || id == TypeId::kLword || id == TypeId::kPointer;
}
bool has_32_bits(TypeId id) { return id == TypeId::kUdint || id == TypeId::kDword; }

std::string shown(const Operand& operand) { return operand.text.empty() ? "a value" : '"' + operand.text + '"'; }

void note_32(Builder& builder, const Operand& operand, const What& what, TypeRef to, TypeRef from) {
  const TypeTable& types = builder.module().types;
  builder.report(Code::P4207, operand.at,
                 fmt::format("{} of type {} takes {} of type {} as an address of 32 bits", what(), types.name_of(to),
                             shown(operand), types.name_of(from)),
                 "declare it as POINTER TO, or as LWORD or ULINT, which hold all of a pointer");
}

/// An integer or bit string as the bits of a LINT; nothing after a report.
std::optional<ValueId> as_lint(Builder& builder, const Operand& operand) {
  const auto refuse = [&]() -> std::optional<ValueId> {
    builder.report(Code::P4206, operand.at,
                   fmt::format("{} is no number of bytes that a pointer can be moved by", shown(operand)),
                   "pointers move by integers, in bytes");
    return std::nullopt;
  };
  if (operand.kind == Operand::Kind::kIntLiteral) {
    return constant(builder, kLintType, static_cast<std::uint64_t>(operand.int_value));
  }
  if (operand.kind != Operand::Kind::kValue) return refuse();
  const auto id = builder.module().types.elementary_of(builder.type_of(operand.value));
  if (!id || *id == TypeId::kBool || !core::in_category(*id, core::kAnyInt | core::kAnyBit)) return refuse();
  if (has_64_bits(*id)) return operand.value;
  const Overload* const wide = conversion(*id, TypeId::kLint);
  return wide == nullptr ? refuse() : call_or_fold(builder, *wide, std::span(&operand.value, 1), kLintType);
}

}  // namespace

bool is_pointer(Builder& builder, const Operand& operand) {
  return operand.kind == Operand::Kind::kValue && type_of(builder, operand.value).kind == TypeKind::kPointer;
}

std::optional<ValueId> convert_pointer(Builder& builder, const Operand& operand, TypeRef to, const What& what) {
  const TypeTable& types = builder.module().types;
  const bool to_pointer = types[to].kind == TypeKind::kPointer;
  const auto refuse = [&](std::string_view given, std::string help) -> std::optional<ValueId> {
    builder.report(Code::P4206, operand.at,
                   fmt::format("{} needs {}, {} is {}", what(), types.name_of(to), shown(operand), given),
                   std::move(help));
    return std::nullopt;
  };
  if (operand.kind != Operand::Kind::kValue) {
    if (operand.kind == Operand::Kind::kIntLiteral && operand.int_value == 0) return constant(builder, to, 0);
    return refuse("a number", "the only number that is a pointer is 0, which leads nowhere: take addresses with ADR");
  }
  const TypeRef from = builder.type_of(operand.value);
  const auto from_id = types.elementary_of(from);
  const auto id = types.elementary_of(to);
  if (to_pointer && types[from].kind == TypeKind::kPointer) return operand.value;
  if (from_id && id && types[to].kind != TypeKind::kEnum && types[from].kind != TypeKind::kEnum) {
    if (has_64_bits(*from_id) && has_64_bits(*id)) return with_type(builder, operand.value, to);
    if (to_pointer && has_32_bits(*from_id)) {
      note_32(builder, operand, what, to, from);
      return builder.pointer_from_32(operand.value, to);
    }
    if (!to_pointer && has_32_bits(*id)) {
      note_32(builder, operand, what, to, from);
      return builder.pointer_to_32(operand.value, to);
    }
  }
  if (!to_pointer)
    return refuse(types.name_of(from), "LWORD and ULINT hold a pointer; what it leads to is read with ^");
  const bool reference = types[from].kind == TypeKind::kReference;
  return refuse(types.name_of(from), reference ? "take the address of what it refers to: ADR(reference^)"
                                               : "take the address of a variable: ADR(variable)");
}

std::optional<ValueId> move_pointer(Builder& builder, ValueId pointer, const Operand& bytes, bool back) {
  const auto distance = as_lint(builder, bytes);
  if (!distance) return std::nullopt;
  const std::array both = {pointer, *distance};
  return builder.call_overload(overload(back ? "SUB" : "ADD", TypeId::kUlint), both, builder.type_of(pointer));
}

std::optional<ValueId> index_pointer(Builder& builder, ValueId pointer, const Operand& index, std::uint64_t size) {
  const auto number = as_lint(builder, index);
  if (!number) return std::nullopt;
  const std::array factors = {*number, constant(builder, kLintType, size)};
  const Overload& times = overload("MUL", TypeId::kLint);
  const bool known = builder.body().insts[number->index].op == Op::kConst;
  const ValueId distance =
      known ? call_or_fold(builder, times, factors, kLintType) : builder.call_overload(times, factors, kLintType);
  const std::array both = {pointer, distance};
  return builder.call_overload(overload("ADD", TypeId::kUlint), both, builder.type_of(pointer));
}

ValueId pointer_distance(Builder& builder, ValueId a, ValueId b) {
  const std::array both = {a, b};
  const ValueId distance = builder.call_overload(overload("SUB", TypeId::kUlint), both, kLintType);
  builder.set_narrow(distance, {TypeId::kDint, stdlib::Idiom::kNone, true});
  return distance;
}

std::optional<ValueId> compare_pointers(Builder& builder, std::string_view function, const Operand& a,
                                        const Operand& b) {
  const Operand& known = is_pointer(builder, a) ? a : b;
  const Operand& other = is_pointer(builder, a) ? b : a;
  const TypeRef pointer = builder.type_of(known.value);
  const What what = [] { return std::string("comparison with a pointer"); };
  std::optional<ValueId> second;
  std::optional<TypeId> id;
  if (other.kind == Operand::Kind::kValue) id = builder.module().types.elementary_of(builder.type_of(other.value));
  ValueId first = known.value;
  TypeId type = TypeId::kUlint;
  if (id && has_32_bits(*id)) {
    // Addresses of 32 bits as such: one that a program moved past the end of its object is no pointer any more.
    const auto address = convert_pointer(builder, known, ref_of(TypeId::kUdint), what);
    if (!address) return std::nullopt;
    first = *address;
    second = other.value;
    type = TypeId::kUdint;
  } else {
    second = convert_pointer(builder, other, pointer, what);
  }
  if (!second) return std::nullopt;
  const bool swapped = &known == &b;
  const std::array both = {swapped ? *second : first, swapped ? first : *second};
  return builder.call_overload(overload(function, type), both, kBoolType);
}

}  // namespace plc::ir
