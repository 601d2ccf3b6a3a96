// Looking up names the way ST does, and guessing what a misspelt one was meant to be.
//
// In: a Builder's module and POU. Out: what a name stands for; help lines. Does not belong here: syntax, IR.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ir/ir.h"

namespace plc::st {

/// What a plain name stands for: variables of the POU hide globals.
struct Named {
  enum class Kind : std::uint8_t { kNothing, kVariable, kGlobal } kind = Kind::kNothing;
  std::uint32_t index = 0;  ///< into Pou::variables or Module::globals
};
Named find_name(const ir::Module& module, const ir::Pou& pou, std::string_view name);

/// An enumeration value: its type and number.
struct EnumValueRef {
  ir::TypeRef type{};
  std::int64_t value = 0;
};
/// Every enumeration that has a value of this name; aliases count once.
std::vector<EnumValueRef> find_enum_values(const ir::TypeTable& types, std::string_view name);
/// The value `name` of enumeration `type`; invalid type if it has none.
EnumValueRef find_enum_value(const ir::TypeTable& types, ir::TypeRef type, std::string_view name);

/// Collects candidates and keeps the one nearest to a misspelt name.
class Guess {
 public:
  explicit Guess(std::string_view wrong) : wrong_(wrong) {}
  void offer(std::string_view candidate);
  /// "did you mean \"Start\"?", or empty when nothing is near.
  [[nodiscard]] std::string help() const;

 private:
  std::string_view wrong_;
  std::string best_;
  std::size_t distance_ = 0;
  bool found_ = false;
};

}  // namespace plc::st
