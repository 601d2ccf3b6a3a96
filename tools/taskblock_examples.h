// The drawn examples of the set that comes with PICARD, embedded by the build.
#pragma once

#include <span>

#include "tools/taskblock_text.h"

namespace plc::tools {

/// In the order of their paths.
std::span<const TaskblockExample> taskblock_examples();

}  // namespace plc::tools
