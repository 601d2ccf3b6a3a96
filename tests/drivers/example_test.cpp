// examples/driver-ads1115 as its README tells, on a simulated bus.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <regex>
#include <string>
#include <thread>

#include "tests/drivers/i2c_bus.h"
#include "tests/support/plc_run.h"
#include "tests/support/run_tool.h"

namespace plc::test {
namespace {

namespace fs = std::filesystem;

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Example : public testing::Test {
 protected:
  void SetUp() override {
    ::umask(022);
    fs::create_directory(scratch.file("build"));
    ::chmod(scratch.file("build").c_str(), 0755);
    fs::copy_file(PLC_ADS1115, scratch.file("build/ads1115.so"));
    ::chmod(scratch.file("build/ads1115.so").c_str(), 0755);
    fs::copy_file(fs::path(PLC_EXAMPLE) / "plant.st", scratch.file("plant.st"));
    configure("range = \"4.096\"\npoll = \"5ms\"\nretry = \"50ms\"\nok = \"AnalogOk\"\n");
    bus_ = ::open(scratch.file("bus").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    const I2cBus bus;
    ASSERT_EQ(::pwrite(bus_, &bus, sizeof bus, 0), static_cast<ssize_t>(sizeof bus));
  }
  void TearDown() override { ::close(bus_); }
  void configure(const std::string& keys, const std::string& channels = kChannels) const {
    std::ofstream(scratch.file("plc.toml"))
        << "[modbus]\nlisten = \"off\"\n[driver_kinds]\nlibraries = [\"build/ads1115.so\"]\n"
           "[drivers.analog]\nkind = \"ads1115\"\nbus = \""
        << kBusDevice << "\"\naddress = 0x49\n"
        << keys << channels;
  }
  /// Volts at AIN0 and AIN1.
  void set_volts(double first, double second) const {
    const std::int16_t volts[] = {static_cast<std::int16_t>(first * 8000), static_cast<std::int16_t>(second * 8000)};
    ASSERT_EQ(::pwrite(bus_, volts, sizeof volts, offsetof(I2cBus, volts)), static_cast<ssize_t>(sizeof volts));
  }
  void set_there(std::int32_t there) const {
    ASSERT_EQ(::pwrite(bus_, &there, sizeof there, offsetof(I2cBus, there)), static_cast<ssize_t>(sizeof there));
  }
  static constexpr const char* kChannels =
      "[inputs]\nPotentiometer = { driver = \"analog\", channel = 0 }\n"
      "PressureVolts = { driver = \"analog\", channel = 1 }\n";
  ScratchFolder scratch;
  int bus_ = -1;
};

/// plc-run on the simulated bus, with the output of --watch and the log in files.
class Plant {
 public:
  explicit Plant(const ScratchFolder& scratch) : out_(scratch.file("out")), err_(scratch.file("err")) {
    pid_ = fork();
    if (pid_ != 0) return;
    const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    const int err = ::open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    setenv(kBusVariable, scratch.file("bus").c_str(), 1);
    setenv("LD_PRELOAD", PLC_I2C_BUS, 1);
    const std::string plant = scratch.file("plant.st"), configuration = scratch.file("plc.toml");
    alarm(60);
    execl(PLC_RUN_TOOL, PLC_RUN_TOOL, plant.c_str(), "--config", configuration.c_str(), "--engineering", "off",
          "--watch", "*", nullptr);
    _exit(99);
  }
  ~Plant() {
    if (pid_ > 0) kill(pid_, SIGKILL), waitpid(pid_, nullptr, 0);
  }
  Plant(const Plant&) = delete;
  Plant& operator=(const Plant&) = delete;

  [[nodiscard]] std::string out() const { return text_of(out_); }
  [[nodiscard]] std::string err() const { return text_of(err_); }
  /// The last value that --watch has shown.
  [[nodiscard]] std::string value(const std::string& name) const {
    const std::string text = out();
    const std::size_t at = text.rfind(name + "=");
    if (at == std::string::npos) return {};
    const std::size_t begin = at + name.size() + 1;
    return text.substr(begin, text.find_first_of(" \n", begin) - begin);
  }
  [[nodiscard]] bool soon(const std::function<bool()>& condition) const {
    for (int i = 0; i < 1500; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }
  int stop() {
    kill(pid_, SIGTERM);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  std::string out_, err_;
  pid_t pid_ = 0;
};

TEST_F(Example, ReadsVoltsAndGetsOverALoss) {
  set_volts(1.25, 2.5);
  Plant plant(scratch);
  EXPECT_TRUE(plant.soon([&] { return plant.value("PressureVolts") == "2.5"; })) << plant.out() << plant.err();
  EXPECT_EQ(plant.value("Potentiometer"), "1.25");
  EXPECT_EQ(plant.value("AnalogOk"), "1");
  EXPECT_TRUE(plant.soon([&] { return plant.value("Bar") == "5"; })) << plant.out();
  set_volts(-0.5, 0.1);
  EXPECT_TRUE(plant.soon([&] { return plant.value("WireBroken") == "1"; })) << plant.out();
  EXPECT_EQ(plant.value("Potentiometer"), "-0.5");
  set_there(0);
  EXPECT_TRUE(plant.soon([&] { return plant.value("AnalogOk") == "0"; })) << plant.out();
  EXPECT_EQ(plant.value("Potentiometer"), "-0.5") << "held";
  EXPECT_TRUE(plant.soon([&] {
    return contains(plant.err(),
                    "warning: analog: the device is lost: /dev/i2c-77, address 73: No such device or address; "
                    "its inputs keep their last values");
  })) << plant.err();
  set_volts(0.75, 2.5);
  set_there(1);
  EXPECT_TRUE(plant.soon([&] { return plant.value("AnalogOk") == "1" && plant.value("Potentiometer") == "0.75"; }))
      << plant.out();
  EXPECT_TRUE(plant.soon([&] { return contains(plant.err(), "note: analog: the device is there after "); }))
      << plant.err();
  EXPECT_EQ(plant.stop(), 0) << plant.err();
}

TEST_F(Example, IsCheckedBeforeItRuns) {
  const auto check = [&] {
    return run_tool({PLC_TOOL, "config", "check", scratch.file("plc.toml"), scratch.file("plant.st")});
  };
  EXPECT_EQ(check().code, 0) << check().all();
  configure("range = \"5\"\n");
  EXPECT_TRUE(contains(check().err, "plc.toml:9:9: error P7305: \"range\" is \"5\"; it takes one of \"6.144\""))
      << check().all();
  configure("", "[inputs]\nPressureVolts = { driver = \"analog\", channel = 4 }\n");
  EXPECT_TRUE(contains(check().err, "error P7305: \"channel\" is \"4\"; it takes a whole number from 0 to 3"))
      << check().all();
  ::chmod(scratch.file("build/ads1115.so").c_str(), 0777);
  EXPECT_TRUE(contains(check().err, "error P7420: ")) << check().all();
  EXPECT_TRUE(contains(check().err, "may be written by everybody")) << check().all();
  fs::remove(scratch.file("build/ads1115.so"));
  EXPECT_TRUE(contains(check().err, "plc.toml:4:14: error P7420: ")) << check().all();
}

TEST_F(Example, SaysThatItsBusIsNotThere) {
  configure("");
  const auto run = [&] {
    return run_plant({scratch.file("plant.st"), "--config", scratch.file("plc.toml"), "--duration", "500ms"});
  };
  const auto refused = run();
  EXPECT_EQ(refused.code, 4);
  EXPECT_TRUE(
      contains(refused.err, "error P7421: analog: the device cannot be opened: /dev/i2c-77: No such file or directory"))
      << refused.all();
  configure("wait = true\n");
  const auto waits = run();
  EXPECT_EQ(waits.code, 0) << waits.all();
  EXPECT_TRUE(contains(waits.err, "control runs without it, it is tried again")) << waits.all();
}

TEST_F(Example, ItsFileIsTheOneOfTheGuide) {
  const std::string file = text_of(fs::path(PLC_EXAMPLE) / "plc.toml");
  std::ofstream(scratch.file("plc.toml")) << file;
  const auto checked = run_tool({PLC_TOOL, "config", "check", scratch.file("plc.toml"), scratch.file("plant.st")});
  EXPECT_EQ(checked.code, 0) << checked.all();
}

}  // namespace
}  // namespace plc::test
