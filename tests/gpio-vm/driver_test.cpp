// The GPIO driver on the kernel's own interface: a real driver, real requests, a simulated chip (gpio-sim). Cycles are
// in virtual time, so nothing here depends on how slow the guest is.
#include <gtest/gtest.h>

#include "tests/gpio-vm/sim_chip.h"
#include "tests/support/gpio_rig.h"

namespace plc::test {
namespace {

std::string panel(const std::string& chip, const std::string& channels, const std::string& more = "") {
  return "[drivers.panel]\nkind = \"gpio\"\nchip = \"" + chip + "\"\nretry = \"10ms\"\n" + more + "\n" + channels;
}

struct KernelRig : GpioRig {
  explicit KernelRig(const std::string& toml, int points = 4) : GpioRig(toml, io::kernel_gpio(), points) {}
  void cycle() { simulation->run_cycles(1); }
  void open() {
    for (const auto& driver : drivers) {
      const auto problem = driver->open();
      ASSERT_FALSE(problem) << problem->message << "\n" << problem->help;
    }
  }
  void expect_problem(core::Code code, const std::string& message, const std::string& help) {
    for (const auto& found : {drivers.at(0)->check(), drivers.at(0)->open()}) {
      ASSERT_TRUE(found);
      EXPECT_EQ(found->code, code);
      EXPECT_EQ(found->message, "panel: " + message);
      EXPECT_NE(found->help.find(help), std::string::npos) << found->help;
    }
  }
};

const char* const kTwoByTwo = R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 1 }
"%IX0.1" = { driver = "panel", channel = 0 }
[outputs]
"%QX0.0" = { driver = "panel", channel = 9 }
"%QX0.1" = { driver = "panel", channel = 8 }
)";

TEST(GpioDriver, InputsAndOutputsByOffset) {
  const SimChip chip("plc-a", {});
  KernelRig rig(panel(chip.name(), kTwoByTwo));
  ASSERT_NO_FATAL_FAILURE(rig.open());
  for (const int pattern : {1, 2, 3, 0, 2}) {
    chip.pull(1, (pattern & 1) != 0);
    chip.pull(0, (pattern & 2) != 0);
    rig.cycle();
    EXPECT_EQ(rig.value("in0") + rig.value("in1"), std::to_string(pattern & 1) + std::to_string(pattern >> 1));
    EXPECT_EQ(chip.value(9), (pattern & 1) != 0);
    EXPECT_EQ(chip.value(8), (pattern & 2) != 0);
  }
}

TEST(GpioDriver, ChipByLabelAndPathLinesByName) {
  const SimChip other("plc-other", {.names = {{3, "DOOR"}}});
  const SimChip chip("plc-a", {.names = {{3, "DOOR"}, {12, "LAMP"}}});
  for (const std::string& name : {std::string("plc-a"), "/dev/" + chip.name()}) {
    KernelRig rig(panel(name,
                        "[inputs]\n\"%IX0.0\" = { driver = \"panel\", channel = \"DOOR\" }\n"
                        "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = \"LAMP\" }\n"));
    ASSERT_NO_FATAL_FAILURE(rig.open());
    chip.pull(3, true);
    rig.cycle();
    EXPECT_EQ(rig.value("in0"), "1");
    EXPECT_TRUE(chip.value(12));
    EXPECT_FALSE(other.value(12));
    chip.pull(3, false);
    rig.cycle();
    EXPECT_FALSE(chip.value(12));
  }
}

TEST(GpioDriver, BiasAndActiveLow) {
  const SimChip chip("plc-a", {});
  KernelRig rig(panel(chip.name(), R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 0, bias = "pull-up" }
"%IX0.1" = { driver = "panel", channel = 1, bias = "pull-down" }
"%IX0.2" = { driver = "panel", channel = 2, active_low = true }
"%IX0.3" = { driver = "panel", channel = 3, active_low = true, invert = true, bias = "pull-up" }
[outputs]
"%QX0.0" = { driver = "panel", channel = 8, active_low = true }
"%QX0.1" = { driver = "panel", channel = 9, invert = true }
"%QX0.2" = { driver = "panel", channel = 10, drive = "open-drain" }
)"));
  chip.pull(1, true);  // the request's own pull-down wins
  ASSERT_NO_FATAL_FAILURE(rig.open());
  EXPECT_TRUE(chip.value(8)) << "FALSE, active low";
  EXPECT_TRUE(chip.value(9)) << "FALSE, inverted";
  rig.cycle();
  EXPECT_EQ(rig.value("in0") + rig.value("in1") + rig.value("in2") + rig.value("in3"), "1011");
  EXPECT_FALSE(chip.value(8));
  EXPECT_TRUE(chip.value(9));
  chip.pull(2, true);
  rig.cycle();
  EXPECT_EQ(rig.value("in2"), "0");
}

