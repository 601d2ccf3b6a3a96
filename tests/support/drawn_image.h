// A project of this repository, or a text, as an image with drawings and probes.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "bytecode/image.h"
#include "compiler/compile.h"
#include "tests/support/run_tool.h"

namespace plc::test {

inline bytecode::VerifiedImage drawn_image(const std::string& path) {
  compiler::Compilation compilation;
  compiler::Request request{path, {}, compiler::Goal::kRun};
  request.drawings = true;
  compiler::compile(request, compilation);
  std::ostringstream problems;
  compilation.diagnostics.render(problems);
  EXPECT_TRUE(compilation.image) << problems.str();
  return std::move(*compilation.image);
}

inline bytecode::VerifiedImage drawn_text(const std::string& text) {
  const ScratchFolder scratch;
  const std::string path = scratch.file("program.st");
  std::ofstream(path) << text;
  return drawn_image(path);
}

}  // namespace plc::test
