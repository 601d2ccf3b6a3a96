// Samples of any time in as many points as one wants: against a plain list of all of them; kills, full disks,
// retention.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>
#include <random>
#include <string>

#include "historian/history_file.h"
#include "historian/history_reader.h"

namespace plc::test {
namespace {

using namespace historian;
namespace fs = std::filesystem;
using core::TypeId;

struct Folder {
  Folder() {
    std::string name = fs::temp_directory_path() / "history-XXXXXX";
    path = ::mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path); }
  [[nodiscard]] std::string file() const { return path + "/history.db"; }
  std::string path;
};

constexpr core::TimeNs kBegin = 1'800'000'000 * kSecond;
constexpr std::uint64_t kMuch = 1'000'000'000'000;

/// Value of the sample at `ns` of the tag `Wave`; `Count` is the number of seconds, `On` whether it is odd.
float wave(core::TimeNs ns) { return static_cast<float>(std::sin(static_cast<double>(ns - kBegin) / 1e9 / 700) * 100); }

std::vector<Tag> tags() { return {{"Wave", TypeId::kReal}, {"Count", TypeId::kLint}, {"On", TypeId::kBool}}; }

void add(HistoryFile& file, core::TimeNs ns) {
  file.add(ns, [ns](std::size_t tag, std::byte* to) {
    const float real = wave(ns);
    const std::int64_t count = (ns - kBegin) / kSecond;
    const std::uint8_t on = count % 2 != 0 ? 1 : 0;
    if (tag == 0) std::memcpy(to, &real, sizeof real);
    if (tag == 1) std::memcpy(to, &count, sizeof count);
    if (tag == 2) std::memcpy(to, &on, sizeof on);
  });
}

TEST(Columns, ComeBackAsTheyWere) {
  Columns columns;
  std::mt19937_64 random(7);
  for (const std::uint32_t width : {1u, 2u, 4u, 8u, 32u}) {
    for (const std::size_t count : {0u, 1u, 600u, 5000u}) {
      std::vector<std::byte> values(count * width);
      for (std::byte& one : values) one = static_cast<std::byte>(random());
      const auto packed = columns.pack(values, width);
      const std::vector<std::byte> kept(packed.begin(), packed.end());
      const auto back = columns.unpack(kept, width);
      EXPECT_TRUE(std::equal(back.begin(), back.end(), values.begin(), values.end())) << width << " x " << count;
    }
  }
  const std::vector<std::byte> constant(600 * 8, std::byte{3});
  EXPECT_LT(columns.pack(constant, 8).size(), 60u);
  const std::vector<std::byte> rubbish(100, std::byte{0x55});
  EXPECT_TRUE(columns.unpack(rubbish, 8).empty());
}

/// What the reader must say: from all samples, one by one.
void compare(HistoryReader& reader, const std::vector<core::TimeNs>& samples, core::TimeNs from, core::TimeNs to,
             std::size_t points) {
  const auto course = reader.read("Wave", from, to, points);
  ASSERT_TRUE(course);
  ASSERT_LE(course->points.size(), points);
  Summary expected, got;
  for (const core::TimeNs ns : samples) {
    if (ns >= from && ns <= to) expected.add(static_cast<double>(wave(ns)));
  }
  std::int64_t before = 0;
  for (const Point& point : course->points) {
    EXPECT_GT(point.us, before);
    before = point.us;
    got.add(point.summary);
    // What a point says is true of the samples that it is made of: none is further off than the step.
    const core::TimeNs begin = point.us * 1000;
    const double middle = static_cast<double>(wave(begin + course->step_ns / 2));
    const double room = 2 * std::min(100.0, static_cast<double>(course->step_ns) / 1e9 / 7) + 1e-3;
    EXPECT_NEAR(point.summary.mean(), middle, room) << "at " << point.us;
    EXPECT_LE(point.summary.least, point.summary.mean() + 1e-9);
    EXPECT_GE(point.summary.greatest, point.summary.mean() - 1e-9);
  }
  if (expected.empty()) return;
  // Summaries at the ends may have samples just outside, within a step.
  const double room = std::min(200.0, static_cast<double>(course->step_ns) / 1e9 / 7) + 1e-3;
  EXPECT_LE(got.least, expected.least);
  EXPECT_GE(got.least, expected.least - room);
  EXPECT_GE(got.greatest, expected.greatest);
  EXPECT_LE(got.greatest, expected.greatest + room);
  EXPECT_GE(got.count, expected.count) << "no sample is missing, " << from << " to " << to << ", " << points;
  EXPECT_LE(got.count, expected.count + 2 * static_cast<double>(course->step_ns) / 1e9 + 2);
}

TEST(History, IsTheSameInEveryZoom) {
  const Folder folder;
  HistoryFile file(folder.file(), tags(), 3650, kMuch);
  HistoryReader reader(file);
  std::vector<core::TimeNs> samples;
  // Eleven hours, a sample a second, with an hour in which nothing ran.
  for (core::TimeNs ns = kBegin; ns < kBegin + 11 * 3600 * kSecond; ns += kSecond) {
    if (ns > kBegin + 2 * 3600 * kSecond && ns < kBegin + 3 * 3600 * kSecond) continue;
    add(file, ns);
    samples.push_back(ns);
  }
  EXPECT_EQ(file.take_said(), "");
  std::mt19937_64 random(11);
  for (int round = 0; round < 200; ++round) {
    const auto any = [&] {
      return kBegin - 600 * kSecond + static_cast<core::TimeNs>(random() % (12 * 3600)) * kSecond;
    };
    core::TimeNs from = any(), to = any();
    if (from > to) std::swap(from, to);
    if (round % 3 == 0) to = from + static_cast<core::TimeNs>(random() % 300) * kSecond;
    compare(reader, samples, from, to, 1 + random() % 2000);
  }
  // As many points as samples: the samples themselves, up to the last one, which is in no row yet.
  const core::TimeNs last = samples.back();
  const auto exact = reader.read("Wave", last - 99 * kSecond, last, 100);
  ASSERT_EQ(exact->points.size(), 100u);
  EXPECT_EQ(exact->step_ns, 0);
  EXPECT_EQ(exact->points.back().us, last / 1000);
  EXPECT_EQ(exact->points.back().summary.least, static_cast<double>(wave(last)));
  EXPECT_EQ(reader.read("Count", last, last, 10)->points.front().summary.least, 11 * 3600 - 1);
  const auto on = reader.read("On", kBegin, last, 10);
  EXPECT_NEAR(on->points.front().summary.mean(), 0.5, 0.01);
  EXPECT_FALSE(reader.read("Nothing", kBegin, last, 10));
  EXPECT_EQ(reader.begin_ns(), kBegin);
}

TEST(History, GoesOnInTheSameFile) {
  const Folder folder;
  {
    HistoryFile file(folder.file(), tags(), 30, kMuch);
    for (int s = 0; s < 100; ++s) add(file, kBegin + s * kSecond);
    file.flush();
  }
  // Other tags, in another order; one of them is another type now.
  HistoryFile file(folder.file(), {{"On", TypeId::kBool}, {"Count", TypeId::kDint}}, 30, kMuch);
  HistoryReader reader(file);
  const auto before = reader.read("Wave", kBegin, kBegin + 1000 * kSecond, 1000);
  ASSERT_TRUE(before) << "a tag that is kept no more can be read";
  EXPECT_EQ(before->points.size(), 100u);
  EXPECT_EQ(reader.read("On", kBegin, kBegin + 1000 * kSecond, 1000)->points.size(), 100u);
  EXPECT_TRUE(reader.read("Count", kBegin, kBegin + 1000 * kSecond, 1000)->points.empty()) << "of another type";
}

TEST(History, GoesOnUnderANameInAnotherLetterCase) {
  const Folder folder;
  {
    HistoryFile file(folder.file(), {{"WAVE", TypeId::kReal}}, 3650, kMuch);
    add(file, kBegin);
  }
  HistoryFile file(folder.file(), {{"Wave", TypeId::kReal}}, 3650, kMuch);
  add(file, kBegin + kSecond);
  HistoryReader reader(file);
  for (const char* const name : {"Wave", "wave"}) {
    const auto course = reader.read(name, kBegin, kBegin + 60 * kSecond, 100);
    ASSERT_TRUE(course) << name;
    EXPECT_EQ(course->points.size(), 2u) << name;
  }
}

TEST(History, RisesAfterAClockThatWasSetBack) {
  const Folder folder;
  HistoryFile file(folder.file(), tags(), 3650, kMuch);
  HistoryReader reader(file);
  for (core::TimeNs s = 0; s <= 50; ++s) add(file, kBegin + s * kSecond);
  for (core::TimeNs s = 20; s < 110; ++s) add(file, kBegin + s * kSecond + kSecond / 2);
  for (const std::size_t points : {1000u, 30u}) {
    const auto course = reader.read("Count", kBegin, kBegin + 150 * kSecond, points);
    ASSERT_TRUE(course);
    double count = 0;
    for (std::size_t i = 0; i < course->points.size(); ++i) {
      const Point& point = course->points[i];
      count += point.summary.count;
      EXPECT_TRUE(i == 0 || course->points[i - 1].us < point.us) << i;
      const double at = static_cast<double>(point.us * 1000 - kBegin) / 1e9;
      EXPECT_GE(point.summary.least, std::floor(at)) << "no sample stands in a stretch that is not its own";
      EXPECT_LE(point.summary.greatest, at + static_cast<double>(course->step_ns) / 1e9);
    }
    EXPECT_EQ(count, 51 + 90) << points;
  }
}

TEST(History, IsNotWrittenByTwo) {
  const Folder folder;
  HistoryFile first(folder.file(), tags(), 3650, kMuch);
  add(first, kBegin);
  HistoryFile second(folder.file(), tags(), 3650, kMuch);
  EXPECT_NE(second.take_said().find("another plc-run writes it"), std::string::npos);
}

TEST(History, LosesSomeSecondsByAKill) {
  const Folder folder;
  for (int round = 0; round < 10; ++round) {
    const core::TimeNs begin = kBegin + round * 1000 * kSecond;
    const int seconds = 30 + round * 13;
    const pid_t child = ::fork();
    if (child == 0) {
      HistoryFile file(folder.file(), tags(), 30, kMuch);
      for (int s = 0; s < seconds; ++s) add(file, begin + s * kSecond);
      ::kill(::getpid(), SIGKILL);
    }
    ::waitpid(child, nullptr, 0);
    HistoryFile file(folder.file(), tags(), 30, kMuch);
    EXPECT_EQ(file.take_said(), "");
    HistoryReader reader(file);
    const auto course = reader.read("Wave", begin, begin + 1000 * kSecond, 1000);
    ASSERT_TRUE(course);
    EXPECT_GE(course->points.size(), static_cast<std::size_t>(seconds - 6)) << "round " << round;
    for (const Point& point : course->points)
      EXPECT_EQ(point.summary.least, static_cast<double>(wave(point.us * 1000))) << point.us;
  }
}

TEST(History, SaysThatTheDiskIsFullAndGoesOn) {
  const Folder folder;
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  HistoryFile file(folder.file(), tags(), 30, kMuch);
  core::TimeNs ns = kBegin;
  for (int s = 0; s < 130; ++s, ns += kSecond) add(file, ns);
  EXPECT_EQ(file.take_said(), "");
  const rlimit full{1, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &full);
  for (int s = 0; s < 300; ++s, ns += kSecond) add(file, ns);
  const std::string said = file.take_said();
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(said.find("cannot be written"), std::string::npos) << said;
  for (int s = 0; s < 70; ++s, ns += kSecond) add(file, ns);
  EXPECT_NE(file.take_said().find("is written again"), std::string::npos);
  file.flush();
  HistoryReader reader(file);
  EXPECT_EQ(reader.read("Wave", kBegin, ns, 1000)->points.size(), 500u) << "what waited is there";
}

TEST(History, KeepsWhatItsAgeAndSizeAllow) {
  const Folder folder;
  HistoryFile file(folder.file(), tags(), 1, kMuch);
  HistoryReader reader(file);
  for (core::TimeNs ns = kBegin; ns < kBegin + 30 * 3600 * kSecond; ns += 2 * kSecond) add(file, ns);
  // A row of summaries that has some of the last day in it is kept as a whole: of five hours.
  EXPECT_GE(reader.begin_ns(), kBegin + 5 * 3600 * kSecond);
  EXPECT_LT(reader.begin_ns(), kBegin + 7 * 3600 * kSecond);
  // By size: random samples that need about 40 bytes each.
  const Folder small;
  constexpr std::uint64_t kMost = 1'000'000;
  std::vector<Tag> many;
  for (int i = 0; i < 10; ++i) many.push_back({"T" + std::to_string(i), TypeId::kReal});
  HistoryFile bounded(small.file(), many, 30, kMost);
  std::mt19937 random(3);
  for (core::TimeNs ns = kBegin; ns < kBegin + 12 * 3600 * kSecond; ns += kSecond) {
    bounded.add(ns, [&](std::size_t, std::byte* to) {
      const auto value = static_cast<float>(random());
      std::memcpy(to, &value, sizeof value);
    });
  }
  EXPECT_EQ(bounded.take_said(), "");
  EXPECT_LT(fs::file_size(small.file()), kMost + kMost / 2);
  HistoryReader newest(bounded);
  const core::TimeNs end = kBegin + 12 * 3600 * kSecond;
  EXPECT_EQ(newest.read("T0", end - 600 * kSecond, end, 1000)->points.size(), 600u);
}

TEST(History, IsWholeAfterAClockThatWasAhead) {
  const Folder folder;
  HistoryFile file(folder.file(), tags(), 3650, kMuch);
  HistoryReader reader(file);
  std::vector<core::TimeNs> samples;
  const auto run = [&](core::TimeNs begin, core::TimeNs seconds) {
    for (core::TimeNs ns = begin; ns < begin + seconds * kSecond; ns += kSecond) {
      add(file, ns);
      samples.push_back(ns);
    }
  };
  // Two hours ahead for some minutes, until the right time comes.
  run(kBegin + 7200 * kSecond, 1500);
  samples.clear();
  run(kBegin, 5400);
  for (const std::size_t points : {5u, 60u, 500u}) {
    compare(reader, samples, kBegin, kBegin + 5000 * kSecond, points);
    compare(reader, samples, kBegin + 1000 * kSecond, kBegin + 4000 * kSecond, points);
  }
  // And past the time that it had before.
  run(kBegin + 5400 * kSecond, 9000);
  for (const std::size_t points : {5u, 60u, 500u}) compare(reader, samples, kBegin, kBegin + 14000 * kSecond, points);
  EXPECT_EQ(file.take_said(), "");
}

TEST(History, KeepsAllButADayUnderAClockThatIsAheadForAMoment) {
  const Folder folder;
  constexpr core::TimeNs kHour = 3600 * kSecond;
  {
    HistoryFile file(folder.file(), tags(), 30, kMuch);
    for (core::TimeNs ns = kBegin; ns < kBegin + 60 * kHour; ns += 30 * kSecond) add(file, ns);
  }
  HistoryFile file(folder.file(), tags(), 30, kMuch);
  for (int minute = 0; minute < 5; ++minute) add(file, kBegin + (365 * 24 + 1) * kHour + minute * 60 * kSecond);
  for (int minute = 0; minute < 5; ++minute) add(file, kBegin + 61 * kHour + minute * 60 * kSecond);
  file.flush();
  EXPECT_EQ(file.take_said(), "");
  HistoryReader reader(file);
  EXPECT_EQ(reader.read("Wave", kBegin + 25 * kHour, kBegin + 26 * kHour - 1, 1000)->points.size(), 120u);
  EXPECT_EQ(reader.read("Wave", kBegin + 59 * kHour, kBegin + 60 * kHour, 1000)->points.size(), 120u);
}

}  // namespace
}  // namespace plc::test
