#include "tools/pipeline.h"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <span>
#include <utility>

#include "bytecode/codegen/generate.h"
#include "core/text.h"
#include "frontend-ld/lower.h"
#include "frontend-st/declare.h"
#include "frontend-st/library_declarations.h"
#include "frontend-st/read.h"
#include "frontend-st/text.h"
#include "ir/check.h"
#include "ir/generic.h"
#include "ir/reach.h"
#include "plcopen/reader.h"
#include "tools/libraries.h"
#include "tools/taskblock_declarations.h"

namespace plc::tools {
namespace {

using core::Code;

bool can_open(const std::string& path, Compilation& compilation) {
  const bool can = tools::can_open(path, compilation.diagnostics);
  compilation.readable = compilation.readable && can;
  return can;
}

/// The language of a POU's bodies; the first that is not empty decides.
plcopen::Language language_of(const plcopen::Pou& pou) {
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language != plcopen::Language::kNone) return body.language;
  }
  return plcopen::Language::kNone;
}

class Lowering {
 public:
  /// `declares_library`: POUs of the project were declarations of what the library has.
  Lowering(const Request& request, Compilation& compilation, bool declares_library)
      : request_(request), compilation_(compilation), declares_library_(declares_library) {}

  void lower_all() {
    const plcopen::Project& project = *compilation_.project;
    ir::Module& module = *compilation_.module;
    done_.resize(project.pous.size());
    // Before any body: whoever uses a stub is told so, wherever it stands.
    for (std::uint32_t i = 0; i < project.pous.size() && request_.options.stub_missing; ++i) {
      const plcopen::Language language = language_of(project.pous[i]);
      module.pous[i].stub = language == plcopen::Language::kIl || language == plcopen::Language::kSfc;
      for (const auto& [name, action] : module.pous[i].actions) module.pous[action].stub = !compiles(action_of(action));
    }
    for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
      if (!project.pous[i].from_library) lower(i);
    }
    // Those that are not compiled yet are no error until something calls them.
    for (std::uint32_t i = 0; i < module.pous.size(); ++i) {
      const bool own = module.pous[i].owner != ir::Pou::kDeclared && !module.pous[i].from_library;
      if (own && (request_.options.stub_missing || compiles(action_of(i)))) lower(i);
    }
    // What a library has beyond that is not compiled, and its problems are nobody's.
    for (const ir::Task& task : module.tasks) {
      for (const ir::ProgramInstance& program : task.programs) lower(program.pou);
    }
    lower_reached();
    // Nobody calls them: their bodies are checked all the same.
    for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
      const ir::Pou& pou = module.pous[i];
      if (!pou.generic || pou.has_made || pou.from_library) continue;
      if (const auto made = ir::specialize_for_check(module, i)) lower(*made);
    }
    lower_reached();
    if (compilation_.diagnostics.has_errors() && !module.library.empty()) report_failed_uses();
    // A text of types and globals alone is a library, and so is what plc lib --xml writes.
    const bool declares_only =
        project.pous.empty() && (project.version == plcopen::Version::kText || declares_library_);
    if (drawn_ == 0 && texts_ == 0 && !declares_only) {
      core::SourceRef at;
      at.line = 1;
      at.file = project.file;
      compilation_.diagnostics.report(Code::P5103, at, {},
                                      "project compiles to nothing: no POU has a body with elements or statements",
                                      "draw or write something, or export the project again with its bodies");
    }
  }

 private:
  static bool compiles(const plcopen::Pou& pou) {
    const plcopen::Language language = language_of(pou);
    return language != plcopen::Language::kIl && language != plcopen::Language::kSfc;
  }

  /// What the file says of action `index` of the module.
  plcopen::Pou& action_of(std::uint32_t index) {
    const ir::Pou& action = compilation_.module->pous[index];
    std::vector<plcopen::Pou>& all = compilation_.project->pous[action.owner].actions;
    return *std::find_if(all.begin(), all.end(), [&](const plcopen::Pou& one) {
      const auto known = compilation_.module->pous[action.owner].actions.find(one.name);
      return known != compilation_.module->pous[action.owner].actions.end() && known->second == index;
    });
  }

  void lower_reached() {
    while (!reached_.empty()) {
      const std::uint32_t pou = reached_.back();
      reached_.pop_back();
      for (const std::uint32_t callee : ir::callees(*compilation_.module, pou)) lower(callee);
    }
  }

  void lower(std::uint32_t index) {
    if (done_.size() <= index) done_.resize(index + 1);
    if (done_[index]) return;
    done_[index] = true;
    const ir::Pou& made = compilation_.module->pous[index];
    if (made.generic) return;     // what is made from it has its body
    if (made.queue_call) return;  // its body is one instruction, made with the code
    reached_.push_back(index);
    const bool declared = made.made_from == ir::Pou::kDeclared;
    plcopen::Pou& pou = made.owner != ir::Pou::kDeclared
                            ? action_of(index)
                            : compilation_.project->pous[declared ? index : made.made_from];
    const std::size_t problems = compilation_.diagnostics.all().size();
    const std::size_t errors = compilation_.diagnostics.error_count();
    const auto part = compilation_.module->library.at(made.at);
    if (part) compilation_.module->library.use(*part, {}, {}, compilation_.diagnostics);
    lower_bodies(pou, index);
    if (part && compilation_.diagnostics.error_count() != errors) fail(*part, problems);
    if (!declared) {
      compilation_.diagnostics.drop_repeated(problems);
      return;
    }
    // WHY: a large drawing takes more memory than the program it becomes; release it body by body.
    pou.bodies = {};
  }

  /// The body of a library's POU has errors, which were reported from the `first` diagnostic on.
  void fail(ir::Library::Index part, std::size_t first) {
    const std::vector<core::Diagnostic>& all = compilation_.diagnostics.all();
    for (std::size_t i = first; i < all.size(); ++i) {
      if (all[i].severity != core::Severity::kError || !compilation_.diagnostics.is_library(all[i].at.file)) continue;
      compilation_.module->library.fail(part, all[i].at, all[i].message);
      return;
    }
  }

  /// What the project itself calls and what cannot be compiled in a library.
  void report_failed_uses() {
    ir::Module& module = *compilation_.module;
    for (const ir::Pou& pou : module.pous) {
      if (compilation_.diagnostics.is_library(pou.at.file)) continue;
      for (const ir::Inst& inst : pou.body.insts) {
        const auto callee = ir::callee_of(module, pou.body, inst);
        const auto part = callee ? module.library.at(module.pous[*callee].at) : std::nullopt;
        if (part) module.library.use(*part, pou.body.sources[inst.source], pou.name, compilation_.diagnostics);
      }
    }
  }

  void lower_bodies(const plcopen::Pou& pou, std::uint32_t index) {
    ir::Module& module = *compilation_.module;
    for (const plcopen::Body& body : pou.bodies) drawn_ += body.drawn_elements;
    switch (language_of(pou)) {
      case plcopen::Language::kNone:
        module.pous[index].compiled = true;
        return;
      case plcopen::Language::kLd:
      case plcopen::Language::kFbd:
        ld::lower_body(pou, module, index, compilation_.diagnostics);
        return;
      case plcopen::Language::kSt:
        ++texts_;
        st::lower_body(pou, module, index, compilation_.diagnostics);
        return;
      case plcopen::Language::kIl:
      case plcopen::Language::kSfc:
        ++texts_;
        not_compiled(pou, index);
        return;
    }
  }

  void not_compiled(const plcopen::Pou& pou, std::uint32_t index) {
    core::SourceRef at = pou.bodies.empty() ? pou.at : pou.bodies.front().at;
    if (at.line == 0) at = pou.at;
    const ir::Pou& made = compilation_.module->pous[index];
    const std::string what = fmt::format("{} \"{}\" is written in {}",
                                         made.owner == ir::Pou::kDeclared ? plcopen::pou_kind_name(pou.kind) : "action",
                                         made.name, plcopen::language_name(language_of(pou)));
    if (request_.options.stub_missing) {
      compilation_.diagnostics.report(Code::P5102, at, made.name, what + ": a stub that does nothing runs in its place",
                                      "write it in LD, FBD or ST before it runs a plant");
      return;
    }
    compilation_.diagnostics.report(Code::P5101, at, made.name, what + ", which is not compiled yet",
                                    "write it in LD, FBD or ST, or run the rest with --stub-missing");
  }

  const Request& request_;
  Compilation& compilation_;
  bool declares_library_;
  std::vector<bool> done_;
  std::vector<std::uint32_t> reached_;  ///< lowered, what they call not yet looked at
  std::uint64_t drawn_ = 0;
  std::uint64_t texts_ = 0;
};

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
    if (auto library = read_project(path, diagnostics)) {
      add_library(*compilation.project, std::move(*library), diagnostics);
    } else {
      core::SourceRef last = first;
      last.line = last.column = UINT32_MAX;
      diagnostics.release(first, last);
    }
  }
  diagnostics.end_libraries();
}

}  // namespace

