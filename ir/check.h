// ir::check: what must hold before code is generated, beyond what the builder already ensured.
#pragma once

#include <string>

#include "core/diagnostics.h"
#include "ir/ir.h"

namespace plc::ir {

/// Recursion among POUs (with its path), instances of function blocks inside themselves, labels jumped to but not
/// bound, several normal coils or tasks writing one variable (warnings). Errors are reported; true when there were
/// none.
bool check(const Module& module, core::Diagnostics& diagnostics);

/// The module as text: declarations and bodies, one instruction a line, with localIds. For goldens and --dump.
std::string print(const Module& module);

}  // namespace plc::ir
