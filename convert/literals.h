// Constants and types of the IR as text of ST, with the type written where a literal would take another one by itself.
//
// In: constants, types. Out: text that reads back as the same. Does not belong here: statements (body_writer.h).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "ir/ir.h"

namespace plc::convert {

/// "INT#5", "T#20ms", "REAL#0.5", "'it$'s'", "Color#Red". Nothing for what has no literal: NaN, a value of an
/// enumeration without name.
std::optional<std::string> literal_text(const ir::TypeTable& types, const ir::Constant& constant);

/// The name of a variable or member as a text can have it: with a "_" where it is a keyword.
std::string name_text(std::string_view name);

/// The name of a type in a declaration. Nothing for types without a name: anonymous enumerations and structures.
std::optional<std::string> type_text(const ir::TypeTable& types, ir::TypeRef type);

}  // namespace plc::convert
