// Which diagnostics are kept and which are shown.
#include "core/diagnostics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

namespace plc::core {
namespace {

void report(Diagnostics& diagnostics, Code code, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    diagnostics.report(code, {.line = static_cast<std::uint32_t>(i + 1), .column = 1}, {}, "found");
  }
}

std::size_t lines_of(const Diagnostics& diagnostics) {
  std::ostringstream out;
  diagnostics.render(out);
  const std::string text = out.str();
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

std::string last_line(const Diagnostics& diagnostics) {
  std::ostringstream out;
  diagnostics.render(out);
  const std::string text = out.str();
  return text.substr(text.rfind('\n', text.size() - 2) + 1);
}

TEST(Diagnostics, OfOneCodeTwentyWarningsAreShownAndTheOthersCounted) {
  Diagnostics diagnostics;
  diagnostics.add_file("a.st");
  report(diagnostics, Code::P2002, Diagnostics::kMaxShown);
  EXPECT_EQ(lines_of(diagnostics), 20u);
  report(diagnostics, Code::P2002, 812);
  report(diagnostics, Code::P4301, 3);
  EXPECT_EQ(lines_of(diagnostics), 20u + 3u + 1u);
  EXPECT_EQ(last_line(diagnostics), "P2002: 812 more; --all shows them\n");
  EXPECT_EQ(diagnostics.warning_count(), 20u + 812u + 3u);
  EXPECT_EQ(diagnostics.all().size(), 20u + 812u + 3u);
}

TEST(Diagnostics, EachCodeIsCountedAlone) {
  Diagnostics diagnostics;
  diagnostics.add_file("a.st");
  report(diagnostics, Code::P2002, 5 * Diagnostics::kMaxKept);
  report(diagnostics, Code::P4301, 21);
  EXPECT_EQ(diagnostics.all().size(), Diagnostics::kMaxKept + 21u);
  std::ostringstream out;
  diagnostics.render(out);
  EXPECT_NE(out.str().find("P2002: 4980 more; --all shows them\nP4301: 1 more; --all shows them\n"), std::string::npos);
}

TEST(Diagnostics, ErrorsAreAllShown) {
  Diagnostics diagnostics;
  diagnostics.add_file("a.st");
  report(diagnostics, Code::P4004, 100);
  EXPECT_EQ(lines_of(diagnostics), 100u);
  report(diagnostics, Code::P4004, Diagnostics::kMaxKept);
  EXPECT_EQ(lines_of(diagnostics), Diagnostics::kMaxKept + 1u);
  EXPECT_EQ(last_line(diagnostics), "note: 100 further errors are counted but not shown\n");
}

TEST(Diagnostics, AllAreShownOnRequest) {
  Diagnostics diagnostics;
  diagnostics.show_all();
  diagnostics.add_file("a.st");
  report(diagnostics, Code::P2002, 3 * Diagnostics::kMaxKept);
  EXPECT_EQ(lines_of(diagnostics), 3 * Diagnostics::kMaxKept);
}

TEST(Diagnostics, WhatIsTakenOutAgainIsNotCounted) {
  Diagnostics diagnostics;
  diagnostics.add_file("a.st");
  report(diagnostics, Code::P2002, 20);
  report(diagnostics, Code::P2002, 21);
  diagnostics.drop_repeated(20);
  EXPECT_EQ(diagnostics.warning_count(), 21u);
  EXPECT_EQ(last_line(diagnostics), "P2002: 1 more; --all shows them\n");
}

}  // namespace
}  // namespace plc::core
