// A project that is linted as plc check does, from ST or with drawings.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/text.h"
#include "declare/declare.h"
#include "frontend-ld/lower.h"
#include "frontend-st/read.h"
#include "frontend-st/text.h"
#include "ir/check.h"
#include "ir/lint.h"
#include "tests/support/body_builder.h"

namespace plc::test {

using core::ElementKind;

/// A project from ST, compiled as plc check does; bodies may be replaced by drawings before that.
struct Linted {
  core::Diagnostics diagnostics;
  std::unique_ptr<plcopen::Project> project;
  std::unique_ptr<ir::Module> module;

  explicit Linted(std::string_view text) { project = st::read_memory(text, "test.st", diagnostics); }

  plcopen::Pou& pou(std::string_view name) {
    return *std::find_if(project->pous.begin(), project->pous.end(),
                         [&](const plcopen::Pou& p) { return core::iequals(p.name, name); });
  }

  /// The findings of `lints`, as "POU:line", separated by blanks; or the errors.
  std::string run(std::string_view lints) {
    module = st::declare(*project, {}, diagnostics);
    for (std::uint32_t i = 0; i < project->pous.size(); ++i) {
      const plcopen::Pou& p = project->pous[i];
      const bool drawn = !p.bodies.empty() && p.bodies.front().language != plcopen::Language::kSt;
      drawn ? ld::lower_body(p, *module, i, diagnostics) : st::lower_body(p, *module, i, diagnostics);
      for (const plcopen::Pou& action : p.actions) {
        st::lower_body(action, *module, module->pous[i].actions.find(action.name)->second, diagnostics);
      }
    }
    const ir::LintOptions options = ir::LintOptions().with(lints).value();
    ir::mute_others(options, diagnostics);
    const std::size_t before = diagnostics.all().size();
    if (ir::check(*module, diagnostics) && !diagnostics.has_errors()) ir::lint(*module, options, diagnostics);
    std::string found;
    for (std::size_t i = 0; i < diagnostics.all().size(); ++i) {
      const core::Diagnostic& d = diagnostics.all()[i];
      if (d.severity == core::Severity::kError) return diagnostics.render_one(d);
      if (i < before) continue;
      found += (found.empty() ? "" : " ") + d.pou + ":" + std::to_string(d.at.line);
    }
    return found;
  }
};

inline std::string lint(std::string_view lints, std::string_view text) { return Linted(text).run(lints); }

/// A program of `declarations` and `statements`; the statements begin in line 11.
inline std::string program(const std::string& declarations, const std::string& statements) {
  const auto lines = std::count(declarations.begin(), declarations.end(), '\n');
  return "PROGRAM Main VAR\n" + declarations + std::string(static_cast<std::size_t>(8 - lines), '\n') + "END_VAR\n" +
         statements + "\nEND_PROGRAM\n";
}

inline std::string lint_statements(std::string_view name, const std::string& declarations,
                                   const std::string& statements) {
  return lint("none," + std::string(name), program(declarations, statements));
}

/// A rail (1), a contact (2) on `contact` and what `rest` draws after it.
template <class Rest>
plcopen::Body ladder(const std::string& contact, Rest rest) {
  BodyBuilder b(plcopen::Language::kLd);
  BodyBuilder::out(b.add(ElementKind::kLeftRail, 1, "", 0, 0), "");
  plcopen::Element& c = b.add(ElementKind::kContact, 2, contact, 50, 0);
  BodyBuilder::feed(c, {1});
  BodyBuilder::out(c, "");
  rest(b);
  return b.body();
}

inline plcopen::Element& add_coil(BodyBuilder& b, std::int64_t id, const std::string& name) {
  plcopen::Element& coil = b.add(ElementKind::kCoil, id, name, 200, static_cast<std::int32_t>(id) * 10);
  BodyBuilder::feed(coil, {2});
  return coil;
}

}  // namespace plc::test
