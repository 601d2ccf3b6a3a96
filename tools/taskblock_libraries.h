// What plc.toml adds to a project: the taskblocks that it may use on this machine, beside those that come with PICARD,
// and files of declarations. A project itself never names code.
//
// In: a Configuration, or the --config of a command that compiles. Out: a Registry, which must outlive what is compiled
// and loaded with it; paths for Request::libraries. Does not belong here: what makes a library good
// (taskblocks/shared_library.h).
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"
#include "taskblocks/registry.h"
#include "taskblocks/shared_library.h"
#include "tools/cli.h"

namespace plc::tools {

/// Those of PICARD and of [taskblocks] libraries. What cannot be used is reported at its line (P7801) and left out.
/// `trial_time`: what each library has to be loaded.
taskblocks::Registry load_taskblocks(const io::Configuration& configuration, core::Diagnostics& diagnostics,
                                     std::chrono::milliseconds trial_time = taskblocks::kTrialTime);

/// Adds the files of [project] libraries after those of --lib. What cannot be opened is reported at its line (P7001).
void add_project_libraries(const io::Configuration& configuration, std::vector<std::string>& libraries,
                           core::Diagnostics& diagnostics);

/// Adds --config for the sake of [project] and [taskblocks] alone. The text must outlive the parsing.
void add_taskblocks_option(Command command, std::string& configuration);
/// What that option asks for into `registry`, and its [project] libraries into `libraries`; errors on stderr. The
/// exit code when there is nothing to go on with.
std::optional<int> load_taskblocks(const std::string& configuration, taskblocks::Registry& registry,
                                   std::vector<std::string>& libraries);
/// The same; `read` becomes what the file says, and its problems are for the caller to print.
std::optional<int> load_taskblocks(const std::string& configuration, taskblocks::Registry& registry,
                                   std::vector<std::string>& libraries, io::Configuration& read,
                                   core::Diagnostics& diagnostics);

}  // namespace plc::tools
