// The line a message is about, with a caret under its column.
#include "core/excerpt.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <sstream>

#include "core/diagnostics.h"

namespace plc::core {
namespace {

class Excerpt : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = ::testing::TempDir() + "excerpt_" + ::testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  void TearDown() override { std::remove(path_.c_str()); }
  void write(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }
  [[nodiscard]] std::string of(std::uint32_t line, std::uint32_t column) const {
    return Excerpts().of(path_, stamp_of(path_), line, column);
  }
  std::string path_;
};

TEST_F(Excerpt, LineAndCaret) {
  write("a\n  Lvel := 3;\r\nc");
  EXPECT_EQ(of(2, 3), " 2 |   Lvel := 3;\n   |   ^\n");
  EXPECT_EQ(of(3, 1), " 3 | c\n   | ^\n");
  EXPECT_EQ(of(3, 2), " 3 | c\n   |  ^\n");  // after the last character: something is missing there
}

TEST_F(Excerpt, TabsStayAndColumnsCountCharacters) {
  write("\t\xC3\xA4\tx := 1;\n");
  EXPECT_EQ(of(1, 4), " 1 | \t\xC3\xA4\tx := 1;\n   | \t \t^\n");
}

TEST_F(Excerpt, ByteOrderMarkIsNoCharacter) {
  write("\xEF\xBB\xBFx\n");
  EXPECT_EQ(of(1, 1), " 1 | x\n   | ^\n");
}

TEST_F(Excerpt, LongLinesAreCutAroundTheColumn) {
  write(std::string(500, 'a') + "X" + std::string(500, 'b'));
  const std::string text = of(1, 501);
  EXPECT_EQ(text, " 1 | ..." + std::string(60, 'a') + "X" + std::string(39, 'b') + "...\n   | " + std::string(63, ' ') +
                      "^\n");
}

TEST_F(Excerpt, NothingThatMovesTheCursorReachesTheTerminal) {
  write(
      "a\x1B[2Jb\x7F\xC2\x9B\xFF"
      "c\n");
  EXPECT_EQ(of(1, 1), " 1 | a?[2Jb???c\n   | ^\n");
}

TEST_F(Excerpt, NothingForPlacesAndFilesThatAreNotThere) {
  write("abc\n");
  EXPECT_EQ(of(0, 0), "");
  EXPECT_EQ(of(1, 0), "");
  EXPECT_EQ(of(9, 1), "");
  EXPECT_EQ(of(1, 9), "");
  EXPECT_EQ(Excerpts().of("/no/such/file", stamp_of("/no/such/file"), 1, 1), "");
  EXPECT_EQ(Excerpts().of("/dev/zero", stamp_of("/dev/zero"), 1, 1), "");
  const FileStamp before = stamp_of(path_);
  write("another line\n");
  EXPECT_EQ(Excerpts().of(path_, before, 1, 1), "");
}

TEST_F(Excerpt, StandsBetweenMessageAndHelp) {
  write("x\n  Lvel := 3;\n");
  Diagnostics diagnostics;
  SourceRef at;
  at.file = diagnostics.add_file(path_);
  at.line = 2;
  at.column = 3;
  diagnostics.report(Code::P4004, at, "Fill", "there is no variable \"Lvel\"", "did you mean \"Level\"?");
  std::ostringstream with, without;
  diagnostics.render_with_lines(with);
  diagnostics.render(without);
  const std::string head = path_ + ":2:3: error P4004: there is no variable \"Lvel\" [POU Fill]\n";
  const std::string help = "  help: did you mean \"Level\"?\n";
  EXPECT_EQ(with.str(), head + " 2 |   Lvel := 3;\n   |   ^\n" + help);
  EXPECT_EQ(without.str(), head + help);
}

}  // namespace
}  // namespace plc::core
