#include "ir/generic.h"

#include <fmt/format.h>

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "core/text.h"

namespace plc::ir {
namespace {

using core::Code;

/// Bounds of an array that stands for any: wide enough for every index that makes sense.
constexpr std::int64_t kAnyLower = -32768, kAnyUpper = 32767;

bool is_open(const TypeTable& types, TypeRef type) { return types[type].kind == TypeKind::kArray && types[type].open; }

/// The declared type of a parameter, without the reference of an in-out.
TypeRef declared_type(const TypeTable& types, const Variable& variable) {
  return variable.role == Role::kInOut ? types[variable.type].element : variable.type;
}

}  // namespace

bool fits_open(const TypeTable& types, TypeRef open, TypeRef given) {
  while (is_open(types, open)) {
    if (types[given].kind != TypeKind::kArray) return false;
    open = types[open].element;
    given = types[given].element;
  }
  return open == given;
}

std::optional<std::uint32_t> specialize(Module& module, std::uint32_t pou, std::span<const OpenArgument> arguments) {
  std::vector<std::uint32_t> key{pou};
  for (const OpenArgument& argument : arguments) key.push_back(argument.type.index);
  if (module.specialized.size() >= kMostMade && !module.specialized.contains(key)) return std::nullopt;
  const auto [known, fresh] = module.specialized.emplace(key, static_cast<std::uint32_t>(module.pous.size()));
  if (!fresh) return known->second;
  Pou made = module.pous[pou];
  made.generic = false;
  made.made_from = pou;
  // Lint looks at the first one: what it finds in the others is the same.
  made.from_library = made.from_library || module.pous[pou].has_made;
  module.pous[pou].has_made = true;
  for (const OpenArgument& argument : arguments) {
    Variable& variable = made.variables[argument.variable];
    variable.type = variable.role == Role::kInOut ? module.types.reference(argument.type) : argument.type;
  }
  module.pous.push_back(std::move(made));
  return known->second;
}

bool is_given_array(const Module& module, const Pou& pou, TypeRef array) {
  if (pou.made_from == Pou::kDeclared) return false;
  const std::vector<Variable>& declared = module.pous[pou.made_from].variables;
  for (std::size_t i = 0; i < declared.size(); ++i) {
    TypeRef open = declared_type(module.types, declared[i]);
    TypeRef given = declared_type(module.types, pou.variables[i]);
    for (; is_open(module.types, open); open = module.types[open].element, given = module.types[given].element) {
      if (given == array) return true;
    }
  }
  return false;
}

std::optional<std::uint32_t> specialize_for_check(Module& module, std::uint32_t pou) {
  std::vector<OpenArgument> arguments;
  for (std::uint32_t i = 0; i < module.pous[pou].variables.size(); ++i) {
    TypeRef type = declared_type(module.types, module.pous[pou].variables[i]);
    std::size_t dimensions = 0;
    for (; is_open(module.types, type); ++dimensions) type = module.types[type].element;
    if (dimensions == 0) continue;
    for (std::size_t d = 0; d < dimensions; ++d) type = module.types.array(type, kAnyLower, kAnyUpper);
    arguments.push_back({i, type});
  }
  return specialize(module, pou, arguments);
}

std::optional<ArrayBound> array_bound_named(std::string_view name) {
  if (core::iequals(name, "LOWER_BOUND")) return ArrayBound::kLower;
  if (core::iequals(name, "UPPER_BOUND")) return ArrayBound::kUpper;
  return std::nullopt;
}

std::optional<Operand> array_bound(Builder& builder, ArrayBound bound, TypeRef array, const Operand& dimension,
                                   const SourceRef& at) {
  const TypeTable& types = builder.module().types;
  const std::string name = bound == ArrayBound::kLower ? "LOWER_BOUND" : "UPPER_BOUND";
  if (types[array].kind != TypeKind::kArray) {
    builder.report(Code::P4103, at, fmt::format("input \"ARR\" of {} has type {}", name, types.name_of(array)),
                   "give it an array");
    return std::nullopt;
  }
  builder.module().pous[builder.pou_index()].asks_bounds = true;
  std::vector<std::int64_t> bounds;
  bool small = true;
  for (TypeRef type = array; types[type].kind == TypeKind::kArray; type = types[type].element) {
    bounds.push_back(bound == ArrayBound::kLower ? types[type].lower : types[type].upper);
    small = small && bounds.back() >= std::numeric_limits<std::int32_t>::min() &&
            bounds.back() <= std::numeric_limits<std::int32_t>::max();
  }
  const TypeRef result = ref_of(small ? TypeId::kDint : TypeId::kLint);
  const auto constant = [&](std::int64_t value) {
    return builder.constant({result, static_cast<std::uint64_t>(value) & (small ? 0xffffffffull : ~0ull), {}});
  };
  if (dimension.kind == Operand::Kind::kIntLiteral) {
    if (dimension.int_value >= 1 && dimension.int_value <= static_cast<std::int64_t>(bounds.size())) {
      Operand literal;
      literal.kind = Operand::Kind::kIntLiteral;
      literal.int_value = bounds[static_cast<std::size_t>(dimension.int_value) - 1];
      literal.at = at;
      return literal;
    }
    builder.report(Code::P4008, dimension.at.line != 0 ? dimension.at : at,
                   fmt::format("{} has no dimension {}", types.name_of(array), dimension.int_value),
                   fmt::format("its dimensions are 1 to {}", bounds.size()));
    return std::nullopt;
  }
  // MUX knows what a number outside does. It takes two inputs at least: with one dimension, the numbers are doubled, so
  // that 2 is outside.
  const auto number = builder.convert(dimension, ref_of(TypeId::kLint), "input \"DIM\" of " + name);
  if (!number) return std::nullopt;
  const auto literal = [&](std::int64_t value) {
    return Operand::of(builder.constant({ref_of(TypeId::kLint), static_cast<std::uint64_t>(value), {}}), at);
  };
  const std::array<Operand, 2> first{Operand::of(*number, at), literal(1)};
  auto index = builder.call("SUB", first, at);
  if (bounds.size() == 1) {
    bounds.push_back(bounds.front());
    const std::array<Operand, 2> doubled{Operand::of(*index, at), literal(2)};
    index = builder.call("MUL", doubled, at);
  }
  std::vector<Operand> inputs{Operand::of(*index, at)};
  for (const std::int64_t value : bounds) inputs.push_back(Operand::of(constant(value), at));
  const auto value = builder.call("MUX", inputs, at);
  if (!value) return std::nullopt;
  return Operand::of(*value, at);
}

}  // namespace plc::ir
