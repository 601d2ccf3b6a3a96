// The GPIO driver over a chip in memory: exchange points, inversion, latches, loss and return, safe values.
#include "io-drivers/gpio/gpio_driver.h"

#include <gtest/gtest.h>

#include <thread>

#include "tests/support/count_allocations.h"
#include "tests/support/gpio_rig.h"
#include "tests/unit/gpio/fake_chip.h"

namespace plc::test {
namespace {

using io::GpioDriver;
using io::LineEdge;
using io::Quality;
constexpr core::TimeNs kMs = 1'000'000;

/// A GpioRig on a chip in memory.
struct FakeRig {
  explicit FakeRig(const std::string& toml, int points = 4, int tasks = 1)
      : rig(toml, chip.access(), points, tasks), driver(rig.drivers.at(0).get()) {}
  [[nodiscard]] std::string value(const std::string& path) const { return rig.value(path); }
  void cycles(std::uint64_t count = 1) { rig.simulation->run_cycles(count); }
  [[nodiscard]] core::TimeNs now() const { return rig.simulation->now_ns(); }
  std::string serve() { return rig.serve(); }

  FakeChip chip;
  GpioRig rig;
  GpioDriver* driver;
};

std::string panel(const std::string& channels, const std::string& more = "") {
  return "[drivers.panel]\nkind = \"gpio\"\nchip = \"gpiochip0\"\ntask = \"Task0\"\nretry = \"1s\"\n" + more + "\n" +
         channels;
}
const char* const kTwoByTwo = R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 4 }
"%IX0.1" = { driver = "panel", channel = "DOOR" }
[outputs]
"%QX0.0" = { driver = "panel", channel = 10 }
"%QX0.1" = { driver = "panel", channel = 11, safe = true }
)";

TEST(GpioDriver, ReadsBeforeAndWritesAfterTheScan) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->check());
  ASSERT_FALSE(rig.driver->open());
  EXPECT_TRUE(rig.driver->has_outputs());
  EXPECT_EQ(rig.driver->name(), "panel");
  rig.chip.level["4"] = true;
  rig.cycles();
  EXPECT_EQ(rig.value("in0"), "1");
  EXPECT_EQ(rig.value("in1"), "0");
  EXPECT_TRUE(rig.chip.out["10"]) << "the same cycle reads the input and writes the output";
  EXPECT_FALSE(rig.chip.out["11"]);
  rig.chip.level = {{"4", false}, {"DOOR", true}};
  rig.cycles();
  EXPECT_FALSE(rig.chip.out["10"]);
  EXPECT_TRUE(rig.chip.out["11"]);
  EXPECT_EQ(rig.driver->status().losses, 0u);
  EXPECT_TRUE(rig.driver->status().connected);
}

TEST(GpioDriver, FirstReadAndInitialValuesAreThereBeforeTheFirstCycle) {
  FakeRig rig(panel(R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 4 }
[outputs]
"%QX0.0" = { driver = "panel", channel = 10, safe = true }
"%QX0.1" = { driver = "panel", channel = 11, safe = true, initial = false }
"%QX0.2" = { driver = "panel", channel = 12, safe = true, invert = true }
)"));
  rig.chip.level["4"] = true;
  EXPECT_EQ(rig.driver->inputs(0).at(0).quality, Quality::kNever);
  ASSERT_FALSE(rig.driver->open());
  EXPECT_EQ(rig.value("in0"), "1");
  EXPECT_EQ(rig.driver->inputs(0).at(0).quality, Quality::kGood);
  EXPECT_TRUE(rig.chip.out["10"]) << "without an initial value, the safe one";
  EXPECT_FALSE(rig.chip.out["11"]);
  EXPECT_FALSE(rig.chip.out["12"]) << "safe TRUE, inverted";
}

