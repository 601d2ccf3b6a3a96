// plcdoc: reference pages from the tables: instruction set, library, conformance, problem codes, lints, plc.toml,
// taskblocks, and the library for editors. A test compares them with docs/reference.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "bytecode/opcode.h"
#include "core/diagnostics.h"
#include "core/types.h"
#include "io-drivers/config/template.h"
#include "io-drivers/machine/driver_types.h"
#include "ir/lint.h"
#include "tools/cli.h"
#include "tools/library_xml.h"
#include "tools/plcdoc/client_stubs.h"
#include "tools/plcdoc/pages.h"

namespace {

using namespace plc;

std::string reps_text(bytecode::RepMask reps) {
  std::string text;
  for (std::size_t i = 0; i < core::kRepCount; ++i) {
    const auto rep = static_cast<core::Rep>(i);
    if ((reps & bytecode::mask_of(rep)) != 0) text += (text.empty() ? "" : "/") + std::string(core::rep_name(rep));
  }
  return text;
}

std::string operand_text(const bytecode::OperandSpec& operand) {
  using bytecode::OperandKind;
  switch (operand.kind) {
    case OperandKind::kIn:
      return reps_text(operand.reps);
    case OperandKind::kOut:
      return "out " + reps_text(operand.reps);
    case OperandKind::kPlaceIn:
      return "place";
    case OperandKind::kPlaceOut:
      return "out place";
    case OperandKind::kPlaceInOut:
      return "inout place";
    case OperandKind::kBaseIn:
      return "place";
    case OperandKind::kBaseOut:
      return "inout place";
    case OperandKind::kValueIn:
      return "value";
    case OperandKind::kValueOut:
      return "out value";
    case OperandKind::kTarget:
      return "target";
    case OperandKind::kType:
      return "type";
    case OperandKind::kPou:
      return "POU";
    case OperandKind::kBlock:
      return "block";
    case OperandKind::kFunction:
      return "function";
    case OperandKind::kQueue:
      return "queue";
    case OperandKind::kGlobal:
      return "global";
    case OperandKind::kCount:
      return "count";
    case OperandKind::kImm:
      return "number";
    case OperandKind::kPath:
      return "path..";
    case OperandKind::kRecords:
      return "records..";
    case OperandKind::kStdArgs:
    case OperandKind::kFnArgs:
      return "arguments..";
  }
  return "";
}

std::string opcodes_page() {
  std::ostringstream out;
  out << tools::generated_from("bytecode/opcodes.def")
      << "# Instruction set\n\n"
         "One row per instruction of the slot machine. Code is a sequence of 32-bit words: the opcode word (opcode in "
         "the\n"
         "low 16 bits, number of list items in the high 16), then one word per operand, then the list if there is "
         "one.\n"
         "Operands are called a, b, c, d in the order given. *Events* may be counted by an instruction (it clears "
         "ENO),\n"
         "*budget* means that it counts against the loop budget of the task.\n\n"
         "| code | mnemonic | operands | may raise | meaning |\n| ---: | --- | --- | --- | --- |\n";
  std::size_t code = 0;
  for (const bytecode::OpcodeInfo& opcode : bytecode::opcodes()) {
    std::string operands;
    for (std::size_t i = 0; i < opcode.operands.count; ++i) {
      operands += (operands.empty() ? "" : ", ") + operand_text(opcode.operands.specs[i]);
    }
    const char* events = opcode.events == bytecode::Events::kNever   ? ""
                         : opcode.events == bytecode::Events::kEvent ? "event"
                                                                     : "budget";
    out << fmt::format("| {} | `{}` | {} | {} | {} |\n", code++, opcode.mnemonic, operands, events, opcode.meaning);
  }
  return out.str();
}

std::string problems_page() {
  std::ostringstream out;
  out << tools::generated_from("core/diagnostics.def")
      << "# Problem codes\n\n`plc explain P3007` prints the page of a code.\n\n| code | severity | title |\n| --- | "
         "--- | --- |\n";
  for (const core::CodeInfo& code : core::all_codes()) {
    const char* severity = code.severity == core::Severity::kError     ? "error"
                           : code.severity == core::Severity::kWarning ? "warning"
                                                                       : "note";
    out << fmt::format("| [{0}](../problems/{0}.md) | {1} | {2} |\n", code.name, severity, code.title);
  }
  return out.str();
}

std::string lint_page() {
  std::ostringstream out;
  out << tools::generated_from("ir/lints.def")
      << "# Lints\n\nWhat `plc check` looks for in projects without errors; `--lint=NAME` and `--lint=-NAME` switch "
         "one on or off. The\n"
         "[guide](../guides/lint.md) says how to choose.\n\n| lint | code | default | finds |\n| --- | --- | --- | --- "
         "|\n";
  for (const ir::LintInfo& row : ir::lints()) {
    out << fmt::format("| `{0}` | [{1}](../problems/{1}.md) | {2} | {3} |\n", row.name, core::info(row.code).name,
                       row.on ? "on" : "off", row.summary);
  }
  return out.str();
}

using tools::Page;

/// False when the file holds something else; says so.
bool is_current(const std::filesystem::path& path, const std::string& text) {
  std::ifstream in(path, std::ios::binary);
  const std::string present{std::istreambuf_iterator<char>(in), {}};
  if (in && present == text) return true;
  std::cerr << path.string() << " is not current: cmake --build --preset release --target docs-update\n";
  return false;
}

/// Pages of groups that are gone.
std::vector<std::filesystem::path> left_over(const std::filesystem::path& folder, const std::vector<Page>& pages) {
  std::vector<std::filesystem::path> files;
  for (const char* const groups : {"library", "taskblocks"}) {
    if (!std::filesystem::exists(folder / groups)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder / groups)) {
      const bool known =
          std::any_of(pages.begin(), pages.end(), [&](const Page& page) { return folder / page.name == entry.path(); });
      if (!known) files.push_back(entry.path());
    }
  }
  return files;
}

}  // namespace

