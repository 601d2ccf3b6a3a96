// The tables and keys of plc.toml as data: what the reader checks, what `plc config init` writes, what the reference
// page says.
//
// In: keys.def. Out: rows. Does not belong here: TOML, where values go (read_configuration.cpp takes that column).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace plc::io {

enum class KeyKind : std::uint8_t {
  kBoolean,
  kInteger,   ///< low..high
  kText,      ///< one line of text
  kTexts,     ///< list of texts
  kChoice,    ///< one of `choices`
  kDuration,  ///< low_text..high_text; 0 = off when low_text says so
  kListen,    ///< "address:port", or "off"
  kChannel,   ///< whole number from 0 on, or text
  kValue,     ///< TRUE or FALSE, a number, or text: a value of the variable
};

/// Which entries a key belongs to: a bit for each kind of driver and each direction. An entry has one of each, or none
/// while it is not known.
using Applies = std::uint8_t;
inline constexpr Applies kGpioBit = 1;
inline constexpr Applies kSimulatedBit = 2;
inline constexpr Applies kInputBit = 4;
inline constexpr Applies kOutputBit = 8;
inline constexpr Applies kAlways = kGpioBit | kSimulatedBit | kInputBit | kOutputBit;
inline constexpr Applies kGpioOnly = kAlways & ~kSimulatedBit;
inline constexpr Applies kSimulatedOnly = kAlways & ~kGpioBit;
inline constexpr Applies kInputsOnly = kAlways & ~kOutputBit;
inline constexpr Applies kOutputsOnly = kAlways & ~kInputBit;
/// Whether a key with `applies` belongs to an entry with these bits.
constexpr bool belongs(Applies applies, Applies entry) { return (applies & entry) == entry; }
/// "gpio only, outputs only", or empty.
std::string applies_text(Applies applies);

struct KeyType {
  KeyKind kind = KeyKind::kText;
  std::int64_t low = 0;
  std::int64_t high = 0;
  std::string_view low_text = {};
  std::string_view high_text = {};
  std::string_view choices = {};  ///< separated by '|', in the order of the enumerators
};

/// What holds when a key is not there.
struct KeyDefault {
  enum class Kind : std::uint8_t { kValue, kNothing, kRequired } kind = Kind::kValue;
  std::string_view toml;  ///< the default as TOML writes it; an example when there is none
  Applies required_for = kAlways;
};

enum class TableId : std::uint8_t {
  kProject,
  kDriver,
  kChannel,
  kScheduler,
  kTask,
  kTaskblocks,
  kModbus,
  kModbusRange,
  kGuardian
};

struct TableInfo {
  TableId id;
  std::string_view heading;        ///< "[modbus]"
  std::string_view documentation;  ///< sentences
};

struct KeyInfo {
  TableId table;
  std::string_view name;
  KeyType type;
  KeyDefault fallback;
  Applies applies = kAlways;
  std::string_view documentation;  ///< sentences
};

/// In the order of keys.def.
std::span<const TableInfo> config_tables();
std::span<const KeyInfo> config_keys();
/// Null when `table` has no key of this name.
const KeyInfo* find_key(TableId table, std::string_view name);

/// "a duration from 10ms to 1h", "one of \"hold\", \"zero\"".
std::string type_text(const KeyType& type);
/// Position of `text` among the choices, -1 when it is none.
int choice_index(const KeyType& type, std::string_view text);
/// Calls `each` with every choice.
template <class Each>
void for_choices(const KeyType& type, Each each) {
  for (std::string_view rest = type.choices; !rest.empty();) {
    const std::size_t bar = rest.find('|');
    each(rest.substr(0, bar));
    rest = bar == std::string_view::npos ? std::string_view{} : rest.substr(bar + 1);
  }
}

}  // namespace plc::io
