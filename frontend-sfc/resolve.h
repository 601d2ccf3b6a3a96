// Names of actions at steps: what they stand for in their POU.
#pragma once

#include <string>

#include "core/diagnostics.h"
#include "frontend-sfc/prepare.h"
#include "ir/ir.h"

namespace plc::sfc {

/// What `name` at step `step` means in the POU `pou`. P3106, and kNothing, when it is neither action nor BOOL variable;
/// `actions_only`: as the entry, main or exit action of a step, which are no variables.
Target resolve(const ir::Module& module, const ir::Pou& pou, const std::string& name, const Step& step,
               const core::SourceRef& at, bool actions_only, core::Diagnostics& diagnostics);

/// One text for all spellings of one action: letter case and blanks do not count.
std::string key_of(const Target& target);

}  // namespace plc::sfc
