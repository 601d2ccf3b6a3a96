#include "examples/cnc/blocks/gcode.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/count_allocations.h"

namespace cnc {
namespace {

struct Read {
  std::vector<Segment> segments;
  Mistake mistake;
};

Read read(const std::string& program, const std::array<double, 3>& from = {}) {
  Interpreter interpreter;
  interpreter.start(program, from);
  Read result;
  Interpreter::Segments some;
  while (!interpreter.finished()) {
    interpreter.next(some);
    result.segments.insert(result.segments.end(), some.all.begin(), some.all.begin() + static_cast<int>(some.count));
  }
  result.mistake = interpreter.mistake();
  return result;
}

void expect_end(const Segment& segment, double x, double y, double z) {
  EXPECT_NEAR(segment.end[0], x, 1e-12);
  EXPECT_NEAR(segment.end[1], y, 1e-12);
  EXPECT_NEAR(segment.end[2], z, 1e-12);
}

TEST(Gcode, LinesRapidsAndModes) {
  const Read r = read("G0 X1 Y2 Z3\nG1 X4 F120\nY5\nG91 X-1 Z.5\nG90 G20 X1 F60 (inch)\nM30\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  ASSERT_EQ(r.segments.size(), 7u);
  EXPECT_EQ(r.segments[0].kind, Segment::kRapid);
  expect_end(r.segments[0], 1, 2, 3);
  EXPECT_EQ(r.segments[1].kind, Segment::kLine);
  EXPECT_EQ(r.segments[1].feed, 2) << "120 mm/min";
  expect_end(r.segments[1], 4, 2, 3);
  expect_end(r.segments[2], 4, 5, 3);
  EXPECT_EQ(r.segments[2].line, 3);
  expect_end(r.segments[3], 3, 5, 3.5);
  expect_end(r.segments[4], 25.4, 5, 3.5);
  EXPECT_NEAR(r.segments[4].feed, 25.4, 1e-12) << "60 in/min";
  EXPECT_EQ(r.segments[5].kind, Segment::kCode);
  EXPECT_EQ(r.segments[5].code, 30);
  EXPECT_EQ(r.segments[6].kind, Segment::kEnd);
}

TEST(Gcode, FormIsFree) {
  const Read r =
      read("%\r\n/G1 X99 F1\nn10g0x1y-2.50z+.5 ; comment (with any ( thing\n( a comment ) g 0 (another) x 7.\r\n\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  ASSERT_EQ(r.segments.size(), 3u);
  expect_end(r.segments[0], 1, -2.5, 0.5);
  expect_end(r.segments[1], 7, -2.5, 0.5);
  EXPECT_EQ(r.segments[2].kind, Segment::kEnd) << "without M2 a program ends with its text";
}

TEST(Gcode, ArcsByCentre) {
  const Read r = read("G0 X10 Y0\nG3 X0 Y10 I-10 J0 F60\nG2 X10 Y0 I0 J-10\nG2 I-10\nG91 G3 X0 Y0 J-2 Z-1\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  EXPECT_NEAR(r.segments[1].sweep, M_PI / 2, 1e-12);
  EXPECT_NEAR(r.segments[1].centre[0], 0, 1e-12);
  EXPECT_NEAR(r.segments[2].sweep, -M_PI / 2, 1e-12);
  EXPECT_NEAR(r.segments[2].centre[1], 0, 1e-12);
  EXPECT_NEAR(r.segments[3].sweep, -2 * M_PI, 1e-12) << "no axis word: a full circle";
  EXPECT_NEAR(r.segments[4].sweep, 2 * M_PI, 1e-12);
  expect_end(r.segments[4], 10, 0, -1);
  EXPECT_NEAR(r.segments[4].centre[1], -2, 1e-12);
}

// RS274NGC, 3.5.3.1: "If the sign of the radius is positive, the arc has less than 180 degrees".
TEST(Gcode, ArcsByRadius) {
  const Read r = read("G3 X10 Y10 R10 F60\nG0 X0 Y0\nG2 X10 Y10 R10\nG0 X0 Y0\nG3 X10 Y10 R-10\nG0 X0 Y0\nG2 X10 R5\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  EXPECT_NEAR(r.segments[0].sweep, M_PI / 2, 1e-9);
  EXPECT_NEAR(r.segments[0].centre[0], 0, 1e-9);
  EXPECT_NEAR(r.segments[0].centre[1], 10, 1e-9);
  EXPECT_NEAR(r.segments[2].sweep, -M_PI / 2, 1e-9);
  EXPECT_NEAR(r.segments[2].centre[0], 10, 1e-9);
  EXPECT_NEAR(r.segments[2].centre[1], 0, 1e-9);
  EXPECT_NEAR(r.segments[4].sweep, 3 * M_PI / 2, 1e-9);
  EXPECT_NEAR(r.segments[4].centre[0], 10, 1e-9);
  EXPECT_NEAR(r.segments[6].sweep, -M_PI, 1e-9);
  EXPECT_NEAR(r.segments[6].centre[0], 5, 1e-9);
}

TEST(Gcode, ARoundedCentreIsMovedToWhereBothEndsAreEquallyFar) {
  const Read r = read("G0 X7.071 Y7.071\nG3 X-7.071 Y7.073 I-7.071 J-7.071 F60\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  const Segment& arc = r.segments[1];
  EXPECT_NEAR(std::hypot(7.071 - arc.centre[0], 7.071 - arc.centre[1]),
              std::hypot(-7.071 - arc.centre[0], 7.073 - arc.centre[1]), 1e-12);
  EXPECT_NEAR(arc.centre[0], 0, 0.002);
}

TEST(Gcode, CodesKeepTheirPlaceInTheBlock) {
  const Read r = read("M3 M8 S500 G0 X1 M0\nG4 P1.5\n");
  ASSERT_EQ(r.mistake.text, nullptr) << r.mistake.text;
  ASSERT_EQ(r.segments.size(), 6u);
  EXPECT_EQ(r.segments[0].code, 3);
  EXPECT_EQ(r.segments[1].code, 8);
  EXPECT_EQ(r.segments[2].kind, Segment::kRapid);
  EXPECT_EQ(r.segments[2].spindle, 500);
  EXPECT_EQ(r.segments[3].kind, Segment::kCode);
  EXPECT_EQ(r.segments[3].code, 0);
  EXPECT_EQ(r.segments[4].kind, Segment::kDwell);
  EXPECT_EQ(r.segments[4].seconds, 1.5);
}

TEST(Gcode, NothingAfterTheEndIsRead) { EXPECT_EQ(read("M2\nrubbish\n").mistake.text, nullptr); }

TEST(Gcode, MistakesHaveLineAndColumn) {
  struct {
    const char* program;
    int line, column;
    const char* text;
  } const rows[] = {
      {"G0 X1\nG1 X2\n", 2, 1, "no feed"},
      {"X1\n", 1, 1, "no G0 to G3"},
      {"G0 X1 Q2\n", 1, 7, "begins with this letter"},
      {"G0 X\n", 1, 5, "a number"},
      {"G0 X1..2\n", 1, 7, "a letter must"},
      {"G0 X1e5\n", 1, 6, "begins with this letter"},
      {"G0 X12345678901234567\n", 1, 5, "15 digits"},
      {"G0 X1 X2\n", 1, 7, "twice"},
      {"G0 (open\n", 1, 4, "no end"},
      {"G0 #1\n", 1, 4, "a letter must"},
      {"G0 G1 X1\n", 1, 4, "second motion"},
      {"G18\n", 1, 1, "not one of"},
      {"G1.5 X1\n", 1, 1, "not one of"},
      {"F0\n", 1, 1, "above zero"},
      {"F-5\n", 1, 1, "above zero"},
      {"S-5\n", 1, 1, "not negative"},
      {"M3.5\n", 1, 1, "whole number"},
      {"M1 M3 M4 M5 M6\n", 1, 13, "more than four"},
      {"G4\n", 1, 1, "needs P"},
      {"G4 P-1\n", 1, 1, "needs P"},
      {"G0 X1 P1\n", 1, 7, "belongs to G4"},
      {"G4 P1 X1\n", 1, 7, "does not move"},
      {"F60 G2 X1\n", 1, 5, "needs R"},
      {"F60 G2 X1 R2 I1\n", 1, 11, "not both"},
      {"F60 G2 R2 X0\n", 1, 8, "full circle"},
      {"F60 G2 X10 R4\n", 1, 12, "less than half"},
      {"F60 G2 X10 I1\n", 1, 5, "equally far"},
      {"F60 G2 X10 I0 J0\n", 1, 5, "in its centre"},
      {"F60 G2 X10 I5 K1\n", 1, 15, "K has no meaning"},
      {"F60 G1 X10 I5\n", 1, 12, "belongs to an arc"},
  };
  for (const auto& row : rows) {
    const Mistake mistake = read(row.program).mistake;
    ASSERT_NE(mistake.text, nullptr) << row.program;
    EXPECT_NE(std::string(mistake.text).find(row.text), std::string::npos) << row.program << mistake.text;
    EXPECT_EQ(mistake.line, row.line) << row.program;
    EXPECT_EQ(mistake.column, row.column) << row.program << mistake.text;
    EXPECT_LT(std::string(mistake.text).size(), 80u) << "MESSAGE has 80 characters";
  }
}

TEST(Gcode, ReadingAllocatesNothing) {
  const std::string program = "G0 X1\nG1 X2 F60\nG2 X4 R1 M3\nG4 P1\nbad\n";
  EXPECT_EQ(plc::test::allocations_of([&program] {
              Interpreter interpreter;
              interpreter.start(program, {});
              Interpreter::Segments some;
              while (!interpreter.finished()) interpreter.next(some);
            }),
            0u);
}

}  // namespace
}  // namespace cnc
