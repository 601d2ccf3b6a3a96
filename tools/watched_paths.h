// Variables by patterns, as --watch has them.
//
// In: patterns, a resource. Out: paths. Does not belong here: values (io-drivers/trace.h).
#pragma once

#include <string>
#include <vector>

#include "runtime/resource.h"

namespace plc::tools {

/// The paths that match any pattern, each once, in declaration order per pattern; all of them without patterns.
std::vector<std::string> watched_paths(const std::vector<std::string>& patterns, runtime::Resource& resource);

}  // namespace plc::tools
