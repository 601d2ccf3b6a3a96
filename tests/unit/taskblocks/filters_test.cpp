#include <gtest/gtest.h>

#include <cmath>

#include "picard/testing.h"
#include "taskblocks/set.h"

namespace plc::blocks {
namespace {

using std::chrono::milliseconds;

TEST(LowPass, FollowsAStepLikeTheExponential) {
  picard::Instance filter(filters_library(), "LOWPASS", milliseconds(10));
  filter.port<double>("CUTOFF") = 2.0;
  filter.fire();
  filter.port<double>("IN") = 1.0;
  for (int i = 1; i <= 100; ++i) {
    filter.fire();
    const double time = i * 0.01;
    EXPECT_NEAR(filter.port<double>("OUT"), 1 - std::exp(-2 * M_PI * 2.0 * time), 1e-12) << i;
  }
}

}  // namespace
}  // namespace plc::blocks
