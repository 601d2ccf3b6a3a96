// Which tests there are below the paths of a command line.
#include "testing/discover.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace plc::tests {
namespace {

namespace fs = std::filesystem;

class Discover : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(::testing::TempDir()) /
            ("discover_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }
  std::string file(const std::string& name, const std::string& text = "") const {
    fs::create_directories((root_ / name).parent_path());
    std::ofstream(root_ / name) << text;
    return (root_ / name).string();
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (root_ / name).string(); }
  fs::path root_;
};

constexpr const char* kTest = "TEST 'a' END_TEST\n";

TEST_F(Discover, ATextHasTestsWhereTestIsFollowedByAName) {
  EXPECT_TRUE(has_tests("test 'x' END_TEST"));
  EXPECT_TRUE(has_tests("PROGRAM P END_PROGRAM\nTEST (* why *) 'x' END_TEST"));
  EXPECT_FALSE(has_tests("(* TEST 'x' *)"));
  EXPECT_FALSE(has_tests("VAR test : STRING := 'x'; END_VAR"));
  EXPECT_FALSE(has_tests("x := 'TEST ''x'''"));
}

TEST_F(Discover, AFileOfTestsBelongsToTheProjectBesideIt) {
  const std::string xml = file("plant.xml");
  const std::string tests = file("plant_test.st", kTest);
  for (const std::string& given : {tests, xml}) {
    const auto units = find_units({given});
    ASSERT_TRUE(units.has_value());
    ASSERT_EQ(units->size(), 1u);
    EXPECT_EQ((*units)[0].path, xml);
    EXPECT_EQ((*units)[0].files, std::vector<std::string>{tests});
  }
}

TEST_F(Discover, AProjectIsASourceProjectOrAnExportAsWell) {
  for (const char* const name : {"mill/Mill.plcproj", "old/Mill.EXP", "older/Mill.exp"}) {
    SCOPED_TRACE(name);
    const std::string project = file(name);
    const std::string tests = file((fs::path(name).parent_path() / "Mill_test.st").string(), kTest);
    const auto units = find_units({tests});
    ASSERT_EQ(units->size(), 1u);
    EXPECT_EQ((*units)[0].path, project);
    EXPECT_EQ((*units)[0].files, std::vector<std::string>{tests});
  }
}

TEST_F(Discover, LinksThatLeadBackAreNotFollowed) {
  const std::string tests = file("a/plant_test.st", kTest);
  fs::create_directory_symlink(path("a"), path("a/again"));
  fs::create_directory_symlink(path("a"), path("a/once more"));
  const auto units = find_units({path("a")});
  ASSERT_EQ(units->size(), 1u);
  EXPECT_EQ((*units)[0].path, tests);
}

TEST_F(Discover, ATextInUtf16HasTestsAsWell) {
  std::string little, big;
  for (const char c : std::string(kTest)) {
    little += {c, '\0'};
    big += {'\0', c};
  }
  file("a/little_test.st", "\xFF\xFE" + little);
  file("a/big_test.st", "\xFE\xFF" + big);
  const auto units = find_units({path("a")});
  ASSERT_TRUE(units.has_value());
  EXPECT_EQ(units->size(), 2u);
}

TEST_F(Discover, WithoutAProjectTheFileStandsAlone) {
  const std::string tests = file("alone_test.st", kTest);
  const auto units = find_units({tests});
  ASSERT_EQ(units->size(), 1u);
  EXPECT_EQ((*units)[0].path, tests);
  EXPECT_TRUE((*units)[0].files.empty());
}

TEST_F(Discover, AFolderHasFilesAndCasesByPath) {
  file("b/press.st", "PROGRAM P END_PROGRAM");
  file("b/press_test.st", kTest);
  file("a/inside.st", kTest);
  file("a/none.st", "PROGRAM P END_PROGRAM");
  file("c/case/project.st");
  file("c/case/expected.csv");
  file(".hidden/x.st", kTest);
  const auto units = find_units({root_.string()});
  ASSERT_EQ(units->size(), 3u);
  EXPECT_EQ((*units)[0].path, path("a/inside.st"));
  EXPECT_EQ((*units)[1].path, path("b/press.st"));
  EXPECT_EQ((*units)[1].files.size(), 1u);
  EXPECT_EQ((*units)[2].path, path("c/case"));
  EXPECT_TRUE((*units)[2].is_case);
}

TEST_F(Discover, EachUnitOnce) {
  const std::string tests = file("plant_test.st", kTest);
  file("plant.st");
  EXPECT_EQ(find_units({root_.string(), tests, path("plant.st")})->size(), 1u);
}

TEST_F(Discover, WhatIsNotThereIsSaid) {
  const auto units = find_units({path("nothing.st")});
  ASSERT_FALSE(units.has_value());
  EXPECT_EQ(units.error().code, core::Code::P7001);
}

}  // namespace
}  // namespace plc::tests
