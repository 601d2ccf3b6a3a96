// FILE_LOGGER against the file it leaves.
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "picard/testing.h"
#include "taskblocks/set.h"
#include "taskblocks/signals/csv_log.h"

namespace plc::blocks {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Why ready() refuses, "" when it does not.
template <class Block>
std::string refusal(Block&& block) {
  try {
    block.ready();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

/// A directory of its own that PICARD_LOG_DIRECTORY names.
class FileLogger : public testing::Test {
 protected:
  FileLogger() {
    std::string name = (fs::temp_directory_path() / "file_logger_XXXXXX").string();
    directory = mkdtemp(name.data());
    setenv("PICARD_LOG_DIRECTORY", directory.c_str(), 1);
  }
  ~FileLogger() override {
    unsetenv("PICARD_LOG_DIRECTORY");
    fs::remove_all(directory);
  }
  static std::unique_ptr<picard::Instance> logger(std::string_view columns, std::string_view if_exists = "NUMBER",
                                                  std::string_view file = "log.csv") {
    auto block = std::make_unique<picard::Instance>(signals_library(), "FILE_LOGGER", milliseconds(1));
    block->port<picard::Text<200>>("COLUMNS") = columns;
    block->port<picard::Text<16>>("IF_EXISTS") = if_exists;
    block->port<picard::Text<80>>("FILE") = file;
    return block;
  }
  /// Fires without a line until the writer's thread shows `error`. False when it does not come to it.
  static bool shows_error(picard::Instance& log, std::int32_t error) {
    log.port<bool>("ENABLE") = false;
    for (int i = 0; i < 1000; ++i) {
      log.fire();
      if (log.port<std::int32_t>("ERROR") == error) return true;
      std::this_thread::sleep_for(milliseconds(10));
    }
    return false;
  }
  [[nodiscard]] std::vector<std::string> lines(const std::string& file) const {
    std::vector<std::string> all;
    std::ifstream in(directory / file);
    for (std::string line; std::getline(in, line);) all.push_back(line);
    return all;
  }
  [[nodiscard]] std::string text(const std::string& file) const {
    std::ifstream in(directory / file);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  fs::path directory;
};

std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) all.push_back(field);
  return all;
}

TEST_F(FileLogger, WritesEachExecutionAsALine) {
  {
    const auto log = logger("speed, load[1]");
    for (int i = 0; i < 100; ++i) {
      log->port<double>("IN1") = i / 3.0;
      log->port<double>("IN2") = -i;
      log->port<bool>("ENABLE") = i % 2 == 0;
      log->fire();
    }
    EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), 0U);
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), 0);
  }
  const std::vector<std::string> all = lines("log.csv");
  ASSERT_EQ(all.size(), 51U);
  EXPECT_EQ(all[0], "utc,time_s,speed,load[1]");
  for (int i = 0; i < 50; ++i) {
    const std::vector<std::string> line = fields(all[static_cast<std::size_t>(i) + 1]);
    ASSERT_EQ(line.size(), 4U);
    EXPECT_EQ(line[1], "0.0" + std::string(i < 5 ? "0" : "") + std::to_string(2 * i) + "000000") << i;
    EXPECT_EQ(std::stod(line[2]), 2 * i / 3.0) << "must read back the same";
    EXPECT_EQ(line[3], std::to_string(-2 * i)) << i;
  }
}

TEST_F(FileLogger, TheDateIsThatOfTheFirstLinePlusTheTimeSince) {
  const auto before = std::chrono::system_clock::now();
  {
    const auto log = logger("x");
    for (int i = 0; i < 2500; ++i) log->fire();  // 2.5 s by the task's clock
  }
  const auto after = std::chrono::system_clock::now();
  const std::vector<std::string> all = lines("log.csv");
  const auto seconds = [](const std::string& line) {
    std::tm date{};
    const std::string utc = fields(line).at(0);
    const char* const rest = strptime(utc.c_str(), "%Y-%m-%dT%H:%M:%S", &date);
    EXPECT_EQ(utc.back(), 'Z');
    return static_cast<double>(timegm(&date)) + std::strtod(rest, nullptr);
  };
  const double first = seconds(all.at(1));
  EXPECT_GE(first, std::chrono::duration<double>(before.time_since_epoch()).count() - 1e-5);
  EXPECT_LE(first, std::chrono::duration<double>(after.time_since_epoch()).count());
  EXPECT_NEAR(seconds(all.at(2500)) - first, 2.499, 1e-5);
}

