// A project in ST that runs scan by scan, with what it keeps.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "compiler/compile.h"
#include "retain/keeper.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/run_tool.h"

namespace plc::test {

inline std::string with_task(const std::string& text) {
  return text +
         "\nCONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T(INTERVAL := T#10ms, PRIORITY := 0);\n"
         "    PROGRAM main WITH T : Main;\n  END_RESOURCE\nEND_CONFIGURATION\n";
}

inline std::unique_ptr<runtime::Resource> load_text(const std::string& text,
                                                    const runtime::ProgramOptions& options = {},
                                                    const core::CompileOptions& compile = {}) {
  const ScratchFolder scratch;
  std::ofstream(scratch.file("test.st")) << text;
  compiler::Compilation compilation;
  compiler::compile({scratch.file("test.st"), compile, compiler::Goal::kRun}, compilation);
  for (const auto& d : compilation.diagnostics.all()) {
    if (core::info(d.code).severity == core::Severity::kError) ADD_FAILURE() << core::info(d.code).name << d.message;
  }
  if (!compilation.image) return nullptr;
  auto loaded = runtime::Resource::load(std::move(*compilation.image), options);
  if (loaded) return std::move(*loaded);
  ADD_FAILURE() << loaded.error().message;
  return nullptr;
}

inline std::string value_of(runtime::Resource& resource, std::string_view path) {
  const runtime::Access access(resource);
  const auto place = access.find(path);
  return place ? access.read(*place) : place.error().message;
}

inline void set_value(runtime::Resource& resource, std::string_view path, std::string_view text) {
  runtime::Access access(resource);
  const auto place = access.find_leaf(path);
  ASSERT_TRUE(place) << path;
  const auto problem = access.write(*place, text);
  EXPECT_FALSE(problem) << path << ": " << problem->message;
}

/// "main.a PERSISTENT", .. as they are kept.
inline std::vector<std::string> kept_paths(const retain::Layout& layout) {
  std::vector<std::string> paths;
  for (const retain::Root& root : layout.roots) {
    paths.push_back(root.path + (root.persistent ? " PERSISTENT" : "") + (root.internal ? " internal" : ""));
  }
  return paths;
}

}  // namespace plc::test
