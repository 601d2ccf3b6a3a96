// st::declare: Project declarations -> ir::Module symbols: data types, POU interfaces, globals, initial values, tasks
// and program instances. Bodies stay empty; front ends fill them afterwards.
#pragma once

#include <memory>

#include "core/diagnostics.h"
#include "core/options.h"
#include "ir/ir.h"
#include "plcopen/project.h"

namespace plc::st {

/// Declares everything `project` declares. Problems (P4xxx: unknown types, bad initial values, addresses, intervals,
/// instance of an unknown program) are reported; what could be declared is there. With options.pou set, the
/// configuration is one 20 ms task running that POU alone, its instance named like it; inputs of the instance stay
/// writable from outside. Module::pous has one entry per Project::pous entry, in the same order.
std::unique_ptr<ir::Module> declare(const plcopen::Project& project, const core::CompileOptions& options,
                                    core::Diagnostics& diagnostics);

}  // namespace plc::st