TEST_F(FileLogger, DropsWhatDoesNotFitIntoTheRingAndCountsIt) {
  constexpr std::uint64_t kLines = 20000;
  std::uint64_t dropped = 0;
  {
    const auto log = logger("x");
    log->port<std::int32_t>("BUFFER") = 16;
    for (std::uint64_t i = 0; i < kLines; ++i) {
      log->port<double>("IN1") = static_cast<double>(i);
      log->fire();
    }
    dropped = log->port<std::uint64_t>("DROPPED");
    EXPECT_GT(dropped, 0U);
  }
  const std::vector<std::string> all = lines("log.csv");
  EXPECT_EQ(all.size() - 1 + dropped, kLines);
  double last = -1;
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double value = std::stod(fields(all[i]).at(2));
    EXPECT_GT(value, last) << "lines keep their order";
    last = value;
  }
}

TEST_F(FileLogger, AllThatIsPacedIsWritten) {
  const auto log = logger("x");
  log->ready();
  for (int i = 0; i < 50; ++i) {
    for (int j = 0; j < 100; ++j) log->fire();
    std::this_thread::sleep_for(milliseconds(1));
  }
  // fire() shows what was written before it: the count comes after the writer's next round.
  for (int i = 0; i < 500 && log->port<std::uint64_t>("WRITTEN") < 5000; ++i) {
    std::this_thread::sleep_for(milliseconds(10));
    log->port<bool>("ENABLE") = false;
    log->fire();
  }
  EXPECT_EQ(log->port<std::uint64_t>("WRITTEN"), 5000U);
  EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), 0U);
  EXPECT_EQ(lines("log.csv").size(), 5001U) << "also while it runs";
}

TEST_F(FileLogger, NumbersFilesThatAreThereAndOverwritesNone) {
  for (int i = 0; i < 3; ++i) {
    const auto log = logger("x");
    log->port<double>("IN1") = i;
    log->fire();
  }
  EXPECT_EQ(fields(lines("log.csv").at(1)).at(2), "0");
  EXPECT_EQ(fields(lines("log-1.csv").at(1)).at(2), "1");
  EXPECT_EQ(fields(lines("log-2.csv").at(1)).at(2), "2");
  EXPECT_TRUE(shows_error(*logger("x", "REFUSE"), EEXIST));
  EXPECT_EQ(lines("log.csv").size(), 2U);
}

TEST_F(FileLogger, AppendsToTheFirstFileWithTheSameColumns) {
  for (int i = 0; i < 3; ++i) {
    const auto log = logger("a,b", "APPEND");
    log->fire();
  }
  EXPECT_EQ(lines("log.csv").size(), 4U);
  logger("a,c", "APPEND")->fire();
  logger("a", "APPEND")->fire();
  logger("a,c", "APPEND")->fire();
  EXPECT_EQ(lines("log.csv").size(), 4U);
  EXPECT_EQ(lines("log-1.csv").size(), 3U);
  EXPECT_EQ(lines("log-2.csv").size(), 2U);
}

TEST_F(FileLogger, EndsALineThatALossOfPowerLeftUnfinished) {
  std::ofstream(directory / "log.csv") << "utc,time_s,a\n2024-01-01T00:00:00.000000Z,0.0000";
  logger("a", "APPEND")->fire();
  const std::vector<std::string> all = lines("log.csv");
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[1], "2024-01-01T00:00:00.000000Z,0.0000");
  EXPECT_EQ(fields(all[2]).size(), 3U);
}