std::unique_ptr<plcopen::Project> read_project(const std::string& path, core::Diagnostics& diagnostics) {
  if (is_text_path(path)) return st::read(path, diagnostics);
  auto project = plcopen::read(path, diagnostics);
  if (project) st::read_plain_declarations(*project, diagnostics);
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
  compilation.project = read_project(request.path, diagnostics);
  if (compilation.project) read_libraries(request, compilation);
  if (!compilation.readable || !compilation.project || request.goal == Goal::kRead) return;

  const std::size_t declared_taskblocks = add_taskblocks(
      *compilation.project, request.taskblocks != nullptr ? *request.taskblocks : taskblocks::Registry::built_in(),
      diagnostics);
  const bool declares_library = st::drop_library_declarations(*compilation.project) + declared_taskblocks != 0;
  if (request.lint) st::warn_of_hidden_names(*compilation.project, diagnostics);
  compilation.module = st::declare(*compilation.project, request.options, diagnostics);
  if (!compilation.module) return;
  Lowering(request, compilation, declares_library).lower_all();
  ir::check(*compilation.module, diagnostics);
  if (diagnostics.has_errors()) return;
  if (request.lint) ir::lint(*compilation.module, *request.lint, diagnostics);

  if (!runs_anything(*compilation.module)) {
    if (request.goal == Goal::kRun) report_nothing_to_run(*compilation.project, diagnostics);
    return;
  }
  std::optional<bytecode::Image> image = bytecode::generate(*compilation.module, diagnostics);
  compilation.module.reset();
  if (!image) return;
  compilation.image = bytecode::verify(std::move(*image), diagnostics);
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
}  // namespace plc::tools
