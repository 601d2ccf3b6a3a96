// From an ImageBuilder to a resource that runs, with direct access to its values.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <optional>
#include <sstream>
#include <string>

#include "bytecode/image.h"
#include "runtime/access.h"
#include "runtime/resource.h"
#include "tests/support/image_builder.h"

namespace plc::test {

/// Verifies and links; fails the test and returns null when either refuses.
inline std::unique_ptr<runtime::Resource> load(ImageBuilder& builder, const runtime::ProgramOptions& options = {}) {
  core::Diagnostics diagnostics;
  auto verified = bytecode::verify(builder.build(), diagnostics);
  std::ostringstream text;
  diagnostics.render(text);
  EXPECT_TRUE(verified.has_value()) << text.str();
  if (!verified) return nullptr;
  auto resource = runtime::Resource::load(std::move(*verified), options);
  EXPECT_TRUE(resource.has_value()) << (resource ? "" : resource.error().message);
  return resource ? std::move(*resource) : nullptr;
}

inline std::string value_of(runtime::Resource& resource, std::string_view path) {
  const runtime::Access access(resource);
  const auto place = access.find(path);
  return place ? access.read(*place) : place.error().message;
}

inline void set(runtime::Resource& resource, std::string_view path, std::string_view text) {
  runtime::Access access(resource);
  const auto place = access.find_leaf(path);
  ASSERT_TRUE(place.has_value()) << place.error().message;
  const auto problem = access.write(*place, text);
  ASSERT_FALSE(problem.has_value()) << problem->message;
}

/// A builder with one program "Main" in one 10 ms task "Cyclic". Main's variables are read as "Main0.name".
struct OneProgram {
  ImageBuilder b;
  PouBuilder main = b.pou("Main", PouKind::kProgram);

  std::unique_ptr<runtime::Resource> load(const runtime::ProgramOptions& options = {}) {
    b.task("Cyclic", 10'000'000, {main.finish()});
    return test::load(b, options);
  }
};

}  // namespace plc::test
