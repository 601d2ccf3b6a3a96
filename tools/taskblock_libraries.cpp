#include "tools/taskblock_libraries.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <system_error>
#include <utility>

#include "frontend-st/read.h"
#include "io-drivers/machine/driver_types.h"
#include "tools/command_line.h"

namespace plc::tools {
namespace {

/// What is wrong with the block as the text that projects see; empty when they can. A port called IF, say.
std::string unreadable(const picard_block& block) {
  core::Diagnostics diagnostics;
  static_cast<void>(st::read_memory(taskblocks::declaration(block), "taskblocks", diagnostics));
  return diagnostics.has_errors() ? diagnostics.all().front().message : std::string{};
}

}  // namespace

taskblocks::Registry load_taskblocks(const io::Configuration& configuration, core::Diagnostics& diagnostics,
                                     std::chrono::milliseconds trial_time) {
  taskblocks::Registry registry = taskblocks::Registry::built_in();
  std::size_t checked = registry.entries().size();
  for (const io::Placed& library : configuration.taskblocks.libraries) {
    const auto problem = taskblocks::load_shared_library(configuration.beside(library.text), registry, trial_time);
    if (problem) diagnostics.report(problem->code, library.at, {}, problem->message, problem->help);
    for (; checked < registry.entries().size(); ++checked) {
      const picard_block& block = *registry.entries()[checked].block;
      const std::string wrong = unreadable(block);
      if (wrong.empty()) continue;
      diagnostics.report(core::Code::P7801, library.at, {},
                         std::string(registry.entries()[checked].source) + ": " + block.name +
                             " cannot be declared in a project: " + wrong,
                         "give ports names that are no keywords");
    }
  }
  return registry;
}

void add_project_libraries(const io::Configuration& configuration, std::vector<std::string>& libraries,
                           core::Diagnostics& diagnostics) {
  for (const io::Placed& library : configuration.project.libraries) {
    std::string path = configuration.beside(library.text);
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored) || !std::ifstream(path)) {
      diagnostics.report(core::Code::P7001, library.at, {}, "library " + path + " cannot be opened for reading",
                         "give its path as seen from the folder of plc.toml");
      continue;
    }
    libraries.push_back(std::move(path));
  }
}

void add_taskblocks_option(Command command, std::string& configuration) {
  command.option("--config=plc.toml", configuration,
                 "configuration whose [project] and [taskblocks] libraries the project uses");
}

std::optional<int> load_taskblocks(const std::string& configuration, taskblocks::Registry& registry,
                                   std::vector<std::string>& libraries) {
  io::Configuration ignored;
  core::Diagnostics diagnostics;
  const auto code = load_taskblocks(configuration, registry, libraries, ignored, diagnostics);
  // What else the file says is for plc config check, and for who runs the project with it.
  if (code) diagnostics.render_with_lines(std::cerr);
  return code;
}

std::optional<int> load_taskblocks(const std::string& configuration, taskblocks::Registry& registry,
                                   std::vector<std::string>& libraries, io::Configuration& read,
                                   core::Diagnostics& diagnostics) {
  registry = taskblocks::Registry::built_in();
  if (configuration.empty()) return std::nullopt;
  if (auto loaded = io::load_configuration(configuration, diagnostics)) {
    read = std::move(*loaded);
    registry = load_taskblocks(read, diagnostics);
    add_project_libraries(read, libraries, diagnostics);
  }
  if (!diagnostics.has_errors()) return std::nullopt;
  // What the file names is a mistake of the file.
  const core::Diagnostic& first = diagnostics.all().front();
  return first.code == core::Code::P7001 && first.at.line == 0 ? kExitUsage : kExitErrors;
}

}  // namespace plc::tools
