// KeyValues: what plc.toml says of the keys that a kind of driver has of its own, for one driver or one channel. The
// kind's folder reads its settings from here.
//
// In: values that the reader found good. Out: values, or the defaults of their rows. Does not belong here: what they
// mean.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/keys.h"

namespace plc::io {

/// A text with its place in the file.
struct Placed {
  std::string text;
  core::SourceRef at;
};

/// text(), list() and number() throw for a key that has no row: a mistake of the kind's author.
class KeyValues {
 public:
  KeyValues() = default;
  /// Defaults. `keys`: the rows, which outlive this.
  explicit KeyValues(std::span<const KeyInfo> keys);

  /// `list` for keys of KeyKind::kTexts. A key without a row is ignored.
  void set(std::string_view key, Placed value, std::vector<Placed> list = {});
  /// Whether the file has the key, with a value that is good.
  [[nodiscard]] bool has(std::string_view key) const { return place(key, {}).line != 0; }
  /// The file has the key, be its value good or not.
  void mention(std::string_view key) { mentioned_.emplace_back(key); }
  /// What is wrong with it was said already: nothing is missing.
  [[nodiscard]] bool mentions(std::string_view key) const {
    return std::ranges::find(mentioned_, key) != mentioned_.end();
  }
  /// Of the value, or `otherwise` when the file does not have the key.
  [[nodiscard]] core::SourceRef place(std::string_view key, const core::SourceRef& otherwise) const;

  /// As in the file, else the default; empty without one.
  [[nodiscard]] const std::string& text(std::string_view key) const { return at(key).value.text; }
  /// Empty when the file does not have the key.
  [[nodiscard]] const std::vector<Placed>& list(std::string_view key) const { return at(key).list; }
  /// true as 1, whole numbers, durations in ns, choices by their position; of the default when the file does not have
  /// the key, and 0 without one.
  [[nodiscard]] std::int64_t number(std::string_view key) const;
  [[nodiscard]] bool flag(std::string_view key) const { return number(key) != 0; }
  /// The enumerators are in the order of the choices.
  template <class Enum>
  [[nodiscard]] Enum choice(std::string_view key) const {
    return static_cast<Enum>(number(key));
  }

 private:
  struct Value {
    const KeyInfo* key;
    Placed value;  ///< without a line: the default
    std::vector<Placed> list;
  };
  [[nodiscard]] const Value* find(std::string_view key) const;
  [[nodiscard]] const Value& at(std::string_view key) const;

  std::vector<Value> values_;           ///< one for each row
  std::vector<std::string> mentioned_;  ///< keys of the file, of a channel
};

}  // namespace plc::io