TEST_F(FileLogger, MendsWhatALossOfPowerLeftOfAFile) {
  using namespace std::string_literals;
  const std::string line = "2024-01-01T00:00:00.000000Z,0.000000000,1\n";
  struct Case {
    std::string there;
    std::size_t lines;
  };
  const Case cases[] = {
      {"", 2},
      {"utc,ti", 2},
      {"utc,time_s,a", 2},
      {"utc,ti"s + std::string(9000, '\0'), 2},
      {std::string(4096, '\0'), 2},
      {"utc,time_s,a\n" + line + std::string(5000, '\0'), 3},
      {"utc,time_s,a\n" + line + "2024-01-01T0"s + std::string(3, '\0'), 4},
  };
  for (const Case& c : cases) {
    std::ofstream(directory / "log.csv", std::ios::binary) << c.there;
    logger("a", "APPEND")->fire();
    const std::vector<std::string> all = lines("log.csv");
    ASSERT_EQ(all.size(), c.lines) << c.there.size();
    EXPECT_EQ(all[0], "utc,time_s,a");
    EXPECT_EQ(text("log.csv").find('\0'), std::string::npos) << c.there.size();
    EXPECT_FALSE(fs::exists(directory / "log-1.csv"));
  }
}

TEST_F(FileLogger, TwoDoNotWriteOneFile) {
  auto first = logger("a", "APPEND");
  ASSERT_TRUE(shows_error(*first, 0));
  for (int i = 0; i < 500 && !fs::exists(directory / "log.csv"); ++i) std::this_thread::sleep_for(milliseconds(10));
  const auto second = logger("a", "APPEND");
  EXPECT_TRUE(shows_error(*second, EWOULDBLOCK));
  first.reset();
  EXPECT_TRUE(shows_error(*second, 0)) << "it is tried again";
}

TEST_F(FileLogger, StartsWithoutItsDirectoryAndWritesWhenThatIsThere) {
  const fs::path later = directory / "later";
  setenv("PICARD_LOG_DIRECTORY", later.c_str(), 1);
  {
    const auto log = logger("x");
    for (int i = 0; i < 10; ++i) log->fire();
    EXPECT_TRUE(shows_error(*log, ENOENT));
    EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), 0U) << "lines wait";
    fs::create_directory(later);
    EXPECT_TRUE(shows_error(*log, 0));
    const auto told = log->told();
    ASSERT_EQ(told.size(), 2U);
    EXPECT_EQ(told[0].text, "log.csv is not written: No such file or directory; it is tried again");
    EXPECT_EQ(told[0].severity, picard::Severity::Warning);
    EXPECT_EQ(told[1].text, "log.csv is written again");
  }
  EXPECT_EQ(lines("later/log.csv").size(), 11U);
}

TEST_F(FileLogger, StartsWhenAllNumbersAreTaken) {
  std::ofstream(directory / "log.csv") << "1";
  for (int i = 1; i <= 9999; ++i) std::ofstream(directory / ("log-" + std::to_string(i) + ".csv"));
  const auto log = logger("x");
  EXPECT_TRUE(shows_error(*log, EEXIST));
  fs::remove(directory / "log-77.csv");
  EXPECT_TRUE(shows_error(*log, 0));
}

/// A disk of 1 MB, seen by this process alone; empty where the system gives none.
std::string small_disk(const fs::path& at) {
  fs::create_directory(at);
  if (unshare(CLONE_NEWNS) != 0) return std::string("no mount namespace: ") + std::strerror(errno);
  if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return std::strerror(errno);
  if (mount("none", at.c_str(), "tmpfs", 0, "size=1m") != 0) return std::strerror(errno);
  return "";
}

