#include "compiler/lower_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "frontend-ld/lower.h"
#include "frontend-st/text.h"
#include "ir/generic.h"
#include "ir/reach.h"

namespace plc::compiler {
namespace {

using core::Code;

/// The language of a POU's bodies; the first that is not empty decides.
plcopen::Language language_of(const plcopen::Pou& pou) {
  for (const plcopen::Body& body : pou.bodies) {
    if (body.language != plcopen::Language::kNone) return body.language;
  }
  return plcopen::Language::kNone;
}

class Lowering {
 public:
  Lowering(plcopen::Project& project, ir::Module& module, bool stub_missing, bool declares_library,
           core::Diagnostics& diagnostics)
      : project_(project),
        module_(module),
        stub_missing_(stub_missing),
        declares_library_(declares_library),
        diagnostics_(diagnostics) {}

  void lower_all() {
    const plcopen::Project& project = project_;
    ir::Module& module = module_;
    done_.resize(project.pous.size());
    // Before any body: every use of a stub is reported, wherever the stub is.
    for (std::uint32_t i = 0; i < project.pous.size() && stub_missing_; ++i) {
      module.pous[i].stub = !compiles(project.pous[i]);
      for (const auto& [name, action] : module.pous[i].actions) module.pous[action].stub = !compiles(action_of(action));
    }
    for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
      if (!project.pous[i].from_library) lower(i);
    }
    // Those that are not compiled yet are no error until something calls them.
    for (std::uint32_t i = 0; i < module.pous.size(); ++i) {
      const bool own = module.pous[i].owner != ir::Pou::kDeclared && !module.pous[i].from_library;
      if (own && (stub_missing_ || compiles(action_of(i)))) lower(i);
    }
    // What a library has beyond that is not compiled, and its problems are not reported.
    for (const ir::Task& task : module.tasks) {
      for (const ir::ProgramInstance& program : task.programs) lower(program.pou);
    }
    lower_reached();
    // They are never called: their bodies are checked all the same.
    for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
      const ir::Pou& pou = module.pous[i];
      if (!pou.generic || pou.has_made || pou.from_library) continue;
      if (const auto made = ir::specialize_for_check(module, i)) lower(*made);
    }
    lower_reached();
    if (diagnostics_.has_errors() && !module.library.empty()) report_failed_uses();
    // A text of types and globals alone is a library, and so is what plc lib --xml writes.
    const bool declares_only =
        project.pous.empty() && (project.version == plcopen::Version::kText || declares_library_);
    if (drawn_ == 0 && texts_ == 0 && !declares_only) {
      core::SourceRef at;
      at.line = 1;
      at.file = project.file;
      diagnostics_.report(Code::P5103, at, {},
                          "project compiles to nothing: no POU has a body with elements or statements",
                          "draw or write something, or export the project again with its bodies");
    }
  }

 private:
  static bool compiles(const plcopen::Pou& pou) {
    if (!pou.unread.empty()) return false;
    const plcopen::Language language = language_of(pou);
    return language != plcopen::Language::kIl && language != plcopen::Language::kSfc;
  }

  /// What the file says of action `index` of the module.
  plcopen::Pou& action_of(std::uint32_t index) {
    const ir::Pou& action = module_.pous[index];
    std::vector<plcopen::Pou>& all = project_.pous[action.owner].actions;
    return *std::find_if(all.begin(), all.end(), [&](const plcopen::Pou& one) {
      const auto known = module_.pous[action.owner].actions.find(one.name);
      return known != module_.pous[action.owner].actions.end() && known->second == index;
    });
  }

  void lower_reached() {
    while (!reached_.empty()) {
      const std::uint32_t pou = reached_.back();
      reached_.pop_back();
      for (const std::uint32_t callee : ir::callees(module_, pou)) lower(callee);
    }
  }

