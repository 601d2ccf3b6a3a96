// Constant values fitted to the types of their places.
#include <bit>
#include <cmath>

#include "declare/constants.h"
#include "frontend-st/literals.h"
#include "stdlib/idioms.h"
#include "stdlib/library.h"

namespace plc::st {
namespace {

using core::Code;
using core::Rep;
using core::TypeId;
using Kind = ConstantValue::Kind;

std::string shown(const ConstantValue& v, const ir::TypeTable& types) {
  switch (v.kind) {
    case Kind::kInt:
      return v.is_unsigned ? std::to_string(static_cast<std::uint64_t>(v.int_value)) : std::to_string(v.int_value);
    case Kind::kReal:
      return "a real number";
    case Kind::kNull:
      return "NULL";
    case Kind::kTyped:
      break;
  }
  return "a value of type " + types.name_of(v.constant.type);
}

/// An integer that is no value of `id`, but has its bits: -1 for UINT, 16#FFFF for INT. One with a type converts.
bool fits_by_bits(const ConstantValue& v, TypeId id) {
  stdlib::Arg literal;
  literal.kind = stdlib::Arg::Kind::kIntLiteral;
  literal.int_value = v.int_value;
  literal.int_is_unsigned = v.is_unsigned;
  literal.based = v.based;
  if (v.type && stdlib::implicit_conversion(*v.type, id) == stdlib::Idiom::kNone) return false;
  return stdlib::literal_fits_by_bits(literal, id) || (v.type && id != TypeId::kBool);
}

}  // namespace

double as_double(const ConstantValue& v) {
  if (v.kind == Kind::kReal) return v.real_value;
  return v.is_unsigned ? static_cast<double>(static_cast<std::uint64_t>(v.int_value))
                       : static_cast<double>(v.int_value);
}

std::optional<ir::Constant> constant_as(const ConstantValue& value, ir::TypeRef to, const ir::TypeTable& types,
                                        std::string& problem, std::optional<core::Code>& note) {
  const ir::Type& target = types[to];
  const auto id = types.elementary_of(to);
  ir::Constant out;
  out.type = to;
  problem = types.name_of(to) + " does not take " + shown(value, types);
  if (target.kind == ir::TypeKind::kReference) return value.kind == Kind::kNull ? std::optional(out) : std::nullopt;
  if (target.kind == ir::TypeKind::kPointer) {
    const bool zero = value.kind == Kind::kNull || (value.kind == Kind::kInt && value.int_value == 0);
    return zero ? std::optional(out) : std::nullopt;
  }
  if (!id || value.kind == Kind::kNull) return std::nullopt;
  const Rep rep = core::rep_of(*id);
  if (target.kind == ir::TypeKind::kEnum) {
    if (value.kind == Kind::kTyped && value.constant.type == to) return value.constant;
    if (value.kind != Kind::kInt) return std::nullopt;
    // Some tools export enumeration values as their numbers.
    for (const ir::EnumMember& member : target.members) {
      if (member.value != value.int_value) continue;
      out.bits = truncate_bits(static_cast<std::uint64_t>(member.value), rep);
      return out;
    }
    return std::nullopt;
  }
  if (target.kind == ir::TypeKind::kString || core::in_category(*id, core::kAnyChar)) {
    const bool wide = rep == Rep::kWstr || *id == TypeId::kWchar;
    if (value.kind != Kind::kTyped) return std::nullopt;
    const auto from = types.elementary_of(value.constant.type);
    if (from != (wide ? TypeId::kWstring : TypeId::kString)) {
      if (from && core::in_category(*from, core::kAnyString)) {
        problem += "; a STRING is written in single quotes, a WSTRING in double ones";
      }
      return std::nullopt;
    }
    const std::size_t length = value.constant.text.size() / (wide ? 2u : 1u);
    if (target.kind == ir::TypeKind::kString) {
      if (length > target.capacity) {
        problem = "a text of " + std::to_string(length) + " characters does not fit into " + types.name_of(to);
        return std::nullopt;
      }
      out.text = value.constant.text;
      return out;
    }
    if (length != 1) return std::nullopt;
    for (std::size_t i = value.constant.text.size(); i-- > 0;) {
      out.bits = (out.bits << 8) | static_cast<unsigned char>(value.constant.text[i]);
    }
    return out;
  }
  if (core::in_category(*id, core::kAnyReal)) {
    if (!is_number(value)) return std::nullopt;
    const double number = as_double(value);
    if (rep == Rep::kF64) {
      out.bits = std::bit_cast<std::uint64_t>(number);
      return out;
    }
    const auto narrow = static_cast<float>(number);
    if (std::isinf(narrow) && !std::isinf(number)) {
      problem = "the value is out of the range of REAL";
      return std::nullopt;
    }
    out.bits = std::bit_cast<std::uint32_t>(narrow);
    return out;
  }
  if (value.kind == Kind::kTyped) {
    const auto from = types.elementary_of(value.constant.type);
    if (!from || types[value.constant.type].kind == ir::TypeKind::kEnum) return std::nullopt;
    const bool number_of_bool =
        *from == TypeId::kBool && *id != TypeId::kBool && core::in_category(*id, core::kAnyInt | core::kAnyBit);
    if (*from != *id && !stdlib::widens(*from, *id) && !number_of_bool) return std::nullopt;
    if (core::in_category(*from, core::kAnyChars)) return std::nullopt;
    out.bits = value.constant.bits;
    if (number_of_bool) {
      note = Code::P4334;
      problem = types.name_of(to) + " takes a BOOL as " + std::to_string(out.bits);
    }
    return out;
  }
  if (value.kind != Kind::kInt) return std::nullopt;
  if (core::in_category(*id, core::kAnyDuration | core::kAnyDate)) {
    // Tools that fill in defaults write a plain 0; any other number has no unit.
    if (value.int_value == 0) return out;
    problem += "; durations and dates have a prefix, as in T#5s";
    return std::nullopt;
  }
  const bool other_type = value.type && *value.type != *id && !stdlib::widens(*value.type, *id);
  if (other_type) {
    note = Code::P4339;
    problem = types.name_of(to) + " takes a value of type " + std::string(core::name_of(*value.type));
  }
  if (!int_fits(value.int_value, value.is_unsigned, *id) && fits_by_bits(value, *id) &&
      target.kind != ir::TypeKind::kSubrange) {
    if (!other_type) {
      note = Code::P4335;
      problem = types.name_of(to) + " takes the bits of " + shown(value, types);
    }
    out.bits = truncate_bits(static_cast<std::uint64_t>(value.int_value), rep);
    return out;
  }
  if (!int_fits(value.int_value, value.is_unsigned, *id)) {
    note.reset();
    problem = shown(value, types) + " does not fit into " + types.name_of(to);
    return std::nullopt;
  }
  if (target.kind == ir::TypeKind::kSubrange && (value.int_value < target.lower || value.int_value > target.upper)) {
    problem = shown(value, types) + " is outside of " + types.name_of(to) + " (" + std::to_string(target.lower) + ".." +
              std::to_string(target.upper) + ")";
    note.reset();
    return std::nullopt;
  }
  out.bits = truncate_bits(static_cast<std::uint64_t>(value.int_value), rep);
  return out;
}

}  // namespace plc::st