TEST(GpioDriver, InitialValuesHoldUntilTheFirstCycleEnds) {
  const SimChip chip("plc-a", {});
  KernelRig rig(panel(chip.name(), R"(
[outputs]
"%QX0.0" = { driver = "panel", channel = 8, initial = true }
"%QX0.1" = { driver = "panel", channel = 9, safe = true }
"%QX0.2" = { driver = "panel", channel = 10, safe = true, initial = false }
)"));
  EXPECT_FALSE(rig.drivers.at(0)->check());
  EXPECT_FALSE(chip.value(8)) << "a check touches nothing";
  ASSERT_NO_FATAL_FAILURE(rig.open());
  EXPECT_TRUE(chip.value(8));
  EXPECT_TRUE(chip.value(9));
  EXPECT_FALSE(chip.value(10));
  rig.cycle();
  EXPECT_FALSE(chip.value(8));
  EXPECT_FALSE(chip.value(9));
  const KernelTrace trace;
  rig.drivers.at(0)->safe_state();
  EXPECT_TRUE(chip.value(9));
  EXPECT_TRUE(chip.value(10));
  EXPECT_FALSE(chip.value(8));
}

TEST(GpioDriver, APulseBetweenTwoCyclesIsSeenForOne) {
  const SimChip chip("plc-a", {});
  KernelRig rig(panel(chip.name(), R"(
[inputs]
"%IX0.0" = { driver = "panel", channel = 0, latch = "rising" }
"%IX0.1" = { driver = "panel", channel = 1, latch = "falling" }
"%IX0.2" = { driver = "panel", channel = 2, latch = "rising", active_low = true, bias = "pull-up" }
"%IX0.3" = { driver = "panel", channel = 3 }
)"));
  chip.pull(1, true);
  ASSERT_NO_FATAL_FAILURE(rig.open());
  rig.cycle();
  const auto seen = [&] { return rig.value("in0") + rig.value("in1") + rig.value("in2") + rig.value("in3"); };
  EXPECT_EQ(seen(), "0100");
  const auto pulse = [&](int line, bool up) {
    chip.pull(line, up);
    usleep(3000);  // edges as fast as sysfs can be written are merged by the simulation
    chip.pull(line, !up);
    usleep(3000);
  };
  // More pulses than the kernel keeps events: the queue is drained whole.
  for (int i = 0; i < 20; ++i) pulse(0, true);
  pulse(1, false);
  pulse(2, false);
  pulse(3, true);
  rig.cycle();
  EXPECT_EQ(seen(), "1010");
  rig.cycle();
  EXPECT_EQ(seen(), "0100");
  pulse(0, true);
  rig.cycle();
  EXPECT_EQ(seen(), "1100");
  chip.pull(0, true);
  usleep(3000);
  rig.cycle();
  rig.cycle();
  EXPECT_EQ(seen(), "1100") << "a level is a level";
}

TEST(GpioDriver, SeventyLinesEachWayOnTwoChips) {
  const SimChip left("plc-left", {.lines = 80}), right("plc-right", {.lines = 80});
  std::string inputs = "[inputs]\n", outputs = "[outputs]\n";
  for (int i = 0; i < 70; ++i) {
    const std::string at = std::to_string(i / 8) + "." + std::to_string(i % 8);
    // In an order of their own, and in two groups by active-low, so that bulks are split and mixed.
    inputs += "\"%IX" + at + "\" = { driver = \"panel\", channel = " + std::to_string((i * 3) % 70) + " }\n";
    outputs += "\"%QX" + at + "\" = { driver = \"lamps\", channel = " + std::to_string((i * 9 + 5) % 70) +
               (i % 10 == 0 ? ", active_low = true }\n" : " }\n");
  }
  KernelRig rig(panel("plc-left", "[drivers.lamps]\nkind = \"gpio\"\nchip = \"plc-right\"\n" + inputs + outputs), 70);
  ASSERT_NO_FATAL_FAILURE(rig.open());
  for (const int only : {0, 1, 31, 63, 64, 69}) {
    left.pull((only * 3) % 70, true);
    rig.cycle();
    for (int i = 0; i < 70; ++i) {
      EXPECT_EQ(rig.value("in" + std::to_string(i)), i == only ? "1" : "0") << i;
      EXPECT_EQ(right.value((i * 9 + 5) % 70), (i == only) != (i % 10 == 0)) << i;
    }
    left.pull((only * 3) % 70, false);
  }
}

TEST(GpioDriver, WhatCannotBeHadIsSaidAndNothingIsTouched) {
  const SimChip chip("plc-a", {.names = {{1, "TWICE"}, {2, "TWICE"}, {8, "LAMP"}}, .hogs = {{7, "kernel-led"}}});
  const SimChip twin1("plc-twin", {}), twin2("plc-twin2", {});
  const auto with = [&](const std::string& channel) {
    return panel("plc-a", "[inputs]\n\"%IX0.0\" = { driver = \"panel\", channel = " + channel +
                              " }\n[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 8, initial = true }\n");
  };
  KernelRig(with("16"))
      .expect_problem(core::Code::P7402, "%IX0.0: " + chip.name() + " has no line \"16\"",
                      "has the lines 0 to 15, by name: TWICE (1), TWICE (2), LAMP (8)");
  KernelRig(with("\"DOOR\""))
      .expect_problem(core::Code::P7402, "%IX0.0: " + chip.name() + " has no line \"DOOR\"", "LAMP (8)");
  KernelRig(with("\"TWICE\""))
      .expect_problem(core::Code::P7403, "%IX0.0: lines 1 and 2 of " + chip.name() + " are both named \"TWICE\"",
                      "offset");
  KernelRig(with("7")).expect_problem(core::Code::P7404,
                                      "%IX0.0: line 7 of " + chip.name() + " is in use by \"kernel-led\"", "gpioinfo");
  KernelRig(with("\"LAMP\""))
      .expect_problem(core::Code::P7405, "%IX0.0 and %QX0.0 are both line 8 of " + chip.name(), "one variable");
  KernelRig(panel("gpiochip99", kTwoByTwo))
      .expect_problem(core::Code::P7401, "GPIO chip \"gpiochip99\" cannot be opened: No such file or directory",
                      chip.name() + " [plc-a] (16 lines)");
  KernelRig(panel("/dev/null", kTwoByTwo))
      .expect_problem(core::Code::P7401, "GPIO chip \"/dev/null\" cannot be opened: Inappropriate ioctl for device",
                      "plc-a");
  EXPECT_FALSE(chip.value(8)) << "no output was requested on the way";

  KernelRig first(panel("plc-a", kTwoByTwo));
  ASSERT_NO_FATAL_FAILURE(first.open());
  KernelRig(panel("plc-a", kTwoByTwo))
      .expect_problem(core::Code::P7404, "%IX0.0: line 1 of " + chip.name() + " is in use by \"plc-run\"", "gpioinfo");
  first.drivers.at(0)->close();
  KernelRig again(panel("plc-a", kTwoByTwo));
  ASSERT_NO_FATAL_FAILURE(again.open());
}

TEST(GpioDriver, AChipThatVanishesAndComesBack) {
  SimChip chip("plc-a", {});
  KernelRig rig(panel(
      "plc-a", std::string(kTwoByTwo) + "[inputs.\"%IX0.2\"]\ndriver = \"panel\"\nchannel = 2\nlatch = \"rising\"\n",
      "ok = \"ok\"\non_loss = \"zero\""));
  ASSERT_NO_FATAL_FAILURE(rig.open());
  chip.pull(1, true);
  rig.cycle();
  EXPECT_EQ(rig.value("in0") + rig.value("ok"), "11");
  chip.unplug();
  rig.cycle();
  EXPECT_EQ(rig.value("in0") + rig.value("ok"), "00");
  EXPECT_EQ(rig.serve(), "panel: plc-a does not answer: No such device; its inputs read FALSE\n");
  rig.simulation->run_cycles(5);
  EXPECT_EQ(rig.serve(), "");
  EXPECT_NE(rig.drivers.at(0)->status().problem.find("GPIO chip \"plc-a\" cannot be opened"), std::string::npos);
  EXPECT_FALSE(rig.drivers.at(0)->drive_safe()) << "there is nothing to drive";

  chip.plug();  // under another name: this kernel never gives that of a chip away that vanished while in use
  rig.simulation->run_cycles(2);
  EXPECT_NE(rig.serve().find("panel: plc-a is back after"), std::string::npos);
  chip.pull(1, true);
  rig.cycle();
  EXPECT_EQ(rig.value("in0") + rig.value("ok"), "11");
  chip.pull(2, true);
  usleep(3000);
  chip.pull(2, false);
  usleep(3000);
  rig.cycle();
  EXPECT_EQ(rig.value("in2"), "1") << "latches work again, too";
}

TEST(GpioDriver, SafeValuesOverAFreshRequest) {
  SimChip chip("plc-a", {});
  KernelRig rig(panel("plc-a", "[outputs]\n\"%QX0.0\" = { driver = \"panel\", channel = 8, safe = true }\n"));
  ASSERT_NO_FATAL_FAILURE(rig.open());
  rig.cycle();
  EXPECT_FALSE(chip.value(8));
  chip.unplug();
  rig.drivers.at(0)->release_if_gone();
  chip.plug();
  EXPECT_FALSE(chip.value(8));
  EXPECT_TRUE(rig.drivers.at(0)->drive_safe());
  EXPECT_TRUE(chip.value(8));
}

}  // namespace
}  // namespace plc::test
