// Conversions: every pair of numbers against a wide oracle, the ends of the ranges, text there and back, strings cut.
#include <limits>

#include "core/windows_1252.h"
#include "stdlib/arithmetic.h"
#include "stdlib/strings.h"
#include "stdlib/text_values.h"
#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;
__extension__ using Wide = __int128;

bool is_whole(TypeId id) { return core::in_category(id, core::kAnyInt | core::kAnyBit); }
unsigned width(TypeId id) { return id == TypeId::kBool ? 1 : 8 * core::rep_bytes(core::rep_of(id)); }
Wide least(TypeId id) { return core::in_category(id, core::kAnySigned) ? -(Wide{1} << (width(id) - 1)) : Wide{0}; }
Wide greatest(TypeId id) {
  return (Wide{1} << (core::in_category(id, core::kAnySigned) ? width(id) - 1 : width(id))) - 1;
}

TEST(Conversion, WholeNumbersKeepTheirLowBits) {
  std::size_t swept = 0;
  for (const Overload& o : stdlib::overloads()) {
    if (o.spec->name != "*_TO_*" || !is_whole(o.t) || !is_whole(o.u)) continue;
    ++swept;
    for (const Wide value :
         {least(o.t), least(o.t) + 1, Wide{0}, Wide{1}, greatest(o.t) / 2, greatest(o.t) - 1, greatest(o.t)}) {
      std::vector<Value> args(1, Value(o.t));
      args[0].set_bits(static_cast<std::uint64_t>(value));
      Value result(o.u);
      EXPECT_EQ(call(o, result, args), Event::kNone);
      const auto low = static_cast<std::uint64_t>(value);
      const std::uint64_t want = o.u == TypeId::kBool ? value != 0
                                 : width(o.u) == 64   ? low
                                                      : low & ((std::uint64_t{1} << width(o.u)) - 1);
      EXPECT_EQ(result.bits(), want) << o.name << " " << static_cast<std::int64_t>(value);
    }
  }
  EXPECT_EQ(swept, 13u * 12u);
}

TEST(Conversion, RealsRoundHalfToEvenAndSaturateWithAnEvent) {
  for (const Overload& o : stdlib::overloads()) {
    const bool is_source = o.t == TypeId::kReal || o.t == TypeId::kLreal;
    if (o.spec->name != "*_TO_*" || !is_source || !is_whole(o.u) || o.u == TypeId::kBool) continue;
    const auto run = [&](double v, Event want_event) {
      std::vector<Value> args(1, Value(o.t));
      if (o.t == TypeId::kReal) {
        args[0].set(static_cast<float>(v));
      } else {
        args[0].set(v);
      }
      Value result(o.u);
      EXPECT_EQ(call(o, result, args), want_event) << o.name << " " << v;
      return result.bits();
    };
    const auto bits = [&](Wide value) {
      Value v(o.u);
      v.set_bits(static_cast<std::uint64_t>(value));
      return v.bits();
    };
    const auto top = static_cast<double>(static_cast<long double>(greatest(o.u)) + 1.0L);
    const auto bottom = static_cast<double>(least(o.u));
    EXPECT_EQ(run(0.5, Event::kNone), bits(0)) << o.name;
    EXPECT_EQ(run(1.5, Event::kNone), bits(2)) << o.name;
    EXPECT_EQ(run(2.5, Event::kNone), bits(2)) << o.name;
    EXPECT_EQ(run(-0.5, Event::kNone), bits(0)) << o.name;
    EXPECT_EQ(run(top, Event::kOutOfRange), bits(greatest(o.u))) << o.name;
    EXPECT_EQ(run(bottom, Event::kNone), bits(least(o.u))) << o.name;
    EXPECT_EQ(run(HUGE_VAL, Event::kOutOfRange), bits(greatest(o.u))) << o.name;
    EXPECT_EQ(run(-HUGE_VAL, Event::kOutOfRange), bits(least(o.u))) << o.name;
    EXPECT_EQ(run(std::nan(""), Event::kOutOfRange), 0u) << o.name;
    if (width(o.u) <= 32 && o.t == TypeId::kLreal) {
      EXPECT_EQ(run(top - 1.0, Event::kNone), bits(greatest(o.u))) << o.name;
      EXPECT_EQ(run(top - 0.51, Event::kNone), bits(greatest(o.u))) << o.name;
      EXPECT_EQ(run(top - 0.5, Event::kOutOfRange), bits(greatest(o.u))) << o.name;
      EXPECT_EQ(run(bottom - 0.5, Event::kNone), bits(least(o.u))) << o.name;
      EXPECT_EQ(run(bottom - 0.51, Event::kOutOfRange), bits(least(o.u))) << o.name;
    }
  }
}

