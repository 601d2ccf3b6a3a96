// plc check: compiles files without writing anything, and lints what compiles.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "alarms/alarms.h"
#include "engineering/hmi_pages.h"
#include "historian/historian.h"
#include "hmi/document.h"
#include "io-drivers/config/read_alarms.h"
#include "io-drivers/config/read_historian.h"
#include "io-drivers/config/table_file.h"
#include "ir/lint.h"
#include "runtime/resource.h"
#include "stdlib/library.h"
#include "tools/command_line.h"
#include "tools/declarations.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/plc/json.h"
#include "tools/taskblock_libraries.h"

namespace plc::tools {
namespace {

struct Check {
  std::vector<std::string> files;
  std::string configuration;
  bool json = false;
  bool werror = false;
  bool lint_libraries = false;
  std::vector<std::string> lints;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

std::string summary(const std::string& file, const Compilation& compilation) {
  const std::size_t errors = compilation.diagnostics.error_count();
  const std::size_t warnings = compilation.diagnostics.warning_count();
  std::string text = fmt::format("{}: {}", file, compilation.ok() ? "ok" : counted(errors, "error"));
  if (warnings != 0) text += ", " + counted(warnings, "warning");
  if (const std::size_t notes = compilation.diagnostics.note_count(); notes != 0) text += ", " + counted(notes, "note");
  if (compilation.project) {
    const auto& pous = compilation.project->pous;
    const auto own =
        std::count_if(pous.begin(), pous.end(), [](const plcopen::Pou& pou) { return pou.taskblock == 0; });
    text += ", " + counted(static_cast<std::size_t>(own), "POU");
  }
  if (compilation.image) {
    text += ", " + counted(compilation.image->image().tasks.size(), "task");
  } else if (compilation.ok()) {
    text += ", no task runs a program";
  }
  return text;
}

/// The lints by name, for the help: "unused-variable (P4301)   declared, but ..", off ones marked.
std::string list_of_lints() {
  std::string text = "Lints (--lint):\n";
  for (const ir::LintInfo& row : ir::lints()) {
    text += fmt::format("  {:<20} {} {}{}\n", row.name, core::info(row.code).name, row.summary,
                        row.on ? "" : " (off by default)");
  }
  return text + "plc explain CODE shows the page of one, with a wrong and a right example.";
}

/// FILE_LOGGER and its like make their files where this says; a check leaves none.
class ScratchFolder {
 public:
  ScratchFolder() {
    char name[] = "/tmp/plc-check-XXXXXX";
    if (::mkdtemp(name) == nullptr) return;
    path_ = name;
    ::setenv("PICARD_LOG_DIRECTORY", name, 1);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  [[nodiscard]] bool made() const { return !path_.empty(); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

 private:
  std::string path_;
};

/// Makes the taskblocks of a project as a start would, which is when they look at their configuration.
void check_taskblocks(Compilation& compilation, const taskblocks::Registry& registry) {
  const auto& blocks = compilation.image->image().blocks;
  const bool any = std::any_of(blocks.begin(), blocks.end(), [](const bytecode::ImageBlock& block) {
    return stdlib::block_named(block.name) == nullptr;
  });
  if (!any) return;
  const ScratchFolder scratch;
  if (!scratch.made()) return;
  runtime::ProgramOptions options;
  options.taskblocks = &registry;
  options.start_taskblocks = false;
  const auto report = [&](const core::Problem& problem) {
    // What is not on this machine need not be: the image may be for another.
    if (problem.code != core::Code::P7803) return;
    const auto declared = compilation.project && !problem.path.empty()
                              ? declaration_of(*compilation.project, problem.path)
                              : std::nullopt;
    compilation.diagnostics.report(problem.code, declared ? declared->at : core::SourceRef{},
                                   declared ? declared->pou : std::string(), problem.message, problem.help);
  };
  const auto resource = runtime::Resource::load(*compilation.image, options);
  if (!resource) return report(resource.error());
  for (std::size_t task = 0; task < (*resource)->task_count(); ++task) {
    if (const auto problem = (*resource)->program(task).start_taskblocks()) report(*problem);
  }
}

/// The HMI pages beside the project, as plc-run reads them.
void check_pages(const std::string& file, Compilation& compilation, const taskblocks::Registry& registry) {
  const std::string path = engineering::pages_file(file);
  std::ifstream in(path, std::ios::binary);
  if (!in) return;
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto document = hmi::read_document(text, path, compilation.diagnostics);
  runtime::ProgramOptions options;
  options.taskblocks = &registry;
  options.start_taskblocks = false;
  const auto resource = runtime::Resource::load(*compilation.image, options);
  if (!document || !resource) return;
  engineering::GlobalValues values((*resource)->globals());
  engineering::Variables variables(**resource, values);
  engineering::offers_of_pages(*document, variables, compilation.diagnostics);
}

/// Where plc-run looks for alarms.toml and historian.toml.
std::filesystem::path folder_of_tables(const std::string& file, const io::Configuration& configuration) {
  const std::filesystem::path beside(configuration.file.empty() ? file : configuration.file);
  std::error_code none;
  return std::filesystem::is_directory(beside, none) ? beside : beside.parent_path();
}

/// The alarms and the variables that are kept, as plc-run reads them.
void check_tables(const std::string& file, const io::Configuration& configuration, Compilation& compilation,
                  const taskblocks::Registry& registry) {
  const std::filesystem::path folder = folder_of_tables(file, configuration);
  const std::string of_alarms = (folder / "alarms.toml").string(), of_history = (folder / "historian.toml").string();
  core::Diagnostics& found = compilation.diagnostics;
  const auto alarm_text = io::table_file_text(of_alarms, found);
  const auto history_text = io::table_file_text(of_history, found);
  if (!alarm_text && !history_text) return;
  auto definitions = alarm_text ? io::read_alarms(*alarm_text, of_alarms, found) : std::vector<alarms::Definition>();
  const auto settings = history_text ? io::read_historian(*history_text, of_history, found) : std::nullopt;
  runtime::ProgramOptions options;
  options.taskblocks = &registry;
  options.start_taskblocks = false;
  const auto resource = runtime::Resource::load(*compilation.image, options);
  if (!resource) return;
  const bool recorded = configuration.record.mode != io::RecordMode::kOff;
  if (alarm_text) const alarms::Alarms all(**resource, std::move(definitions), recorded, found);
  if (settings) static_cast<void>(historian::chosen_by(*settings, **resource, recorded, found));
}

/// Variables that devices, servers, alarms, the history or HMI pages of a project read or write. What is wrong with the
/// files is for check_pages() and check_tables().
std::vector<std::string> named_variables(const std::string& file, const io::Configuration& configuration) {
  std::vector<std::string> names = {configuration.modbus.client_seen.text, configuration.engineering.no_force.text,
                                    configuration.engineering.no_program.text};
  for (const io::DriverConfig& driver : configuration.drivers) names.push_back(driver.ok.text);
  for (const auto* channels : {&configuration.inputs, &configuration.outputs}) {
    for (const io::ChannelConfig& channel : *channels) names.push_back(channel.variable.text);
  }
  core::Diagnostics ignored;
  const std::filesystem::path folder = folder_of_tables(file, configuration);
  const std::string of_alarms = (folder / "alarms.toml").string(), of_history = (folder / "historian.toml").string();
  if (const auto text = io::table_file_text(of_alarms, ignored)) {
    for (const alarms::Definition& alarm : io::read_alarms(*text, of_alarms, ignored)) {
      names.push_back(alarm.variable);
      names.push_back(alarm.suppress);
    }
  }
  if (const auto text = io::table_file_text(of_history, ignored)) {
    // A pattern takes what there is.
    if (const auto settings = io::read_historian(*text, of_history, ignored)) {
      std::copy_if(settings->tags.begin(), settings->tags.end(), std::back_inserter(names),
                   [](const std::string& tag) { return tag.find_first_of("*?") == std::string::npos; });
    }
  }
  const std::string of_pages = engineering::pages_file(file);
  std::ifstream in(of_pages, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (const auto document = in ? hmi::read_document(text, of_pages, ignored) : std::nullopt) {
    for (const hmi::Page& page : document->pages) {
      for (const hmi::Element& element : page.elements) {
        names.emplace_back(element.text(hmi::key("variable")));
        const auto* const plotted = std::get_if<std::vector<std::string>>(&element.values[hmi::key("variables")]);
        if (plotted != nullptr) names.insert(names.end(), plotted->begin(), plotted->end());
      }
    }
    for (const hmi::Offer& offer : hmi::offers_of(*document)) names.push_back(offer.path);
  }
  std::erase(names, "");
  return names;
}

int run(const Check& check) {
  std::vector<CheckedFile> checked;
  ir::LintOptions lint;
  for (const std::string& list : check.lints) {
    const core::Result<ir::LintOptions> changed = lint.with(list);
    if (!changed) {
      complain("plc check", changed.error().message, changed.error().help);
      return kExitUsage;
    }
    lint = *changed;
  }
  lint.set_libraries(check.lint_libraries);
  taskblocks::Registry registry;
  std::vector<std::string> libraries = check.libraries;
  io::Configuration configuration;
  core::Diagnostics of_configuration;
  const auto code = load_taskblocks(check.configuration, registry, libraries, configuration, of_configuration);
  // What else the file says is for plc config check.
  if (code) of_configuration.render_with_lines(std::cerr);
  if (code) return *code;
  int exit_code = kExitOk;
  for (const std::string& file : check.files) {
    Compilation compilation;
    lint.set_used_outside(named_variables(file, configuration));
    open({file, check.options, Goal::kCheck, libraries, lint, &registry}, compilation);
    if (compilation.ok() && compilation.image) check_taskblocks(compilation, registry);
    if (compilation.ok() && compilation.image) {
      check_pages(file, compilation, registry);
      check_tables(file, configuration, compilation, registry);
    }
    const bool good = compilation.ok() && !(check.werror && compilation.diagnostics.warning_count() != 0);
    exit_code = std::max(exit_code, good ? kExitOk : compilation.readable ? kExitErrors : kExitUsage);
    if (!check.json) {
      compilation.diagnostics.render_with_lines(std::cerr);
      if (compilation.readable) std::cout << summary(file, compilation) << std::endl;
      continue;
    }
    checked.push_back({file, compilation.ok(), std::move(compilation.diagnostics)});
  }
  if (check.json) std::cout << diagnostics_json(checked);
  return exit_code;
}

}  // namespace

void add_check(Command program) {
  static Check check;
  const Command command = program.sub(
      "check",
      "Compiles files and reports every problem found, writes nothing. Files without errors are linted: what\n"
      "compiles, but is hardly meant, is a warning; what only other tools take, as the standard does not know it,\n"
      "is a note. A pages.toml, alarms.toml and historian.toml beside a project are checked, too.\n"
      "\n"
      "Examples:\n"
      "  plc check plant.xml\n"
      "  plc check plant.st --lib drives.st           with the data types, POUs and globals of a library\n"
      "  plc check --json *.xml > problems.json       one JSON document, for editors and scripts\n"
      "  plc check --stub-missing plant.xml           what would be missing, as warnings\n"
      "  plc check --lint=-shadowed-name plant.xml    the usual lints but one\n"
      "  plc check --lint=none,double-coil plant.xml  one lint only\n"
      "  plc check --werror plant.xml                 exit code 1 when there is any warning\n"
      "  plc check --strict plant.xml                 what the standard does not know is an error");
  command.option("FILE", check.files, "PLCopen XML or ST files, source folders, or images").required();
  command.flag("--json", check.json, "one JSON document on stdout instead of text on stderr");
  add_library_option(command, check.libraries);
  command.option("--config=plc.toml", check.configuration,
                 "configuration whose [project] and [taskblocks] libraries the project uses; globals that it names are "
                 "used from outside");
  command
      .option("--lint=LIST", check.lints,
              "which lints: all, none, NAME, -NAME, separated by commas, applied from left to right to those "
              "that are on by default")
      .repeated();
  command.flag("--lint-libraries", check.lint_libraries, "look also at what comes from libraries (--lib)");
  command.flag("--werror", check.werror, "warnings make the exit code 1, as errors do");
  command.footer(list_of_lints());
  add_compile_options(command, check.options);
  command.on_run([] { return run(check); });
}

}  // namespace plc::tools
