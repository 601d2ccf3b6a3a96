#include "compiler/compile.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <span>
#include <system_error>
#include <utility>

#include "bytecode/codegen/generate.h"
#include "compiler/libraries.h"
#include "compiler/lower_project.h"
#include "compiler/taskblock_declarations.h"
#include "core/text.h"
#include "declare/declare.h"
#include "declare/extended_structures.h"
#include "declare/generic_blocks.h"
#include "declare/library_declarations.h"
#include "drawings/make.h"
#include "frontend-st/read.h"
#include "frontend-st/text.h"
#include "ir/check.h"
#include "plcopen/reader.h"
#include "sources/folder.h"

namespace plc::compiler {
namespace {

using core::Code;

bool can_open(const std::string& path, Compilation& compilation) {
  // Folders are read by sources::read().
  std::error_code ignored;
  const bool can = std::filesystem::is_directory(path, ignored) || compiler::can_open(path, compilation.diagnostics);
  compilation.readable = compilation.readable && can;
  return can;
}

bool runs_anything(const ir::Module& module) {
  for (const ir::Task& task : module.tasks) {
    if (!task.programs.empty()) return true;
  }
  return false;
}

void report_nothing_to_run(const plcopen::Project& project, core::Diagnostics& diagnostics) {
  std::string choices;
  for (const plcopen::Pou& pou : project.pous) {
    if (pou.kind == plcopen::PouKind::kFunction || pou.from_library) continue;
    if (!choices.empty()) choices += ", ";
    choices += "--pou " + pou.name;
  }
  core::SourceRef at;
  at.line = 1;
  at.file = project.file;
  diagnostics.report(Code::P5104, at, {}, "no task runs a program: the file has no instance of any POU",
                     choices.empty() ? std::string("add a task with a program instance to the configuration")
                                     : "run one alone in a 20 ms task: " + choices);
}

/// True when the file is to be read as ST. Files named neither way are looked into.
bool is_text_path(const std::string& path) {
  if (has_extension(path, ".st") || has_extension(path, ".iecst")) return true;
  if (has_extension(path, ".xml")) return false;
  constexpr std::size_t kLookedAt = 65536;
  std::string bytes(kLookedAt, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(in.gcount()));
  return st::looks_like_text(bytes);
}

/// Files of tests, and the tests of the project, where they are compiled; else a look at their syntax.
void read_tests(const Request& request, Compilation& compilation) {
  core::Diagnostics& diagnostics = compilation.diagnostics;
  if (!request.tests) {
    for (const plcopen::Pou& test : compilation.project->tests) {
      for (const plcopen::Body& body : test.bodies)
        st::check_syntax(body.text, body.text_at, "TEST '" + test.name + "'", diagnostics);
    }
    return;
  }
  std::vector<plcopen::Project> files;
  for (const std::string& path : request.test_files) {
    if (!can_open(path, compilation)) continue;
    if (auto file = read_project(path, diagnostics, request.options.defines)) files.push_back(std::move(*file));
  }
  add_tests(*compilation.project, std::move(files), diagnostics);
}

bool has_tests(const plcopen::Project& project) {
  return std::any_of(project.pous.begin(), project.pous.end(), [](const plcopen::Pou& pou) { return pou.test; });
}

void read_libraries(const Request& request, Compilation& compilation) {
  core::Diagnostics& diagnostics = compilation.diagnostics;
  const bool linted = request.lint && request.lint->libraries();
  diagnostics.begin_libraries(linted ? std::vector<Code>{} : ir::codes_about_writing());
  for (const std::string& path : request.libraries) {
    if (is_image_path(path)) {
      core::SourceRef at;
      at.file = diagnostics.add_file(path);
      diagnostics.report(Code::P5111, at, {}, "image as a library: it has no declarations any more",
                         "give the ST or PLCopen XML file it was made from");
      continue;
    }
    if (!can_open(path, compilation)) continue;
    core::SourceRef first;
    first.file = static_cast<std::uint16_t>(diagnostics.file_count());
    if (auto library = read_project(path, diagnostics, request.options.defines)) {
      add_library(*compilation.project, std::move(*library), diagnostics);
    } else {
      core::SourceRef last = first;
      last.line = last.column = UINT32_MAX;
      diagnostics.release(first, last);
    }
  }
  diagnostics.end_libraries();
}

/// What the bodies that are lowered look like, until it is known which of them are in the image.
class DrawnBodies {
 public:
  DrawnBodies(const plcopen::Project& project, const core::Diagnostics& places) : project_(project), places_(places) {}

  BodySink sink() {
    return [this](const plcopen::Pou& pou, const std::string& name, bytecode::DrawnOwner owner) {
      const bool plane = project_.version != plcopen::Version::kIec61131_10;
      const auto [known, fresh] = bodies_.try_emplace(name);
      if (fresh) known->second = drawings::make_bodies(pou, name, owner, plane, places_);
    };
  }