TEST_F(FileLogger, GoesOnWhenAFullDiskHasSpaceAgain) {
  const fs::path disk = directory / "disk";
  if (const std::string why = small_disk(disk); !why.empty()) GTEST_SKIP() << "needs to mount a small disk: " << why;
  setenv("PICARD_LOG_DIRECTORY", disk.c_str(), 1);
  const auto fill = [&] { std::ofstream(disk / "rubbish") << std::string(2'000'000, 'x') << std::flush; };
  fill();
  {
    const auto log = logger("x", "APPEND");
    for (int i = 0; i < 100; ++i) log->fire();
    EXPECT_TRUE(shows_error(*log, ENOSPC)) << "full at the start";
    fs::remove(disk / "rubbish");
    EXPECT_TRUE(shows_error(*log, 0));
    fill();
    log->port<bool>("ENABLE") = true;
    // What is left of the last page of the file is less than this.
    for (int i = 0; i < 3000; ++i) log->fire();
    EXPECT_TRUE(shows_error(*log, ENOSPC)) << "full while it runs";
    fs::remove(disk / "rubbish");
    EXPECT_TRUE(shows_error(*log, 0));
  }
  EXPECT_EQ(lines("disk/log.csv").size(), 3101U) << "nothing is lost that fits into the ring";
  EXPECT_EQ(lines("disk/log.csv").at(0), "utc,time_s,x");
  umount(disk.c_str());
}

std::atomic<std::int64_t> clock_step{0};
std::int64_t stepped_clock() noexcept { return CsvLog::utc_now_ns() + clock_step.load(); }

