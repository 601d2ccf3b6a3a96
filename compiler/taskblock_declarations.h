// Taskblocks join a project as function blocks without statements: what front ends, checks and code generation know of
// blocks holds for them as well.
#pragma once

#include <cstddef>

#include "core/diagnostics.h"
#include "plcopen/project.h"
#include "taskblocks/registry.h"

namespace plc::compiler {

/// Declares the taskblocks that `project` names and does not declare itself, and the structures of their ports that it
/// names. What an editor has from `plc blocks --xml` gives way to them first: function blocks of the same ports without
/// a body, structures with the same fields. Returns how many of those there were. Another function block of a
/// taskblock's name is meant as it stands, and hides the taskblock (P4019).
std::size_t add_taskblocks(plcopen::Project& project, const taskblocks::Registry& registry,
                           core::Diagnostics& diagnostics);

}  // namespace plc::compiler
