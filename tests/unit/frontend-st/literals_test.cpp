#include "frontend-st/literals.h"

#include <gtest/gtest.h>

#include <bit>

#include "declare/declarer.h"
#include "frontend-st/addresses.h"

namespace plc::st {
namespace {

using core::TypeId;

Literal good(std::string_view text) {
  std::string problem;
  const auto literal = parse_literal(text, problem);
  EXPECT_TRUE(literal) << text << ": " << problem;
  return literal.value_or(Literal{});
}
std::string bad(std::string_view text) {
  std::string problem;
  EXPECT_FALSE(parse_literal(text, problem)) << text;
  return problem;
}
std::int64_t ns(std::string_view text) { return static_cast<std::int64_t>(good(text).bits); }

TEST(Literals, UntypedIntegers) {
  EXPECT_EQ(good("0").int_value, 0);
  EXPECT_EQ(good("1_000_000").int_value, 1'000'000);
  EXPECT_EQ(good("16#1234_5678").int_value, 0x12345678);
  EXPECT_EQ(good("16#ff").int_value, 255);
  EXPECT_EQ(good("8#17").int_value, 15);
  EXPECT_EQ(good("2#1010_0101").int_value, 0xa5);
  EXPECT_EQ(good("-9223372036854775808").int_value, INT64_MIN);
  EXPECT_FALSE(good("9223372036854775807").int_is_unsigned);
  const Literal large = good("18446744073709551615");
  EXPECT_TRUE(large.int_is_unsigned);
  EXPECT_EQ(large.int_value, -1);
}

TEST(Literals, MalformedIntegers) {
  for (const char* text :
       {"18446744073709551616", "2#2", "8#8", "3#1", "1__0", "1_", "16#", "-9223372036854775809", "16#G"}) {
    EXPECT_FALSE(bad(text).empty());
  }
}

TEST(Literals, Reals) {
  EXPECT_DOUBLE_EQ(good("1.0E-3").real_value, 1e-3);
  EXPECT_DOUBLE_EQ(good("-12.5").real_value, -12.5);
  EXPECT_DOUBLE_EQ(good("3.14_15").real_value, 3.1415);
  EXPECT_DOUBLE_EQ(good("1e3").real_value, 1000.0);
  EXPECT_EQ(good("0.1").kind, Literal::Kind::kReal);
  EXPECT_FALSE(bad("1.0e999").empty());
  EXPECT_EQ(good("REAL#0.1").bits, std::bit_cast<std::uint32_t>(0.1f));
  EXPECT_EQ(good("LREAL#-1.5E2").bits, std::bit_cast<std::uint64_t>(-150.0));
  EXPECT_EQ(good("REAL#5").bits, std::bit_cast<std::uint32_t>(5.0f));
}

TEST(Literals, TypedIntegersAreRangeChecked) {
  EXPECT_EQ(good("INT#5").type, TypeId::kInt);
  EXPECT_EQ(good("int#-5").bits, 0xfffbu);
  EXPECT_EQ(good("SINT#-128").bits, 0x80u);
  EXPECT_EQ(good("WORD#16#AFFE").bits, 0xaffeu);
  EXPECT_EQ(good("UDINT#4294967295").bits, 0xffffffffu);
  EXPECT_EQ(good("ULINT#18446744073709551615").bits, ~0ull);
  for (const char* text : {"SINT#128", "SINT#-129", "USINT#256", "USINT#-1", "INT#32768", "BYTE#256",
                           "LINT#9223372036854775808", "BOOL#2", "INT#", "INT#abc"}) {
    EXPECT_FALSE(bad(text).empty()) << text;
  }
}

TEST(Literals, Booleans) {
  EXPECT_EQ(good("TRUE").bits, 1u);
  EXPECT_EQ(good("False").bits, 0u);
  EXPECT_EQ(good("BOOL#1").bits, 1u);
  EXPECT_EQ(good("BOOL#FALSE").bits, 0u);
}

TEST(Literals, Durations) {
  EXPECT_EQ(ns("T#20ms"), 20'000'000);
  EXPECT_EQ(ns("t#5d14h12m18s3.5ms"), ((5ll * 24 + 14) * 3600 + 12 * 60 + 18) * 1'000'000'000 + 3'500'000);
  EXPECT_EQ(ns("T#1h2m3s4.5ms"), 3'723'004'500'000);
  EXPECT_EQ(ns("TIME#1.5s"), 1'500'000'000);
  EXPECT_EQ(ns("T#-2m"), -120'000'000'000);
  EXPECT_EQ(ns("T#1d_2h"), 93'600'000'000'000);
  EXPECT_EQ(ns("LTIME#7us3ns"), 7'003);
  EXPECT_EQ(ns("T#0.1ms"), 100'000);
  EXPECT_EQ(good("LT#1s").type, TypeId::kLtime);
  for (const char* text :
       {"T#", "T#5", "T#5x", "T#1s2m", "T#1.5m3s", "T#s", "T#99999999999999999999d", "T#300000000000d", "T#1s1s"}) {
    EXPECT_FALSE(bad(text).empty()) << text;
  }
}

TEST(Literals, Dates) {
  EXPECT_EQ(ns("D#1970-01-02"), 86'400'000'000'000);
  EXPECT_EQ(ns("DATE#2000-02-29"), 951'782'400ll * 1'000'000'000);
  EXPECT_EQ(ns("TOD#12:30:05.25"), 45'005'250'000'000);
  EXPECT_EQ(ns("TIME_OF_DAY#00:00:01"), 1'000'000'000);
  EXPECT_EQ(ns("DT#1970-01-01-00:01:00"), 60'000'000'000);
  EXPECT_EQ(ns("DATE_AND_TIME#1969-12-31-23:59:59"), -1'000'000'000);
  EXPECT_EQ(good("LDT#2024-05-01-10:00:00").type, TypeId::kLdt);
  EXPECT_EQ(good("LTOD#1:02:03").type, TypeId::kLtod);
  for (const char* text :
       {"D#2023-02-29", "D#2023-13-01", "D#23-1-1", "TOD#24:00:00", "TOD#10:60", "DT#2024-01-01", "D#1000-01-01"}) {
    EXPECT_FALSE(bad(text).empty()) << text;
  }
}

TEST(Literals, Strings) {
  EXPECT_EQ(good("'abc'").text, "abc");
  EXPECT_EQ(good("''").text, "");
  EXPECT_EQ(good("'a$'b$$c$L$N$P$R$T$41'").text, "a'b$c\n\n\f\r\tA");
  EXPECT_EQ(good("\"a$0041\"").text, std::string("a\0A\0", 4));
  EXPECT_EQ(good("\"\xc3\xa4\"").text, std::string("\xe4\0", 2));
  EXPECT_EQ(good("STRING#'x'").type, TypeId::kString);
  EXPECT_EQ(good("CHAR#'x'").type, TypeId::kChar);
  EXPECT_FALSE(bad("'a$Zb'").empty());
  EXPECT_FALSE(bad("CHAR#'xy'").empty());
  EXPECT_FALSE(bad("INT#'5'").empty());
}

TEST(Addresses, OneSpellingEach) {
  std::string problem;
  const auto text = [&](std::string_view a) {
    const auto address = parse_address(a, problem);
    return address ? address->text() : "bad";
  };
  EXPECT_EQ(text("%I0.0"), "%IX0.0");
  EXPECT_EQ(text("%ix00.07"), "%IX0.7");
  EXPECT_EQ(text("%IW0.0.1.0"), "%IW0.0.1.0");
  EXPECT_EQ(text("%ML1025"), "%ML1025");
  EXPECT_EQ(text("%I*"), "%I*");
  EXPECT_EQ(text("%QX*"), "%Q*");
  for (const char* wrong : {"%IX0.8", "%Z1", "IX0.0", "%IX", "%IK3", "%IX0.", "%IW99999999999", "%"})
    EXPECT_EQ(text(wrong), "bad") << wrong;
}

TEST(Intervals, AllSpellings) {
  struct Row {
    const char* text;
    const char* unit;
    std::int64_t ns;
  };
  for (const Row& row :
       {Row{"T#20ms", "", 20'000'000}, Row{"t#50ms", "", 50'000'000}, Row{"T#0.1ms", "", 100'000},
        Row{"T#1s", "", 1'000'000'000}, Row{"PT0.02S", "", 20'000'000}, Row{"10000", "us", 10'000'000},
        Row{"20", "ms", 20'000'000}, Row{"00:00:00.100000", "", 100'000'000}, Row{"00:00:00.1", "", 100'000'000},
        Row{"10ms", "", 10'000'000}, Row{"P0DT0H0M0.5S", "", 500'000'000}, Row{"PT1M", "", 60'000'000'000},
        Row{"PT0S", "", 0}, Row{" TIME#5ms ", "", 5'000'000}, Row{"t#20ms", "ms", 20'000'000}}) {
    std::string problem;
    const auto ns_value = parse_interval(row.text, row.unit, problem);
    ASSERT_TRUE(ns_value) << row.text << ": " << problem;
    EXPECT_EQ(*ns_value, row.ns) << row.text;
  }
  for (const char* wrong : {"20", "P1Y", "P1M", "PT", "T#-5ms", "x", "00:00", "T#", "INT#5", "1:2:3:4", "PT5"}) {
    std::string problem;
    EXPECT_FALSE(parse_interval(wrong, "", problem)) << wrong;
    EXPECT_FALSE(problem.empty());
  }
}

}  // namespace
}  // namespace plc::st
