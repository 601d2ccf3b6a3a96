#include "frontend-st/any_types.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/text.h"

namespace plc::st {
namespace {

using core::TypeId;
using ir::TypeKind;
using ir::TypeRef;

constexpr AnyInput kAnyInputs[] = {
    {"ANY", 0},
    {"ANY_BIT", core::kAnyBit},
    {"ANY_DATE", core::kAnyDate},
    {"ANY_INT", core::kAnyInt},
    {"ANY_NUM", core::kAnyNum},
    {"ANY_REAL", core::kAnyReal},
    {"ANY_STRING", core::kAnyString},
};

// No source can spell the blank.
constexpr std::string_view kPrefix = "input ";

/// The values of TYPE_CLASS, in the order of CODESYS, and the elementary types they stand for.
struct TypeClass {
  std::string_view name;
  std::optional<TypeId> type = std::nullopt;
};
constexpr TypeClass kTypeClasses[] = {
    {"TYPE_BOOL", TypeId::kBool},
    {"TYPE_BIT"},
    {"TYPE_BYTE", TypeId::kByte},
    {"TYPE_WORD", TypeId::kWord},
    {"TYPE_DWORD", TypeId::kDword},
    {"TYPE_LWORD", TypeId::kLword},
    {"TYPE_SINT", TypeId::kSint},
    {"TYPE_INT", TypeId::kInt},
    {"TYPE_DINT", TypeId::kDint},
    {"TYPE_LINT", TypeId::kLint},
    {"TYPE_USINT", TypeId::kUsint},
    {"TYPE_UINT", TypeId::kUint},
    {"TYPE_UDINT", TypeId::kUdint},
    {"TYPE_ULINT", TypeId::kUlint},
    {"TYPE_REAL", TypeId::kReal},
    {"TYPE_LREAL", TypeId::kLreal},
    {"TYPE_STRING", TypeId::kString},
    {"TYPE_WSTRING", TypeId::kWstring},
    {"TYPE_TIME", TypeId::kTime},
    {"TYPE_DATE", TypeId::kDate},
    {"TYPE_DATEANDTIME", TypeId::kDt},
    {"TYPE_TIMEOFDAY", TypeId::kTod},
    {"TYPE_POINTER", TypeId::kPointer},
    {"TYPE_REFERENCE"},
    {"TYPE_SUBRANGE"},
    {"TYPE_ENUM"},
    {"TYPE_ARRAY"},
    {"TYPE_PARAMS"},
    {"TYPE_USERDEF"},
    {"TYPE_NONE"},
    {"TYPE_ANY"},
    {"TYPE_ANYBIT"},
    {"TYPE_ANYDATE"},
    {"TYPE_ANYINT"},
    {"TYPE_ANYNUM"},
    {"TYPE_ANYREAL"},
    {"TYPE_LAZY"},
    {"TYPE_LTIME", TypeId::kLtime},
    {"TYPE_BITCONST"},
    // Those that came later with the third edition.
    {"TYPE_LDATE", TypeId::kLdate},
    {"TYPE_LDATEANDTIME", TypeId::kLdt},
    {"TYPE_LTIMEOFDAY", TypeId::kLtod},
    {"TYPE_CHAR", TypeId::kChar},
    {"TYPE_WCHAR", TypeId::kWchar},
};

std::int64_t number_named(std::string_view name) {
  const auto found = std::find_if(std::begin(kTypeClasses), std::end(kTypeClasses),
                                  [&](const TypeClass& c) { return c.name == name; });
  return found - std::begin(kTypeClasses);
}

TypeRef type_class(ir::TypeTable& types) {
  constexpr std::string_view kName = "TYPE_CLASS";
  if (const auto known = types.find(kName)) return *known;
  ir::Type type;
  type.kind = TypeKind::kEnum;
  type.elementary = TypeId::kInt;
  for (const TypeClass& one : kTypeClasses) {
    type.members.push_back({std::string(one.name), static_cast<std::int64_t>(type.members.size())});
  }
  types.declare(kName, std::move(type));
  return *types.find(kName);
}

}  // namespace

std::optional<TypeRef> any_type(ir::TypeTable& types, std::string_view name) {
  const auto input = std::find_if(std::begin(kAnyInputs), std::end(kAnyInputs),
                                  [&](const AnyInput& one) { return core::iequals(one.name, name); });
  if (input == std::end(kAnyInputs)) return std::nullopt;
  const std::string declared = std::string(kPrefix) + std::string(input->name);
  if (const auto known = types.find(declared)) return known;
  ir::Type type;
  type.kind = TypeKind::kStruct;
  type.fields.push_back({"TypeClass", type_class(types)});
  type.fields.push_back({"pValue", types.pointer(ir::ref_of(TypeId::kByte))});
  type.fields.push_back({"diSize", ir::ref_of(TypeId::kDint)});
  types.declare(declared, std::move(type));
  return types.find(declared);
}

std::optional<AnyInput> any_input(const ir::TypeTable& types, TypeRef type) {
  const std::string_view name = types[type].name;
  if (types[type].kind != TypeKind::kStruct || !name.starts_with(kPrefix)) return std::nullopt;
  const auto input = std::find_if(std::begin(kAnyInputs), std::end(kAnyInputs),
                                  [&](const AnyInput& one) { return one.name == name.substr(kPrefix.size()); });
  return input == std::end(kAnyInputs) ? std::nullopt : std::optional(*input);
}

std::int64_t type_class_of(const ir::TypeTable& types, TypeRef type) {
  const ir::Type& t = types[type];
  switch (t.kind) {
    case TypeKind::kSubrange:
      return number_named("TYPE_SUBRANGE");
    case TypeKind::kEnum:
      return number_named("TYPE_ENUM");
    case TypeKind::kArray:
      return number_named("TYPE_ARRAY");
    case TypeKind::kReference:
      return number_named("TYPE_REFERENCE");
    case TypeKind::kStruct:
    case TypeKind::kUnion:
    case TypeKind::kBlock:
    case TypeKind::kPou:
      return number_named("TYPE_USERDEF");
    case TypeKind::kElementary:
    case TypeKind::kString:
    case TypeKind::kPointer:
      break;
  }
  const auto found = std::find_if(std::begin(kTypeClasses), std::end(kTypeClasses),
                                  [&](const TypeClass& c) { return c.type == t.elementary; });
  return found == std::end(kTypeClasses) ? number_named("TYPE_NONE") : found - std::begin(kTypeClasses);
}

}  // namespace plc::st
