// TypeTable: every type of a project, elementary and derived, interned; and the layout of values in a table.
//
// In: built by frontend-st from declarations. Out: read by all front ends, check and code generation. Types are
// referred to by TypeRef; equal types have equal TypeRefs (structures and enumerations are equal by name).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/source_ref.h"
#include "core/text.h"
#include "core/types.h"
#include "stdlib/library.h"

namespace plc::ir {

using core::Rep;
using core::SourceRef;
using core::TypeId;

/// Strong index into a TypeTable. The elementary types (but STRING/WSTRING, which carry a capacity) are at their
/// TypeId.
struct TypeRef {
  std::uint32_t index = kNone;
  static constexpr std::uint32_t kNone = 0xffffffffu;
  [[nodiscard]] bool valid() const { return index != kNone; }
  friend bool operator==(TypeRef, TypeRef) = default;
};
constexpr TypeRef ref_of(TypeId id) { return {static_cast<std::uint32_t>(id)}; }
/// BOOL, the type most asked for.
inline constexpr TypeRef kBoolType = ref_of(TypeId::kBool);

enum class TypeKind : std::uint8_t {
  kElementary,
  kString,
  kArray,
  kStruct,
  kEnum,
  kSubrange,
  kBlock,
  kPou,
  kReference,
  kPointer,
  kUnion
};

struct TypeField {
  std::string name;
  TypeRef type;
};
struct EnumMember {
  std::string name;
  std::int64_t value = 0;
};

struct Type {
  TypeKind kind = TypeKind::kElementary;
  TypeId elementary = TypeId::kBool;  ///< kElementary; kString: kString or kWstring; kEnum, kSubrange: the base
  std::uint16_t capacity = 0;         ///< kString
  std::string name;                   ///< declared name; empty for anonymous arrays
  TypeRef element{};                  ///< kArray element, kReference and kPointer target
  std::int64_t lower = 0, upper = 0;  ///< kArray bounds of this dimension (arrays of arrays for more), kSubrange limits
  std::vector<TypeField> fields;      ///< kStruct, kUnion
  std::vector<EnumMember> members;    ///< kEnum
  std::int64_t initial = 0;           ///< kEnum, kSubrange: initial value
  const stdlib::BlockSpec* block = nullptr;  ///< kBlock: standard function block
  std::uint32_t pou = 0;                     ///< kPou: index of the program or function block in Module::pous
  /// kStruct without fields that stands for a type the project does not bring (--stub-missing). Values of it do
  /// nothing.
  bool stub = false;
  bool from_library = false;  ///< kEnum: declared in a library
  bool qualified = false;     ///< kEnum: its values are named with the type before them (qualified_only)
  bool open = false;          ///< kArray [*]: the type of a parameter of a generic function, of no value
  bool implicit = false;      ///< kReference: REFERENCE TO, which stands for what it refers to; else REF_TO
  SourceRef at;
};

class TypeTable {
 public:
  TypeTable();

  [[nodiscard]] const Type& operator[](TypeRef ref) const { return types_[ref.index]; }
  [[nodiscard]] Type& mutable_type(TypeRef ref) { return types_[ref.index]; }
  [[nodiscard]] std::size_t size() const { return types_.size(); }
  /// All enumerations: few, where instance types of POUs may be many.
  [[nodiscard]] const std::vector<TypeRef>& enumerations() const { return enumerations_; }

  TypeRef string(TypeId string_or_wstring, std::uint16_t capacity);
  TypeRef array(TypeRef element, std::int64_t lower, std::int64_t upper);
  /// ARRAY [*] OF element.
  TypeRef open_array(TypeRef element);
  TypeRef reference(TypeRef target);
  /// REFERENCE TO target: a reference whose name stands for what it refers to.
  TypeRef reference_to(TypeRef target);
  TypeRef pointer(TypeRef target);
  TypeRef block(const stdlib::BlockSpec& block);
  /// The instance type of a program or function block POU.
  TypeRef pou(std::uint32_t pou_index, std::string_view name);
  /// Declares a named type (kStruct, kEnum, kSubrange, or an alias of any other type). False when the name is taken.
  bool declare(std::string_view name, Type type);
  /// Makes `name` another name of `target`. False when the name is taken.
  bool declare_alias(std::string_view name, TypeRef target);
  /// The type of this name: elementary, declared, standard block or POU. Names are case-insensitive.
  [[nodiscard]] std::optional<TypeRef> find(std::string_view name);

  /// Name for messages: "DINT", "STRING[20]", "ARRAY [1..3] OF REAL", "TON".
  [[nodiscard]] std::string name_of(TypeRef ref) const;
  [[nodiscard]] bool is_elementary(TypeRef ref) const { return types_[ref.index].kind == TypeKind::kElementary; }
  /// The field of a structure or the value of an enumeration with this name: its position in Type::fields or members.
  [[nodiscard]] std::optional<std::uint32_t> position_of(TypeRef ref, std::string_view name) const;
  /// True when a function block instance, standard or not, is part of a value of this type.
  [[nodiscard]] bool holds_instance(TypeRef ref) const;
  /// True when a reference is part of a value of this type.
  [[nodiscard]] bool holds_reference(TypeRef ref) const;
  /// Machine representation of a scalar (elementary, enum, subrange, string, reference); nothing for aggregates.
  [[nodiscard]] std::optional<Rep> rep_of(TypeRef ref) const;
  /// The elementary type an operand of this type counts as in a call: itself, an enumeration's or subrange's base,
  /// STRING for any capacity. Nothing for aggregates and references.
  [[nodiscard]] std::optional<TypeId> elementary_of(TypeRef ref) const;

 private:
  TypeRef add(Type type);
  /// Whether a value of type `ref` is of a kind that is looked for, or has one in it.
  template <class Found>
  bool holds(TypeRef ref, Found found) const;
  TypeRef intern(const std::string& key, Type type);
  std::vector<Type> types_;
  using Positions = std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual>;
  mutable std::unordered_map<std::uint32_t, Positions> positions_;  ///< of types with many names, when first asked for
  std::vector<TypeRef> enumerations_;
  std::unordered_map<std::string, TypeRef> interned_;  ///< anonymous types by structure, blocks and POUs by identity
  std::unordered_map<std::string, TypeRef, core::NameHash, core::NameEqual> by_name_;
};

}  // namespace plc::ir
