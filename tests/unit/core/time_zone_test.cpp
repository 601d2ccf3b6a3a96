// Local time, against the C library and by hand.
#include "core/time_zone.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <random>
#include <string>

namespace plc::core {
namespace {

constexpr TimeNs kSecond = 1'000'000'000;
constexpr TimeNs kHour = 3'600 * kSecond;

TEST(TimeZone, IsUtcWithoutAName) {
  const TimeZone zone;
  EXPECT_EQ(zone.offset_ns(0), 0);
  EXPECT_EQ(zone.offset_ns(INT64_MAX), 0);
  EXPECT_EQ(zone.name(), "UTC");
  EXPECT_EQ(TimeZone::load("UTC")->offset_ns(1'774'746'000 * kSecond), 0);
}

// Central Europe in 2026: summer time from 2026-03-29T01:00Z to 2026-10-25T01:00Z.
TEST(TimeZone, ChangesAtTheInstant) {
  const auto zone = TimeZone::load("CET-1CEST,M3.5.0,M10.5.0/3");
  ASSERT_TRUE(zone);
  constexpr TimeNs kSpring = 1'774'746'000 * kSecond;
  constexpr TimeNs kAutumn = 1'792'890'000 * kSecond;
  EXPECT_EQ(zone->offset_ns(kSpring - 1), kHour);
  EXPECT_EQ(zone->offset_ns(kSpring), 2 * kHour);
  EXPECT_EQ(zone->offset_ns(kAutumn - 1), 2 * kHour);
  EXPECT_EQ(zone->offset_ns(kAutumn), kHour);
  EXPECT_EQ(zone->offset_ns(-kSpring), zone->offset_ns(0)) << "before the table";
}

TEST(TimeZone, IsWhatTheCLibrarySays) {
  if (!std::filesystem::exists("/usr/share/zoneinfo/Europe/Berlin")) GTEST_SKIP() << "no time zone database (tzdata)";
  const char* const before = std::getenv("TZ");
  const std::string kept = before != nullptr ? before : "";
  std::mt19937_64 random(7);
  for (const char* const name : {"Europe/Berlin", "America/New_York", "Australia/Lord_Howe", "Africa/Casablanca",
                                 "Asia/Kathmandu", "Etc/GMT+12"}) {
    const auto zone = TimeZone::load(name);
    ASSERT_TRUE(zone) << name;
    EXPECT_EQ(zone->name(), name);
    ::setenv("TZ", name, 1);
    ::tzset();
    for (int i = 0; i < 20'000; ++i) {
      const auto second = static_cast<std::time_t>(random() % 4'102'444'800);
      std::tm local{};
      ::localtime_r(&second, &local);
      ASSERT_EQ(zone->offset_ns(second * kSecond), local.tm_gmtoff * kSecond) << name << " at " << second;
    }
  }
  before != nullptr ? ::setenv("TZ", kept.c_str(), 1) : ::unsetenv("TZ");
  ::tzset();
}

TEST(TimeZone, LeavesTheZoneOfTheProcessAsItIs) {
  ::setenv("TZ", "XYZ-5", 1);
  ::tzset();
  ASSERT_TRUE(TimeZone::load("CET-1CEST,M3.5.0,M10.5.0/3"));
  const std::time_t second = 0;
  std::tm local{};
  ::localtime_r(&second, &local);
  EXPECT_EQ(local.tm_gmtoff, 5 * 3600);
  EXPECT_EQ(TimeZone::load("")->offset_ns(0), 5 * kHour) << "that of the machine";
  EXPECT_EQ(TimeZone::load("")->name(), "XYZ-5");
  ::unsetenv("TZ");
  ::tzset();
}

TEST(TimeZone, KnowsNoOtherNames) {
  for (const char* const name : {"Europe/Nowhere", "Berlin", "../etc/passwd", "/etc/localtime", "CE", "Europe", "MEZ,"})
    EXPECT_FALSE(TimeZone::load(name)) << name;
}

}  // namespace
}  // namespace plc::core
