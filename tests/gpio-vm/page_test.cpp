// The examples of the pages of docs/problems that need GPIO lines: plc-run with the configuration of the page, on a
// machine such as the page describes.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "tests/gpio-vm/sim_chip.h"
#include "tests/support/problem_page.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;

const std::string kPages = "/srv/problems/";
/// The name that the pages give to the machine's chip.
const std::string kChipOfPages = "gpiochip0";

/// plc-run's exit code and output with the example's configuration. Given a command to run right before, the project is
/// compiled before that and plc-run gets the image, so that it needs no process for the compiler.
ToolResult run(const Example& example, const std::string& chip, const std::string& before = "") {
  const ScratchFolder folder;
  std::string toml = example.files.at("plc.toml");
  for (std::size_t at = 0; (at = toml.find(kChipOfPages, at)) != std::string::npos; at += chip.size()) {
    toml.replace(at, kChipOfPages.size(), chip);
  }
  write_text(folder.file("plc.toml"), toml);
  write_text(folder.file("example.st"), kSmallProject);
  std::string project = "example.st";
  std::string first = before;
  if (!before.empty()) {
    project = "example.pbc";
    first = "plc compile example.st --config plc.toml -o " + project + "; " + before;
  }
  return run_tool({"/bin/sh", "-ec",
                   "cd \"$0\"; " + first + "exec plc-run " + project +
                       " --config plc.toml --modbus off --engineering off --cycles 3",
                   folder.file("")});
}

/// `exit_code`: 4 where another start may succeed, 1 where only another configuration does.
void expect_page_holds(const std::string& code, const std::string& chip, int exit_code = 1) {
  const Example wrong = read_example(kPages + code + ".md", "Wrong");
  const Example right = read_example(kPages + code + ".md", "Right");
  ASSERT_EQ(wrong.files.count("plc.toml") + right.files.count("plc.toml"), 2u);
  const ToolResult bad = run(wrong, chip);
  EXPECT_TRUE(names(bad.all(), code)) << bad.all();
  EXPECT_EQ(bad.code, exit_code) << bad.all();
  const ToolResult good = run(right, chip);
  EXPECT_FALSE(names(good.all(), code)) << good.all();
  EXPECT_EQ(good.code, 0) << good.all();
}

TEST(Pages, LineDoesNotExist) {
  const SimChip chip("plc-page", {.lines = 54});
  expect_page_holds("P7402", chip.name());
}

TEST(Pages, LineNameIsNotUnique) {
  const SimChip chip("plc-page", {.names = {{4, "DI"}, {5, "DI"}}});
  expect_page_holds("P7403", chip.name());
}

TEST(Pages, LineIsInUse) {
  const SimChip chip("plc-page", {.lines = 54, .hogs = {{17, "gpioset"}}});
  expect_page_holds("P7404", chip.name(), 4);
}

TEST(Pages, LineIsBoundTwice) {
  const SimChip chip("plc-page", {.lines = 54, .names = {{17, "GPIO17"}, {22, "GPIO22"}}});
  expect_page_holds("P7405", chip.name());
}

/// A chip on an I2C bus whose interrupt is not wired: a real driver of the kernel on a bus that is none.
class Expander {
 public:
  Expander() {
    for (const auto& bus : fs::directory_iterator("/sys/bus/i2c/devices")) {
      if (text_of(bus.path() / "name").rfind("SMBus stub", 0) == 0) bus_ = bus.path();
    }
    if (!bus_.empty()) write_text(bus_ / "new_device", "pcf8574 0x20");
  }
  ~Expander() {
    if (!bus_.empty()) write_text(bus_ / "delete_device", "0x20");
  }
  Expander(const Expander&) = delete;
  Expander& operator=(const Expander&) = delete;

 private:
  fs::path bus_;
};

TEST(Pages, LineIsRefused) {
  const Expander expander;
  expect_page_holds("P7406", "", 4);
}

/// Runs the service in a control group with the TasksMax of its unit file, as systemd does.
ToolResult run_as_service(const Example& example) {
  const std::string unit = example.files.at("plc-run.service");
  const std::string key = "TasksMax=";
  const std::string most = unit.substr(unit.find(key) + key.size());
  const std::string group = "/sys/fs/cgroup/plc-page";
  fs::create_directories(group);
  write_text(group + "/pids.max", most);
  const SimChip chip("plc-page", {});
  Example output;
  output.files["plc.toml"] = R"(
[drivers.panel]
kind = "gpio"
chip = "gpiochip0"
[outputs]
"%QX0.0" = { driver = "panel", channel = 8 }
)";
  const ToolResult result = run(output, chip.name(), "echo 0 > " + group + "/cgroup.procs; ");
  fs::remove(group);
  return result;
}

TEST(Pages, GuardianCannotStart) {
  ASSERT_EQ(run_tool({"/bin/sh", "-ec",
                      "mount -t cgroup2 none /sys/fs/cgroup; echo +pids > /sys/fs/cgroup/cgroup.subtree_control"})
                .code,
            0);
  const ToolResult bad = run_as_service(read_example(kPages + "P7410.md", "Wrong"));
  EXPECT_TRUE(names(bad.all(), "P7410")) << bad.all();
  EXPECT_EQ(bad.code, 4) << bad.all();
  const ToolResult good = run_as_service(read_example(kPages + "P7410.md", "Right"));
  EXPECT_FALSE(names(good.all(), "P7410")) << good.all();
  EXPECT_EQ(good.code, 0) << good.all();
}

}  // namespace
}  // namespace plc::test
