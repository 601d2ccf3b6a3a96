// plc config: writes a plc.toml for a project, and checks one against it.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <system_error>

#include "io-drivers/config/bind.h"
#include "io-drivers/config/check_schedule.h"
#include "io-drivers/config/driver_type.h"
#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/config/template.h"
#include "io-drivers/machine/driver_types.h"
#include "io-drivers/modbus/address_map.h"
#include "runtime/memory/global_ports.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/plc/json.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Init {
  std::string file, output, configuration;
  bool force = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

struct Check {
  std::string configuration, file;
  bool json = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

std::unique_ptr<runtime::Resource> load(Compilation& compilation, const taskblocks::Registry& registry) {
  runtime::ProgramOptions program;
  program.taskblocks = &registry;
  program.start_taskblocks = false;  // nothing runs
  auto resource = runtime::Resource::load(std::move(*compilation.image), program);
  if (resource) return std::move(*resource);
  const core::Problem& problem = resource.error();
  compilation.diagnostics.report(problem.code, {}, {}, problem.message, problem.help);
  return nullptr;
}

int init(Command command, const Init& init) {
  std::error_code ignored;
  if (std::filesystem::equivalent(init.file, init.output, ignored)) {
    complain("plc config init", "-o " + init.output + " would overwrite the project", "call it plc.toml");
    return kExitUsage;
  }
  // A symbolic link is something that exists, wherever it leads.
  const auto present = std::filesystem::symlink_status(init.output, ignored);
  const bool plain =
      present.type() == std::filesystem::file_type::regular || present.type() == std::filesystem::file_type::symlink;
  if (!init.output.empty() && plain && !init.force) {
    complain("plc config init", init.output + " exists", "give another name to -o, or --force to replace it");
    return kExitUsage;
  }
  taskblocks::Registry registry;
  std::vector<std::string> libraries = init.libraries;
  if (const auto code = load_taskblocks(init.configuration, registry, libraries)) return *code;
  Compilation compilation;
  if (const auto code = open_or_explain(command, {init.file, init.options, Goal::kRun, libraries, {}, &registry, true},
                                        compilation)) {
    return *code;
  }
  const auto resource = load(compilation, registry);
  if (resource == nullptr) {
    compilation.diagnostics.render_with_lines(std::cerr);
    return kExitErrors;
  }
  const std::string text = io::configuration_template(*resource, init.file, io::driver_types());
  if (init.output.empty()) {
    std::cout << text;
    return kExitOk;
  }
  std::string why;
  if (!write_file(init.output, text, why)) {
    complain("plc config init", fmt::format("{} cannot be written: {}", init.output, why));
    return kExitUsage;
  }
  std::cout << fmt::format("{}: every setting is commented out; what is uncommented counts\n", init.output);
  return kExitOk;
}

/// "plc.toml: ok, 2 drivers, 5 inputs, 6 outputs mapped, 0 warnings".
std::string summary(const Check& check, const core::Diagnostics& diagnostics, std::size_t errors,
                    const std::optional<io::Binding>& binding) {
  const std::string warnings = counted(diagnostics.warning_count(), "warning");
  if (!binding) return fmt::format("{}: {}, {}", check.configuration, counted(errors, "error"), warnings);
  std::size_t inputs = 0, outputs = 0;
  for (const io::BoundDriver& driver : binding->drivers) {
    inputs += driver.inputs.size();
    outputs += driver.outputs.size();
  }
  return fmt::format("{}: ok, {}, {}, {} mapped, {}", check.configuration, counted(binding->drivers.size(), "driver"),
                     counted(inputs, "input"), counted(outputs, "output"), warnings);
}

/// What plc-run would find in the files that plc.toml names.
void check_files(const Check& check, const io::Configuration& configuration, const io::Binding& binding,
                 runtime::Resource& resource, core::Diagnostics& diagnostics) {
  const auto report = [&](const core::SourceRef& at, const core::Problem& problem) {
    diagnostics.report(problem.code, at.line != 0 ? at : configuration.at, {}, problem.message, problem.help);
  };
  for (const io::BoundDriver& driver : binding.drivers) {
    const io::DriverType& type = *driver.config->type;
    if (type.check_files == nullptr) continue;
    const auto problem = type.check_files(driver, configuration, resource);
    if (problem) report(driver.config->values.place(type.device_key, driver.config->at), *problem);
  }
  if (!configuration.modbus.serves()) return;
  auto frozen = modbus::read_frozen(modbus::lock_file_of(configuration, check.file), resource.image());
  if (!frozen) {
    report(configuration.modbus.lock_file.at, frozen.error());
    return;
  }
  const std::vector<std::uint32_t> claimed = io::claimed_fields(binding);
  std::optional<runtime::GlobalInputs> inputs;
  if (!claimed.empty()) inputs.emplace(resource.globals(), claimed);
  static_cast<void>(modbus::AddressMap::build(resource, configuration.modbus, *frozen, diagnostics));
}

/// What plc-run would say of the tasks.
void check_tasks(const io::Configuration& configuration, const bytecode::Image& image, core::Diagnostics& diagnostics) {
  const std::vector<int> cpus = io::available_cpus();
  const auto plan = io::plan_tasks(configuration, image, cpus, runtime::FaultPolicy::kSafeState, diagnostics);
  if (plan) io::check_schedule(configuration, image, *plan, cpus, diagnostics);
}

int check(Command command, const Check& check) {
  if (is_image_path(check.file) && has_compile_options(command)) {
    complain("plc config check", fmt::format("{} is an image: its compile options are stored in it", check.file),
             "compile the project file again with other options, or omit the options");
    return kExitUsage;
  }
  Compilation compilation;
  core::Diagnostics& diagnostics = compilation.diagnostics;
  if (check.options.show_all) diagnostics.show_all();
  // What it names is there before the project that uses it.
  const auto configuration = io::load_configuration(check.configuration, diagnostics);
  taskblocks::Registry registry = taskblocks::Registry::built_in();
  std::vector<std::string> libraries = check.libraries;
  if (configuration) {
    registry = load_taskblocks(*configuration, diagnostics);
    add_project_libraries(*configuration, libraries, diagnostics);
  }
  const std::size_t errors = diagnostics.error_count();
  open({check.file, check.options, Goal::kRun, libraries, {}, &registry, true}, compilation);
  const std::size_t project_errors = diagnostics.error_count() - errors;

  std::unique_ptr<runtime::Resource> resource;
  std::optional<io::Binding> binding;
  if (compilation.image && configuration) resource = load(compilation, registry);
  if (resource != nullptr) binding = io::bind(*configuration, *resource, diagnostics);
  if (binding) check_files(check, *configuration, *binding, *resource, diagnostics);
  if (resource != nullptr) check_tasks(*configuration, resource->image(), diagnostics);
  if (diagnostics.has_errors()) binding.reset();

  const bool readable = std::none_of(diagnostics.all().begin(), diagnostics.all().end(), [](const core::Diagnostic& d) {
    return d.code == core::Code::P7001 && d.at.line == 0;
  });
  const int exit_code = binding ? kExitOk : readable ? kExitErrors : kExitUsage;
  if (check.json) {
    std::vector<CheckedFile> files;
    files.push_back({check.configuration, binding.has_value(), std::move(diagnostics)});
    std::cout << diagnostics_json(files);
    return exit_code;
  }
  diagnostics.render_with_lines(std::cerr);
  if (!readable) return exit_code;
  if (project_errors != 0) std::cout << fmt::format("{}: {}\n", check.file, counted(project_errors, "error"));
  std::cout << summary(check, diagnostics, diagnostics.error_count() - project_errors, binding) << std::endl;
  return exit_code;
}

void add_init(Command config) {
  static Init options;
  const Command command = config.sub(
      "init",
      "Writes a plc.toml for a project: every key with its default and what it means, every variable at an address\n"
      "with a line that would connect it. All settings are commented out.\n"
      "\n"
      "Examples:\n"
      "  plc config init plant.xml                    on standard output\n"
      "  plc config init plant.xml -o plc.toml        never overwrites a file without --force");
  command.option("FILE", options.file, "PLCopen XML or ST file, source folder, or image").required();
  command.option("-o,--output=PLC.TOML", options.output, "file to write instead of standard output");
  command.flag("--force", options.force, "replace the file when it exists");
  add_library_option(command, options.libraries);
  add_taskblocks_option(command, options.configuration);
  add_compile_options(command, options.options);
  command.on_run([command] { return init(command, options); });
}

void add_config_check(Command config) {
  static Check options;
  const Command command = config.sub(
      "check",
      "Checks a plc.toml against a project and reports every problem with line and column; opens no device.\n"
      "\n"
      "Examples:\n"
      "  plc config check plc.toml plant.xml\n"
      "  plc config check --json plc.toml plant.pbc > problems.json");
  command.option("PLC.TOML", options.configuration, "the configuration").required();
  command.option("FILE", options.file, "PLCopen XML or ST file, source folder, or image").required();
  command.flag("--json", options.json, "one JSON document on stdout instead of text on stderr");
  add_library_option(command, options.libraries);
  add_compile_options(command, options.options);
  command.on_run([command] { return check(command, options); });
}

}  // namespace

void add_config(Command program) {
  const Command config = program.sub("config",
                                     "Writes and checks plc.toml: which device is which variable, Modbus/TCP, the "
                                     "guardian.\n"
                                     "\n"
                                     "Examples:\n"
                                     "  plc config init plant.xml -o plc.toml\n"
                                     "  plc config check plc.toml plant.xml");
  add_init(config);
  add_config_check(config);
}

}  // namespace plc::tools