TEST(GpioDriver, InvertsWhatTheProgramMeans) {
  FakeRig rig(panel(R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 4, invert = true }
[outputs]
"%QX0.0" = { driver = "panel", channel = 10, invert = true }
"%QX0.1" = { driver = "panel", channel = 11, active_low = true, bias = "pull-up", drive = "open-drain" }
)"));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  EXPECT_EQ(rig.value("in0"), "1");
  EXPECT_FALSE(rig.chip.out["10"]);
  rig.chip.level["4"] = true;
  rig.cycles();
  EXPECT_EQ(rig.value("in0"), "0");
  EXPECT_TRUE(rig.chip.out["10"]);
  const io::LineSpec& kernel = rig.chip.opened.at(0).outputs.at(1);
  EXPECT_TRUE(kernel.active_low) << "the kernel's part";
  EXPECT_EQ(kernel.bias, io::Bias::kPullUp);
  EXPECT_EQ(kernel.drive, io::Drive::kOpenDrain);
  EXPECT_FALSE(rig.chip.opened.at(0).outputs.at(0).active_low) << "ours";
}

TEST(GpioDriver, ALatchShowsAPulseForOneCycle) {
  FakeRig rig(panel(R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 1, latch = "rising" }
"%IX0.1" = { driver = "panel", channel = 2, latch = "falling" }
"%IX0.2" = { driver = "panel", channel = 3, latch = "rising", invert = true }
"%IX0.3" = { driver = "panel", channel = 4 }
)"));
  rig.chip.level = {{"2", true}, {"3", true}};
  rig.chip.edges = {"1", "2", "3"};
  ASSERT_FALSE(rig.driver->open());
  const auto& asked = rig.chip.opened.at(0).inputs;
  EXPECT_EQ(asked[0].edge, LineEdge::kRising);
  EXPECT_EQ(asked[1].edge, LineEdge::kFalling);
  EXPECT_EQ(asked[2].edge, LineEdge::kFalling) << "the program's rising edge is the line's falling one";
  EXPECT_EQ(asked[3].edge, LineEdge::kNone);
  rig.cycles();
  EXPECT_EQ(rig.value("in0") + rig.value("in1") + rig.value("in2"), "010") << "edges from before the start are none";
  rig.chip.edges = {"1", "2", "3"};
  rig.cycles();
  EXPECT_EQ(rig.value("in0") + rig.value("in1") + rig.value("in2"), "101");
  rig.cycles();
  EXPECT_EQ(rig.value("in0") + rig.value("in1") + rig.value("in2"), "010");
}

TEST(GpioDriver, ManyLinesKeepTheirOrder) {
  std::string inputs = "[inputs]\n", outputs = "[outputs]\n";
  for (int i = 0; i < 150; ++i) {
    const std::string at = std::to_string(i / 8) + "." + std::to_string(i % 8);
    // Neither in the order of the file nor of the addresses.
    inputs += "\"%IX" + at + "\" = { driver = \"panel\", channel = " + std::to_string((i * 7) % 150) + " }\n";
    outputs += "\"%QX" + at + "\" = { driver = \"panel\", channel = " + std::to_string(200 + (i * 11) % 150) + " }\n";
  }
  FakeRig rig(panel(inputs + outputs), 150);
  ASSERT_FALSE(rig.driver->open());
  for (const int only : {0, 63, 64, 127, 128, 149}) {
    rig.chip.level = {{std::to_string((only * 7) % 150), true}};
    rig.cycles();
    for (int i = 0; i < 150; ++i) {
      EXPECT_EQ(rig.value("in" + std::to_string(i)), i == only ? "1" : "0") << i;
      EXPECT_EQ(rig.chip.out[std::to_string(200 + (i * 11) % 150)], i == only) << i;
    }
  }
}

TEST(GpioDriver, UnchangedOutputsAreWrittenNowAndThen) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  EXPECT_EQ(rig.chip.writes, 1);
  rig.cycles(9);
  EXPECT_EQ(rig.chip.writes, 1);
  rig.chip.out["11"] = true;  // an expander that lost its state
  rig.cycles();
  EXPECT_EQ(rig.chip.writes, 2) << "100 ms later";
  EXPECT_FALSE(rig.chip.out["11"]);
  rig.chip.level["4"] = true;
  rig.cycles();
  EXPECT_EQ(rig.chip.writes, 3) << "at once when something changed";
}