  /// Of the POUs in the image, in the order of the project.
  std::vector<std::byte> pack_for(const bytecode::Image& image) {
    std::set<std::string> in_image;
    for (const bytecode::ImagePou& pou : image.pous) in_image.insert(pou.name);
    bytecode::Drawings drawings;
    const auto take = [&](const std::string& name) {
      const auto found = bodies_.find(name);
      if (found == bodies_.end() || !in_image.contains(name)) return;
      std::move(found->second.begin(), found->second.end(), std::back_inserter(drawings.bodies));
      bodies_.erase(found);
    };
    for (const plcopen::Pou& pou : project_.pous) {
      take(pou.name);
      for (const plcopen::Pou& action : pou.actions) take(drawings::part_name(pou, action));
      for (const plcopen::Pou& transition : pou.transitions) take(drawings::part_name(pou, transition));
    }
    return bytecode::pack(drawings);
  }

 private:
  const plcopen::Project& project_;
  const core::Diagnostics& places_;
  std::map<std::string, std::vector<bytecode::DrawnBody>> bodies_;
};

}  // namespace

std::unique_ptr<plcopen::Project> read_project(const std::string& path, core::Diagnostics& diagnostics,
                                               const std::vector<std::string>& defines) {
  if (sources::is_source_path(path)) return sources::read(path, diagnostics, defines);
  if (is_text_path(path)) return st::read(path, diagnostics, defines);
  auto project = plcopen::read(path, diagnostics);
  if (project) st::read_plain_declarations(*project, diagnostics, defines);
  return project;
}

void compile(const Request& request, Compilation& compilation) {
  if (!can_open(request.path, compilation)) return;
  core::Diagnostics& diagnostics = compilation.diagnostics;
  diagnostics.set_notes(request.options.strict ? core::Notes::kRefuse
                        : request.lint         ? core::Notes::kShow
                                               : core::Notes::kHide);
  if (request.options.show_all) diagnostics.show_all();
  if (request.lint) ir::mute_others(*request.lint, diagnostics);
  for (const ir::LintInfo& lint : ir::lints()) {
    if (request.answers && core::info(lint.code).severity == core::Severity::kWarning) diagnostics.mute(lint.code);
  }
  compilation.project = read_project(request.path, diagnostics, request.options.defines);
  if (compilation.project) read_libraries(request, compilation);
  if (compilation.project && request.goal != Goal::kRead) read_tests(request, compilation);
  if (!compilation.readable || !compilation.project || request.goal == Goal::kRead) return;

  const std::size_t declared_taskblocks = add_taskblocks(
      *compilation.project, request.taskblocks != nullptr ? *request.taskblocks : taskblocks::Registry::built_in(),
      diagnostics);
  const bool declares_library = st::drop_library_declarations(*compilation.project) + declared_taskblocks != 0;
  st::join_extended_structures(*compilation.project);
  st::make_generic_blocks(*compilation.project, diagnostics);
  if (request.lint) st::warn_of_hidden_names(*compilation.project, diagnostics);
  compilation.module = st::declare(*compilation.project, request.options, diagnostics);
  if (!compilation.module) return;
  compilation.module->probes = request.drawings;
  const bool tests = request.tests && has_tests(*compilation.project);
  if (tests) prepare_tests(*compilation.project, *compilation.module, diagnostics);
  if (request.coverage) ir::begin_coverage(*compilation.module);
  DrawnBodies drawn(*compilation.project, diagnostics);
  lower_project(*compilation.project, *compilation.module, request.options.stub_missing, declares_library, diagnostics,
                request.drawings ? drawn.sink() : BodySink{});
  ir::check(*compilation.module, diagnostics);
  if (diagnostics.has_errors() || request.goal == Goal::kModule) return;
  if (request.lint) ir::lint(*compilation.module, *request.lint, diagnostics);

  const bool runs = runs_anything(*compilation.module);
  if (!runs && !tests) {
    if (request.goal == Goal::kRun) report_nothing_to_run(*compilation.project, diagnostics);
    return;
  }
  if (compilation.module->coverage) compilation.cover_sites = compilation.module->coverage->sites;
  std::optional<bytecode::Image> image;
  if (runs) image = bytecode::generate(*compilation.module, diagnostics);
  if (image && request.drawings) image->drawings = drawn.pack_for(*image);
  if (tests && !diagnostics.has_errors()) compilation.tests = generate_tests(*compilation.module, diagnostics);
  if (compilation.tests) compilation.tests->pragmas = compilation.project->pragmas;
  compilation.module.reset();
  if (image) compilation.image = bytecode::verify(std::move(*image), diagnostics);
  if (request.goal == Goal::kRun) compilation.project.reset();
  // WHY: what 100,000 rungs were made from is several times their image; a runtime that stays up for years gives that
  // back.
  ::malloc_trim(0);
}

void open(const Request& request, Compilation& compilation) {
  if (!is_image_path(request.path)) {
    compile(request, compilation);
  } else if (can_open(request.path, compilation)) {
    compilation.image = load_image(request.path, compilation.diagnostics);
  }
}
}  // namespace plc::compiler
