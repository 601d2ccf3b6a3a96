// The end of plc-run: whether this process becomes the next one (tools/plc-run/relaunch.h), and that it comes
// (end_guard.h).
#include "tools/plc-run/relaunch.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tools/cli.h"
#include "tools/command_line.h"
#include "tools/plc-run/end_guard.h"
#include "tools/plc-run/signals.h"

namespace plc::tools {
namespace {

int signalled = 0;

/// Of a process that was started anew.
constexpr int kAgain = 42;

/// This program, when it was started anew, says what it was given, and nothing else.
[[maybe_unused]] const bool kIsFirst = [] {
  if (std::getenv("PICARD_RELAUNCH") == nullptr) return true;
  std::array<char*, 2> words = {const_cast<char*>("again"), nullptr};
  Relaunch next;
  next.begin(1, words.data());
  const std::string text = next.handed_over().value_or("nothing");
  const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
  ::_exit(written == static_cast<ssize_t>(text.size()) ? kAgain : 1);
}();

/// Exit code and output of a process that ends as main() of plc-run does; `run`: what happens in it before.
std::pair<int, std::string> end_of(const std::function<int(Relaunch&)>& run) {
  std::array<int, 2> pipe{};
  EXPECT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(pipe[1], STDOUT_FILENO);
    std::array<char*, 3> words = {const_cast<char*>("plc-run"), const_cast<char*>("plant.xml"), nullptr};
    Relaunch& relaunch = Relaunch::instance();
    relaunch.begin(2, words.data());
    ::_exit(relaunch.end(run(relaunch)));
  }
  ::close(pipe[1]);
  std::string said;
  std::array<char, 256> piece{};
  for (ssize_t got = 0; (got = ::read(pipe[0], piece.data(), piece.size())) > 0;)
    said.append(piece.data(), static_cast<std::size_t>(got));
  ::close(pipe[0]);
  int status = 0;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status), said};
}

int throws(int, char**) { throw std::runtime_error("thrown"); }

TEST(Relaunch, AfterAnExceptionOnTrialIsOfTheProgramBefore) {
  const auto [code, said] = end_of([](Relaunch& relaunch) {
    relaunch.hand_over("who is logged in");
    relaunch.set_trial(true);
    return guarded("plc-run", throws, 0, nullptr);
  });
  EXPECT_EQ(code, kAgain);
  EXPECT_EQ(said, "who is logged in");
}

