// Engines: --engine, and native code for the tasks of a resource before their first scan (docs/guides/engines.md).
//
// In: a resource that does not run yet. Out: compiled tasks, installed; what could not be compiled and why. Does not
// belong here: the compiler (native/).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "runtime/resource.h"
#include "tools/cli.h"

namespace plc::tools {

enum class Engine : std::uint8_t {
  kAuto,         ///< native code; a task that cannot be compiled runs in the interpreter, with a note
  kInterpreter,  ///< the reference
  kNative,       ///< native code; a task that cannot be compiled is an error
};

/// Adds --engine. `engine` must outlive the parsing.
void add_engine_option(Command command, Engine& engine);

/// "interpreter" or "native": what the task runs in.
std::string engine_name(const runtime::Program& program);

/// Compiles and installs what the tasks of a resource run in, before their first scan. kAuto says on stderr, in the
/// name of `command`, which task stays with the interpreter and why; kNative returns the first such problem.
std::optional<core::Problem> prepare_engine(runtime::Resource& resource, Engine engine, const char* command);

}  // namespace plc::tools
