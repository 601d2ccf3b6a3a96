// Overload resolution: exact, then the cheapest widening, literals last; and the widening relation itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "stdlib/library.h"

namespace plc::test {
namespace {

using core::TypeId;
using stdlib::Arg;
using stdlib::resolve;
using Status = stdlib::Resolution::Status;
using enum core::TypeId;

Arg typed(TypeId id) { return {Arg::Kind::kTyped, id}; }
Arg literal(std::int64_t value) { return {Arg::Kind::kIntLiteral, kBool, value}; }
Arg big_literal(std::uint64_t value) { return {Arg::Kind::kIntLiteral, kBool, static_cast<std::int64_t>(value), true}; }
Arg real_literal() { return {Arg::Kind::kRealLiteral}; }
Arg open() { return {Arg::Kind::kUnconnected}; }

struct Case {
  const char* name;
  std::vector<Arg> args;
  std::optional<TypeId> expected;
  const char* key;
};

TEST(Resolve, PicksTheOverload) {
  const Case kCases[] = {
      // exact
      {"ADD", {typed(kInt), typed(kInt)}, {}, "ADD:INT"},
      {"add", {typed(kTime), typed(kTime)}, {}, "ADD:TIME"},
      {"ADD", {typed(kInt), typed(kInt)}, kDint, "ADD:INT"},
      {"EQ", {typed(kString), typed(kString)}, {}, "EQ:STRING"},
      // widening
      {"ADD", {typed(kInt), typed(kDint)}, {}, "ADD:DINT"},
      {"ADD", {typed(kSint), typed(kInt), typed(kLint)}, {}, "ADD:LINT"},
      {"ADD", {typed(kInt), typed(kUint)}, {}, "ADD:DINT"},
      {"ADD", {typed(kUsint), typed(kUint)}, {}, "ADD:UINT"},
      {"ADD", {typed(kUsint), typed(kSint)}, {}, "ADD:INT"},
      {"ADD", {typed(kInt), typed(kReal)}, {}, "ADD:REAL"},
      {"ADD", {typed(kDint), typed(kReal)}, {}, "ADD:LREAL"},
      {"AND", {typed(kByte), typed(kWord)}, {}, "AND:WORD"},
      {"AND", {typed(kBool), typed(kBool)}, {}, "AND:BOOL"},
      {"GT", {typed(kTime), typed(kLtime)}, {}, "GT:LTIME"},
      {"SQRT", {typed(kInt)}, {}, "SQRT:REAL"},
      {"SQRT", {typed(kDint)}, {}, "SQRT:LREAL"},
      {"EXPT", {typed(kReal), typed(kInt)}, {}, "EXPT:REAL,INT"},
      {"EXPT", {typed(kInt), typed(kInt)}, {}, "EXPT:REAL,INT"},
      // several families of one name
      {"MUL", {typed(kTime), typed(kInt)}, {}, "MUL:TIME,INT"},
      {"MUL", {typed(kTime), literal(3)}, {}, "MUL:TIME,DINT"},
      {"DIV", {typed(kTime), real_literal()}, {}, "DIV:TIME,LREAL"},
      {"ADD", {typed(kTod), typed(kTime)}, {}, "ADD:TIME_OF_DAY,TIME"},
      {"SUB", {typed(kDt), typed(kDt)}, {}, "SUB:DATE_AND_TIME,DATE_AND_TIME"},
      // literals follow the others
      {"ADD", {typed(kSint), literal(5)}, {}, "ADD:SINT"},
      {"ADD", {typed(kSint), literal(200)}, {}, "ADD:INT"},
      {"ADD", {literal(5), typed(kReal)}, {}, "ADD:REAL"},
      {"MUL", {typed(kReal), real_literal()}, {}, "MUL:REAL"},
      {"MUL", {typed(kInt), real_literal()}, {}, "MUL:REAL"},
      {"AND", {typed(kWord), literal(0xff)}, {}, "AND:WORD"},
      {"AND", {typed(kBool), literal(1)}, {}, "AND:BOOL"},
      {"ADD", {literal(1), literal(2)}, {}, "ADD:DINT"},
      {"ADD", {literal(1), literal(5'000'000'000)}, {}, "ADD:LINT"},
      {"ADD", {literal(1), big_literal(0xffffffffffffffffull)}, {}, "ADD:ULINT"},
      {"SQRT", {real_literal()}, {}, "SQRT:LREAL"},
      {"SHL", {typed(kWord), literal(3)}, {}, "SHL:WORD,DINT"},
      {"GT", {typed(kUint), literal(10)}, {}, "GT:UINT"},
      // what is expected breaks ties
      {"ADD", {literal(1), literal(2)}, kInt, "ADD:INT"},
      {"SQRT", {real_literal()}, kReal, "SQRT:REAL"},
      {"SEL", {typed(kBool), literal(1), literal(0)}, kWord, "SEL:WORD"},
      {"MOVE", {open()}, kTime, "MOVE:TIME"},
      {"MOVE", {literal(1)}, kLreal, "MOVE:LREAL"},
      // unconnected pins take what the others need
      {"ADD", {open(), typed(kInt)}, {}, "ADD:INT"},
      {"SEL", {open(), open(), typed(kString)}, {}, "SEL:STRING"},
      {"MUX", {typed(kUint), open(), typed(kReal)}, {}, "MUX:REAL,UINT"},
      // a result that no argument decides
      {"TRUNC", {typed(kReal)}, {}, "TRUNC:REAL,DINT"},
      {"TRUNC", {typed(kReal)}, kSint, "TRUNC:REAL,SINT"},
      {"TRUNC", {typed(kLreal)}, kLreal, "TRUNC:LREAL,DINT"},
      // conversions
      {"TO_INT", {typed(kReal)}, {}, "TO_INT:REAL,INT"},
      {"dint_to_real", {typed(kInt)}, {}, "DINT_TO_REAL:DINT,REAL"},
      {"TIME_TO_DINT", {typed(kTime)}, {}, "TIME_TO_DINT:TIME,DINT"},
      {"CONCAT", {typed(kChar), typed(kString)}, {}, "CONCAT:STRING"},
  };
  for (const Case& c : kCases) {
    const auto found = resolve(c.name, c.args, c.expected);
    ASSERT_EQ(found.status, Status::kFound) << c.key;
    EXPECT_EQ(stdlib::key_of(*found.overload), c.key);
  }
}

TEST(Resolve, SaysWhyThereIsNone) {
  const auto status = [](const char* name, std::vector<Arg> args) { return resolve(name, args).status; };
  EXPECT_EQ(status("FROB", {typed(kInt)}), Status::kUnknownName);
  EXPECT_EQ(status("", {}), Status::kUnknownName);
  EXPECT_EQ(status("ADD", {typed(kInt)}), Status::kWrongCount);
  EXPECT_EQ(status("SUB", {typed(kInt), typed(kInt), typed(kInt)}), Status::kWrongCount);
  EXPECT_EQ(status("NE", {typed(kInt), typed(kInt), typed(kInt)}), Status::kWrongCount);
  EXPECT_EQ(status("ADD", std::vector<Arg>(stdlib::kMaxArguments + 1, typed(kInt))), Status::kWrongCount);
  EXPECT_EQ(status("ADD", {typed(kBool), typed(kInt)}), Status::kNoMatch);
  EXPECT_EQ(status("ADD", {typed(kLint), typed(kReal)}), Status::kNoMatch);
  EXPECT_EQ(status("ADD", {typed(kLint), typed(kUlint)}), Status::kNoMatch);
  EXPECT_EQ(status("AND", {typed(kInt), typed(kInt)}), Status::kNoMatch);
  EXPECT_EQ(status("AND", {typed(kByte), literal(-1)}), Status::kNoMatch);
  EXPECT_EQ(status("SIN", {typed(kString)}), Status::kNoMatch);
  EXPECT_EQ(status("EQ", {typed(kString), typed(kWstring)}), Status::kNoMatch);
}

TEST(Resolve, NamesBothWhenNothingDecides) {
  const std::vector<Arg> args{open()};
  const auto found = resolve("MOVE", args);
  EXPECT_EQ(found.status, Status::kAmbiguous);
  ASSERT_NE(found.overload, nullptr);
  ASSERT_NE(found.rival, nullptr);
  EXPECT_NE(found.overload, found.rival);
}

TEST(Resolve, WideningIsTheStandards) {
  const auto expect = [](TypeId from, std::initializer_list<TypeId> into) {
    for (std::size_t i = 0; i < core::kTypeCount; ++i) {
      const auto to = static_cast<TypeId>(i);
      const bool listed = from == to || std::find(into.begin(), into.end(), to) != into.end();
      EXPECT_EQ(stdlib::widens(from, to), listed) << core::name_of(from) << " to " << core::name_of(to);
    }
  };
  expect(kBool, {kByte, kWord, kDword, kLword});
  expect(kByte, {kWord, kDword, kLword});
  expect(kLword, {});
  expect(kSint, {kInt, kDint, kLint, kReal, kLreal});
  expect(kInt, {kDint, kLint, kReal, kLreal});
  expect(kDint, {kLint, kLreal});
  expect(kLint, {});
  expect(kUsint, {kUint, kUdint, kUlint, kInt, kDint, kLint, kReal, kLreal});
  expect(kUint, {kUdint, kUlint, kDint, kLint, kReal, kLreal});
  expect(kUdint, {kUlint, kLint, kLreal});
  expect(kUlint, {});
  expect(kReal, {kLreal});
  expect(kLreal, {});
  expect(kTime, {kLtime});
  expect(kDate, {kLdate});
  expect(kTod, {kLtod});
  expect(kDt, {kLdt});
  expect(kChar, {kString});
  expect(kWchar, {kWstring});
  expect(kString, {});
}

TEST(Resolve, LiteralsFitByValue) {
  EXPECT_TRUE(stdlib::literal_fits(literal(127), kSint));
  EXPECT_FALSE(stdlib::literal_fits(literal(128), kSint));
  EXPECT_TRUE(stdlib::literal_fits(literal(-128), kSint));
  EXPECT_FALSE(stdlib::literal_fits(literal(-129), kSint));
  EXPECT_FALSE(stdlib::literal_fits(literal(-1), kUlint));
  EXPECT_TRUE(stdlib::literal_fits(big_literal(~0ull), kUlint));
  EXPECT_TRUE(stdlib::literal_fits(big_literal(~0ull), kLword));
  EXPECT_FALSE(stdlib::literal_fits(big_literal(~0ull), kLint));
  EXPECT_TRUE(stdlib::literal_fits(literal(1), kBool));
  EXPECT_FALSE(stdlib::literal_fits(literal(2), kBool));
  EXPECT_TRUE(stdlib::literal_fits(literal(5), kReal));
  EXPECT_FALSE(stdlib::literal_fits(literal(5), kTime));
  EXPECT_FALSE(stdlib::literal_fits(literal(5), kString));
  EXPECT_FALSE(stdlib::literal_fits(real_literal(), kDint));
}

}  // namespace
}  // namespace plc::test
