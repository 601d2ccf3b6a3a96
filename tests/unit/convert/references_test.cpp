// Drawings with variables and functions of type REFERENCE TO as statements: a name is what it refers to.
#include <gtest/gtest.h>

#include <string>

#include "convert/body_writer.h"
#include "tests/unit/frontend-fbd/diagram.h"

namespace plc::convert {
namespace {

constexpr const char* kVariables = "n : INT; r : REFERENCE TO INT; list : ARRAY [1..3] OF INT;";
constexpr const char* kOthers =
    "FUNCTION Entry : REFERENCE TO INT VAR_IN_OUT values : ARRAY [1..3] OF INT; END_VAR VAR_INPUT i : INT; END_VAR "
    "Entry REF= values[i]; END_FUNCTION\n";

WrittenBody written(const test::Sketch& sketch) {
  test::Diagram d(kVariables, sketch, kOthers);
  EXPECT_EQ(d.codes(), "") << d.message();
  const ir::Pou& main = d.pou();
  AddedVariables added(*d.module, main);
  return write_body(*d.module, main, main, added);
}

TEST(References, AreWrittenAsTheirNames) {
  test::Sketch reads;
  reads.in(1, "r");
  reads.out(2, "n", "1");
  EXPECT_EQ(written(reads).text, "  n := r;\n");
  test::Sketch writes;
  writes.in(1, "n");
  writes.out(2, "r", "1");
  EXPECT_EQ(written(writes).text, "  r := n;\n");
}

TEST(References, GivenByFunctionsAreRefused) {
  test::Sketch calls;
  calls.in(1, "Entry(list, 2)");
  calls.out(2, "n", "1");
  EXPECT_EQ(written(calls).problem, "calls \"Entry\", which gives a REFERENCE TO");
}

}  // namespace
}  // namespace plc::convert
