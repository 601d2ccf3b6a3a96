// plc doctor: is this machine fit to run a project?
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "doctor/examine.h"
#include "doctor/process.h"
#include "io-drivers/machine/driver_types.h"
#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

using doctor::Line;
using doctor::State;
using nlohmann::ordered_json;

struct Doctor {
  std::string file, configuration, state, root, process = "self";
  bool json = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

/// Time that a library of taskblocks has to be loaded.
constexpr std::chrono::milliseconds kLibraryTime{900};

/// How many lines have each state.
std::array<std::size_t, 5> counts_of(const std::vector<Line>& lines) {
  std::array<std::size_t, 5> counts{};
  for (const Line& line : lines) ++counts[static_cast<std::size_t>(line.state)];
  return counts;
}

void print_json(const std::vector<Line>& lines) {
  ordered_json document;
  document["lines"] = ordered_json::array();
  for (const Line& line : lines) {
    ordered_json one;
    one["state"] = doctor::state_word(line.state);
    one["code"] = core::info(line.code).name;
    one["area"] = line.area;
    one["what"] = line.what;
    one["seen"] = line.seen;
    one["help"] = line.help;
    document["lines"].push_back(std::move(one));
  }
  const auto counts = counts_of(lines);
  for (std::size_t s = 0; s < counts.size(); ++s) {
    document["counts"][std::string(doctor::state_word(static_cast<State>(s)))] = counts[s];
  }
  std::cout << document.dump(2, ' ', false, ordered_json::error_handler_t::replace) << '\n';
}

void print_text(const std::vector<Line>& lines) {
  for (const Line& line : lines) {
    const bool wrong = line.state > State::kUnknown;
    std::cout << fmt::format("{:<8}{:<6}{:<32}{}\n", doctor::state_word(line.state),
                             wrong ? core::info(line.code).name : "", fmt::format("{}: {}", line.area, line.what),
                             line.seen);
    if (!line.help.empty()) std::cout << fmt::format("{:14}help: {}\n", "", line.help);
  }
  const auto counts = counts_of(lines);
  std::cout << fmt::format("\n{}, {}, {}, {} ok, {} unknown{}\n", counted(counts[4], "problem"),
                           counted(counts[3], "warning"), counted(counts[2], "note"), counts[0], counts[1],
                           counts[2] + counts[3] + counts[4] != 0 ? "; `plc explain CODE` says more" : "");
}

int run(const Doctor& given) {
  std::error_code ignored;
  if (!given.root.empty() && !std::filesystem::is_directory(given.root, ignored)) {
    complain("plc doctor", given.root + " is no folder",
             "give one with etc, proc and sys of a machine in it to --root");
    return kExitUsage;
  }
  Doctor options = given;
  if (compiler::has_extension(options.file, ".toml")) {
    if (!options.configuration.empty()) {
      complain("plc doctor", "two configurations: " + options.file + " and " + options.configuration, "give one");
      return kExitUsage;
    }
    options.configuration = std::move(options.file);
    options.file.clear();
  }
  const bool here = options.root.empty();
  const doctor::System system = here ? doctor::System::here() : doctor::System(options.root);
  if (options.process != "self" && !doctor::Process(system, options.process).known()) {
    complain("plc doctor", fmt::format("there is no process {}{}", options.process, here ? "" : " in " + options.root),
             "`pidof -s plc-run` tells the one of a plc-run that runs");
    return kExitUsage;
  }
  doctor::Subject subject;
  subject.configuration_file = options.configuration;
  subject.project_file = options.file;
  subject.state = options.state;

  Compilation compilation;
  core::Diagnostics& diagnostics = compilation.diagnostics;
  taskblocks::Registry registry = taskblocks::Registry::built_in();
  if (!options.configuration.empty()) {
    auto read = io::load_configuration(options.configuration, diagnostics);
    subject.configuration_is_known = read.has_value();
    if (read) {
      subject.configuration = std::move(*read);
      // Code of another machine is not run.
      if (here) registry = load_taskblocks(subject.configuration, diagnostics, kLibraryTime);
      add_project_libraries(subject.configuration, options.libraries, diagnostics);
    }
  }
  std::unique_ptr<runtime::Resource> resource;
  if (!options.file.empty()) {
    compiler::open({options.file, options.options, Goal::kRun, options.libraries, {}, &registry, true}, compilation);
  }
  if (compilation.image) {
    runtime::ProgramOptions program;
    program.taskblocks = &registry;
    program.start_taskblocks = false;  // nothing runs
    auto loaded = runtime::Resource::load(std::move(*compilation.image), program);
    if (loaded) {
      resource = std::move(*loaded);
    } else {
      diagnostics.report(loaded.error().code, {}, {}, loaded.error().message, loaded.error().help);
    }
  }
  subject.resource = resource.get();
  const bool readable = std::none_of(diagnostics.all().begin(), diagnostics.all().end(), [](const core::Diagnostic& d) {
    return d.code == core::Code::P7001 && d.at.line == 0;
  });
  subject.diagnostics = std::move(diagnostics);

  const std::vector<Line> lines = doctor::examine(system, options.process, subject);
  if (options.json) {
    print_json(lines);
  } else {
    print_text(lines);
  }
  if (!readable) return kExitUsage;
  return counts_of(lines)[static_cast<std::size_t>(State::kProblem)] == 0 ? kExitOk : kExitErrors;
}

}  // namespace

void add_doctor(Command program) {
  static Doctor options;
  const Command command = program.sub(
      "doctor",
      "Looks at this machine: is it fit to run a project, and as well as it could? Kernel, clocks, processors, "
      "memory,\n"
      "rights, devices, ports, disk, retained values. Changes nothing, and needs no rights. A problem keeps plc-run "
      "from\n"
      "starting or working, a warning makes it worse than it could be, a note may be as it is meant.\n"
      "Exit code 1 when there is a problem.\n"
      "\n"
      "Examples:\n"
      "  plc doctor                                              the machine alone\n"
      "  plc doctor plc.toml                                     with the devices and the port of a configuration\n"
      "  plc doctor plant.pbc --config plc.toml --state /var/lib/picard/plant\n"
      "  plc doctor plc.toml --process $(pidof -s plc-run)       with the rights of a service that runs");
  command.option("FILE", options.file, "plc.toml; or the project: PLCopen XML or ST file, source folder, or image");
  command.option("--config=plc.toml", options.configuration, "configuration that the project runs with");
  command.option("--state=DIR", options.state, "folder of retained values, as for plc-run");
  command.option("--process=PID", options.process, "rights and limits are those of this process").check(wrong_count);
  command.option("--root=DIR", options.root, "a machine that lies in a folder; what no file tells is unknown then");
  command.flag("--json", options.json, "one JSON document");
  add_library_option(command, options.libraries);
  add_compile_options(command, options.options);
  command.on_run([] { return run(options); });
}

}  // namespace plc::tools
