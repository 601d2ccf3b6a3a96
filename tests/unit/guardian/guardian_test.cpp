// The guardian: every way a runtime can end, with processes of our own and a driver that writes down what it was told.
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "tests/support/guardian_fixture.h"

namespace plc::io {
namespace {

using std::chrono::milliseconds;

void cycle(Pulse& pulse, std::uint32_t task = 0) { pulse.after_scan({task, 0, 0, 0}); }

void cycle_for(Pulse& pulse, milliseconds duration, milliseconds period = milliseconds(10)) {
  for (const auto end = std::chrono::steady_clock::now() + duration; std::chrono::steady_clock::now() < end;) {
    cycle(pulse);
    std::this_thread::sleep_for(period);
  }
}

volatile std::sig_atomic_t got_signal = 0;
void note_signal(int number) { got_signal = number; }

TEST_F(GuardianTest, AnOrderlyEndPassesOnTheCode) {
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(300));
    pulse.stopping();
    pulse.finished();
    return 7;
  });
  EXPECT_EQ(wait_for_guardian(), 7);
  EXPECT_EQ(notes.safe_calls, 0) << "the runtime did that itself";
  EXPECT_EQ(said, "");
  EXPECT_GT(notes.looks, 0);
}

TEST_F(GuardianTest, AKilledRuntimeLeavesSafeOutputs) {
  start([](Pulse& pulse) {
    cycle(pulse);
    kill(getpid(), SIGKILL);
    return 0;
  });
  expect_guardian_acted("was killed by signal 9");
}

TEST_F(GuardianTest, ACrashBeforeTheFirstCycleCountsToo) {
  start([](Pulse&) {
    signal(SIGSEGV, SIG_DFL);
    raise(SIGSEGV);
    return 0;
  });
  expect_guardian_acted("was killed by signal 11");
}

TEST_F(GuardianTest, AnEndWithoutAWordIsNoOrderlyEnd) {
  start([](Pulse& pulse) {
    pulse.stopping();
    return 0;
  });
  expect_guardian_acted("ended with code 0 without having made its outputs safe");
}

