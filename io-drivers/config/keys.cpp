#include "io-drivers/config/keys.h"

#include <algorithm>

namespace plc::io {
namespace {

// The columns of keys.def.
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
constexpr KeyDefault otherwise(std::string_view toml) { return {KeyDefault::Kind::kValue, toml}; }
constexpr KeyDefault nothing(std::string_view example) { return {KeyDefault::Kind::kNothing, example}; }
constexpr KeyDefault required(std::string_view example, Applies required_for = kAlways) {
  return {KeyDefault::Kind::kRequired, example, required_for};
}

constexpr TableInfo kTables[] = {
#define PLC_CONFIG_TABLE(table, heading, documentation) {TableId::table, heading, documentation},
#include "io-drivers/config/keys.def"
};
constexpr KeyInfo kKeys[] = {
#define PLC_CONFIG_KEY(table, name, place, type, fallback, applies, documentation) \
  {TableId::table, name, type, fallback, applies, documentation},
#include "io-drivers/config/keys.def"
};

}  // namespace

std::span<const TableInfo> config_tables() { return kTables; }
std::span<const KeyInfo> config_keys() { return kKeys; }

const KeyInfo* find_key(TableId table, std::string_view name) {
  const auto found = std::find_if(std::begin(kKeys), std::end(kKeys),
                                  [&](const KeyInfo& key) { return key.table == table && key.name == name; });
  return found == std::end(kKeys) ? nullptr : found;
}

std::string applies_text(Applies applies) {
  std::string text;
  const auto add = [&text](std::string_view part) { text += (text.empty() ? "" : ", ") + std::string(part); };
  if ((applies & kSimulatedBit) == 0) add("gpio only");
  if ((applies & kGpioBit) == 0) add("simulated only");
  if ((applies & kInputBit) == 0) add("outputs only");
  if ((applies & kOutputBit) == 0) add("inputs only");
  return text;
}

std::string type_text(const KeyType& type) {
  switch (type.kind) {
    case KeyKind::kBoolean:
      return "true or false";
    case KeyKind::kInteger:
      return "a whole number from " + std::to_string(type.low) + " to " + std::to_string(type.high);
    case KeyKind::kText:
      return "a text";
    case KeyKind::kTexts:
      return "a list of texts";
    case KeyKind::kChoice: {
      std::string list;
      for_choices(type, [&](std::string_view one) { list += (list.empty() ? "\"" : ", \"") + std::string(one) + '"'; });
      return "one of " + list;
    }
    case KeyKind::kDuration:
      return "a duration from \"" + std::string(type.low_text) + "\" to \"" + std::string(type.high_text) + '"';
    case KeyKind::kListen:
      return "an IP address with a port, or \"off\"";
    case KeyKind::kChannel:
      return "a whole number from 0 to " + std::to_string(type.high) + ", or a name";
    case KeyKind::kValue:
      return "a value of the variable";
  }
  return {};
}

int choice_index(const KeyType& type, std::string_view text) {
  int index = 0;
  int found = -1;
  for_choices(type, [&](std::string_view one) {
    if (one == text) found = index;
    ++index;
  });
  return found;
}

}  // namespace plc::io
