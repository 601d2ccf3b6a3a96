#include "ir/types.h"

#include <fmt/format.h>

#include <unordered_set>
#include <utility>

namespace plc::ir {
namespace {

bool is_string(TypeId id) { return id == TypeId::kString || id == TypeId::kWstring; }

}  // namespace

TypeTable::TypeTable() {
  types_.reserve(core::kTypeCount + 64);
  for (std::size_t i = 0; i < core::kTypeCount; ++i) {
    Type type;
    type.elementary = static_cast<TypeId>(i);
    if (is_string(type.elementary)) {
      type.kind = TypeKind::kString;
      type.capacity = core::kDefaultStringCapacity;
    }
    const TypeRef ref = add(std::move(type));
    if (types_[ref.index].kind == TypeKind::kString) {
      interned_.emplace(fmt::format("S{}:{}", i, core::kDefaultStringCapacity), ref);
    }
  }
}

TypeRef TypeTable::add(Type type) {
  const TypeRef ref{static_cast<std::uint32_t>(types_.size())};
  if (type.kind == TypeKind::kEnum) enumerations_.push_back(ref);
  types_.push_back(std::move(type));
  return ref;
}

TypeRef TypeTable::intern(const std::string& key, Type type) {
  const auto it = interned_.find(key);
  if (it != interned_.end()) return it->second;
  const TypeRef ref = add(std::move(type));
  interned_.emplace(key, ref);
  return ref;
}

TypeRef TypeTable::string(TypeId string_or_wstring, std::uint16_t capacity) {
  Type type;
  type.kind = TypeKind::kString;
  type.elementary = string_or_wstring;
  type.capacity = capacity;
  return intern(fmt::format("S{}:{}", static_cast<unsigned>(string_or_wstring), capacity), std::move(type));
}

TypeRef TypeTable::array(TypeRef element, std::int64_t lower, std::int64_t upper) {
  Type type;
  type.kind = TypeKind::kArray;
  type.element = element;
  type.lower = lower;
  type.upper = upper;
  return intern(fmt::format("A{}:{}:{}", element.index, lower, upper), std::move(type));
}

TypeRef TypeTable::open_array(TypeRef element) {
  Type type;
  type.kind = TypeKind::kArray;
  type.element = element;
  type.lower = 1;
  type.open = true;
  return intern(fmt::format("A{}:*", element.index), std::move(type));
}

TypeRef TypeTable::reference(TypeRef target) {
  Type type;
  type.kind = TypeKind::kReference;
  type.element = target;
  return intern(fmt::format("R{}", target.index), std::move(type));
}

TypeRef TypeTable::reference_to(TypeRef target) {
  Type type;
  type.kind = TypeKind::kReference;
  type.element = target;
  type.implicit = true;
  return intern(fmt::format("I{}", target.index), std::move(type));
}

TypeRef TypeTable::pointer(TypeRef target) {
  Type type;
  type.kind = TypeKind::kPointer;
  type.elementary = TypeId::kPointer;
  type.element = target;
  return intern(fmt::format("*{}", target.index), std::move(type));
}

TypeRef TypeTable::block(const stdlib::BlockSpec& block) {
  Type type;
  type.kind = TypeKind::kBlock;
  type.name = std::string(block.name);
  type.block = &block;
  return intern(fmt::format("B{}", block.name), std::move(type));
}

TypeRef TypeTable::pou(std::uint32_t pou_index, std::string_view name) {
  Type type;
  type.kind = TypeKind::kPou;
  type.name = std::string(name);
  type.pou = pou_index;
  const TypeRef ref = intern(fmt::format("P{}", pou_index), std::move(type));
  by_name_.emplace(std::string(name), ref);
  return ref;
}

bool TypeTable::declare(std::string_view name, Type type) {
  if (core::type_named(name) || by_name_.find(name) != by_name_.end()) return false;
  type.name = std::string(name);
  const TypeRef ref = add(std::move(type));
  by_name_.emplace(std::string(name), ref);
  return true;
}

bool TypeTable::declare_alias(std::string_view name, TypeRef target) {
  if (core::type_named(name)) return false;
  return by_name_.emplace(std::string(name), target).second;
}

std::optional<TypeRef> TypeTable::find(std::string_view name) {
  // A project's own declaration hides a standard block of the same name: real projects bring their own "CTU" or "RTC".
  const auto it = by_name_.find(name);
  if (it != by_name_.end()) return it->second;
  if (const auto id = core::type_named(name); id && *id != TypeId::kPointer) return ref_of(*id);
  if (const stdlib::BlockSpec* spec = stdlib::block_named(name)) return block(*spec);
  return std::nullopt;
}

std::string TypeTable::name_of(TypeRef ref) const {
  if (!ref.valid()) return "nothing";
  const Type& type = types_[ref.index];
  if (!type.name.empty()) return type.name;
  switch (type.kind) {
    case TypeKind::kString:
      return fmt::format("{}[{}]", core::name_of(type.elementary), type.capacity);
    case TypeKind::kArray: {
      const auto bounds_of = [](const Type& array) {
        return array.open ? std::string("*") : fmt::format("{}..{}", array.lower, array.upper);
      };
      std::string bounds = bounds_of(type);
      TypeRef element = type.element;
      while (types_[element.index].kind == TypeKind::kArray && types_[element.index].name.empty()) {
        const Type& inner = types_[element.index];
        bounds += ", " + bounds_of(inner);
        element = inner.element;
      }
      return fmt::format("ARRAY [{}] OF {}", bounds, name_of(element));
    }
    case TypeKind::kReference:
      return (type.implicit ? "REFERENCE TO " : "REF_TO ") + name_of(type.element);
    case TypeKind::kPointer:
      return "POINTER TO " + name_of(type.element);
    case TypeKind::kSubrange:
      return fmt::format("{} ({}..{})", core::name_of(type.elementary), type.lower, type.upper);
    default:
      return std::string(core::name_of(type.elementary));
  }
}

std::optional<Rep> TypeTable::rep_of(TypeRef ref) const {
  if (types_[ref.index].kind == TypeKind::kReference) return Rep::kRef;
  if (const auto id = elementary_of(ref)) return core::rep_of(*id);
  return std::nullopt;
}

std::optional<TypeId> TypeTable::elementary_of(TypeRef ref) const {
  const Type& type = types_[ref.index];
  switch (type.kind) {
    case TypeKind::kElementary:
    case TypeKind::kString:
    case TypeKind::kEnum:
    case TypeKind::kSubrange:
    case TypeKind::kPointer:
      return type.elementary;
    default:
      return std::nullopt;
  }
}

std::optional<std::uint32_t> TypeTable::position_of(TypeRef ref, std::string_view name) const {
  const Type& type = types_[ref.index];
  const bool fields = type.kind == TypeKind::kStruct || type.kind == TypeKind::kUnion;
  const std::size_t count = fields ? type.fields.size() : type.members.size();
  const auto name_at = [&](std::size_t i) -> const std::string& {
    return fields ? type.fields[i].name : type.members[i].name;
  };
  constexpr std::size_t kMany = 32;
  if (count < kMany) {
    for (std::size_t i = 0; i < count; ++i) {
      if (core::iequals(name_at(i), name)) return static_cast<std::uint32_t>(i);
    }
    return std::nullopt;
  }
  Positions& positions = positions_[ref.index];
  // A type under construction may have grown; the first of two equal names counts.
  for (std::size_t i = positions.size(); i < count && positions.size() < count; ++i) {
    positions.emplace(name_at(i), static_cast<std::uint32_t>(i));
  }
  const auto found = positions.find(name);
  return found == positions.end() ? std::nullopt : std::optional(found->second);
}

template <class Found>
bool TypeTable::holds(TypeRef ref, Found found) const {
  // Each type once: two members of one type each, nested sixty deep, have 2^60 leaves.
  std::vector<TypeRef> open = {ref};
  std::unordered_set<std::uint32_t> seen;
  while (!open.empty()) {
    const Type& type = types_[open.back().index];
    const bool fresh = seen.insert(open.back().index).second;
    open.pop_back();
    if (found(type.kind)) return true;
    if (!fresh) continue;
    if (type.kind == TypeKind::kArray) open.push_back(type.element);
    for (const TypeField& field : type.fields) open.push_back(field.type);
  }
  return false;
}

bool TypeTable::holds_instance(TypeRef ref) const {
  return holds(ref, [](TypeKind kind) { return kind == TypeKind::kBlock || kind == TypeKind::kPou; });
}

bool TypeTable::holds_reference(TypeRef ref) const {
  return holds(ref, [](TypeKind kind) { return kind == TypeKind::kReference; });
}

}  // namespace plc::ir
