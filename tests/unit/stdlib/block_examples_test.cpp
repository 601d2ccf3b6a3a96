// What the rows of the blocks say about themselves is true: every example of every block, executed.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/stdlib/block_table.h"

namespace plc::test {
namespace {

class BlockExamples : public ::testing::TestWithParam<const stdlib::BlockSpec*> {};

TEST_P(BlockExamples, AreTrue) {
  const stdlib::BlockSpec& block = *GetParam();
  EXPECT_FALSE(block.examples.empty()) << block.name << " has no example";
  for (const stdlib::BlockExample& example : block.examples) {
    EXPECT_FALSE(example.title.empty()) << block.name;
    run_table(block.name, example.title, example.table);
  }
}

std::vector<const stdlib::BlockSpec*> all_blocks() {
  std::vector<const stdlib::BlockSpec*> all;
  for (const stdlib::BlockSpec& block : stdlib::blocks()) all.push_back(&block);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Stdlib, BlockExamples, ::testing::ValuesIn(all_blocks()),
                         [](const auto& block) { return std::string(block.param->name); });

/// Somewhere among the examples every pin of a block is driven or looked at, but for the pins that do nothing.
TEST(BlockExamplesTogether, ShowEveryPin) {
  for (const stdlib::BlockSpec& block : stdlib::blocks()) {
    for (const stdlib::Field& field : block.fields) {
      if (field.direction == stdlib::Direction::kState || field.name == "CYCLE") continue;
      bool shown = false;
      for (const stdlib::BlockExample& example : block.examples) {
        const std::vector<std::string> names = words_of(example.table).front();
        shown |= std::find(names.begin(), names.end(), std::string(field.name)) != names.end();
      }
      EXPECT_TRUE(shown) << block.name << "." << field.name << " is in no example";
    }
  }
}

}  // namespace
}  // namespace plc::test