TEST_F(GuardianTest, ATaskWhoseCyclesCeaseIsAHang) {
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(300));
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, AStoppedProcessIsAHang) {
  start([](Pulse& pulse) {
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(100));
  EXPECT_EQ(notes.output, 1);
  kill(notes.runtime, SIGSTOP);
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, OneHangingTaskOfTwoIsEnough) {
  options.watched.push_back({1, "Other", 10 * kMs});
  start([](Pulse& pulse) {
    cycle(pulse, 1);
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Other\"");
}

TEST_F(GuardianTest, ASlowTaskHasThreePeriods) {
  options.watched = {{0, "Slow", 400 * kMs}};  // time-out 200 ms
  start([](Pulse& pulse) {
    cycle_for(pulse, milliseconds(1600), milliseconds(400));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, TheFirstCycleMayTakeLonger) {
  start([](Pulse& pulse) {
    std::this_thread::sleep_for(milliseconds(700));
    cycle_for(pulse, milliseconds(100));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, ButNotForever) {
  options.start_timeout_ns = 400 * kMs;
  start([](Pulse&) {
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("has not completed a cycle of task \"Fast\"");
}

TEST_F(GuardianTest, AFaultedTaskDoesNotHang) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.task_stopped(0);
    std::this_thread::sleep_for(milliseconds(700));
    pulse.finished();
    return 1;
  });
  EXPECT_EQ(wait_for_guardian(), 1) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, AnOrderlyStopMayTakeItsTime) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.stopping();
    std::this_thread::sleep_for(milliseconds(350));
    pulse.finished();
    std::this_thread::sleep_for(milliseconds(1000));  // its report; outputs are safe by now
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, AnOrderlyStopThatDoesNotEndIsAHang) {
  start([](Pulse& pulse) {
    cycle(pulse);
    pulse.stopping();
    for (;;) pause();
    return 0;
  });
  expect_guardian_acted("did not end within 0.6 s of an orderly stop");
}

TEST_F(GuardianTest, SignalsAreForwarded) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    notes.runtime = 0;
    start([number](Pulse& pulse) {
      got_signal = 0;
      signal(number, note_signal);
      while (got_signal != number) {
        cycle(pulse);
        std::this_thread::sleep_for(milliseconds(5));
      }
      pulse.stopping();
      pulse.finished();
      return 40 + number;
    });
    ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
    std::this_thread::sleep_for(milliseconds(50));
    kill(guardian, number);
    EXPECT_EQ(wait_for_guardian(), 40 + number) << said;
  }
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, ASignalThatComesWithTheEndOfTheRuntimeIsNotLost) {
  options.hang_timeout_ns = 0;
  options.ended = [](int code, bool asked) { return asked ? 50 : code; };
  Notes& shared = notes;
  start([&shared](Pulse& pulse) {
    pulse.stopping();
    pulse.finished();
    shared.hold = 1;
    if (!soon([&shared] { return shared.hold == 2; })) return 8;
    kill(getppid(), SIGTERM);
    return 7;
  });
  ASSERT_TRUE(soon([&] { return notes.hold == 2; }));
  std::this_thread::sleep_for(milliseconds(500));  // the runtime has ended; the guardian sees both at once
  notes.hold = 0;
  EXPECT_EQ(wait_for_guardian(), 50) << said;
}

TEST_F(GuardianTest, AWishForAReportIsForwardedAndEndsNothing) {
  start([](Pulse& pulse) {
    signal(SIGUSR1, note_signal);
    while (got_signal != SIGUSR1) {
      cycle(pulse);
      std::this_thread::sleep_for(milliseconds(5));
    }
    // Longer than an orderly stop may take.
    cycle_for(pulse, milliseconds(900));
    pulse.finished();
    return 41;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(50));
  kill(guardian, SIGUSR1);
  EXPECT_EQ(wait_for_guardian(), 41) << said;
  EXPECT_EQ(notes.safe_calls, 0);
}

TEST_F(GuardianTest, ARuntimeThatIgnoresTheSignalIsKilled) {
  start([](Pulse& pulse) {
    signal(SIGTERM, SIG_IGN);
    for (;;) cycle_for(pulse, milliseconds(1000));
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(50));
  kill(guardian, SIGTERM);
  expect_guardian_acted("did not end within 0.6 s of an orderly stop");
}

TEST_F(GuardianTest, WithoutItsGuardianTheRuntimeStops) {
  prctl(PR_SET_CHILD_SUBREAPER, 1);
  Notes& shared = notes;
  start([&shared](Pulse& pulse) {
    signal(SIGTERM, note_signal);
    shared.closed = 1;
    while (got_signal != SIGTERM) {
      cycle(pulse);
      std::this_thread::sleep_for(milliseconds(5));
    }
    shared.stopped_in_order = 1;
    pulse.finished();
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.closed == 1; }));
  kill(guardian, SIGKILL);
  EXPECT_EQ(wait_for_guardian(), -SIGKILL);
  EXPECT_TRUE(soon([&] { return notes.stopped_in_order == 1; }));
  int status = 0;
  EXPECT_EQ(waitpid(notes.runtime, &status, 0), notes.runtime);
  EXPECT_TRUE(WIFEXITED(status));
  notes.runtime = 0;
  prctl(PR_SET_CHILD_SUBREAPER, 0);
}

TEST_F(GuardianTest, WhatIsStillPrintedAtTheEndHasItsTimeToo) {
  options.hang_timeout_ns = 0;
  start([](Pulse& pulse) {
    signal(SIGTERM, SIG_IGN);
    cycle(pulse);
    pulse.stopping();
    pulse.finished();
    for (;;) pause();
    return 0;
  });
  ASSERT_TRUE(soon([&] { return notes.runtime != 0; }));
  std::this_thread::sleep_for(milliseconds(1000));
  EXPECT_EQ(notes.safe_calls, 0) << "who was not asked to end may print for ever";
  kill(guardian, SIGTERM);
  EXPECT_EQ(wait_for_guardian(), kGuardianExit);
  EXPECT_NE(said.find("did not end within 0.6 s of an orderly stop"), std::string::npos) << said;
  EXPECT_TRUE(runtime_is_gone());
}

TEST_F(GuardianTest, WithoutATimeOutOnlyDeathsCount) {
  options.hang_timeout_ns = 0;
  start([](Pulse& pulse) {
    cycle(pulse);
    std::this_thread::sleep_for(milliseconds(1500));
    pulse.finished();
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), 0) << said;
}

TEST_F(GuardianTest, OutputsThatCannotBeDrivenAreNamed) {
  with_broken = true;
  start([](Pulse&) {
    kill(getpid(), SIGKILL);
    return 0;
  });
  EXPECT_EQ(wait_for_guardian(), kGuardianExit);
  EXPECT_EQ(notes.safe_calls, 2);
  EXPECT_EQ(notes.output, 0);
  EXPECT_NE(said.find("the outputs of panel have their safe values"), std::string::npos) << said;
  EXPECT_NE(said.find("THE OUTPUTS OF broken COULD NOT BE MADE SAFE"), std::string::npos) << said;
}

TEST(Pulse, TasksThatNobodyWatchesAreIgnored) {
  const pid_t child = fork();
  if (child == 0) {
    auto pulse = start_guardian({}, {});
    if (!pulse) _exit(99);
    (*pulse)->after_scan({17, 0, 0, 0});
    (*pulse)->task_stopped(17);
    (*pulse)->finished();
    _exit(0);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace plc::io
