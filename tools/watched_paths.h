// Variables by patterns, as --watch has them.
//
// In: patterns, a resource. Out: paths, an open trace. Does not belong here: values (io-drivers/trace.h).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/trace.h"
#include "runtime/resource.h"

namespace plc::tools {

/// The paths that match any pattern, each once, in declaration order per pattern; all of them without patterns.
std::vector<std::string> watched_paths(const std::vector<std::string>& patterns, runtime::Resource& resource);

/// Opens what --trace, --watch and --values of `command` ask for; `trace` stays null when they ask for nothing. The
/// exit code, after a message, when it cannot be.
std::optional<int> open_trace(const char* command, const std::string& file, const std::vector<std::string>& watch,
                              std::optional<runtime::ValueStyle> values, runtime::Resource& resource,
                              std::unique_ptr<io::TraceWriter>& trace);

}  // namespace plc::tools
