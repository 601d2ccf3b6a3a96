// That allocations are counted: what says of others that they do none.
#include <gtest/gtest.h>

#include <memory>

#include "tests/support/count_allocations.h"

namespace plc::test {
namespace {

TEST(Allocations, AreSeen) {
  EXPECT_EQ(allocations_of([] { const auto number = std::make_unique<volatile int>(1); }), 1u);
}

}  // namespace
}  // namespace plc::test
