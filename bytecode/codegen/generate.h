// bytecode::generate: checked IR -> Image. Lays out memory, maps boolean nets onto look-up records, emits code.
#pragma once

#include <optional>

#include "bytecode/image.h"
#include "core/diagnostics.h"
#include "ir/ir.h"

namespace plc::bytecode {

/// Generates the image of a module without errors. Only what the tasks reach is in it. Reports P5xxx and returns
/// nothing when a limit of the format is passed (table size, call depth).
std::optional<Image> generate(const ir::Module& module, core::Diagnostics& diagnostics);

}  // namespace plc::bytecode
