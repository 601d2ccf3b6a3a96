#include "compiler/lower_project.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drawings/make.h"
#include "frontend-il/text.h"
#include "frontend-ld/lower.h"
#include "frontend-sfc/lower.h"
#include "frontend-st/text.h"
#include "frontend-st/worksheets.h"
#include "ir/generic.h"
#include "ir/reach.h"

namespace plc::compiler {
namespace {

using core::Code;

bool is_chart(const plcopen::Body& body) { return body.language == plcopen::Language::kSfc; }

/// Of worksheets that are mixed, one is a chart: it evaluates all of its POU.
bool mixes_chart(const plcopen::Pou& pou) {
  return st::is_mixed(pou) && std::any_of(pou.bodies.begin(), pou.bodies.end(), is_chart);
}

class Lowering {
 public:
  Lowering(plcopen::Project& project, ir::Module& module, bool stub_missing, bool declares_library,
           core::Diagnostics& diagnostics, const BodySink& sink)
      : project_(project),
        module_(module),
        stub_missing_(stub_missing),
        declares_library_(declares_library),
        diagnostics_(diagnostics),
        sink_(sink) {}

  void lower_all() {
    const plcopen::Project& project = project_;
    ir::Module& module = module_;
    done_.resize(project.pous.size());
    core::FinalScan& final_scan = module.options.sfc_final_scan;
    if (final_scan == core::FinalScan::kAuto && std::any_of(project.pous.begin(), project.pous.end(), has_chart)) {
      final_scan = project.has_3s_charts ? core::FinalScan::kOn : core::FinalScan::kOff;
    }
    // Before any body: every use of a stub is reported, wherever the stub is.
    for (std::uint32_t i = 0; i < project.pous.size() && stub_missing_; ++i) {
      module.pous[i].stub = !compiles(project.pous[i]);
      for (const auto& [name, action] : module.pous[i].actions) module.pous[action].stub = !compiles(part_of(action));
    }
    for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
      if (!project.pous[i].from_library) lower(i);
    }
    // Those that are not compiled yet are no error until something calls them.
    for (std::uint32_t i = 0; i < module.pous.size(); ++i) {
      const bool own = module.pous[i].owner != ir::Pou::kDeclared && !module.pous[i].from_library;
      if (own && (stub_missing_ || compiles(part_of(i)))) lower(i);
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
    if (!pou.unread.empty() || mixes_chart(pou)) return false;
    // A chart in a form that is not read has neither elements nor text.
    return std::none_of(pou.bodies.begin(), pou.bodies.end(), [](const plcopen::Body& body) {
      return is_chart(body) && body.drawn_elements != 0 && body.elements.empty() && body.text.empty();
    });
  }

  /// What the file says of action or transition `index` of the module.
  plcopen::Pou& part_of(std::uint32_t index) {
    const std::uint32_t owner = module_.pous[index].owner;
    const bool transition = module_.transitions.contains(index);
    plcopen::Pou& from = project_.pous[owner];
    std::vector<plcopen::Pou>& all = transition ? from.transitions : from.actions;
    // Charts add actions after the first question.
    for (std::size_t& seen = seen_[{owner, transition}]; seen < all.size(); ++seen) {
      std::optional<std::uint32_t> made;
      if (transition) {
        made = module_.find_transition(owner, all[seen].name);
      } else if (const auto known = module_.pous[owner].actions.find(all[seen].name);
                 known != module_.pous[owner].actions.end()) {
        made = known->second;
      }
      if (made) parts_.try_emplace(*made, seen);
    }
    return all[parts_.at(index)];
  }

  /// The charts of a POU, which its bodies see: read before the first of them is lowered.
  const sfc::PreparedCharts* charts_of(std::uint32_t owner) {
    const auto [known, fresh] = charts_.try_emplace(owner);
    if (fresh && has_chart(project_.pous[owner])) {
      known->second = sfc::prepare(project_.pous[owner], module_, owner, diagnostics_);
    }
    return known->second.get();
  }

  static bool has_chart(const plcopen::Pou& pou) {
    const auto draws = [](const plcopen::Pou& one) {
      return std::any_of(one.bodies.begin(), one.bodies.end(), is_chart);
    };
    return draws(pou) || std::any_of(pou.actions.begin(), pou.actions.end(), draws);
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
    if (module_.pous[index].generic) return;     // what is made from it has its body
    if (module_.pous[index].queue_call) return;  // its body is one instruction, made with the code
    reached_.push_back(index);
    const bool declared = module_.pous[index].made_from == ir::Pou::kDeclared;
    const bool part_of_pou = module_.pous[index].owner != ir::Pou::kDeclared;
    const std::size_t first_problem = diagnostics_.all().size();
    const std::size_t first_error = diagnostics_.error_count();
    if (declared) charts_of(part_of_pou ? module_.pous[index].owner : index);
    const ir::Pou& made = module_.pous[index];
    plcopen::Pou& pou = part_of_pou ? part_of(index) : project_.pous[declared ? index : made.made_from];
    const std::size_t problems = first_problem;
    const std::size_t errors = first_error;
    const auto part = module_.library.at(made.at);
    if (part) module_.library.use(*part, {}, {}, diagnostics_);
    lower_bodies(pou, index);
    if (part && diagnostics_.error_count() != errors) fail(*part, problems);
    if (sink_) sink_(pou, module_.pous[index].name, owner_of(index, pou));
    // Blocks made from a generic one have its text.
    if (!declared || pou.name.find('<') != std::string::npos) diagnostics_.drop_repeated(problems);
    if (!declared) return;
    // WHY: a large drawing takes more memory than the program it becomes; release it body by body.
    pou.bodies = {};
  }

