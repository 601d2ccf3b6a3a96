// The elementary types and their machine representations, derived from types.def.
//
// In: nothing. Out: TypeId, Rep, the category bits of IEC 61131-3 (third edition, figure 5), lookups by name.
// Does not belong here: derived types (ir/types.h), the typed map of an image (bytecode/type_map.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace plc::core {

/// Head of a STRING or WSTRING value in a table. `capacity` characters of 1 (STRING) or 2 (WSTRING)
/// bytes follow at once; bytes beyond `length` are unspecified. Readers clamp length to capacity and
/// capacity to what the type map says, so a forged header cannot reach outside the value.
struct StringHeader {
  std::uint16_t capacity = 0;  ///< characters that fit
  std::uint16_t length = 0;    ///< characters in use, 0..capacity
};

/// What the machine sees of a value. BOOL is one byte holding 0 or 1 and nothing else.
enum class Rep : std::uint8_t { kBool, kI8, kU8, kI16, kU16, kI32, kU32, kI64, kU64, kF32, kF64, kStr, kWstr, kRef };
inline constexpr std::size_t kRepCount = 14;

/// Bytes of one value of `rep`; 0 for strings, whose size depends on the capacity. kRef is a checked handle of 8.
constexpr std::uint32_t rep_bytes(Rep rep) {
  constexpr std::uint32_t kBytes[kRepCount] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8, 0, 0, 8};
  return kBytes[static_cast<std::size_t>(rep)];
}
/// Short lower-case name of a representation, as the disassembler writes it ("bool", "i16", "f64", "str").
std::string_view rep_name(Rep rep);

/// Category bits. The generic types of the standard are unions of them (IEC 61131-3, table 11).
enum Category : std::uint16_t {
  kAnySigned = 1u << 0,
  kAnyUnsigned = 1u << 1,
  kAnyReal = 1u << 2,
  kAnyBit = 1u << 3,
  kAnyDuration = 1u << 4,
  kAnyDate = 1u << 5,
  kAnyChar = 1u << 6,
  kAnyString = 1u << 7,
  kAnyInt = kAnySigned | kAnyUnsigned,
  kAnyNum = kAnyInt | kAnyReal,
  kAnyMagnitude = kAnyNum | kAnyDuration,
  kAnyChars = kAnyChar | kAnyString,
  kAnyElementary = kAnyMagnitude | kAnyBit | kAnyDate | kAnyChars,
};

enum class TypeId : std::uint8_t {
#define PLC_TYPE(Name, iec, alias, Cpp, rep, cats) k##Name,
#include "core/types.def"
};

struct TypeInfo {
  std::string_view iec;    ///< name in the standard, upper case
  std::string_view alias;  ///< short name ("TOD") or empty
  Rep rep;
  std::uint16_t categories;  ///< Category bits
};

inline constexpr TypeInfo kTypes[] = {
#define PLC_TYPE(Name, iec, alias, Cpp, rep, cats) {iec, alias, Rep::rep, static_cast<std::uint16_t>(cats)},
#include "core/types.def"
};
inline constexpr std::size_t kTypeCount = std::size(kTypes);

constexpr const TypeInfo& info(TypeId id) { return kTypes[static_cast<std::size_t>(id)]; }
constexpr std::string_view name_of(TypeId id) { return info(id).iec; }
constexpr Rep rep_of(TypeId id) { return info(id).rep; }
constexpr bool in_category(TypeId id, std::uint16_t categories) { return (info(id).categories & categories) != 0; }
/// The elementary type with this name or alias, in any letter case.
std::optional<TypeId> type_named(std::string_view name);

template <TypeId>
struct CppOf;
#define PLC_TYPE(Name, iec, alias, Cpp, rep, cats) \
  template <>                                      \
  struct CppOf<TypeId::k##Name> {                  \
    using type = Cpp;                              \
  };
#include "core/types.def"
/// The C++ type that holds a value of elementary type `Id` in a table.
template <TypeId Id>
using cpp_of = typename CppOf<Id>::type;

/// Capacity of a STRING or WSTRING declared without a length, in characters.
inline constexpr std::uint16_t kDefaultStringCapacity = 80;
/// Largest capacity that may be declared.
inline constexpr std::uint16_t kMaxStringCapacity = 32767;

}  // namespace plc::core