TEST_F(FileLogger, TheDateFollowsTheClockOfTheMachine) {
  CsvLog::Options options;
  options.directory = directory;
  options.file = "log.csv";
  options.columns = {"x"};
  options.utc_ns = stepped_clock;
  constexpr std::int64_t kDay = 86'400'000'000'000;
  clock_step = -20'000 * kDay;
  {
    CsvLog log(options);
    const auto written = [&](std::uint64_t count) {
      for (int i = 0; i < 1000 && log.written() < count; ++i) std::this_thread::sleep_for(milliseconds(10));
      return log.written() == count;
    };
    ASSERT_TRUE(log.push({1'000'000'000, {}}));
    ASSERT_TRUE(written(1));
    clock_step = 0;
    ASSERT_TRUE(log.push({2'000'000'000, {}}));
    ASSERT_TRUE(written(2));
    clock_step = -kDay;
    ASSERT_TRUE(log.push({3'000'000'000, {}}));
    ASSERT_TRUE(written(3));
  }
  const std::vector<std::string> all = lines("log.csv");
  ASSERT_EQ(all.size(), 4U);
  const auto day = [&](std::size_t line) {
    std::tm date{};
    strptime(all.at(line).c_str(), "%Y-%m-%dT%H:%M:%S", &date);
    return static_cast<double>(timegm(&date)) / 86'400;
  };
  EXPECT_NEAR(day(2) - day(1), 20'000, 1e-3);
  EXPECT_NEAR(day(3) - day(2), -1, 1e-3);
  EXPECT_EQ(fields(all[3]).at(1), "2.000000000") << "the other time does not jump";
}

TEST_F(FileLogger, RefusesWhatIsNoFileNameInItsDirectory) {
  for (const char* const bad : {"", "..", ".", "../log.csv", "a/b.csv", "/log.csv", ".hidden", "-rf", "a b", "a\nb"}) {
    EXPECT_NE(refusal(*logger("x", "NUMBER", bad)).find("is not a name of"), std::string::npos) << bad;
  }
  EXPECT_TRUE(fs::is_empty(directory));
  EXPECT_EQ(refusal(*logger("x", "REFUSED")), "IF_EXISTS is none of NUMBER, APPEND, REFUSE");
  setenv("PICARD_LOG_DIRECTORY", (directory / "none").c_str(), 1);
  EXPECT_TRUE(shows_error(*logger("x"), ENOENT));
}

TEST_F(FileLogger, FollowsNoLinkAndWaitsForNoPipe) {
  std::ofstream(directory / "target") << "utc,time_s,x\n";  // what APPEND would go on with
  fs::create_symlink("target", directory / "log.csv");
  EXPECT_TRUE(shows_error(*logger("x", "REFUSE"), EEXIST));
  logger("x", "APPEND")->fire();
  logger("x", "NUMBER")->fire();
  EXPECT_EQ(text("target"), "utc,time_s,x\n");
  EXPECT_EQ(lines("log-1.csv").size(), 2U);
  EXPECT_EQ(lines("log-2.csv").size(), 2U);
  ASSERT_EQ(mkfifo((directory / "pipe").c_str(), 0600), 0);
  logger("x", "APPEND", "pipe")->fire();
  EXPECT_EQ(lines("pipe-1").size(), 2U);
}

TEST_F(FileLogger, RefusesNamesOfColumnsThatWouldSpoilTheFile) {
  for (const char* const bad : {"", "a,,b", "a,", "a\"", "a;b", "a b"}) {
    EXPECT_NE(refusal(*logger(bad)).find("COLUMNS has a name"), std::string::npos) << bad;
  }
  EXPECT_EQ(refusal(*logger("1,2,3,4,5,6,7,8,9")), "COLUMNS has more than 8 names");
  EXPECT_EQ(refusal(*logger("1,2,3,4,5,6,7,8")), "");
}

TEST_F(FileLogger, StopsAtItsLimitWithWholeLines) {
  std::uint64_t written = 0;
  std::uint64_t dropped = 0;
  constexpr int kLines = 60000;  // of 40 bytes or more: 1 MB are some 20000
  {
    const auto log = logger("x");
    log->port<std::int32_t>("LIMIT") = 1;
    log->port<std::int32_t>("BUFFER") = 65536;
    for (int i = 0; i < kLines; ++i) log->fire();
    log->port<bool>("ENABLE") = false;
    for (int i = 0; i < 500 && log->port<std::int32_t>("ERROR") == 0; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
    }
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), EFBIG);
    for (int i = 0; i < 500 && written + dropped < kLines; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
      written = log->port<std::uint64_t>("WRITTEN");
      dropped = log->port<std::uint64_t>("DROPPED");
    }
    EXPECT_EQ(written + dropped, static_cast<std::uint64_t>(kLines));
    log->port<bool>("ENABLE") = true;
    log->fire();
    EXPECT_EQ(log->port<std::uint64_t>("DROPPED"), dropped + 1);
  }
  EXPECT_LE(fs::file_size(directory / "log.csv"), 1'000'000U);
  EXPECT_GT(fs::file_size(directory / "log.csv"), 900'000U);
  EXPECT_EQ(text("log.csv").back(), '\n');
  EXPECT_EQ(lines("log.csv").size(), written + 1);
}

TEST_F(FileLogger, LeavesWholeLinesWhenTheSystemRefusesToWrite) {
  // The system's own limit of files: the write is cut short first, then refused with a signal that would end the
  // process if the writer did not block it.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{100'000, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::uint64_t written = 0;
  std::uint64_t dropped = 0;
  {
    const auto log = logger("x");
    log->port<std::int32_t>("LIMIT") = 0;
    log->port<std::int32_t>("BUFFER") = 65536;
    for (int i = 0; i < 10000; ++i) log->fire();
    log->port<bool>("ENABLE") = false;
    for (int i = 0; i < 500 && written + dropped < 10000; ++i) {
      std::this_thread::sleep_for(milliseconds(10));
      log->fire();
      written = log->port<std::uint64_t>("WRITTEN");
      dropped = log->port<std::uint64_t>("DROPPED");
    }
    EXPECT_EQ(log->port<std::int32_t>("ERROR"), EFBIG);
  }
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(written + dropped, 10000U);
  EXPECT_EQ(text("log.csv").back(), '\n');
  EXPECT_EQ(lines("log.csv").size(), written + 1);
}

TEST_F(FileLogger, WritesValuesThatAreNoNumbersAsWords) {
  {
    const auto log = logger("a,b,c");
    log->port<double>("IN1") = std::abs(kNan);
    log->port<double>("IN2") = kInfinity;
    log->port<double>("IN3") = -kInfinity;
    log->fire();
  }
  EXPECT_NE(lines("log.csv").at(1).find(",nan,inf,-inf"), std::string::npos);
}

}  // namespace
}  // namespace plc::blocks