TEST(GpioDriver, CyclesOfOtherTasksAreNotItsBusiness) {
  FakeRig rig(panel(kTwoByTwo), 4, 2);
  ASSERT_FALSE(rig.driver->open());
  const int reads = rig.chip.reads;
  rig.driver->before_scan({1, 0, 0, 0});
  rig.driver->after_scan({1, 0, 0, 0});
  EXPECT_EQ(rig.chip.reads, reads);
  EXPECT_EQ(rig.chip.writes, 0);
}

TEST(GpioDriver, AProblemAtOpenTouchesNothing) {
  FakeRig rig(panel(kTwoByTwo));
  rig.chip.busy = {"11"};
  const auto found = rig.driver->check();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->code, core::Code::P7404);
  EXPECT_EQ(found->message, "panel: %QX0.1: in use");
  const auto problem = rig.driver->open();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->message, "panel: %QX0.1: in use");
  EXPECT_TRUE(rig.chip.out.empty());
  EXPECT_FALSE(rig.driver->status().connected);
  EXPECT_EQ(rig.serve(), "") << "it was never there, so it is not lost";
  rig.driver->close();
  EXPECT_EQ(rig.chip.tries, 1) << "closing what was never opened drives nothing";
}

TEST(GpioDriver, LossHoldsInputsAndReturnIsNoticed) {
  FakeRig rig(panel(kTwoByTwo, "ok = \"ok\""));
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->open());
  EXPECT_EQ(rig.value("ok"), "1");
  rig.cycles();
  rig.chip.present = false;
  rig.cycles();
  EXPECT_EQ(rig.value("in0"), "1") << "on_loss = hold";
  EXPECT_EQ(rig.value("ok"), "0");
  EXPECT_EQ(rig.driver->inputs(rig.now()).at(0).quality, Quality::kLost);
  EXPECT_EQ(rig.driver->status().losses, 1u);
  EXPECT_EQ(rig.serve(), "panel: gpiochip0 does not answer: No such device; its inputs keep their last values\n");
  EXPECT_EQ(rig.chip.handles, 0) << "a dead handle is given back, or the chip's name would stay taken";
  EXPECT_EQ(rig.driver->status().problem, "GPIO chip \"gpiochip0\" cannot be opened");
  const int tries = rig.chip.tries;
  rig.cycles(50);
  EXPECT_EQ(rig.serve(), "") << "said once";
  EXPECT_EQ(rig.chip.tries, tries) << "retry = 1s";
  rig.cycles(50);
  EXPECT_EQ(rig.driver->status().losses, 1u);
  EXPECT_GT(rig.driver->inputs(rig.now()).at(0).age_ns, -1);
  rig.chip.replug();
  rig.chip.out = {{"10", true}, {"11", false}};
  EXPECT_EQ(rig.serve(), "panel: gpiochip0 is back after 1.0 s\n");
  EXPECT_TRUE(rig.chip.out["10"]) << "what the program wants, from the request on";
  EXPECT_FALSE(rig.chip.out["11"]);
  rig.cycles();
  EXPECT_TRUE(rig.chip.out["10"]);
  EXPECT_FALSE(rig.chip.out["11"]);
  EXPECT_EQ(rig.value("ok"), "1");
  const io::DriverStatus status = rig.driver->status();
  EXPECT_TRUE(status.connected);
  EXPECT_EQ(status.recoveries, 1u);
  EXPECT_EQ(status.problem, "");
}

TEST(GpioDriver, LossCanMakeInputsFalse) {
  FakeRig rig(panel(R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 4 }
"%IX0.1" = { driver = "panel", channel = 5, invert = true }
)",
                    "on_loss = \"zero\""));
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  EXPECT_EQ(rig.value("in0") + rig.value("in1"), "11");
  rig.chip.present = false;
  rig.cycles();
  EXPECT_EQ(rig.value("in0") + rig.value("in1"), "00") << "FALSE for the program, inverted or not";
  EXPECT_NE(rig.serve().find("its inputs read FALSE"), std::string::npos);
  EXPECT_FALSE(rig.driver->has_outputs());
}