namespace plc::tools {

std::string generated_from(const std::string& source) {
  return fmt::format(
      "<!-- Generated by plcdoc from {}; `cmake --build --preset release --target docs-update` rewrites it. -->\n",
      source);
}

std::string cell(std::string text) {
  for (std::size_t bar = text.find('|'); bar != std::string::npos; bar = text.find('|', bar + 2))
    text.insert(bar, "\\");
  return text;
}

std::string as_code(std::string_view text) { return fmt::format("`{}`", text); }

std::string table(const std::vector<std::string>& heading, const std::vector<std::vector<std::string>>& rows) {
  const auto row = [](const std::vector<std::string>& cells) {
    std::string text = "|";
    for (const std::string& c : cells) text += c.empty() ? " |" : " " + cell(c) + " |";
    return text + '\n';
  };
  std::string text = row(heading) + "|";
  for (std::size_t i = 0; i < heading.size(); ++i) text += " --- |";
  text += '\n';
  for (const auto& cells : rows) text += row(cells);
  return text;
}

}  // namespace plc::tools

int main(int argc, char** argv) {
  const tools::Program program(
      "plcdoc", "Writes the reference pages that follow from the tables, or checks that they are current.");
  std::string folder, cases, clients;
  bool check = false;
  program.option("FOLDER", folder, "docs/reference");
  program.option("CASES", cases, "tests/cases, with the features of the standard");
  program.option(
      "--clients=DIR", clients,
      "writes calls.py and calls.ts, the methods of the clients of the engineering server, and nothing else");
  program.flag("--check", check, "write nothing; exit 1 when a page differs");
  if (const auto code = program.parse(argc, argv)) return *code;

  if (!clients.empty()) {
    std::filesystem::create_directories(clients);
    std::ofstream(clients + "/calls.py", std::ios::binary) << tools::python_calls();
    std::ofstream(clients + "/calls.ts", std::ios::binary) << tools::typescript_calls();
    return 0;
  }
  if (cases.empty()) {
    std::cerr << "plcdoc: FOLDER and CASES are required\n";
    return 2;
  }
  const tools::FeatureTables features = tools::read_feature_tables(cases);
  for (const std::string& problem : features.problems) std::cerr << "tables.txt: " << problem << '\n';
  if (!features.problems.empty()) return 1;

  std::vector<Page> pages = {
      {"opcodes.md", opcodes_page()},
      {"problems.md", problems_page()},
      {"lint.md", lint_page()},
      tools::engineering_page(),
      {"configuration.md", tools::generated_from("io-drivers/config/keys.def and the kinds of drivers") +
                               io::configuration_reference(io::driver_types())},
      {"picard-library.xml", tools::library_xml()},
      tools::conformance_page(features, cases)};
  for (Page& page : tools::library_pages()) pages.push_back(std::move(page));
  for (Page& page : tools::taskblock_pages()) pages.push_back(std::move(page));
  int exit_code = 0;
  for (const Page& page : pages) {
    const std::filesystem::path path = std::filesystem::path(folder) / page.name;
    if (check) {
      if (!is_current(path, page.text)) exit_code = 1;
      continue;
    }
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << page.text;
  }
  for (const std::filesystem::path& path : left_over(folder, pages)) {
    if (!check) {
      std::filesystem::remove(path);
      continue;
    }
    std::cerr << path.string() << " belongs to no group: cmake --build --preset release --target docs-update\n";
    exit_code = 1;
  }
  return exit_code;
}
