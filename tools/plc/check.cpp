// plc check: compiles files without writing anything.
#include <fmt/format.h>

#include <iostream>
#include <string>
#include <vector>

#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/plc/json.h"

namespace plc::tools {
namespace {

struct Check {
  std::vector<std::string> files;
  bool json = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
};

std::string summary(const std::string& file, const Compilation& compilation) {
  const std::size_t errors = compilation.diagnostics.error_count();
  const std::size_t warnings = compilation.diagnostics.warning_count();
  std::string text = fmt::format("{}: {}", file, compilation.ok() ? "ok" : counted(errors, "error"));
  if (warnings != 0) text += ", " + counted(warnings, "warning");
  if (compilation.project) text += ", " + counted(compilation.project->pous.size(), "POU");
  if (compilation.image) {
    text += ", " + counted(compilation.image->image().tasks.size(), "task");
  } else if (compilation.ok()) {
    text += ", no task runs a program";
  }
  return text;
}

int run(const Check& check) {
  std::vector<CheckedFile> checked;
  int exit_code = kExitOk;
  for (const std::string& file : check.files) {
    Compilation compilation;
    open({file, check.options, Goal::kCheck, check.libraries}, compilation);
    exit_code = std::max(exit_code, compilation.ok() ? kExitOk : compilation.readable ? kExitErrors : kExitUsage);
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

void add_check(CLI::App& app, int& exit_code) {
  static Check check;
  CLI::App* command = app.add_subcommand(
      "check",
      "Compiles files and reports every problem found, writes nothing.\n"
      "\n"
      "Examples:\n"
      "  plc check plant.xml\n"
      "  plc check plant.st --lib drives.st           with the data types, POUs and globals of a library\n"
      "  plc check --json *.xml > problems.json       one JSON document, for editors and scripts\n"
      "  plc check --stub-missing plant.xml           what would be missing, as warnings");
  command->add_option("FILE", check.files, "PLCopen XML or ST files, or images")->required();
  command->add_flag("--json", check.json, "one JSON document on stdout instead of text on stderr");
  add_library_option(*command, check.libraries);
  add_compile_options(*command, check.options);
  command->callback([&exit_code] { exit_code = run(check); });
}

}  // namespace plc::tools
