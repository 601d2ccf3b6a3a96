// plc-run as a service of systemd: what it tells the service manager.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/plc_run.h"
#include "tests/tools/fixture.h"

namespace plc::test {
namespace {

/// A service manager that listens: each datagram is one entry.
class Manager {
 public:
  explicit Manager(const std::string& watchdog_us) : path_(scratch_.file("notify")) {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    if (!watchdog_us.empty()) ::setenv("WATCHDOG_USEC", watchdog_us.c_str(), 1);
    reader_ = std::thread([this] { read(); });
  }
  ~Manager() {
    end();
    ::close(socket_);
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  /// All that was told, after the program has ended.
  const std::vector<std::string>& told() {
    end();
    return told_;
  }
  [[nodiscard]] std::size_t count(const std::string& text) {
    const auto& all = told();
    return static_cast<std::size_t>(std::count(all.begin(), all.end(), text));
  }

 private:
  void end() {
    ended_ = true;
    if (reader_.joinable()) reader_.join();
  }
  void read() {
    char text[512];
    for (;;) {
      pollfd descriptor{socket_, POLLIN, 0};
      if (::poll(&descriptor, 1, 20) > 0) {
        const ssize_t n = ::recv(socket_, text, sizeof text, 0);
        if (n > 0) told_.emplace_back(text, static_cast<std::size_t>(n));
      } else if (ended_) {
        return;
      }
    }
  }

  ScratchFolder scratch_;
  std::string path_;
  int socket_ = -1;
  std::atomic<bool> ended_{false};
  std::thread reader_;
  std::vector<std::string> told_;
};

std::string plant(const std::string& body) {
  return "PROGRAM Main VAR n : DINT; x : LREAL; END_VAR\n" + body +
         "\nEND_PROGRAM\n"
         "CONFIGURATION C RESOURCE R ON PLC TASK T(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM main WITH T : Main; "
         "END_RESOURCE END_CONFIGURATION\n";
}

TEST(Service, IsToldThatThePlantRunsAndThatItEnds) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, plant("n := n + 1;"));
  Manager manager("400000");
  const auto result = run_plant({file, "--duration", "1500ms"});
  EXPECT_EQ(result.code, 0) << result.all();
  const auto& told = manager.told();
  ASSERT_GE(told.size(), 4u);
  EXPECT_EQ(told.front(), "READY=1\nSTATUS=runs " + file);
  // What takes its time after it still feeds the watchdog (end_guard.h).
  EXPECT_EQ(manager.count("STOPPING=1\nSTATUS=outputs go to their safe state"), 1u);
  EXPECT_EQ(manager.count("WATCHDOG=1"), told.size() - 2);
}

TEST(Service, IsNotToldThatAHangingTaskRuns) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, plant("n := n + 1; WHILE n > 3 DO x := SIN(x) + 1.0; END_WHILE;"));
  Manager manager("400000");
  // The budget of loops is used up long after the end: until then nothing but the service manager sees it.
  const auto result = run_plant({file, "--duration", "2500ms", "--loop-budget", "4000000000"});
  // 400 ms without a scan, a quarter of that later it is looked at again: seven times at most, of 25.
  EXPECT_GE(manager.count("WATCHDOG=1"), 1u) << result.all();
  EXPECT_LE(manager.count("WATCHDOG=1"), 12u) << result.all();
}

/// A service manager that has no time: as much waits for it as may.
class BusyManager {
 public:
  BusyManager() : path_(scratch_.file("notify")) {
    socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path_.copy(address.sun_path, sizeof address.sun_path - 1);
    const auto* const to = reinterpret_cast<const sockaddr*>(&address);
    EXPECT_EQ(::bind(socket_, to, sizeof address), 0);
    // WHY several: what one socket may send is limited, too, and can be less than what the queue takes.
    for (bool sent = true; sent;) {
      const int other = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
      sent = false;
      while (::sendto(other, "x", 1, 0, to, sizeof address) == 1) sent = true;
      ::close(other);
    }
    ::setenv("NOTIFY_SOCKET", path_.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "400000", 1);
  }
  ~BusyManager() {
    ::close(socket_);
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  BusyManager(const BusyManager&) = delete;
  BusyManager& operator=(const BusyManager&) = delete;

  /// All that it hears from now on, until there is silence.
  std::vector<std::string> hear() const {
    std::vector<std::string> told;
    char text[512];
    for (pollfd descriptor{socket_, POLLIN, 0}; ::poll(&descriptor, 1, 2000) > 0;) {
      const ssize_t n = ::recv(socket_, text, sizeof text, 0);
      if (n > 0) told.emplace_back(text, static_cast<std::size_t>(n));
    }
    return told;
  }

 private:
  ScratchFolder scratch_;
  std::string path_;
  int socket_ = -1;
};

TEST(Service, TellsAgainWhatABusyManagerHasNotHeard) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, plant("n := n + 1;"));
  const BusyManager manager;
  std::vector<std::string> told;
  std::thread listens([&] {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    told = manager.hear();
  });
  const auto result = run_plant({file, "--duration", "5s"}, 20);
  listens.join();
  EXPECT_EQ(result.code, 0) << result.all();
  const auto has = [&told](const std::string& text) { return std::find(told.begin(), told.end(), text) != told.end(); };
  EXPECT_TRUE(has("READY=1\nSTATUS=runs " + file));
  EXPECT_TRUE(has("WATCHDOG=1"));
}

TEST(Service, EndsAlsoWhenNoManagerListens) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, plant("n := n + 1;"));
  const BusyManager manager;
  EXPECT_EQ(run_plant({file, "--duration", "500ms"}, 20).code, 0);
}

TEST(Service, HearsNoWatchdogItDidNotAskFor) {
  const ScratchFolder scratch;
  const std::string file = scratch.file("plant.st");
  write_text(file, plant("n := n + 1;"));
  for (const std::string time : {"", "0", "soon"}) {
    Manager manager(time);
    EXPECT_EQ(run_plant({file, "--cycles", "30"}).code, 0);
    EXPECT_EQ(manager.count("WATCHDOG=1"), 0u);
    EXPECT_EQ(manager.told().size(), 2u);
  }
}

}  // namespace
}  // namespace plc::test
