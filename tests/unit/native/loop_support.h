// One program in all engines: what the tests of loops begin with.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "tests/support/engines.h"
#include "tests/support/image_builder.h"

namespace plc::test {

inline constexpr core::TimeNs kPeriodNs = 10'000'000;

/// A task that runs `main`, with a loop budget; null, and the test has failed, when it cannot be loaded.
inline std::unique_ptr<Engines> load(ImageBuilder& b, PouBuilder& main, std::uint32_t budget = 1000) {
  b.task("Cyclic", kPeriodNs, {main.finish()});
  std::string problem;
  auto engines = Engines::load(b.build(), problem, {.loop_budget = budget});
  EXPECT_NE(engines, nullptr) << problem;
  return engines;
}

}  // namespace plc::test
