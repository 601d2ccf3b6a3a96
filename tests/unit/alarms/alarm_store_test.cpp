// The history of alarms over restarts, over a kill at any time and with a disk that refuses.
#include "alarms/alarm_store.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

namespace plc::test {
namespace {

using namespace alarms;
namespace fs = std::filesystem;

struct Folder {
  Folder() {
    std::string name = fs::temp_directory_path() / "alarms-XXXXXX";
    path = ::mkdtemp(name.data());
  }
  ~Folder() { fs::remove_all(path); }
  std::string path;
};

Event event(std::int64_t number, const std::string& alarm = "High") {
  Event made;
  made.number = number;
  made.what = number % 2 == 1 ? Happened::kRaised : Happened::kReturned;
  made.alarm = alarm;
  made.text = "Level is too high";
  made.priority = Priority::kHigh;
  made.utc_ns = number * 1'000'000'000;
  made.task = "Fast";
  made.scan = static_cast<std::uint64_t>(number * 10);
  made.value = 91.5;
  return made;
}

TEST(AlarmStore, KeepsEventsAndStates) {
  const Folder folder;
  std::vector<std::string> said;
  {
    AlarmStore store(folder.path, said);
    store.start();
    store.add({event(1), event(2), event(3, "Low")}, {{"High", 5, 77, 3}, {"High", 7, std::nullopt, 4}});
    store.stop();
  }
  AlarmStore store(folder.path, said);
  EXPECT_TRUE(said.empty()) << said.front();
  EXPECT_EQ(fs::status(folder.path + "/alarms.db").permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(store.last_number(), 3);
  ASSERT_EQ(store.states().size(), 1u);
  EXPECT_EQ(store.states()[0].packed, 7) << "the last one counts";
  EXPECT_FALSE(store.states()[0].shelved_until_ns);
  const auto all = store.read({});
  ASSERT_EQ(all.size(), 3u);
  EXPECT_EQ(all[0].number, 3) << "the newest first";
  EXPECT_EQ(all[2].scan, 10u);
  EXPECT_EQ(all[2].value, 91.5);
  EXPECT_EQ(all[2].priority, Priority::kHigh);
  EXPECT_EQ(store.read({.before = 3}).size(), 2u);
  EXPECT_EQ(store.read({.alarm = "low"}).size(), 1u);
  EXPECT_EQ(store.read({.from_ns = 2'000'000'000}).size(), 2u);
  EXPECT_EQ(store.read({.to_ns = 2'000'000'000}).size(), 2u);
  EXPECT_EQ(store.read({.most = 1}).size(), 1u);
}

TEST(AlarmStore, KnowsWhoHasSaidWhatSinceItWasRaised) {
  const Folder folder;
  std::vector<std::string> said;
  {
    AlarmStore store(folder.path, said);
    store.start();
    Event seen = event(2);
    seen.what = Happened::kAcknowledged;
    seen.user = "otto";
    seen.comment = "seen";
    Event shelved = event(4, "Low");
    shelved.what = Happened::kShelved;
    shelved.user = "anna";
    shelved.comment = "sensor is being changed";
    store.add({event(1), seen, event(3, "Low"), shelved, event(5)}, {{"High", 3, std::nullopt, 5}, {"Low", 1, 99, 3}});
    store.stop();
  }
  AlarmStore store(folder.path, said);
  const auto states = store.states();
  ASSERT_EQ(states.size(), 2u);
  EXPECT_EQ(states[0].user + states[0].comment, "") << "High was raised again since";
  EXPECT_EQ(states[1].user + ": " + states[1].comment, "anna: sensor is being changed");
}

TEST(AlarmStore, IsNotWrittenByTwo) {
  const Folder folder;
  std::vector<std::string> said;
  auto first = std::make_unique<AlarmStore>(folder.path, said);
  first->start();
  first->add({event(1), event(2)}, {});
  ASSERT_TRUE(said.empty()) << said.front();
  AlarmStore second(folder.path, said);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("another plc-run writes it"), std::string::npos) << said[0];
  second.start();
  second.add({event(1, "Other")}, {});
  first.reset();
  std::string again;
  for (int i = 0; i < 2000 && again.empty(); ++i) {
    again = second.take_said();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto all = second.read({});
  ASSERT_EQ(all.size(), 3u) << "what waited comes behind what the first one has written";
  EXPECT_EQ(all[0].alarm, "Other");
}

TEST(AlarmStore, IsWholeAfterAKill) {
  const Folder folder;
  std::int64_t last = 0;
  for (int round = 0; round < 10; ++round) {
    int pipes[2];
    ASSERT_EQ(::pipe(pipes), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      std::vector<std::string> said;
      AlarmStore store(folder.path, said);
      store.start();
      for (std::int64_t i = last + 1;; ++i) {
        store.add({event(i)}, {{"High", i, std::nullopt, i}});
        const char byte = 1;
        if (i == last + 200 && ::write(pipes[1], &byte, 1) != 1) ::_exit(1);
        ::usleep(20);
      }
    }
    char byte = 0;
    ASSERT_EQ(::read(pipes[0], &byte, 1), 1);
    ::usleep(static_cast<useconds_t>(1000 * (1 + round * 7 % 20)));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ::close(pipes[0]);
    ::close(pipes[1]);
    std::vector<std::string> said;
    AlarmStore store(folder.path, said);
    EXPECT_TRUE(said.empty()) << said.front();
    const std::int64_t now = store.last_number();
    EXPECT_GT(now, last) << "round " << round;
    EXPECT_EQ(store.read({.most = 1'000'000}).size(), static_cast<std::size_t>(now))
        << "no event in between is missing";
    ASSERT_EQ(store.states().size(), 1u);
    EXPECT_EQ(store.states()[0].packed, now) << "state and events are of one moment";
    last = now;
  }
}

TEST(AlarmStore, SaysThatTheDiskRefusesAndGoesOn) {
  const Folder folder;
  const auto wait_for = [](AlarmStore& store) {
    std::string said;
    for (int i = 0; i < 2000 && said.empty(); ++i) {
      said = store.take_said();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return said;
  };
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  std::vector<std::string> said;
  AlarmStore store(folder.path, said);
  store.start();
  // A full disk: no file may grow.
  const rlimit none{1, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &none);
  store.add({event(1)}, {});
  const std::string trouble = wait_for(store);
  store.add({event(2)}, {});
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NE(trouble.find("cannot be written"), std::string::npos) << trouble;
  EXPECT_NE(wait_for(store).find("is written again"), std::string::npos);
  EXPECT_EQ(store.read({}).size(), 2u) << "what waited is there";
}

TEST(AlarmStore, BeginsAnewWhereTheFileIsNoDatabase) {
  const Folder folder;
  std::ofstream(folder.path + "/alarms.db") << std::string(5000, 'x');
  std::vector<std::string> said;
  AlarmStore store(folder.path, said);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_NE(said[0].find("alarms.db.broken"), std::string::npos) << said[0];
  EXPECT_TRUE(fs::exists(folder.path + "/alarms.db.broken"));
  store.start();
  store.add({event(1)}, {});
  store.stop();
  EXPECT_EQ(store.read({}).size(), 1u);
}

TEST(AlarmStore, GoesOnBehindWhatIsThereWhenItCanBeOpenedLater) {
  const Folder folder;
  std::vector<std::string> said;
  {
    AlarmStore store(folder.path, said);
    store.start();
    store.add({event(1), event(2), event(3, "Low")}, {});
    store.stop();
  }
  ASSERT_TRUE(said.empty()) << said.front();
  const std::string file = folder.path + "/alarms.db", aside = folder.path + "/aside";
  fs::rename(file, aside);
  fs::create_directory(file);
  AlarmStore store(folder.path, said);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(store.last_number(), 0);
  store.start();
  store.add({event(1, "New")}, {});
  fs::remove(file);
  fs::rename(aside, file);
  std::string again;
  for (int i = 0; i < 2000 && again.empty(); ++i) {
    again = store.take_said();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_NE(again.find("is written again"), std::string::npos) << again;
  store.add({event(2, "Newer")}, {});
  store.stop();
  const auto all = store.read({});
  ASSERT_EQ(all.size(), 5u) << "nothing is overwritten";
  EXPECT_EQ(all[0].alarm + " " + std::to_string(all[0].number), "Newer 5");
  EXPECT_EQ(all[1].alarm + " " + std::to_string(all[1].number), "New 4");
  EXPECT_EQ(all[2].alarm + " " + std::to_string(all[2].number), "Low 3");
}

}  // namespace
}  // namespace plc::test