  void lower(std::uint32_t index) {
    if (done_.size() <= index) done_.resize(index + 1);
    if (done_[index]) return;
    done_[index] = true;
    const ir::Pou& made = module_.pous[index];
    if (made.generic) return;     // what is made from it has its body
    if (made.queue_call) return;  // its body is one instruction, made with the code
    reached_.push_back(index);
    const bool declared = made.made_from == ir::Pou::kDeclared;
    plcopen::Pou& pou =
        made.owner != ir::Pou::kDeclared ? action_of(index) : project_.pous[declared ? index : made.made_from];
    const std::size_t problems = diagnostics_.all().size();
    const std::size_t errors = diagnostics_.error_count();
    const auto part = module_.library.at(made.at);
    if (part) module_.library.use(*part, {}, {}, diagnostics_);
    lower_bodies(pou, index);
    if (part && diagnostics_.error_count() != errors) fail(*part, problems);
    if (!declared) {
      diagnostics_.drop_repeated(problems);
      return;
    }
    // WHY: a large drawing takes more memory than the program it becomes; release it body by body.
    pou.bodies = {};
  }

  /// The body of a library's POU has errors, which were reported from the `first` diagnostic on.
  void fail(ir::Library::Index part, std::size_t first) {
    const std::vector<core::Diagnostic>& all = diagnostics_.all();
    for (std::size_t i = first; i < all.size(); ++i) {
      if (all[i].severity != core::Severity::kError || !diagnostics_.is_library(all[i].at.file)) continue;
      module_.library.fail(part, all[i].at, all[i].message);
      return;
    }
  }

  /// What the project itself calls and what cannot be compiled in a library.
  void report_failed_uses() {
    ir::Module& module = module_;
    for (const ir::Pou& pou : module.pous) {
      if (diagnostics_.is_library(pou.at.file)) continue;
      for (const ir::Inst& inst : pou.body.insts) {
        const auto callee = ir::callee_of(module, pou.body, inst);
        const auto part = callee ? module.library.at(module.pous[*callee].at) : std::nullopt;
        if (part) module.library.use(*part, pou.body.sources[inst.source], pou.name, diagnostics_);
      }
    }
  }

  void lower_bodies(const plcopen::Pou& pou, std::uint32_t index) {
    ir::Module& module = module_;
    for (const plcopen::Body& body : pou.bodies) drawn_ += body.drawn_elements;
    if (!pou.unread.empty()) {
      ++texts_;
      not_compiled(pou, index);
      return;
    }
    switch (language_of(pou)) {
      case plcopen::Language::kNone:
        module.pous[index].compiled = true;
        return;
      case plcopen::Language::kLd:
      case plcopen::Language::kFbd:
        ld::lower_body(pou, module, index, diagnostics_);
        return;
      case plcopen::Language::kSt:
        ++texts_;
        st::lower_body(pou, module, index, diagnostics_);
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
    const ir::Pou& made = module_.pous[index];
    const std::string reason =
        pou.unread.empty() ? fmt::format("is written in {}", plcopen::language_name(language_of(pou))) : pou.unread;
    const std::string what =
        fmt::format("{} \"{}\" {}", made.owner == ir::Pou::kDeclared ? plcopen::pou_kind_name(pou.kind) : "action",
                    made.name, reason);
    if (stub_missing_) {
      diagnostics_.report(Code::P5102, at, made.name, what + ": a stub that does nothing runs in its place",
                          "write it in LD, FBD or ST before it runs a plant");
      return;
    }
    if (!pou.unread.empty()) {
      diagnostics_.report(
          pou.object_oriented ? Code::P1201 : Code::P1202, at, made.name, what,
          pou.object_oriented
              ? "write it as function blocks, functions and structures, or run the rest with --stub-missing"
              : "export it as PLCopen XML or write it in ST, or run the rest with --stub-missing");
      return;
    }
    diagnostics_.report(Code::P5101, at, made.name, what + ", which is not compiled yet",
                        "write it in LD, FBD or ST, or run the rest with --stub-missing");
  }

  plcopen::Project& project_;
  ir::Module& module_;
  bool stub_missing_;
  bool declares_library_;
  core::Diagnostics& diagnostics_;
  std::vector<bool> done_;
  std::vector<std::uint32_t> reached_;  ///< lowered, what they call not yet looked at
  std::uint64_t drawn_ = 0;
  std::uint64_t texts_ = 0;
};

}  // namespace

void lower_project(plcopen::Project& project, ir::Module& module, bool stub_missing, bool declares_library,
                   core::Diagnostics& diagnostics) {
  Lowering(project, module, stub_missing, declares_library, diagnostics).lower_all();
}

}  // namespace plc::compiler
