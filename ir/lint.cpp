#include "ir/lint.h"

#include <fmt/format.h>

#include <algorithm>
#include <tuple>

#include "core/guess.h"
#include "core/text.h"
#include "ir/lint_findings.h"

namespace plc::ir {

std::span<const LintInfo> lints() {
  static constexpr LintInfo kLints[] = {
#define PLC_LINT(name, word, code, on, summary) {word, core::Code::code, on, summary},
#include "ir/lints.def"
  };
  return kLints;
}

// ---- options ------------------------------------------------------------------------------------------------------

LintOptions::LintOptions() {
  for (std::size_t i = 0; i < kLintCount; ++i) on_[i] = lints()[i].on;
}

core::Result<LintOptions> LintOptions::with(std::string_view list) const {
  LintOptions out = *this;
  while (!list.empty()) {
    const std::size_t comma = std::min(list.find(','), list.size());
    std::string_view item = core::trimmed(list.substr(0, comma));
    list.remove_prefix(std::min(comma + 1, list.size()));
    const std::string_view written = item;
    const bool on = item.empty() || item.front() != '-';
    if (!on) item.remove_prefix(1);
    if (on && (core::iequals(item, "all") || core::iequals(item, "none"))) {
      out.on_.fill(core::iequals(item, "all"));
      continue;
    }
    const auto all = lints();
    const auto found = std::find_if(all.begin(), all.end(), [&](const LintInfo& row) {
      return core::iequals(row.name, item) || core::iequals(core::info(row.code).name, item);
    });
    if (found == all.end()) {
      core::Guess guess(item);
      for (const LintInfo& row : all) guess.offer(row.name);
      const std::string help = guess.help();
      return core::Problem{core::Code::P7001, fmt::format("there is no lint {}", quoted(written)),
                           help.empty() ? "plc check --help lists them all" : help};
    }
    out.on_[static_cast<std::size_t>(found - all.begin())] = on;
  }
  return out;
}

bool LintOptions::is_used_outside(std::string_view global) const {
  return std::ranges::any_of(used_outside_, [&](const std::string& path) {
    const std::string_view head = std::string_view(path).substr(0, global.size());
    const bool whole = path.size() == head.size() || path[head.size()] == '.' || path[head.size()] == '[';
    return whole && core::iequals(head, global);
  });
}

std::vector<core::Code> codes_about_writing() {
  using core::Code;
  // Which of two declarations of one name counts, a global that several tasks write, and what --stub-missing leaves
  // out.
  constexpr Code kOfTheProject[] = {Code::P5110, Code::P4019, Code::P4204, Code::P4031, Code::P5102, Code::P3020};
  std::vector<Code> out;
  for (std::size_t i = 0; i < core::all_codes().size(); ++i) {
    const auto code = static_cast<Code>(i);
    const bool of_project =
        std::find(std::begin(kOfTheProject), std::end(kOfTheProject), code) != std::end(kOfTheProject);
    if (core::all_codes()[i].severity != core::Severity::kError && !of_project) out.push_back(code);
  }
  return out;
}

void mute_others(const LintOptions& options, core::Diagnostics& diagnostics) {
  for (std::size_t i = 0; i < kLintCount; ++i) {
    if (!options.on(static_cast<Lint>(i))) diagnostics.mute(lints()[i].code);
  }
}

// ---- findings -----------------------------------------------------------------------------------------------------

void Findings::add(Lint lint, const SourceRef& at, std::string_view pou, std::string message, std::string help) {
  if (wants(lint)) all_.push_back({lint, at, std::string(pou), std::move(message), std::move(help)});
}

void Findings::report(core::Diagnostics& diagnostics) {
  std::stable_sort(all_.begin(), all_.end(), [](const Finding& a, const Finding& b) {
    return std::tie(a.at.file, a.at.line, a.at.column) < std::tie(b.at.file, b.at.line, b.at.column);
  });
  for (Finding& f : all_) {
    diagnostics.report(info(f.lint).code, f.at, f.pou, std::move(f.message), std::move(f.help));
  }
}

bool Findings::is_linted(const Pou& pou) const {
  const bool made_again = pou.from_library && pou.made_from != Pou::kDeclared;
  return pou.compiled && !pou.stub && !made_again && !pou.queue_call && pou.taskblock == 0 &&
         !skips_library(pou.from_library);
}

void lint(const Module& module, const LintOptions& options, core::Diagnostics& diagnostics) {
  Findings findings(options);
  lint_variables(module, findings);
  lint_names(module, findings);
  lint_declarations(module, findings);
  lint_coils(module, findings);
  lint_tasks(module, findings);
  lint_charts(module, findings);
  for (const Pou& pou : module.pous) {
    if (!findings.is_linted(pou) || pou.body.insts.empty()) continue;
    const BodyFlow flow(pou.body);
    const LintBody body{module, pou, flow};
    lint_expressions(body, findings);
    lint_statements(body, findings);
    lint_blocks(body, findings);
  }
  findings.report(diagnostics);
}

}  // namespace plc::ir
