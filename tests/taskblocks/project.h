// A project in ST with components of a test's own, compiled and loaded.
#pragma once

#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "compiler/compile.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "taskblocks/registry.h"
#include "tests/support/run_tool.h"

namespace plc::test {

struct TaskblockProject {
  compiler::Compilation compilation;
  std::unique_ptr<runtime::Resource> resource;
  std::string problem;  ///< codes of what was reported, or of what refused to load

  TaskblockProject(const taskblocks::Registry& registry, const std::string& text,
                   runtime::ProgramOptions options = {}) {
    const ScratchFolder scratch;
    std::ofstream(scratch.file("test.st")) << text;
    compiler::Request request{scratch.file("test.st"), {}, compiler::Goal::kRun};
    request.taskblocks = &registry;
    compiler::compile(request, compilation);
    for (const auto& d : compilation.diagnostics.all()) problem += std::string(core::info(d.code).name) + " ";
    if (!compilation.image) return;
    options.taskblocks = &registry;
    auto loaded = runtime::Resource::load(std::move(*compilation.image), options);
    if (!loaded) {
      problem += std::string(core::info(loaded.error().code).name) + ": " + loaded.error().message;
      return;
    }
    resource = std::move(*loaded);
  }
  runtime::Fault scan(core::TimeNs now_ns = 0, std::size_t task = 0) {
    return resource->program(task).execute({now_ns});
  }
  [[nodiscard]] std::string value(const std::string& path) const {
    const runtime::Access access(*resource);
    const auto found = access.find(path);
    return found ? access.read(*found) : found.error().message;
  }
};

/// The statements as the program of one task of 10 ms.
inline std::string in_task(const std::string& variables, const std::string& statements,
                           const std::string& globals = {}) {
  return globals + "PROGRAM Main\nVAR\n" + variables + "END_VAR\n" + statements +
         "END_PROGRAM\nCONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "    PROGRAM main WITH T : Main;\n  END_RESOURCE\nEND_CONFIGURATION\n";
}

}  // namespace plc::test
