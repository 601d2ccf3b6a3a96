// Looking up names the way ST does.
//
// In: a Builder's module and POU. Out: what a name stands for. Does not belong here: syntax, IR.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/guess.h"
#include "ir/ir.h"

namespace plc::st {

/// What a plain name stands for: variables of the POU hide globals, but for ".x", which is the global x.
struct Named {
  enum class Kind : std::uint8_t {
    kNothing,
    kVariable,
    kGlobal,
    kRefused,  ///< a variable whose declaration was reported as wrong: nothing more is said of it
  } kind = Kind::kNothing;
  std::uint32_t index = 0;  ///< into Pou::variables or Module::globals
  [[nodiscard]] bool is_place() const { return kind == Kind::kVariable || kind == Kind::kGlobal; }
};
Named find_name(const ir::Module& module, const ir::Pou& pou, std::string_view name);

/// The program of this name, into Module::pous.
std::optional<std::uint32_t> find_program(const ir::Module& module, std::string_view name);

/// An action as a call names it.
struct ActionName {
  std::string_view instance;  ///< path of the instance it runs on; empty = the one that the calling body runs on
  std::uint32_t action = 0;   ///< into Module::pous
};
/// What "Start", "pump.Start", "line[2].pump.Start" or "Program.Start" means in a body of `pou`, if it is an action.
/// Reports nothing, makes no instructions.
std::optional<ActionName> find_action(const ir::Module& module, const ir::Pou& pou, std::string_view path);

/// Whether a call of `name` in a body of `pou` is that of a function, of the project or of the library: instances hide
/// functions of their name, other variables do not.
bool names_function(const ir::Module& module, const ir::Pou& pou, std::string_view name);

/// An enumeration value: its type and number.
struct EnumValueRef {
  ir::TypeRef type{};
  std::int64_t value = 0;
};
/// Every enumeration that has a value of this name; aliases count once. Those of libraries are no choice where the
/// project has one, nor those of the project where a library asks and libraries have one.
std::vector<EnumValueRef> find_enum_values(const ir::TypeTable& types, std::string_view name, bool in_library);
/// The value `name` of enumeration `type`; invalid type if it has none.
EnumValueRef find_enum_value(const ir::TypeTable& types, ir::TypeRef type, std::string_view name);

/// Whether an enumeration that is not of a library has a value of this name.
bool is_project_enum_value(const ir::TypeTable& types, std::string_view name);

using core::Guess;

}  // namespace plc::st
