#include "tools/taskblock_libraries.h"

#include <algorithm>
#include <iostream>

#include "taskblocks/shared_library.h"
#include "tools/command_line.h"

namespace plc::tools {

taskblocks::Registry load_taskblocks(const io::Configuration& configuration, core::Diagnostics& diagnostics) {
  taskblocks::Registry registry = taskblocks::Registry::built_in();
  for (const io::Placed& library : configuration.taskblocks.libraries) {
    const auto problem = taskblocks::load_shared_library(configuration.beside(library.text), registry);
    if (problem) diagnostics.report(problem->code, library.at, {}, problem->message, problem->help);
  }
  return registry;
}

void add_taskblocks_option(CLI::App& app, std::string& configuration) {
  app.add_option("--config", configuration, "configuration whose [taskblocks] libraries the project may use")
      ->type_name("plc.toml");
}

std::optional<int> load_taskblocks(const std::string& configuration, taskblocks::Registry& registry) {
  registry = taskblocks::Registry::built_in();
  if (configuration.empty()) return std::nullopt;
  core::Diagnostics diagnostics;
  const auto read = io::load_configuration(configuration, diagnostics);
  if (read) registry = load_taskblocks(*read, diagnostics);
  diagnostics.render_with_lines(std::cerr);
  if (!diagnostics.has_errors()) return std::nullopt;
  return diagnostics.all().front().code == core::Code::P7001 ? kExitUsage : kExitErrors;
}

}  // namespace plc::tools
