// plc report: what became of every element of a project file.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "tools/command_line.h"
#include "tools/open.h"
#include "tools/plc/commands.h"

namespace plc::tools {
namespace {

using plcopen::Fate;

const char* version_text(plcopen::Version version) {
  switch (version) {
    case plcopen::Version::kUnknown:
      return "an unknown namespace, read by element names";
    case plcopen::Version::kTc6v101:
      return "PLCopen TC6 1.01";
    case plcopen::Version::kTc6v200:
      return "PLCopen TC6 2.00";
    case plcopen::Version::kTc6v201:
      return "PLCopen TC6 2.01";
    case plcopen::Version::kIec61131_10:
      return "IEC 61131-10";
    case plcopen::Version::kText:
      return "Structured Text, IEC 61131-3";
  }
  return "";
}

void print_rows(const plcopen::Project& project, Fate fate, const char* heading) {
  std::vector<const plcopen::ReportRow*> rows;
  for (const plcopen::ReportRow& row : project.report) {
    if (row.fate == fate) rows.push_back(&row);
  }
  if (rows.empty()) return;
  std::sort(rows.begin(), rows.end(), [](const auto* a, const auto* b) { return a->first_line < b->first_line; });
  std::cout << fmt::format("\n{}\n", heading);
  std::cout << fmt::format("  {:>7} {:>8}  {}\n", "count", "line", "element");
  for (const plcopen::ReportRow* row : rows) {
    std::cout << fmt::format("  {:>7} {:>8}  {}", row->count, row->first_line, row->element);
    if (!row->reason.empty()) std::cout << ": " << row->reason;
    std::cout << '\n';
  }
}

/// "line 12"; in projects of several files with the name of the file.
std::string place_text(const Compilation& compilation, const core::SourceRef& at) {
  if (at.file == compilation.project->file) return fmt::format("line {}", at.line);
  return fmt::format("{}, line {}", compilation.diagnostics.file_name(at.file), at.line);
}

void print_pou(const char* kind, const std::string& name, const plcopen::Pou& pou, const Compilation& compilation) {
  std::size_t elements = 0;
  std::size_t lines = 0;
  std::string language = "none";
  for (const plcopen::Body& body : pou.bodies) {
    elements += body.drawn_elements;
    const auto ends = std::count(body.text.begin(), body.text.end(), '\n');
    if (!body.text.empty()) lines += static_cast<std::size_t>(ends) + 1;
    if (body.language != plcopen::Language::kNone) language = plcopen::language_name(body.language);
  }
  if (!pou.unread.empty()) language = "-";
  std::cout << fmt::format("  {:<14} {:<5} {:>6} {:<8}  {}  ({})\n", kind, language, lines != 0 ? lines : elements,
                           lines != 0 ? "lines" : "elements", name, place_text(compilation, pou.at));
}

int run(const std::string& file, const core::CompileOptions& options) {
  Compilation compilation;
  open({file, options, Goal::kRead}, compilation);
  compilation.diagnostics.render_with_lines(std::cerr);
  if (!compilation.readable) return kExitUsage;
  if (!compilation.project) return kExitErrors;
  const plcopen::Project& project = *compilation.project;
  std::cout << fmt::format("{}: {}", file, version_text(project.version));
  if (!project.product.empty()) std::cout << fmt::format(", written by {}", project.product);
  if (!project.name.empty()) std::cout << fmt::format(", project \"{}\"", project.name);
  std::cout << fmt::format("\n\nPOUs\n");
  for (const plcopen::Pou& pou : project.pous) {
    print_pou(plcopen::pou_kind_name(pou.kind), pou.name, pou, compilation);
    for (const plcopen::Pou& action : pou.actions)
      print_pou("action", pou.name + "." + action.name, action, compilation);
  }
  print_rows(project, Fate::kUsed, "Used");
  print_rows(project, Fate::kPreserved, "Preserved: read and kept, without meaning for the program");
  print_rows(project, Fate::kIgnored, "Ignored");
  print_rows(project, Fate::kRefused, "Refused");
  return compilation.ok() ? kExitOk : kExitErrors;
}

}  // namespace

void add_report(Command program) {
  static std::string file;
  static core::CompileOptions options;
  const Command command =
      program.sub("report",
                  "Prints what became of every XML element or declaration of a file: used, preserved, ignored\n"
                  "(and why) or refused.\n"
                  "\n"
                  "Example:\n"
                  "  plc report plant.xml");
  command.option("FILE", file, "PLCopen XML or ST file, or source folder").required();
  add_all_option(command, options);
  command.on_run([] { return run(file, options); });
}

}  // namespace plc::tools
