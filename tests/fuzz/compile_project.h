// What follows reading, for fuzzers: join structures, declare, lower, check, generate, verify. Nothing may crash; what
// was compiled without an error must pass the verifier.
//
// In: a Project whose bodies are drawn or ST. Out: nothing; aborts when a step breaks its promise.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "bytecode/codegen/generate.h"
#include "bytecode/image.h"
#include "core/diagnostics.h"
#include "declare/declare.h"
#include "declare/extended_structures.h"
#include "frontend-ld/lower.h"
#include "frontend-st/text.h"
#include "ir/check.h"
#include "plcopen/project.h"

namespace plc::test {

inline void compile_project(plcopen::Project& project, core::Diagnostics& diagnostics) {
  st::join_extended_structures(project);
  const std::unique_ptr<ir::Module> module = st::declare(project, {}, diagnostics);
  std::size_t declared = project.pous.size();
  for (const plcopen::Pou& pou : project.pous) declared += pou.actions.size();
  if (module == nullptr || module->pous.size() < project.pous.size() || module->pous.size() > declared) std::abort();
  for (std::uint32_t i = 0; i < project.pous.size(); ++i) {
    bool drawn = false, text = false;
    for (const plcopen::Body& body : project.pous[i].bodies) {
      drawn = drawn || body.language == plcopen::Language::kLd || body.language == plcopen::Language::kFbd;
      text = text || body.language == plcopen::Language::kSt;
    }
    const bool good = drawn  ? ld::lower_body(project.pous[i], *module, i, diagnostics)
                      : text ? st::lower_body(project.pous[i], *module, i, diagnostics)
                             : true;
    if (!good && text && !drawn && !diagnostics.has_errors()) std::abort();
  }
  ir::check(*module, diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) static_cast<void>(diagnostics.render_one(d));
  if (diagnostics.has_errors()) return;
  std::optional<bytecode::Image> image = bytecode::generate(*module, diagnostics);
  if (!image) {
    if (!diagnostics.has_errors()) std::abort();
    return;
  }
  if (!bytecode::verify(std::move(*image), diagnostics)) {
    diagnostics.render(std::cerr);
    std::abort();
  }
}

}  // namespace plc::test