TEST(Relaunch, GivesTheLastText) {
  const auto last_of = [](const std::vector<std::string>& texts) {
    return end_of([&](Relaunch& relaunch) {
      for (const std::string& text : texts) relaunch.hand_over(text);
      return kExitRelaunch;
    });
  };
  const std::string large(200'000, 'x');
  EXPECT_EQ(last_of({}), std::pair(kAgain, std::string()));
  EXPECT_EQ(last_of({"one"}), std::pair(kAgain, std::string("one")));
  EXPECT_EQ(last_of({"one", "two and more", "3"}), std::pair(kAgain, std::string("3")));
  EXPECT_EQ(last_of({"one", large, "two", large + "y"}), std::pair(kAgain, large + "y"));
  EXPECT_EQ(last_of({large, ""}), std::pair(kAgain, std::string()));
}

TEST(Relaunch, IsNoneAfterAnExceptionOfAProgramThatStays) {
  const auto [code, said] = end_of([](Relaunch& relaunch) {
    relaunch.set_trial(true);
    relaunch.set_trial(false);
    return guarded("plc-run", throws, 0, nullptr);
  });
  EXPECT_EQ(code, kExitErrors);
  EXPECT_EQ(said, "");
}

TEST(Relaunch, IsNoneAfterAGoodEndOrASignal) {
  EXPECT_EQ(end_of([](Relaunch& relaunch) {
              relaunch.set_trial(true);
              return kExitOk;
            }).first,
            kExitOk);
  EXPECT_EQ(end_of([](Relaunch& relaunch) {
              relaunch.set_trial(true);
              signalled = SIGTERM;
              return kExitErrors;
            }).first,
            kExitErrors);
}

TEST(Relaunch, OfARuntimeWithAGuardianIsLeftToThatOne) {
  EXPECT_EQ(end_of([](Relaunch& relaunch) {
              relaunch.set_trial(true);
              const pid_t runtime = ::fork();
              if (runtime == 0) ::_exit(relaunch.end(kExitRelaunch));
              int status = 0;
              ::waitpid(runtime, &status, 0);
              return WEXITSTATUS(status) == kExitRelaunch ? kExitOk : kExitUsage;
            }).first,
            kExitOk);
}

/// Of a process whose end hangs.
std::pair<int, std::string> end_of_hanging(int code, const std::function<void(EndGuard&)>& change = {}) {
  return end_of([&](Relaunch& relaunch) {
    relaunch.hand_over("nobody");
    EndGuard guard;
    guard.begin(code, std::chrono::milliseconds(50), {});
    if (change) change(guard);
    ::sleep(20);
    return kExitOk;
  });
}

TEST(EndGuard, EndsAProcessThatHangs) {
  EXPECT_EQ(end_of_hanging(kExitErrors), std::pair(kExitErrors, std::string()));
  EXPECT_EQ(end_of_hanging(kExitRelaunch), std::pair(kAgain, std::string("nobody")));
  EXPECT_EQ(end_of_hanging(kExitUsage, [](EndGuard& guard) { guard.expect(kExitErrors); }).first, kExitErrors);
}

TEST(EndGuard, EndsOneAlsoWhenNobodyReadsWhatItSays) {
  EXPECT_EQ(end_of_hanging(kExitErrors,
                           [](EndGuard&) {
                             std::array<int, 2> full{};
                             EXPECT_EQ(::pipe2(full.data(), O_NONBLOCK), 0);
                             while (::write(full[1], "x", 1) == 1) {
                             }
                             ::dup2(full[1], STDERR_FILENO);
                           })
                .first,
            kExitErrors);
}

TEST(EndGuard, LeavesAProcessThatEndsInTime) {
  EXPECT_EQ(end_of([](Relaunch&) {
              {
                EndGuard guard;
                guard.begin(kExitErrors, std::chrono::seconds(20), {});
              }
              const EndGuard never_begun;
              return kExitOk;
            }).first,
            kExitOk);
}

TEST(EndGuard, DoesNotCountRestAndReaders) {
  EXPECT_EQ(end_of([](Relaunch&) {
              EndGuard guard;
              guard.begin(kExitErrors, std::chrono::seconds(1), {});
              guard.rest();
              std::this_thread::sleep_for(std::chrono::milliseconds(1500));
              guard.go_on();
              for (int i = 0; i < 150; ++i) {
                guard.waits_for_reader();
                std::this_thread::sleep_for(std::chrono::milliseconds(10));
              }
              return kExitOk;
            }).first,
            kExitOk);
  EXPECT_EQ(end_of_hanging(kExitErrors,
                           [](EndGuard& guard) {
                             guard.rest();
                             guard.go_on();
                             guard.waits_for_reader();
                           })
                .first,
            kExitErrors);
}

TEST(EndGuard, TellsThatTheProcessLivesWhileItWaits) {
  const auto [code, said] = end_of([](Relaunch&) {
    EndGuard guard;
    guard.begin(kExitErrors, std::chrono::milliseconds(500),
                {[] { static_cast<void>(!::write(STDOUT_FILENO, "!", 1)); }, std::chrono::milliseconds(50)});
    ::sleep(20);
    return kExitOk;
  });
  EXPECT_EQ(code, kExitErrors);
  EXPECT_GE(said.size(), 3u);
  EXPECT_LE(said.size(), 10u);
}

}  // namespace

/// In place of signals.cpp, whose handlers are those of a plant.
int signal_to_stop() { return signalled; }

}  // namespace plc::tools
