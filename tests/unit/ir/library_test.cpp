#include "ir/library.h"

#include <gtest/gtest.h>

namespace plc::ir {
namespace {

using core::Code;
using core::SourceRef;

SourceRef place(std::uint16_t file, std::uint32_t line, std::uint32_t column = 1) {
  SourceRef at;
  at.file = file;
  at.line = line;
  at.column = column;
  return at;
}

/// File 0 is the project, file 1 a library of A (lines 1 to 3), B (5 to 9) and C (11 to 12).
struct Fixture {
  core::Diagnostics diagnostics;
  Library library;
  Fixture() {
    diagnostics.add_file("plant.st");
    diagnostics.begin_libraries({Code::P4313});
    diagnostics.add_file("drives.st");
    diagnostics.end_libraries();
    diagnostics.add_file("taskblocks");
    // In any order.
    library.add({"C"}, place(1, 11), place(1, 12, 9));
    library.add({"A", "A2"}, place(1, 1), place(1, 3, 9));
    library.add({"B"}, place(1, 5), place(1, 9, 9));
    library.finish();
  }
  void error(std::uint32_t line) { diagnostics.report(Code::P4014, place(1, line), "", "bad " + std::to_string(line)); }
  [[nodiscard]] Library::Index part(std::uint32_t line) const { return *library.at(place(1, line)); }
};

TEST(Library, KnowsWhatStandsWhere) {
  const Fixture f;
  EXPECT_EQ(f.library.at(place(1, 1)), f.library.at(place(1, 3, 9)));
  EXPECT_NE(f.library.at(place(1, 1)), f.library.at(place(1, 5)));
  EXPECT_FALSE(f.library.at(place(1, 4)));
  EXPECT_FALSE(f.library.at(place(1, 3, 10)));
  EXPECT_FALSE(f.library.at(place(0, 2)));
  EXPECT_FALSE(f.library.at(place(2, 2)));
  EXPECT_FALSE(f.library.at(place(1, 0)));
}

TEST(Library, WhatIsNotUsedIsNotReported) {
  Fixture f;
  f.error(4);
  f.error(6);
  EXPECT_TRUE(f.library.use(f.part(1), place(0, 7), "Main", f.diagnostics));
  EXPECT_FALSE(f.diagnostics.has_errors());
  EXPECT_TRUE(f.diagnostics.all().empty());
  EXPECT_FALSE(f.library.broken("A", f.diagnostics));
  EXPECT_EQ(f.library.broken("b", f.diagnostics), f.part(6));
}

TEST(Library, WhatIsUsedSaysWhatIsWrongWithItAndWithWhatItNeeds) {
  Fixture f;
  f.error(6);
  f.error(11);
  f.library.need(f.part(1), f.part(5));
  EXPECT_FALSE(f.library.use(f.part(1), place(0, 7), "Main", f.diagnostics));
  ASSERT_EQ(f.diagnostics.all().size(), 2u);
  EXPECT_EQ(f.diagnostics.all()[0].at, place(1, 6));
  EXPECT_EQ(f.diagnostics.all()[1].code, Code::P4060);
  EXPECT_EQ(f.diagnostics.all()[1].message,
            "\"A\" of library drives.st cannot be used: it needs \"B\": bad 6 (line 6)");
  // The first use is enough.
  EXPECT_FALSE(f.library.use(f.part(1), place(0, 8), "Main", f.diagnostics));
  EXPECT_EQ(f.diagnostics.error_count(), 2u);
}

TEST(Library, UsesInsideOfItAreNoUsesOfTheProject) {
  Fixture f;
  f.error(6);
  EXPECT_FALSE(f.library.use(f.part(5), place(1, 2), "A", f.diagnostics));
  EXPECT_EQ(f.diagnostics.error_count(), 1u);
  EXPECT_FALSE(f.library.use(f.part(5), place(0, 2), "Main", f.diagnostics));
  EXPECT_EQ(f.diagnostics.error_count(), 2u);
}

TEST(Library, DeclarationsThatNeedEachOtherEnd) {
  Fixture f;
  f.library.need(f.part(1), f.part(5));
  f.library.need(f.part(5), f.part(1));
  EXPECT_TRUE(f.library.use(f.part(1), place(0, 7), "Main", f.diagnostics));
  f.library.fail(f.part(5), place(1, 7), "body");
  EXPECT_FALSE(f.library.use(f.part(1), place(0, 7), "Main", f.diagnostics));
  EXPECT_EQ(f.diagnostics.error_count(), 1u);
}

TEST(Library, OnlyLibrariesAreSetAside) {
  Fixture f;
  f.diagnostics.report(Code::P4014, place(2, 1), "", "of a taskblock");
  f.diagnostics.report(Code::P4014, place(1, 0, 0), "", "of the file as a whole");
  f.diagnostics.report_at_once(Code::P5110, place(1, 2), "", "of two libraries");
  EXPECT_EQ(f.diagnostics.all().size(), 3u);
  f.diagnostics.report(Code::P4313, place(0, 1), "", "lint of the project");
  f.diagnostics.end_setting_aside();
  f.diagnostics.report(Code::P4313, place(1, 1), "", "lint of the library");
  EXPECT_EQ(f.diagnostics.all().size(), 4u);
}

}  // namespace
}  // namespace plc::ir
