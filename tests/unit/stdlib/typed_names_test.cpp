// Typed names of overloaded functions: ADD_INT is ADD for INT, found by a rule and not by rows.
#include <set>

#include "core/text.h"
#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Overload;

/// Names with a row of their own: their typed spelling is taken.
bool has_row(const std::string& name) {
  static const std::set<std::string> kNames = [] {
    std::set<std::string> names;
    for (const Overload& o : stdlib::overloads()) names.insert(core::folded(o.name));
    return names;
  }();
  return kNames.count(core::folded(name)) != 0;
}

TEST(TypedNames, EveryOverloadWithATypeVariableHasOne) {
  std::size_t typed = 0;
  for (const Overload& o : stdlib::overloads()) {
    if (o.spec->t_categories == 0 || o.name != o.spec->name) continue;
    for (const std::string_view type : {core::info(o.t).iec, core::info(o.t).alias}) {
      if (type.empty() || type == "D" || type == "LD") continue;
      const std::string name = std::string(o.name) + "_" + std::string(type);
      const auto found = stdlib::overloads_named(core::folded(name));
      if (has_row(name)) {
        EXPECT_TRUE(core::iequals(found.front().name, name)) << name;
        continue;
      }
      ++typed;
      EXPECT_TRUE(&o >= found.data() && &o < found.data() + found.size()) << name;
      for (const Overload& other : found) {
        EXPECT_EQ(other.t, o.t) << name;
        EXPECT_EQ(other.spec, o.spec) << name;
      }
    }
  }
  EXPECT_GT(typed, 500u);
}

TEST(TypedNames, AreThoseOfTheStandard) {
  const std::pair<const char*, const char*> names[] = {{"ADD_INT", "ADD:INT"},
                                                       {"add_lreal", "ADD:LREAL"},
                                                       {"GT_DINT", "GT:DINT"},
                                                       {"AND_WORD", "AND:WORD"},
                                                       {"LIMIT_REAL", "LIMIT:REAL"},
                                                       {"SEL_TIME", "SEL:TIME"},
                                                       {"ABS_INT", "ABS:INT"},
                                                       {"SQRT_REAL", "SQRT:REAL"},
                                                       {"MOVE_STRING", "MOVE:STRING"},
                                                       {"EQ_TOD", "EQ:TIME_OF_DAY"},
                                                       {"EQ_DATE_AND_TIME", "EQ:DATE_AND_TIME"},
                                                       {"IS_VALID_REAL", "IS_VALID:REAL"},
                                                       {"IS_VALID_BCD_WORD", "IS_VALID_BCD:WORD"}};
  for (const auto& [name, key] : names) {
    const auto found = stdlib::overloads_named(name);
    ASSERT_FALSE(found.empty()) << name;
    EXPECT_EQ(stdlib::key_of(found.front()), key);
  }
  EXPECT_EQ(stdlib::overloads_named("SHL_WORD").size(), 8u) << "one for each type of N";
}

TEST(TypedNames, NamesOfRowsStayWhatTheyAre) {
  EXPECT_EQ(stdlib::key_of(stdlib::overloads_named("ADD_TIME").front()), "ADD_TIME:TIME,TIME");
  EXPECT_EQ(stdlib::overloads_named("MUL_TIME").front().spec->t_categories, 0);
  EXPECT_EQ(stdlib::overloads_named("TRUNC_INT").front().result_type(), TypeId::kInt);
  EXPECT_EQ(stdlib::overloads_named("CONCAT_TOD").front().result_type(), TypeId::kTod);
  EXPECT_EQ(stdlib::overloads_named("IS_VALID_BCD").front().spec->name, "IS_VALID_BCD");
}

TEST(TypedNames, NothingElseHasOne) {
  for (const char* name : {"ADD_", "_INT", "ADD_STRING", "ADD_BOOL", "SQRT_INT", "ADD_INT_INT", "ADD__INT", "MAX_D",
                           "EQ_LD", "TO_INT_REAL", "REAL_TO_INT_REAL", "ADD_TIME_INT", "INT_ADD", "ADD_WORD",
                           "NOPE_INT", "SPLIT_DATE_DATE", "_", "__"}) {
    EXPECT_TRUE(stdlib::overloads_named(name).empty()) << name;
  }
}

TEST(TypedNames, AreNoKeys) {
  EXPECT_EQ(stdlib::overload_with_key("ADD_INT:INT"), nullptr);
  EXPECT_EQ(stdlib::overload_with_key("ADD_INT"), nullptr);
}

TEST(TypedNames, ResolveToTheirType) {
  stdlib::Arg literal;
  literal.kind = stdlib::Arg::Kind::kIntLiteral;
  literal.int_value = 1;
  stdlib::Arg sint;
  sint.type = TypeId::kSint;
  const stdlib::Arg args[] = {literal, sint};
  const auto found = stdlib::resolve("ADD_REAL", args);
  ASSERT_EQ(found.status, stdlib::Resolution::Status::kFound);
  EXPECT_EQ(stdlib::key_of(*found.overload), "ADD:REAL");
  stdlib::Arg dint;
  dint.type = TypeId::kDint;
  const stdlib::Arg wide[] = {dint, sint};
  EXPECT_EQ(stdlib::resolve("ADD_INT", wide).status, stdlib::Resolution::Status::kNoMatch);
}

}  // namespace
}  // namespace plc::test
