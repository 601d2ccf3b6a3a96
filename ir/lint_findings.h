// Inside ir::lint: where findings go, and the groups of lints by what they look at. Nothing else includes this.
//
// In: a Module. Out: Findings. Does not belong here: the list of lints (lints.def), control flow (lint_flow.h).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/diagnostics.h"
#include "ir/lint.h"
#include "ir/lint_flow.h"

namespace plc::ir {

/// Collects warnings and hands them on in the order of the files.
class Findings {
 public:
  explicit Findings(const LintOptions& options) : options_(options) {}
  [[nodiscard]] bool wants(Lint lint) const { return options_.on(lint); }
  /// True for a POU whose declarations and body somebody wrote, whole: here, or on request in a library.
  [[nodiscard]] bool is_linted(const Pou& pou) const;
  /// True for what is in a library that was not to be looked at.
  [[nodiscard]] bool skips_library(bool from_library) const { return from_library && !options_.libraries(); }
  [[nodiscard]] bool is_used_outside(std::string_view global) const { return options_.is_used_outside(global); }
  void add(Lint lint, const SourceRef& at, std::string_view pou, std::string message, std::string help = {});
  void report(core::Diagnostics& diagnostics);

 private:
  struct Finding {
    Lint lint;
    SourceRef at;
    std::string pou, message, help;
  };
  const LintOptions& options_;
  std::vector<Finding> all_;
};

/// One body with its control flow, as the groups below see it.
struct LintBody {
  const Module& module;
  const Pou& pou;  ///< may be an action
  const BodyFlow& flow;

  /// Variable `index` of the POU, or of the one that the action belongs to.
  [[nodiscard]] const Variable& variable(std::uint32_t index) const { return module.owner_of(pou).variables[index]; }
  [[nodiscard]] const Body& body() const { return pou.body; }
  [[nodiscard]] const Inst& inst(std::uint32_t index) const { return pou.body.insts[index]; }
  [[nodiscard]] const SourceRef& at(std::uint32_t index) const { return pou.body.sources[inst(index).source]; }
};

/// True for a variable that the source declares.
inline bool is_visible(const Variable& variable) {
  return !variable.step && !variable.name.empty() && variable.name.find('#') == std::string::npos;
}
inline std::string quoted(std::string_view text) { return '"' + std::string(text) + '"'; }

void lint_variables(const Module& module, Findings& findings);     // lint_variables.cpp
void lint_declarations(const Module& module, Findings& findings);  // lint_declarations.cpp
void lint_names(const Module& module, Findings& findings);         // lint_names.cpp
void lint_coils(const Module& module, Findings& findings);         // lint_coils.cpp
void lint_tasks(const Module& module, Findings& findings);         // lint_tasks.cpp
void lint_charts(const Module& module, Findings& findings);        // lint_charts.cpp
void lint_expressions(const LintBody& body, Findings& findings);   // lint_expressions.cpp
void lint_statements(const LintBody& body, Findings& findings);    // lint_statements.cpp
void lint_blocks(const LintBody& body, Findings& findings);        // lint_blocks.cpp

}  // namespace plc::ir
