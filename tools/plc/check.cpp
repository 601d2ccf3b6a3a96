// plc check: compiles files without writing anything.
#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/command_line.h"
#include "tools/plc/commands.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;

struct Check {
  std::vector<std::string> files;
  bool json = false;
  core::CompileOptions options;
};

const char* severity_word(core::Severity severity) {
  switch (severity) {
    case core::Severity::kNote:
      return "note";
    case core::Severity::kWarning:
      return "warning";
    case core::Severity::kError:
      return "error";
  }
  return "";
}

ordered_json to_json(const core::Diagnostics& diagnostics, const core::Diagnostic& diagnostic) {
  const core::SourceRef& at = diagnostic.at;
  ordered_json row;
  row["file"] = diagnostics.file_name(at.file);
  row["line"] = at.line;
  row["column"] = at.column;
  row["code"] = core::info(diagnostic.code).name;
  row["severity"] = severity_word(diagnostic.severity);
  row["pou"] = diagnostic.pou;
  row["element"] = core::element_word(at.kind);
  row["localId"] = at.local_id < 0 ? ordered_json() : ordered_json(at.local_id);
  row["message"] = diagnostic.message;
  row["help"] = diagnostic.help;
  return row;
}

/// "1 error", "3 errors".
std::string counted(std::size_t count, const char* word) { return fmt::format("{} {}{}", count, word, count == 1 ? "" : "s"); }

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
  ordered_json document;
  document["files"] = ordered_json::array();
  document["diagnostics"] = ordered_json::array();
  int exit_code = kExitOk;
  for (const std::string& file : check.files) {
    Compilation compilation;
    open({file, check.options, Goal::kCheck}, compilation);
    exit_code = std::max(exit_code, compilation.ok() ? kExitOk : compilation.readable ? kExitErrors : kExitUsage);
    if (!check.json) {
      compilation.diagnostics.render(std::cerr);
      if (compilation.readable) std::cout << summary(file, compilation) << std::endl;
      continue;
    }
    document["files"].push_back({{"file", file},
                                 {"ok", compilation.ok()},
                                 {"errors", compilation.diagnostics.error_count()},
                                 {"warnings", compilation.diagnostics.warning_count()}});
    for (const core::Diagnostic& diagnostic : compilation.diagnostics.all()) {
      document["diagnostics"].push_back(to_json(compilation.diagnostics, diagnostic));
    }
  }
  if (check.json) {
    // WHY replace: a broken file may put bytes into a message that are no UTF-8; the document stays valid JSON.
    std::cout << document.dump(2, ' ', false, ordered_json::error_handler_t::replace) << '\n';
  }
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
      "  plc check --json *.xml > problems.json       one JSON document, for editors and scripts\n"
      "  plc check --stub-missing plant.xml           what would be missing, as warnings");
  command->add_option("FILE", check.files, "PLCopen XML files, or images")->required();
  command->add_flag("--json", check.json, "one JSON document on stdout instead of text on stderr");
  add_compile_options(*command, check.options);
  command->callback([&exit_code] { exit_code = run(check); });
}

}  // namespace plc::tools