TEST(GpioDriver, AChipWithOutputsOnlyIsMissedWithinTheRefresh) {
  FakeRig rig(panel("[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 10 }\n", "ok = \"ok\""));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  EXPECT_EQ(rig.value("ok"), "1");
  rig.chip.present = false;
  rig.cycles(12);
  EXPECT_EQ(rig.value("ok"), "0");
  EXPECT_NE(rig.serve().find("does not answer"), std::string::npos);
}

TEST(GpioDriver, AHiccupKeepsTheLines) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  rig.chip.error = EIO;
  rig.cycles(4);
  EXPECT_NE(rig.serve().find("gpiochip0 does not answer: Input/output error"), std::string::npos);
  EXPECT_EQ(rig.chip.handles, 1) << "the guardian has these lines as well: a new request would find them busy";
  rig.chip.error = 0;
  rig.cycles(100);
  EXPECT_NE(rig.serve().find("is back"), std::string::npos);
  EXPECT_EQ(rig.chip.tries, 1);
  rig.chip.level["4"] = true;
  rig.cycles();
  EXPECT_TRUE(rig.chip.out["10"]);
}

/// Everything the lines had, in order: what a contactor would have seen.
struct Seen {
  explicit Seen(FakeRig& r) : rig(r) {}
  void cycle() {
    rig.cycles();
    all += rig.chip.out["10"] ? '1' : '0';
    all += rig.chip.out["11"] ? '1' : '0';
    all += rig.value("ok") == "1" ? '+' : '-';
  }
  FakeRig& rig;
  std::string all;
};

TEST(GpioDriver, OneErrorIsGotOverInTheSameCycle) {
  FakeRig rig(panel(kTwoByTwo, "ok = \"ok\""));
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  for (int i = 0; i < 20; ++i) {  // reads, and writes of the refresh
    rig.chip.errors_left = 1;
    rig.chip.error = EIO;
    Seen seen(rig);
    seen.cycle();
    EXPECT_EQ(seen.all, "10+");
  }
  EXPECT_EQ(rig.serve(), "panel: gpiochip0: Input/output error, tried again; 20 errors since the start\n");
  EXPECT_EQ(rig.serve(), "") << "once a minute";
  EXPECT_EQ(rig.driver->status().losses, 0u);
}

TEST(GpioDriver, AFewCyclesThatFailAreNoLoss) {
  FakeRig rig(panel(kTwoByTwo, "ok = \"ok\"\nerrors = 2"));
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  Seen seen(rig);
  for (int i = 0; i < 5; ++i) {
    rig.chip.error = EIO;
    seen.cycle();
    seen.cycle();
    rig.chip.error = 0;
    seen.cycle();
  }
  EXPECT_EQ(seen.all, "10+10+10+10+10+10+10+10+10+10+10+10+10+10+10+");
  EXPECT_EQ(rig.driver->status().losses, 0u);
  rig.chip.error = EIO;
  rig.chip.level["4"] = false;
  for (int i = 0; i < 4; ++i) seen.cycle();
  EXPECT_EQ(seen.all.substr(45), "10+10+10-10-") << "the third in a row is one too many; the lines are left alone";
  EXPECT_EQ(rig.driver->status().losses, 1u);
  rig.serve();
  rig.chip.error = 0;
  rig.cycles(100);
  rig.chip.out["10"] = false;
  rig.serve();
  EXPECT_TRUE(rig.chip.out["10"]) << "what the program wants with the inputs it held";
  rig.cycles();
  EXPECT_FALSE(rig.chip.out["10"]);
}

TEST(GpioDriver, OutputsAreWrittenAgainInTheNextCycle) {
  FakeRig rig(
      panel("[inputs]\n\"%IX0.0\" = { driver = \"panel\", channel = 4 }\n"
            "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 10 }\n"));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  rig.chip.level["4"] = true;
  const runtime::ReleaseContext context{0, 1, 20 * kMs, 20 * kMs};
  rig.driver->before_scan(context);
  rig.chip.error = EIO;
  rig.cycles();
  EXPECT_FALSE(rig.chip.out["10"]);
  rig.chip.error = 0;
  rig.cycles();
  EXPECT_TRUE(rig.chip.out["10"]);
}

