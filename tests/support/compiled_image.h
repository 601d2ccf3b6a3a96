// The image that `plc compile` makes of a project file, for tests that look inside.
//
// In: the tool, a file, options. Out: the image; failures are those of the running test. Does not belong here: running.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bytecode/image.h"
#include "tests/support/run_tool.h"

namespace plc::test {

inline std::optional<bytecode::Image> compiled_image(const std::string& tool, const std::string& file,
                                                     const std::vector<std::string>& options) {
  const ScratchFolder scratch;
  const std::string path = scratch.file("project.pbc");
  std::vector<std::string> arguments = {tool, "compile", file, "-o", path};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const ToolResult result = run_tool(arguments);
  if (result.code != 0) {
    ADD_FAILURE() << command_line(arguments) << "\n" << result.all();
    return std::nullopt;
  }
  std::ifstream in(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  auto image = bytecode::load(std::as_bytes(std::span(bytes)));
  if (image) return std::move(*image);
  ADD_FAILURE() << image.error().message;
  return std::nullopt;
}

}  // namespace plc::test
