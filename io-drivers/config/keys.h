// The tables and keys of plc.toml as data: what the reader checks, what `plc config init` writes, what the reference
// page says.
//
// In: keys.def, the keys that kinds of drivers have of their own (driver_type.h). Out: rows. Does not belong here:
// TOML, where values go (read_configuration.cpp takes that column).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace plc::io {

struct DriverType;
/// The kinds of drivers that a program knows, in the order in which people see them.
using DriverTypes = std::span<const DriverType* const>;

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

/// Which directions a key belongs to, or an entry has: a bit each.
using Applies = std::uint8_t;
inline constexpr Applies kInputsOnly = 1;
inline constexpr Applies kOutputsOnly = 2;
inline constexpr Applies kAlways = kInputsOnly | kOutputsOnly;

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
};

enum class TableId : std::uint8_t {
  kProject,
  kDriverKinds,
  kDriver,
  kChannel,
  kScheduler,
  kTask,
  kTaskblocks,
  kRetain,
  kLog,
  kRecord,
  kClock,
  kModbus,
  kModbusSerial,
  kModbusRange,
  kEngineering,
  kGuardian
};

struct TableInfo {
  TableId id;
  std::string_view heading;        ///< "[modbus]"
  std::string_view documentation;  ///< sentences
};

struct KeyInfo {
  std::string_view name;
  KeyType type = {};
  KeyDefault fallback = {};
  std::string_view documentation = {};  ///< sentences
  Applies applies = kAlways;
  // A kind's folder omits these: Keys knows them.
  TableId table = TableId::kDriver;
  const DriverType* kind = nullptr;  ///< whose key it is; null: that of every kind, or of another table
};

/// All keys of plc.toml for a program that knows these kinds of drivers.
class Keys {
 public:
  explicit Keys(DriverTypes types);
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;

  /// Those of keys.def in its order, then those of the kinds in theirs.
  [[nodiscard]] const std::vector<KeyInfo>& rows() const { return rows_; }
  /// The key that entries of `kind` (null: not known) have, else one that only other kinds have, else null.
  [[nodiscard]] const KeyInfo* find(TableId table, std::string_view name, const DriverType* kind = nullptr) const;

 private:
  std::string kinds_, kinds_help_, first_kind_;  ///< of the key "kind"
  std::vector<KeyInfo> rows_;
};

/// In the order of keys.def.
std::span<const TableInfo> config_tables();
/// "gpio only, outputs only", or empty.
std::string applies_text(const KeyInfo& key);
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

/// The columns of a row, for keys.def and the kinds of drivers.
namespace key {
constexpr KeyType boolean() { return {.kind = KeyKind::kBoolean}; }
constexpr KeyType integer(std::int64_t low, std::int64_t high) {
  return {.kind = KeyKind::kInteger, .low = low, .high = high};
}
constexpr KeyType text() { return {.kind = KeyKind::kText}; }
constexpr KeyType texts() { return {.kind = KeyKind::kTexts}; }
constexpr KeyType choice(std::string_view choices) { return {.kind = KeyKind::kChoice, .choices = choices}; }
constexpr KeyType duration(std::string_view low, std::string_view high) {
  return {.kind = KeyKind::kDuration, .low_text = low, .high_text = high};
}
constexpr KeyType listen() { return {.kind = KeyKind::kListen}; }
constexpr KeyType channel() { return {.kind = KeyKind::kChannel, .high = 65535}; }
constexpr KeyType value() { return {.kind = KeyKind::kValue}; }
/// Without the key: this value, of texts without escapes.
constexpr KeyDefault otherwise(std::string_view toml) { return {KeyDefault::Kind::kValue, toml}; }
/// Without the key: nothing, which the documentation explains.
constexpr KeyDefault nothing(std::string_view example) { return {KeyDefault::Kind::kNothing, example}; }
constexpr KeyDefault required(std::string_view example) { return {KeyDefault::Kind::kRequired, example}; }
}  // namespace key

}  // namespace plc::io