TEST(GpioDriver, AChipThatIsNotThereYetIsWaitedFor) {
  FakeRig rig(panel(kTwoByTwo, "ok = \"ok\"\nwait = true"));
  rig.chip.present = false;
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->check());
  ASSERT_FALSE(rig.driver->open());
  EXPECT_FALSE(rig.driver->status().connected);
  rig.cycles();
  EXPECT_EQ(rig.value("in0"), "0") << "the initial value";
  EXPECT_EQ(rig.value("ok"), "0");
  EXPECT_EQ(rig.driver->inputs(rig.now()).at(0).quality, Quality::kNever);
  EXPECT_EQ(rig.serve(),
            "panel: GPIO chip \"gpiochip0\" cannot be opened; control runs without it, it is tried again\n");
  rig.cycles(100);
  EXPECT_EQ(rig.serve(), "") << "said once";
  rig.chip.present = true;
  rig.chip.busy.insert("10");
  rig.cycles(100);
  EXPECT_EQ(rig.serve(), "panel: %QX0.0: in use; control runs without it, it is tried again\n") << "another reason";
  rig.chip.busy.clear();
  rig.cycles(100);
  EXPECT_NE(rig.serve().find("panel: gpiochip0 is there after "), std::string::npos);
  EXPECT_FALSE(rig.chip.out["10"]);
  rig.cycles();
  EXPECT_TRUE(rig.chip.out["10"]);
  EXPECT_EQ(rig.value("ok"), "1");
  EXPECT_EQ(rig.driver->status().recoveries, 0u);
}

TEST(GpioDriver, WaitingIsForChipsNotForMistakes) {
  FakeRig rig(panel(kTwoByTwo, "wait = true"));
  rig.chip.busy.insert("10");
  EXPECT_TRUE(rig.driver->check());
  EXPECT_TRUE(rig.driver->open());
  FakeRig without(panel(kTwoByTwo));
  without.chip.present = false;
  EXPECT_TRUE(without.driver->check());
  EXPECT_TRUE(without.driver->open());
}

TEST(GpioDriver, AStoppedTaskLeavesItsOutputsSafe) {
  FakeRig rig(panel(kTwoByTwo), 4, 2);
  ASSERT_FALSE(rig.driver->open());
  rig.chip.level["4"] = true;
  rig.cycles();
  EXPECT_TRUE(rig.chip.out["10"]);
  rig.driver->task_stopped(0);
  EXPECT_FALSE(rig.chip.out["10"]) << "nobody runs its cycle any more, so at once";
  EXPECT_TRUE(rig.chip.out["11"]);
}

TEST(GpioDriver, OutputsThatAnotherTaskWroteBecomeSafeInTheNextCycle) {
  FakeRig rig(panel(kTwoByTwo), 4, 2);  // both tasks export the outputs
  ASSERT_FALSE(rig.driver->open());
  rig.chip.level["4"] = true;
  rig.cycles();
  rig.driver->task_stopped(1);
  EXPECT_TRUE(rig.chip.out["10"]) << "not on a thread that is not ours";
  rig.cycles();
  EXPECT_FALSE(rig.chip.out["10"]);
  EXPECT_TRUE(rig.chip.out["11"]);
  rig.cycles(3);
  EXPECT_FALSE(rig.chip.out["10"]) << "for good";
}

TEST(GpioDriver, StoppingLeavesSafeValuesAndFreeLines) {
  FakeRig rig(panel(kTwoByTwo));
  rig.chip.level["4"] = true;
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  rig.driver->safe_state();
  EXPECT_FALSE(rig.chip.out["10"]);
  EXPECT_TRUE(rig.chip.out["11"]);
  EXPECT_EQ(rig.chip.handles, 1);
  rig.chip.out["10"] = true;
  rig.driver->close();
  EXPECT_FALSE(rig.chip.out["10"]) << "closing drives them once more";
  EXPECT_EQ(rig.chip.handles, 0);
  EXPECT_EQ(rig.serve(), "");
}

