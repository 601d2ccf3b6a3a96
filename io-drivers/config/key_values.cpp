#include "io-drivers/config/key_values.h"

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "core/duration.h"
#include "core/text.h"

namespace plc::io {

KeyValues::KeyValues(std::span<const KeyInfo> keys) {
  for (const KeyInfo& key : keys) {
    std::string_view text = key.fallback.kind == KeyDefault::Kind::kValue ? key.fallback.toml : "";
    if (text.starts_with('"')) text = text.substr(1, text.size() - 2);
    values_.push_back({&key, {std::string(text), {}}, {}});
  }
}

const KeyValues::Value* KeyValues::find(std::string_view key) const {
  const auto found = std::find_if(values_.begin(), values_.end(), [&](const Value& v) { return v.key->name == key; });
  return found == values_.end() ? nullptr : &*found;
}

const KeyValues::Value& KeyValues::at(std::string_view key) const {
  if (const Value* const value = find(key)) return *value;
  throw std::logic_error("no row for the key " + std::string(key));
}

void KeyValues::set(std::string_view key, Placed value, std::vector<Placed> list) {
  const Value* const found = find(key);
  if (found != nullptr) values_[std::size_t(found - values_.data())] = {found->key, std::move(value), std::move(list)};
}

core::SourceRef KeyValues::place(std::string_view key, const core::SourceRef& otherwise) const {
  const Value* const value = find(key);
  return value != nullptr && value->value.at.line != 0 ? value->value.at : otherwise;
}

std::int64_t KeyValues::number(std::string_view key) const {
  const KeyType& type = at(key).key->type;
  const std::string& value = text(key);
  if (type.kind == KeyKind::kBoolean) return core::iequals(value, "true") ? 1 : 0;
  if (type.kind == KeyKind::kDuration) return core::parse_duration_ns(value).value_or(0);
  if (type.kind == KeyKind::kChoice) return std::max(choice_index(type, value), 0);
  std::int64_t number = 0;
  std::from_chars(value.data(), value.data() + value.size(), number);
  return number;
}

}  // namespace plc::io