  [[nodiscard]] bytecode::DrawnOwner owner_of(std::uint32_t index, const plcopen::Pou& pou) const {
    if (module_.transitions.contains(index)) return bytecode::DrawnOwner::kTransition;
    if (module_.pous[index].owner != ir::Pou::kDeclared) return bytecode::DrawnOwner::kAction;
    return drawings::owner_of(pou.kind);
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
    if (module.transitions.contains(index)) {
      sfc::lower_transition(pou, module, index, diagnostics_);
      return;
    }
    if (!pou.unread.empty()) {
      ++texts_;
      not_compiled(pou, index);
      return;
    }
    if (mixes_chart(pou)) return not_compiled(pou, index);
    if (st::is_mixed(pou)) return lower_mixed(pou, index);
    switch (st::language_of(pou)) {
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
      case plcopen::Language::kSfc: {
        ++texts_;
        if (!compiles(pou)) return not_compiled(pou, index);
        const std::uint32_t owner = module.pous[index].owner;
        const sfc::PreparedCharts* const charts = charts_of(owner == ir::Pou::kDeclared ? index : owner);
        if (charts != nullptr) sfc::lower_body(*charts, module, index, diagnostics_);
        return;
      }
      case plcopen::Language::kIl:
        ++texts_;
        il::lower_body(pou, module, index, diagnostics_);
        return;
    }
  }

  /// Worksheets in several languages are executed one after the other, as those in one language are.
  void lower_mixed(const plcopen::Pou& pou, std::uint32_t index) {
    ++texts_;
    const std::size_t errors = diagnostics_.error_count();
    ir::Builder builder(module_, index, diagnostics_);
    st::lower_prologue(builder);
    ld::Worksheets drawings;
    bool drawn = false;
    for (const plcopen::Body& body : pou.bodies) {
      if (st::is_empty_body(body)) continue;
      if (body.language == plcopen::Language::kSt) {
        st::lower_statements(body.text, body.text_at.line != 0 ? body.text_at : body.at, builder, body.defines.get());
      } else if (body.language == plcopen::Language::kIl) {
        il::lower_list(body, builder);
      } else {
        ld::lower_drawing(body, builder, drawings);
        drawn = true;
      }
    }
    const bool good = diagnostics_.error_count() == errors;
    if (good && drawn) ld::warn_of_idle(pou, drawings, builder);
    module_.pous[index].compiled = good;
  }

  void not_compiled(const plcopen::Pou& pou, std::uint32_t index) {
    core::SourceRef at = pou.bodies.empty() ? pou.at : pou.bodies.front().at;
    if (at.line == 0) at = pou.at;
    const ir::Pou& made = module_.pous[index];
    const std::string reason = !pou.unread.empty() ? pou.unread
                               : mixes_chart(pou)
                                   ? "has a chart beside bodies in other languages"
                                   : fmt::format("is written in {}", plcopen::language_name(st::language_of(pou)));
    const std::string what =
        fmt::format("{} \"{}\" {}", made.owner == ir::Pou::kDeclared ? plcopen::pou_kind_name(pou.kind) : "action",
                    made.name, reason);
    if (stub_missing_) {
      diagnostics_.report(Code::P5102, at, made.name, what + ": a stub that does nothing runs in its place",
                          "write it in LD, FBD, ST, IL, or as a chart of PLCopen XML before it runs a plant");
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
    if (mixes_chart(pou)) {
      diagnostics_.report(Code::P5101, at, made.name, what,
                          "put the chart or the other bodies into an action or a function block of their own, or run "
                          "the rest with --stub-missing");
      return;
    }
    diagnostics_.report(
        Code::P5101, at, made.name, what + " in a form that is not read",
        "write it in LD, FBD, ST, IL, or as a chart of PLCopen XML, or run the rest with --stub-missing");
  }

  plcopen::Project& project_;
  ir::Module& module_;
  bool stub_missing_;
  bool declares_library_;
  core::Diagnostics& diagnostics_;
  const BodySink& sink_;
  std::map<std::uint32_t, std::unique_ptr<sfc::PreparedCharts>> charts_;  ///< by POU
  std::map<std::uint32_t, std::size_t> parts_;  ///< places of actions and transitions in lists of their POU
  std::map<std::pair<std::uint32_t, bool>, std::size_t> seen_;  ///< how many of these lists are in `parts_`
  std::vector<bool> done_;
  std::vector<std::uint32_t> reached_;  ///< lowered, what they call not yet looked at
  std::uint64_t drawn_ = 0;
  std::uint64_t texts_ = 0;
};

}  // namespace

void lower_project(plcopen::Project& project, ir::Module& module, bool stub_missing, bool declares_library,
                   core::Diagnostics& diagnostics, const BodySink& sink) {
  Lowering(project, module, stub_missing, declares_library, diagnostics, sink).lower_all();
}

}  // namespace plc::compiler
