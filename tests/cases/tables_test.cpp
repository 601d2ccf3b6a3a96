// The list of features of IEC 61131-3:2013, tables.txt, agrees with the cases: no feature without a case, no case for a
// feature that the list lacks. docs/reference/conformance.md shows both together.
//
// Does not belong here: running cases.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/run_tool.h"
#include "tools/feature_tables.h"

namespace plc::test {
namespace {

using tools::Answer;
using tools::Feature;

TEST(CaseTables, EveryFeatureHasACaseOrAReason) {
  const tools::FeatureTables features = tools::read_feature_tables(PLC_CASES);
  for (const std::string& problem : features.problems) ADD_FAILURE() << problem;
  EXPECT_GT(features.tables.size(), 70U);
}

/// A folder with one case, which proves 1.1.
struct Cases {
  ScratchFolder scratch;
  tools::FeatureTables read(const char* list) const {
    std::ofstream(scratch.file("tables.txt")) << "## 1 Things\n" << list;
    std::ofstream(scratch.file("case.txt")) << "tables: 1.1\n";
    return tools::read_feature_tables(scratch.file(""));
  }
};

TEST(CaseTables, TheLibraryAnswersForItsNames) {
  const Cases cases;
  const auto features = cases.read("1.1 | one\n1.2 | `ADD`\n1.3 | `NO_SUCH`\n1.4 | `INT_TO_{REAL, NOTHING}`\n").tables;
  ASSERT_EQ(features.size(), 1U);
  ASSERT_EQ(features[0].features.size(), 4U);
  EXPECT_EQ(features[0].features[0].cases, std::vector<std::string>{"."});
  EXPECT_EQ(features[0].features[1].answer, Answer::kYes);
  EXPECT_EQ(features[0].features[2].answer, Answer::kNo);
  EXPECT_EQ(features[0].features[2].note, "NO_SUCH not in the library");
  EXPECT_EQ(features[0].features[3].answer, Answer::kPartly);
  EXPECT_EQ(features[0].features[3].note, "INT_TO_NOTHING not in the library");
}

TEST(CaseTables, WhatIsWrongWithTheListIsSaid) {
  const Cases cases;
  EXPECT_TRUE(cases.read("1.1 | one\n").problems.empty());
  EXPECT_EQ(cases.read("1.1 | one\n1.2 | two\n").problems, std::vector<std::string>{"1.2 (two) has no case"});
  EXPECT_EQ(cases.read("1.1 | one\n1.1 | one\n").problems, std::vector<std::string>{"1.1 is there twice"});
  EXPECT_EQ(cases.read("- 1.1 | one | why not\n").problems,
            std::vector<std::string>{"1.1 (one) is missing: why not, and . proves it"});
  EXPECT_EQ(cases.read("- 1.2 | two | why not\n").problems,
            std::vector<std::string>{". names 1.1, which is not listed"});
  EXPECT_EQ(cases.read("1.1 | one\n- 1.2 | two\n").problems.size(), 1U);
}

}  // namespace
}  // namespace plc::test
