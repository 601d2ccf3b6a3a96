// CONCAT_.., SPLIT_.. and DAY_OF_WEEK against the C library's calendar, and at the ends of ranges.
#include <ctime>
#include <random>
#include <set>

#include "core/text.h"
#include "tests/unit/stdlib/values.h"

namespace plc::test {
namespace {

using stdlib::Event;
using stdlib::Overload;

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kDay = 86'400 * kSecond;
constexpr std::int64_t kFirst = std::numeric_limits<std::int64_t>::min();
constexpr std::int64_t kLast = std::numeric_limits<std::int64_t>::max();

std::int64_t floor_seconds(std::int64_t ns) { return ns / kSecond - (ns % kSecond < 0 ? 1 : 0); }

std::int64_t milliseconds_in_second(std::int64_t ns) { return (ns % kSecond + kSecond) % kSecond / 1'000'000; }

struct Outcome {
  std::int64_t value;
  Event event;
};
Outcome concat(const std::string& key, const std::vector<std::int64_t>& parts) {
  const Overload& o = overload(key);
  std::vector<Value> args;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    args.emplace_back(o.param_type(i));
    args.back().set_bits(static_cast<std::uint64_t>(parts[i]));
  }
  Value result(o.result_type());
  const Event event = call(o, result, args);
  return {result.get<std::int64_t>(), event};
}
std::int64_t part(const std::string& function, std::int64_t ns) {
  for (const Overload& o : stdlib::overloads_named(function)) {
    if (o.result_type() != TypeId::kInt) continue;
    Value in(o.param_type(0));
    in.set_bits(static_cast<std::uint64_t>(ns));
    Value result(o.result_type());
    EXPECT_EQ(call(o, result, {in}), Event::kNone);
    return result.get<std::int16_t>();
  }
  ADD_FAILURE() << function;
  return -1;
}

/// Instants of all years, the edges of months, leap years and the range among them.
std::vector<std::int64_t> instants() {
  std::vector<std::int64_t> out{kFirst, kFirst + 1, kLast, kLast - 1, 0, -1, 1, kDay, -kDay, kDay - 1, -kDay - 1};
  for (int year = 1678; year <= 2261; ++year) {
    for (const auto& [month, day] : {std::pair{1, 1}, {2, 28}, {3, 1}, {12, 31}}) {
      const std::int64_t midnight = seconds_of_date(year, month, day) * kSecond;
      out.insert(out.end(), {midnight, midnight - 1, midnight + kDay - 1});
    }
  }
  std::mt19937_64 random(36);
  for (int i = 0; i < 5000; ++i) out.push_back(static_cast<std::int64_t>(random()));
  return out;
}

TEST(Dates, SplitIsWhatTheCLibrarySays) {
  for (const std::int64_t ns : instants()) {
    const std::time_t seconds = floor_seconds(ns);
    std::tm tm{};
    ASSERT_NE(gmtime_r(&seconds, &tm), nullptr);
    for (const std::string name : {"SPLIT_DT", "SPLIT_LDT", "SPLIT_DATE"}) {
      ASSERT_EQ(part(name + ".YEAR", ns), tm.tm_year + 1900) << ns;
      ASSERT_EQ(part(name + ".MONTH", ns), tm.tm_mon + 1) << ns;
      ASSERT_EQ(part(name + ".DAY", ns), tm.tm_mday) << ns;
    }
    for (const std::string name : {"SPLIT_DT", "SPLIT_LDT", "SPLIT_TOD", "SPLIT_LTOD"}) {
      ASSERT_EQ(part(name + ".HOUR", ns), tm.tm_hour) << ns;
      ASSERT_EQ(part(name + ".MINUTE", ns), tm.tm_min) << ns;
      ASSERT_EQ(part(name + ".SECOND", ns), tm.tm_sec) << ns;
      ASSERT_EQ(part(name + ".MILLISECOND", ns), milliseconds_in_second(ns)) << ns;
    }
    ASSERT_EQ(part("DAY_OF_WEEK", ns), tm.tm_wday) << ns;
  }
}

TEST(Dates, ConcatIsWhatTheCLibrarySays) {
  for (const std::int64_t ns : instants()) {
    const std::time_t seconds = floor_seconds(ns);
    std::tm tm{};
    ASSERT_NE(gmtime_r(&seconds, &tm), nullptr);
    const std::int64_t ms = milliseconds_in_second(ns);
    // The first millisecond that there is began before the first instant.
    if (ns < kFirst + 1'000'000) continue;
    const std::vector<std::int64_t> parts{tm.tm_year + 1900, tm.tm_mon + 1, tm.tm_mday, tm.tm_hour,
                                          tm.tm_min,         tm.tm_sec,     ms};
    for (const char* key : {"CONCAT_DT:INT", "CONCAT_LDT:ULINT", "CONCAT_DT:UDINT"}) {
      const Outcome dt = concat(key, parts);
      ASSERT_EQ(dt.value, ns - (ns % 1'000'000 + 1'000'000) % 1'000'000) << key;
      ASSERT_EQ(dt.event, Event::kNone) << key;
    }
    for (const char* key : {"CONCAT_TOD:SINT", "CONCAT_LTOD:UINT"}) {
      const bool fits = ms < 128;
      if (!fits && std::string_view(key).ends_with(":SINT")) continue;
      const Outcome tod = concat(key, {tm.tm_hour, tm.tm_min, tm.tm_sec, ms});
      ASSERT_EQ(tod.value, ((tm.tm_hour * 60 + tm.tm_min) * 60 + tm.tm_sec) * kSecond + ms * 1'000'000) << key;
      ASSERT_EQ(tod.event, Event::kNone) << key;
    }
    tm.tm_hour = tm.tm_min = tm.tm_sec = 0;
    const std::int64_t midnight = timegm(&tm);
    if (midnight >= -106'751 * 86'400ll) {
      const Outcome date = concat("CONCAT_DATE:DINT", {parts[0], parts[1], parts[2]});
      ASSERT_EQ(date.value, midnight * kSecond);
      ASSERT_EQ(date.event, Event::kNone);
      const Outcome both = concat("CONCAT_DATE_TOD:DATE,TIME_OF_DAY", {midnight * kSecond, ns - midnight * kSecond});
      ASSERT_EQ(both.value, ns);
      ASSERT_EQ(both.event, Event::kNone);
    }
  }
}

TEST(Dates, PartsOutOfRangeCountAsTheNearest) {
  struct Case {
    const char* key;
    std::vector<std::int64_t> given;
    std::vector<std::int64_t> meant;
  };
  const Case cases[] = {
      {"CONCAT_DATE:INT", {2024, 2, 30}, {2024, 2, 29}},
      {"CONCAT_DATE:INT", {2023, 2, 29}, {2023, 2, 28}},
      {"CONCAT_DATE:INT", {2100, 2, 29}, {2100, 2, 28}},
      {"CONCAT_DATE:INT", {2000, 2, 31}, {2000, 2, 29}},
      {"CONCAT_DATE:INT", {2024, 4, 31}, {2024, 4, 30}},
      {"CONCAT_DATE:INT", {2024, 13, 32}, {2024, 12, 31}},
      {"CONCAT_DATE:INT", {2024, 0, 0}, {2024, 1, 1}},
      {"CONCAT_DATE:INT", {2024, -1, -32768}, {2024, 1, 1}},
      {"CONCAT_DATE:LINT", {2024, kLast, kFirst}, {2024, 12, 1}},
      {"CONCAT_DATE:ULINT", {2024, -1, -1}, {2024, 12, 31}},
      {"CONCAT_TOD:INT", {24, 60, 60, 1000}, {23, 59, 59, 999}},
      {"CONCAT_TOD:INT", {-1, -1, -1, -1}, {0, 0, 0, 0}},
      {"CONCAT_LTOD:USINT", {255, 0, 255, 255}, {23, 0, 59, 255}},
      {"CONCAT_DT:INT", {2023, 2, 31, 24, 0, 61, -5}, {2023, 2, 28, 23, 0, 59, 0}},
  };
  for (const Case& c : cases) {
    const Outcome given = concat(c.key, c.given);
    const Outcome meant = concat(c.key, c.meant);
    EXPECT_EQ(given.event, Event::kOutOfRange) << c.key;
    EXPECT_EQ(meant.event, Event::kNone) << c.key;
    EXPECT_EQ(given.value, meant.value) << c.key;
  }
}

TEST(Dates, ResultsBeyondTheRangeAreTheNearest) {
  for (const char* key : {"CONCAT_DT:DINT", "CONCAT_LDT:LINT"}) {
    for (const std::int64_t year : {2263, 9999, 10000, 2147483647}) {
      const Outcome out = concat(key, {year, 1, 1, 0, 0, 0, 0});
      EXPECT_EQ(out.value, kLast);
      EXPECT_EQ(out.event, Event::kOutOfRange);
    }
    for (const std::int64_t year : {1676, 1, 0, -1, -9999, -2147483647}) {
      const Outcome out = concat(key, {year, 12, 31, 23, 59, 59, 999});
      EXPECT_EQ(out.value, kFirst);
      EXPECT_EQ(out.event, Event::kOutOfRange);
    }
    const Outcome last = concat(key, {2262, 4, 11, 23, 47, 16, 854});
    EXPECT_EQ(last.value, kLast / 1'000'000 * 1'000'000);
    EXPECT_EQ(last.event, Event::kNone);
    EXPECT_EQ(concat(key, {2262, 4, 11, 23, 47, 16, 855}).value, kLast);
    const Outcome first = concat(key, {1677, 9, 21, 0, 12, 43, 146});
    EXPECT_EQ(first.value, kFirst / 1'000'000 * 1'000'000);
    EXPECT_EQ(first.event, Event::kNone);
    const Outcome below = concat(key, {1677, 9, 21, 0, 12, 43, 145});
    EXPECT_EQ(below.value, kFirst);
    EXPECT_EQ(below.event, Event::kOutOfRange);
  }
  const Outcome late = concat("CONCAT_DATE:INT", {2262, 4, 12});
  EXPECT_EQ(late.value, 106'751 * kDay);
  EXPECT_EQ(late.event, Event::kOutOfRange);
  EXPECT_EQ(concat("CONCAT_DATE:INT", {2262, 4, 11}).event, Event::kNone);
  const Outcome early = concat("CONCAT_DATE:INT", {1677, 9, 21});
  EXPECT_EQ(early.value, -106'751 * kDay);
  EXPECT_EQ(early.event, Event::kOutOfRange);
  EXPECT_EQ(concat("CONCAT_DATE:INT", {1677, 9, 22}).event, Event::kNone);
  const Outcome sum = concat("CONCAT_DATE_TOD:DATE,TIME_OF_DAY", {106'751 * kDay, kDay - 1});
  EXPECT_EQ(sum.value, kLast);
  EXPECT_EQ(sum.event, Event::kOutOfRange);
  EXPECT_EQ(concat("CONCAT_DATE_LTOD:DATE,LTIME_OF_DAY", {kFirst, 0}).value, kFirst);
}

TEST(Dates, BundlesAreFoundAndTheirOutputsAreFunctionsNobodyCanName) {
  std::set<std::string_view> outputs;
  for (const stdlib::BundleSpec& bundle : stdlib::bundles()) {
    EXPECT_EQ(stdlib::bundle_named(core::folded(bundle.name)), &bundle);
    EXPECT_TRUE(stdlib::overloads_named(bundle.name).empty()) << bundle.name;
    EXPECT_TRUE(stdlib::is_function(bundle.name));
    EXPECT_TRUE(bundle.summary.ends_with("."));
    EXPECT_TRUE(bundle.example.starts_with(bundle.name));
    for (const stdlib::FunctionSpec* output : bundle.outputs) {
      EXPECT_TRUE(stdlib::is_bundle_output(*output));
      EXPECT_EQ(std::string(bundle.name) + "." + std::string(stdlib::output_name(*output)), output->name);
      EXPECT_EQ(output->param_count, 1);
      EXPECT_EQ(output->params[0].type.fixed, bundle.input.type.fixed);
      // Parts of dates are ANY_INT, one row for each type.
      const bool any_integer = stdlib::output_takes(*output, TypeId::kUsint);
      EXPECT_EQ(stdlib::overloads_named(output->name).size(), any_integer ? 8u : 1u) << output->name;
      EXPECT_TRUE(outputs.insert(output->name).second) << output->name;
    }
  }
  for (const stdlib::FunctionSpec* spec : stdlib::function_specs()) {
    EXPECT_EQ(stdlib::is_bundle_output(*spec), outputs.count(spec->name) != 0) << spec->name;
  }
  EXPECT_EQ(stdlib::bundle_named("SPLIT"), nullptr);
  EXPECT_EQ(stdlib::bundle_named("SPLIT_DATE.YEAR"), nullptr);
}

}  // namespace
}  // namespace plc::test