TEST(Conversion, TruncationDropsTheFraction) {
  Event event = Event::kNone;
  EXPECT_EQ(stdlib::saturate_cast<std::int8_t>(127.99, event), 127);
  EXPECT_EQ(stdlib::saturate_cast<std::int8_t>(-128.99, event), -128);
  EXPECT_EQ(stdlib::saturate_cast<std::uint8_t>(-0.99, event), 0);
  EXPECT_EQ(stdlib::saturate_cast<std::int64_t>(-9223372036854775808.0, event),
            std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(event, Event::kNone);
  EXPECT_EQ(stdlib::saturate_cast<std::int8_t>(-129.0, event), -128);
  EXPECT_EQ(event, Event::kOutOfRange);
  event = Event::kNone;
  EXPECT_EQ(stdlib::saturate_cast<std::uint64_t>(18446744073709551616.0, event),
            std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(event, Event::kOutOfRange);
}

TEST(Conversion, TimeCountsMillisecondsAndLtimeNanoseconds) {
  const auto run = [](const char* key, const char* literal) {
    const Overload& o = overload(key);
    Value result(o.result_type());
    EXPECT_EQ(call(o, result, {Value(o.t, literal)}), Event::kNone);
    return result;
  };
  EXPECT_EQ(run("TIME_TO_LINT:TIME,LINT", "T#1m1ms").bits(), 60001u);
  EXPECT_EQ(run("TIME_TO_UINT:TIME,UINT", "T#65537ms").bits(), 1u) << "wraps like any narrowing";
  EXPECT_EQ(run("TIME_TO_DINT:TIME,DINT", "T#1999us").bits(), 1u) << "whole milliseconds toward zero";
  EXPECT_EQ(run("LTIME_TO_LINT:LTIME,LINT", "LTIME#1ms").bits(), 1'000'000u);
  EXPECT_EQ(run("UDINT_TO_TIME:UDINT,TIME", "4294967295").bits(), 4294967295ull * 1'000'000);
  EXPECT_EQ(run("ULINT_TO_LTIME:ULINT,LTIME", "7").bits(), 7u);
  EXPECT_EQ(run("TIME_TO_LTIME:TIME,LTIME", "T#5ms").bits(), 5'000'000u);
  EXPECT_EQ(run("TIME_TO_LREAL:TIME,LREAL", "T#1500us").get<double>(), 1.5);
  EXPECT_EQ(run("TIME_TO_BOOL:TIME,BOOL", "T#1ns").bits(), 1u);
  EXPECT_EQ(run("LREAL_TO_TIME:LREAL,TIME", "0.0000005").bits(), 0u) << "half a nanosecond rounds to even";
}

TEST(Conversion, NanIsFalseWithAnEvent) {
  Value result(TypeId::kBool, "TRUE");
  EXPECT_EQ(call(overload("REAL_TO_BOOL:REAL,BOOL"), result, {Value(TypeId::kReal, "NaN")}), Event::kOutOfRange);
  EXPECT_EQ(result.bits(), 0u);
}

TEST(Conversion, DatesTakeApartBeforeTheEpochToo) {
  Value dt(TypeId::kDt, "DT#1969-12-30-06:00:00"), date(TypeId::kDate), tod(TypeId::kTod);
  EXPECT_EQ(call(overload("DT_TO_DATE:DATE_AND_TIME,DATE"), date, {dt}), Event::kNone);
  EXPECT_EQ(call(overload("DT_TO_TOD:DATE_AND_TIME,TIME_OF_DAY"), tod, {dt}), Event::kNone);
  EXPECT_TRUE(date.same_as(Value(TypeId::kDate, "D#1969-12-30")));
  EXPECT_TRUE(tod.same_as(Value(TypeId::kTod, "TOD#06:00:00")));
}

// ---- text -------------------------------------------------------------------------------------------------------

TEST(Conversion, EveryTypeReadsBackWhatItWrites) {
  std::size_t swept = 0;
  for (const Overload& write : stdlib::overloads()) {
    if (write.spec->name != "*_TO_*" || !core::in_category(write.u, core::kAnyString)) continue;
    if (core::in_category(write.t, core::kAnyString | core::kAnyChar)) continue;
    const auto back = stdlib::overloads_named(std::string(write.u == TypeId::kString ? "STRING_TO_" : "WSTRING_TO_") +
                                              std::string(write.name.substr(0, write.name.find("_TO_"))));
    ASSERT_EQ(back.size(), 1u) << write.name;
    ++swept;
    for (const std::uint64_t bits :
         {0ull, 1ull, 42ull, 0x7full, 0x80ull, 0x3fc00000ull, 0x4009'21fb'5444'2d18ull, 0x7fff'ffff'ffff'ffffull,
          0x8000'0000'0000'0001ull, 0x7f80'0000ull, ~0ull, 0x00000001'00000000ull}) {
      if (write.t == TypeId::kBool && bits > 1) continue;
      Value in(write.t);
      in.set_bits(bits);
      if (write.t == TypeId::kReal) in.set(stdlib::canonical(in.get<float>()));
      if (write.t == TypeId::kLreal) in.set(stdlib::canonical(in.get<double>()));
      if (core::in_category(write.t, core::kAnyDate)) {
        // What the type holds: whole days, times within a day.
        constexpr std::int64_t kDay = 86'400'000'000'000;
        const auto ns = static_cast<std::int64_t>(bits >> 3);
        const bool is_date = write.t == TypeId::kDate || write.t == TypeId::kLdate;
        const bool is_tod = write.t == TypeId::kTod || write.t == TypeId::kLtod;
        in.set(is_date ? ns - ns % kDay : is_tod ? ns % kDay : ns);
      }
      Value text(write.u), out(write.t);
      EXPECT_EQ(call(write, text, {in}), Event::kNone) << write.name << " " << bits;
      EXPECT_EQ(call(back[0], out, {text}), Event::kNone) << write.name << " " << bits << " " << text.text();
      EXPECT_EQ(out.bits(), in.bits()) << write.name << " " << text.text();
    }
  }
  EXPECT_GE(swept, 46u);
}

TEST(Conversion, TextIsALiteralOfTheStandard) {
  const auto written = [](const char* key, const char* literal) {
    const Overload& o = overload(key);
    Value result(TypeId::kString);
    EXPECT_EQ(call(o, result, {Value(o.t, literal)}), Event::kNone);
    return result.text();
  };
  EXPECT_EQ(written("BOOL_TO_STRING:BOOL,STRING", "TRUE"), "TRUE");
  EXPECT_EQ(written("BYTE_TO_STRING:BYTE,STRING", "10"), "16#0A");
  EXPECT_EQ(written("ULINT_TO_STRING:ULINT,STRING", "18446744073709551615"), "18446744073709551615");
  EXPECT_EQ(written("LINT_TO_STRING:LINT,STRING", "9223372036854775808"), "-9223372036854775808");
  EXPECT_EQ(written("REAL_TO_STRING:REAL,STRING", "1.0"), "1.0");
  EXPECT_EQ(written("REAL_TO_STRING:REAL,STRING", "1e20"), "1.0E+20");
  EXPECT_EQ(written("LREAL_TO_STRING:LREAL,STRING", "-0.1"), "-0.1");
  EXPECT_EQ(written("LREAL_TO_STRING:LREAL,STRING", "NaN"), "NaN");
  EXPECT_EQ(written("TIME_TO_STRING:TIME,STRING", "T#-1d500ms"), "T#-1d500ms");
  EXPECT_EQ(written("TIME_TO_STRING:TIME,STRING", "0"), "T#0s");
  EXPECT_EQ(written("DT_TO_STRING:DATE_AND_TIME,STRING", "DT#2024-02-29-12:34:56"), "DT#2024-02-29-12:34:56");
  EXPECT_EQ(written("TOD_TO_STRING:TIME_OF_DAY,STRING", "T#1s50ms"), "TOD#00:00:01.05");
  EXPECT_EQ(written("DATE_TO_STRING:DATE,STRING", "D#1968-02-29"), "D#1968-02-29");
}

struct Reading {
  const char* text;
  std::int64_t value;
  Event event;
};
TEST(Conversion, ReadsIntegersOrSaysWhyNot) {
  const Reading kReadings[] = {{"12", 12, Event::kNone},
                               {"  -12\t", -12, Event::kNone},
                               {"+1_000", 1000, Event::kNone},
                               {"16#7f", 127, Event::kNone},
                               {"INT#2#101", 5, Event::kNone},
                               {"-8#17", -15, Event::kNone},
                               {"32768", 32767, Event::kOutOfRange},
                               {"-32769", -32768, Event::kOutOfRange},
                               {"99999999999999999999999999", 32767, Event::kOutOfRange},
                               {"", 0, Event::kInvalid},
                               {"-", 0, Event::kInvalid},
                               {"1.5", 0, Event::kInvalid},
                               {"1__0", 0, Event::kInvalid},
                               {"10_", 0, Event::kInvalid},
                               {"3#12", 0, Event::kInvalid},
                               {"16#", 0, Event::kInvalid},
                               {"12 apples", 0, Event::kInvalid}};
  for (const Reading& r : kReadings) {
    Event event = Event::kNone;
    EXPECT_EQ(stdlib::parse_signed(r.text, -32768, 32767, event), r.value) << r.text;
    EXPECT_EQ(event, r.event) << r.text;
  }
}
TEST(Conversion, ReadsDurationsOrSaysWhyNot) {
  const Reading kReadings[] = {
      {"T#1d2h3m4s5ms6us7ns", 93'784'005'006'007, Event::kNone},
      {"time#1.5s", 1'500'000'000, Event::kNone},
      {"5d14h12m18s3.5ms", 483'138'003'500'000, Event::kNone},
      {"t#-20ms", -20'000'000, Event::kNone},
      {"LTIME#1h_30m", 5'400'000'000'000, Event::kNone},
      {"0.5d", 43'200'000'000'000, Event::kNone},
      {"T#9999999d", std::numeric_limits<std::int64_t>::max(), Event::kOutOfRange},
      {"-999999999999999999999d", std::numeric_limits<std::int64_t>::min(), Event::kOutOfRange},
      {"", 0, Event::kInvalid},
      {"T#", 0, Event::kInvalid},
      {"5", 0, Event::kInvalid},
      {"5x", 0, Event::kInvalid},
      {"1s junk", 0, Event::kInvalid}};
  for (const Reading& r : kReadings) {
    Event event = Event::kNone;
    EXPECT_EQ(stdlib::parse_duration(r.text, event), r.value) << r.text;
    EXPECT_EQ(event, r.event) << r.text;
  }
}
TEST(Conversion, ReadsRealsOrSaysWhyNot) {
  struct {
    const char* text;
    double value;
    Event event;
  } const kReadings[] = {
      {"1.5", 1.5, Event::kNone},        {"-2", -2.0, Event::kNone},        {"1_0.2_5E+1", 102.5, Event::kNone},
      {"REAL#0.5", 0.5, Event::kNone},   {"-Inf", -HUGE_VAL, Event::kNone}, {"abc", 0, Event::kInvalid},
      {"", 0, Event::kInvalid},          {"--1", 0, Event::kInvalid},       {"1.5 V", 0, Event::kInvalid},
      {"1e-999", 0, Event::kOutOfRange}, {"infinity", 0, Event::kInvalid}};
  for (const auto& r : kReadings) {
    Event event = Event::kNone;
    EXPECT_EQ(stdlib::parse_lreal(r.text, event), r.value) << r.text;
    EXPECT_EQ(event, r.event) << r.text;
  }
  Event event = Event::kNone;
  EXPECT_EQ(stdlib::parse_real("1e39", event), std::numeric_limits<float>::max());
  EXPECT_EQ(event, Event::kOutOfRange);
}
TEST(Conversion, ReadsDatesThatExist) {
  Event event = Event::kNone;
  stdlib::parse_date("D#2023-02-29", TypeId::kDate, event);
  EXPECT_EQ(event, Event::kInvalid);
  event = Event::kNone;
  stdlib::parse_date("TOD#24:00:00", TypeId::kTod, event);
  EXPECT_EQ(event, Event::kInvalid);
  event = Event::kNone;
  stdlib::parse_date("D#3000-01-01", TypeId::kDate, event);
  EXPECT_EQ(event, Event::kOutOfRange);
  event = Event::kNone;
  EXPECT_EQ(stdlib::parse_date("2000-03-01-00:00:01.5", TypeId::kDt, event),
            seconds_of_date(2000, 3, 1) * 1'000'000'000 + 1'500'000'000);
  EXPECT_EQ(event, Event::kNone);
}

// ---- strings ----------------------------------------------------------------------------------------------------

TEST(Strings, AreCutToTheCapacityOfTheResultWithAnEvent) {
  for (const auto& [key, quote] : {std::pair{"CONCAT:STRING", "'"}, std::pair{"CONCAT:WSTRING", "\""}}) {
    const Overload& o = overload(key);
    Value result(o.t);
    result.set(core::StringHeader{3, 0});
    const std::string q = quote;
    EXPECT_EQ(call(o, result, {Value(o.t, q + "ab" + q), Value(o.t, q + "cd" + q)}), Event::kTruncated);
    EXPECT_EQ(result.text(), "abc");
    EXPECT_EQ(result.get<core::StringHeader>().capacity, 3);
  }
}

TEST(Strings, ForgedLengthsStayInside) {
  Value in(TypeId::kString, "'abc'");
  in.set(core::StringHeader{3, 60000});
  EXPECT_EQ(stdlib::text_of<char>(in.bytes), "abc");
  in.set(core::StringHeader{60000, 60000});
  EXPECT_EQ(stdlib::text_of<char>(in.bytes).size(), core::kMaxStringCapacity);
  EXPECT_EQ(stdlib::text_of<char>(in.bytes, 2), "ab");
}

TEST(Strings, PositionsOutsideSelectNothingWithAnEvent) {
  const auto run = [](const char* key, std::vector<std::string> literals, Event want) {
    const Overload& o = overload(key);
    std::vector<Value> args;
    for (std::size_t i = 0; i < literals.size(); ++i) args.emplace_back(o.param_type(i), literals[i]);
    Value result(o.result_type());
    EXPECT_EQ(call(o, result, args), want) << key;
    return result.text();
  };
  EXPECT_EQ(run("MID:STRING,INT", {"'abc'", "9", "2"}, Event::kNone), "bc");
  EXPECT_EQ(run("MID:STRING,INT", {"'abc'", "1", "0"}, Event::kOutOfRange), "");
  EXPECT_EQ(run("MID:STRING,ULINT", {"'abc'", "18446744073709551615", "1"}, Event::kNone), "abc");
  EXPECT_EQ(run("DELETE:STRING,ULINT", {"'abc'", "18446744073709551615", "2"}, Event::kNone), "a");
  EXPECT_EQ(run("INSERT:STRING,DINT", {"'abc'", "'X'", "3"}, Event::kNone), "abcX");
  EXPECT_EQ(run("REPLACE:STRING,INT", {"'abc'", "'XYZ'", "0", "1"}, Event::kNone), "XYZabc");
  EXPECT_EQ(run("RIGHT:STRING,SINT", {"''", "1"}, Event::kNone), "");
}

TEST(Strings, WideCharactersThatStringLacksAreMarked) {
  Value in(TypeId::kWstring, "\"ab\""), out(TypeId::kString);
  const char16_t omega = 0x03a9;
  std::memcpy(in.bytes + 6, &omega, 2);
  EXPECT_EQ(call(overload("WSTRING_TO_STRING:WSTRING,STRING"), out, {in}), Event::kInvalid);
  EXPECT_EQ(out.text(), "a?");
}

TEST(Strings, WindowsHas27CharactersMoreThanLatin1) {
  unsigned moved = 0;
  for (unsigned byte = 0; byte < 256; ++byte) {
    const char16_t wide = core::from_windows_1252(static_cast<std::uint8_t>(byte));
    EXPECT_EQ(core::to_windows_1252(wide), byte);
    moved += wide != byte;
  }
  EXPECT_EQ(moved, 27u);
  EXPECT_EQ(core::from_windows_1252(0x80), u'\u20ac');
  EXPECT_EQ(core::to_windows_1252(0x80), 0x80);  // as ISO 8859-1 has it
  EXPECT_EQ(core::to_windows_1252(0x3a9), std::nullopt);
  EXPECT_EQ(core::to_windows_1252(0x1f600), std::nullopt);
}

}  // namespace
}  // namespace plc::test
