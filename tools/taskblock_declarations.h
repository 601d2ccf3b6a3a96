// Taskblocks join a project as function blocks without statements: what front ends, checks and code generation know of
// blocks holds for them as well.
#pragma once

#include "core/diagnostics.h"
#include "plcopen/project.h"
#include "taskblocks/registry.h"

namespace plc::tools {

/// Declares the taskblocks that `project` names and does not declare itself, with the structures their ports need. A
/// declaration that an editor has from `plc blocks --xml`, a function block of the same ports and no body, gives way.
void add_taskblocks(plcopen::Project& project, const taskblocks::Registry& registry, core::Diagnostics& diagnostics);

}  // namespace plc::tools
