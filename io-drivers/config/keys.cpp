#include "io-drivers/config/keys.h"

#include "io-drivers/config/driver_type.h"

namespace plc::io {
namespace {

using namespace key;

constexpr TableInfo kTables[] = {
#define PLC_CONFIG_TABLE(table, structure, heading, documentation) {TableId::table, heading, documentation},
#include "io-drivers/config/keys.def"
};
constexpr KeyInfo kKeys[] = {
#define PLC_CONFIG_KEY(table, name, place, type, fallback, applies, documentation) \
  {name, type, fallback, documentation, applies, TableId::table},
#include "io-drivers/config/keys.def"
};

}  // namespace

Keys::Keys(DriverTypes types) : rows_(std::begin(kKeys), std::end(kKeys)) {
  for (const DriverType* type : types) {
    kinds_ += (kinds_.empty() ? "" : "|") + std::string(type->name);
    kinds_help_ += (kinds_help_.empty() ? "" : " ") + std::string(type->name) + ": " + std::string(type->summary);
    if (first_kind_.empty()) first_kind_ = '"' + std::string(type->name) + '"';
    const auto add = [&](std::span<const KeyInfo> keys, TableId table) {
      for (KeyInfo key : keys) {
        key.table = table;
        key.kind = type;
        rows_.push_back(key);
      }
    };
    add(type->driver_keys, TableId::kDriver);
    add(type->channel_keys, TableId::kChannel);
  }
  for (KeyInfo& key : rows_) {
    if (key.table != TableId::kDriver || key.name != "kind") continue;
    key.type.choices = kinds_;
    key.fallback.toml = first_kind_;
    key.documentation = kinds_help_;
  }
}

const KeyInfo* Keys::find(TableId table, std::string_view name, const DriverType* kind) const {
  const KeyInfo* other = nullptr;
  for (const KeyInfo& key : rows_) {
    if (key.table != table || key.name != name) continue;
    if (key.kind == nullptr || key.kind == kind) return &key;
    if (other == nullptr) other = &key;
  }
  return other;
}

std::span<const TableInfo> config_tables() { return kTables; }

std::string applies_text(const KeyInfo& key) {
  std::string text = key.kind == nullptr ? "" : std::string(key.kind->name) + " only";
  const std::string_view way = key.applies == kOutputsOnly  ? "outputs only"
                               : key.applies == kInputsOnly ? "inputs only"
                                                            : "";
  return text + (text.empty() || way.empty() ? "" : ", ") + std::string(way);
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
