// Messages that come too often are counted, and their number is told.
#include "log/limiter.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace plc::log {
namespace {

constexpr core::TimeNs kSecond = 1'000'000'000;

Record said(const std::string& text, const std::string& source = "panel") {
  Record record;
  record.severity = core::Severity::kWarning;
  record.text = text;
  record.source = source;
  return record;
}

std::vector<std::string> texts(const std::vector<Record>& records) {
  std::vector<std::string> all;
  for (const Record& record : records) all.push_back(record.text);
  return all;
}

TEST(Limiter, CountsARepetitionAndTellsItsNumber) {
  Limiter limiter(60 * kSecond, 200);
  EXPECT_TRUE(limiter.admit(said("the chip is gone"), 0));
  for (int i = 0; i < 412; ++i) EXPECT_FALSE(limiter.admit(said("the chip is gone"), kSecond + i));
  EXPECT_TRUE(limiter.sums(59 * kSecond, 1).empty());
  EXPECT_EQ(texts(limiter.sums(60 * kSecond, 1)),
            std::vector<std::string>{"the chip is gone (412 times more in 60 s)"});
  // It goes on: once in each window. Then it is new again.
  EXPECT_FALSE(limiter.admit(said("the chip is gone"), 61 * kSecond));
  EXPECT_EQ(texts(limiter.sums(120 * kSecond, 1)), std::vector<std::string>{"the chip is gone (1 time more in 60 s)"});
  EXPECT_TRUE(limiter.sums(180 * kSecond, 1).empty());
  EXPECT_TRUE(limiter.admit(said("the chip is gone"), 181 * kSecond));
}

TEST(Limiter, TellsMessagesApartByWhatTheySay) {
  Limiter limiter(60 * kSecond, 200);
  EXPECT_TRUE(limiter.admit(said("device 3 is silent"), 0));
  EXPECT_TRUE(limiter.admit(said("device 4 is silent"), 0));
  EXPECT_TRUE(limiter.admit(said("device 3 is silent", "other"), 0));
  Record scan = said("device 3 is silent");
  scan.scan = 17;
  scan.utc_ns = 5;
  EXPECT_FALSE(limiter.admit(scan, 0));
  scan.severity = core::Severity::kError;
  EXPECT_TRUE(limiter.admit(scan, 0));
}

TEST(Limiter, ASourceThatAlwaysSaysSomethingElseIsLimitedToo) {
  Limiter limiter(60 * kSecond, 10);
  int written = 0;
  for (int i = 0; i < 5000; ++i) written += limiter.admit(said("value " + std::to_string(i)), 0) ? 1 : 0;
  EXPECT_EQ(written, 10);
  EXPECT_TRUE(limiter.admit(said("of another one", "modbus"), 0)) << "no source takes from another";
  EXPECT_EQ(texts(limiter.sums(60 * kSecond, 1)),
            std::vector<std::string>{"panel: 4990 further messages in 60 s are left out"});
  EXPECT_TRUE(limiter.admit(said("value 5000"), 61 * kSecond));
}

TEST(Limiter, TheEndTellsWhatIsHeld) {
  Limiter limiter(60 * kSecond, 200);
  limiter.admit(said("a"), 0);
  limiter.admit(said("a"), 1);
  EXPECT_EQ(texts(limiter.sums(7 * kSecond, 1, true)), std::vector<std::string>{"a (1 time more in 7 s)"});
  EXPECT_TRUE(limiter.sums(8 * kSecond, 1, true).empty());
}

TEST(Limiter, LetsAllThroughWhenNoTimeIsGiven) {
  Limiter limiter(0, 1);
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(limiter.admit(said("a"), 0));
  EXPECT_TRUE(limiter.sums(kSecond, 1, true).empty());
}

}  // namespace
}  // namespace plc::log
