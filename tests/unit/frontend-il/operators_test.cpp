// Every operator over every type does what the operator of ST does, or is refused like it; N and brackets too.
#include "frontend-il/operators.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/types.h"
#include "frontend-st/operators.h"
#include "tests/unit/frontend-il/listed.h"

namespace plc::il {
namespace {

using test::Listed;

/// Two values of a type, as a scan writes them.
struct Values {
  const char* a;
  const char* b;
};

std::vector<Values> values_of(core::TypeId type) {
  if (type == core::TypeId::kBool) return {{"0", "0"}, {"0", "1"}, {"1", "0"}, {"1", "1"}};
  if (core::in_category(type, core::kAnyReal)) return {{"7.5", "2.5"}, {"2.5", "7.5"}, {"-1.25", "-1.25"}};
  if (core::in_category(type, core::kAnyInt | core::kAnyBit)) return {{"100", "7"}, {"7", "100"}, {"12", "12"}};
  if (core::in_category(type, core::kAnyDuration)) return {{"7000000", "3000000"}, {"3000000", "7000000"}, {"5", "5"}};
  if (core::in_category(type, core::kAnyDate)) return {{"86400000000000", "0"}, {"0", "86400000000000"}};
  return {};  // texts: those that the variables begin with
}

struct Form {
  std::string il;  ///< between LD a and ST c
  std::string st;  ///< the same as an expression
};

/// The type of a variable that takes the result.
std::string result_type(const OperatorRow& row, std::string_view type) {
  return st::is_comparison(row.op) ? "BOOL" : std::string(type);
}

void compare(const OperatorRow& row, core::TypeId id, const Form& form) {
  const std::string type(core::name_of(id));
  const std::string declared = "a, b : " + type + "; c : " + result_type(row, type) + ";";
  const std::string block = "FUNCTION_BLOCK Same VAR_INPUT a, b : " + type +
                            "; END_VAR VAR_OUTPUT c : " + result_type(row, type) + "; END_VAR c := " + form.st +
                            "; END_FUNCTION_BLOCK\n";
  Listed text(declared, "", block);
  Listed list(declared, "LD a\n" + form.il + "\nST c");
  const bool refused = !text.codes().empty() && text.diagnostics.has_errors();
  list.codes();
  EXPECT_EQ(list.diagnostics.has_errors(), refused) << form.il << " of " << type << ": " << list.message();
  if (refused || list.diagnostics.has_errors()) return;
  Listed both(declared + " same : Same;", "LD a\n" + form.il + "\nST c\nCAL same(a := a, b := b)\n", block);
  both.codes();
  ASSERT_FALSE(both.diagnostics.has_errors()) << both.message();
  std::vector<Values> all = values_of(id);
  if (all.empty()) {
    both.scan("", "c");
    EXPECT_EQ(both.read("c"), both.read("same.c")) << form.il << " of " << type;
  }
  for (const Values& one : all) {
    both.scan(std::string("a=") + one.a + " b=" + one.b, "c");
    EXPECT_EQ(both.read("c"), both.read("same.c")) << form.il << " of " << type << " with " << one.a << ", " << one.b;
  }
}

std::vector<core::TypeId> elementary_types() {
  std::vector<core::TypeId> types;
  for (std::size_t i = 0; i < core::kTypeCount; ++i) types.push_back(static_cast<core::TypeId>(i));
  return types;
}

class Operators : public testing::TestWithParam<std::size_t> {};

TEST_P(Operators, DoWhatThoseOfTextsDo) {
  const OperatorRow& row = operator_rows()[GetParam()];
  if (row.kind != Kind::kBinary) return;
  const std::string sign(st::function_of(row.op));
  const std::string name(row.name);
  const std::string call = sign + "(a, b)";
  for (const core::TypeId type : elementary_types()) {
    compare(row, type, {name + " b", call});
    compare(row, type, {name + "( b )", call});
    if (row.takes(kN)) compare(row, type, {name + "N b", sign + "(a, NOT b)"});
    if (row.takes(kN)) compare(row, type, {name + "N( LD b )", sign + "(a, NOT b)"});
  }
}

INSTANTIATE_TEST_SUITE_P(Rows, Operators, testing::Range(std::size_t{0}, operator_rows().size()));

TEST(OperatorNames, AreTakenApart) {
  const auto andn = operator_named("andn");
  ASSERT_TRUE(andn);
  EXPECT_EQ(andn->row->name, "AND");
  EXPECT_TRUE(andn->negated);
  const auto jump = operator_named("JMPCN");
  ASSERT_TRUE(jump);
  EXPECT_EQ(jump->row->kind, Kind::kJump);
  EXPECT_EQ(jump->condition, Condition::kIfFalse);
  EXPECT_EQ(operator_named("CALN")->condition, Condition::kIfFalse) << "CODESYS writes N for CN";
  EXPECT_EQ(operator_named("LDN")->row->kind, Kind::kLoad);
  EXPECT_EQ(operator_named("S1")->row->kind, Kind::kInput);
  for (const char* none : {"", "LDC", "ADDN", "NOTN", "SN", "JMPX", "LOAD", "S2", "GTN"})
    EXPECT_FALSE(operator_named(none)) << none;
  EXPECT_EQ(operator_meant("JMPCM"), "did you mean \"JMPC\"?");
}

}  // namespace
}  // namespace plc::il