TEST(GpioDriver, SafeValuesGoOverAFreshRequestWhenTheHandleIsDead) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  rig.chip.replug();
  rig.chip.busy_for = 3;  // the killed runtime still lets go
  EXPECT_TRUE(rig.driver->drive_safe());
  EXPECT_FALSE(rig.chip.out["10"]);
  EXPECT_TRUE(rig.chip.out["11"]);
  EXPECT_TRUE(rig.chip.opened.back().inputs.empty()) << "inputs are of no use to the dead";
  rig.chip.present = false;
  EXPECT_FALSE(rig.driver->drive_safe());
}

TEST(GpioDriver, SafeValuesOverLinesThatWereLostForAMoment) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->open());
  rig.chip.error = EIO;
  rig.cycles();
  EXPECT_FALSE(rig.driver->drive_safe());
  rig.chip.error = 0;
  EXPECT_TRUE(rig.driver->drive_safe());
  EXPECT_TRUE(rig.chip.out["11"]);
  EXPECT_EQ(rig.chip.tries, 1);
}

TEST(GpioDriver, TheGuardianLetsGoOfADeadHandleOnly) {
  FakeRig rig(panel(kTwoByTwo));
  ASSERT_FALSE(rig.driver->open());
  rig.driver->release_if_gone();
  EXPECT_EQ(rig.chip.handles, 1);
  rig.chip.present = false;
  rig.driver->release_if_gone();
  EXPECT_EQ(rig.chip.handles, 0);
  rig.driver->release_if_gone();
}

TEST(GpioDriver, TheCycleAllocatesNothing) {
  FakeRig rig(panel(kTwoByTwo, "ok = \"ok\""));
  ASSERT_FALSE(rig.driver->open());
  rig.cycles();
  const auto scan = [&](std::uint64_t cycle) {
    const runtime::ReleaseContext context{0, cycle, core::TimeNs(cycle) * 10 * kMs, 0};
    return allocations_of([&] {
      rig.driver->before_scan(context);
      rig.driver->after_scan(context);
    });
  };
  for (std::uint64_t cycle = 1; cycle < 30; ++cycle) EXPECT_EQ(scan(cycle), 0u) << cycle;
  rig.chip.present = false;
  EXPECT_EQ(scan(30), 0u);
  EXPECT_EQ(scan(31), 0u);
  EXPECT_EQ(allocations_of([&] { rig.driver->task_stopped(0); }), 0u);
}

TEST(GpioDriver, CycleAndServiceNeverUseTheLinesAtOnce) {
  FakeRig rig(panel(kTwoByTwo, "on_loss = \"zero\"\nerrors = 0"));
  ASSERT_FALSE(rig.driver->open());
  std::atomic<bool> end{false};
  std::atomic<std::uint64_t> back{0};
  std::thread service([&] {
    // Retries are a second apart, in a time of its own.
    for (core::TimeNs now = 0; !end; now += 2'000 * kMs) {
      rig.driver->service(now);
      back = rig.driver->status().recoveries;
      std::this_thread::yield();
    }
  });
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (std::uint64_t cycle = 0; back < 200 && std::chrono::steady_clock::now() < deadline; ++cycle) {
    rig.chip.error = cycle % 50 == 49 ? EIO : 0;
    const runtime::ReleaseContext context{0, cycle, core::TimeNs(cycle) * 10 * kMs, 0};
    rig.driver->before_scan(context);
    rig.driver->after_scan(context);
    if (cycle % 50 == 0) std::this_thread::yield();
  }
  end = true;
  service.join();
  EXPECT_GE(back, 200u);
  EXPECT_FALSE(rig.chip.clashed);
  EXPECT_EQ(rig.chip.handles, 1);
}

}  // namespace
}  // namespace plc::test
