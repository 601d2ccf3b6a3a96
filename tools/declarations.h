// Where the variable at a path of the running project is declared.
//
// In: a Project, "main.curves[2]". Out: the place in its file. Does not belong here: values (runtime/access.h).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/source_ref.h"
#include "plcopen/project.h"

namespace plc::tools {

struct Declaration {
  core::SourceRef at;
  std::string pou;  ///< that declares it, or empty
};
/// The declaration of the last variable of the path that has one; nothing when not even the first name is known.
std::optional<Declaration> declaration_of(const plcopen::Project& project, std::string_view path);

}  // namespace plc::tools
