// A project as text, compiled and run in virtual time.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "bytecode/codegen/generate.h"
#include "bytecode/verifier.h"
#include "compiler/lower_project.h"
#include "core/diagnostics.h"
#include "declare/declare.h"
#include "frontend-st/read.h"
#include "ir/check.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "runtime/sched/simulation.h"

namespace plc::test {

class CompiledChart {
 public:
  explicit CompiledChart(const std::string& text, const core::CompileOptions& options = {}) {
    const auto project = st::read_memory(text, "chart.st", diagnostics);
    if (!project) return;
    const auto module = st::declare(*project, options, diagnostics);
    compiler::lower_project(*project, *module, false, false, diagnostics);
    ir::check(*module, diagnostics);
    if (diagnostics.has_errors()) return;
    auto image = bytecode::generate(*module, diagnostics);
    if (!image) return;
    auto verified = bytecode::verify(std::move(*image), diagnostics);
    if (!verified) return;
    auto loaded = runtime::Resource::load(std::move(*verified));
    if (!loaded) {
      problem = loaded.error().message + '\n';
      return;
    }
    resource = std::move(*loaded);
    simulation = std::make_unique<runtime::Simulation>(*resource);
  }

  [[nodiscard]] std::string read(const std::string& path) const {
    const runtime::Access access(*resource);
    const auto place = access.find_leaf(path);
    return place ? access.read(*place) : "no " + path;
  }
  void write(const std::string& path, const std::string& value) const {
    runtime::Access access(*resource);
    const auto place = access.find_leaf(path);
    ASSERT_TRUE(place) << path;
    EXPECT_FALSE(access.write(*place, value)) << path;
  }
  /// What is wrong with it, a line each.
  [[nodiscard]] std::string errors() const {
    std::string text = problem;
    for (const core::Diagnostic& one : diagnostics.all()) {
      if (one.severity == core::Severity::kError) text += one.message + '\n';
    }
    return text;
  }
  /// Messages of one code.
  [[nodiscard]] std::size_t count(core::Code code) const {
    std::size_t n = 0;
    for (const core::Diagnostic& one : diagnostics.all()) n += one.code == code ? 1 : 0;
    return n;
  }

  core::Diagnostics diagnostics;
  std::string problem;  ///< why it cannot be loaded
  std::unique_ptr<runtime::Resource> resource;
  std::unique_ptr<runtime::Simulation> simulation;
};

}  // namespace plc::test
