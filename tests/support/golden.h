// Golden files: text in the source tree that a test compares with what the program makes.
//
// PLC_GOLDEN_UPDATE=1 in the environment rewrites the files instead of comparing; the change is reviewed like code.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace plc::test {

/// The root of the source tree.
inline std::filesystem::path source_root() { return PLC_SOURCE_ROOT; }

/// Expects `path` (relative to the source tree) to hold `text`.
inline void expect_golden(const std::string& path, const std::string& text) {
  const std::filesystem::path file = source_root() / path;
  const char* const update = std::getenv("PLC_GOLDEN_UPDATE");
  if (update != nullptr && std::string(update) == "1") {
    std::ofstream(file, std::ios::binary) << text;
    return;
  }
  std::ifstream in(file, std::ios::binary);
  const std::string golden{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(text, golden) << path << " differs; if the change is meant, run the test with PLC_GOLDEN_UPDATE=1";
}

}  // namespace plc::test
