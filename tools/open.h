// open_or_explain(): what every command that compiles does first.
//
// In: a request. Out: a compilation with all its diagnostics on stderr. Does not belong here: compiling (compile.h).
#pragma once

#include <optional>

#include "compiler/compile.h"
#include "tools/command_line.h"

namespace plc::tools {

using compiler::Compilation;
using compiler::Goal;
using compiler::Request;

/// compile() or load with all diagnostics on stderr. Refuses compile options for an image. The exit code when there is
/// nothing to go on with.
std::optional<int> open_or_explain(Command command, const Request& request, Compilation& compilation);

}  // namespace plc::tools
