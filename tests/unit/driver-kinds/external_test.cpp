// Kinds of a library, without the library: its row, its numbers, and what becomes of a device that fails.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "io-drivers/external/external_driver.h"
#include "io-drivers/external/external_types.h"
#include "io-drivers/machine/driver_types.h"
#include "io-drivers/numbers.h"
#include "picard/driver.h"
#include "runtime/access.h"
#include "tests/support/image_builder.h"

namespace plc::io {
namespace {

using core::TypeId;
using test::ImageBuilder;

/// The device: what it reads, what was written to it, and how it fails.
struct Device {
  std::mutex mutex;
  std::vector<double> inputs{1.5, 0};
  std::vector<double> written;
  bool there = true;
  bool readable = true;
  int failing = 0;  ///< calls that fail
  int opened = 0, closed = 0;
  std::string settings;

  template <class Get>
  auto locked(Get get) {
    const std::scoped_lock lock(mutex);
    return get();
  }
  void fail_or_go() {
    if (!there) throw picard::Failure("no acknowledge");
    if (failing > 0) {
      --failing;
      throw picard::Failure::format("error %d", 5);
    }
  }
};
Device device;

constexpr picard_key kDriverKeys[] = {
    picard::text("place", nullptr, "Where it is.", "\"rack\""),
    picard::integer("gain", 1, 9, "3", "Factor."),
    picard::choice("speed", "slow|fast", "\"fast\"", "How fast."),
    picard::duration("rest", "1ms", "1s", "\"2ms\"", "Between two."),
    picard::boolean("loud", "true", "Whether."),
};
constexpr picard_key kChannelKeys[] = {picard::integer("channel", 0, 7, nullptr, "Number.", "0")};

class Card final : public picard::Driver {
 public:
  static constexpr picard::DriverInfo info{.name = "card",
                                           .summary = "a card.",
                                           .example = "rack",
                                           .device = "place",
                                           .driver_keys = kDriverKeys,
                                           .channel_keys = kChannelKeys};
  explicit Card(const picard::DriverConfig& config) {
    if (config.settings[1].number == 9) throw picard::Failure("a gain of 9 is too much");
    device.settings = std::string(config.name) + ": " + config.settings[0].text;
    for (int i = 1; i < 5; ++i)
      device.settings += " " + std::string(config.settings[i].text) + "=" + std::to_string(config.settings[i].number);
    for (std::uint32_t i = 0; i < config.input_count; ++i)
      device.settings += " in " + std::string(config.inputs[i].variable) + "@" + config.inputs[i].settings[0].text;
    for (std::uint32_t i = 0; i < config.output_count; ++i)
      device.settings += " out " + std::string(config.outputs[i].variable) + "@" + config.outputs[i].settings[0].text;
  }
  void open() override {
    const std::scoped_lock lock(device.mutex);
    ++device.opened;
    device.fail_or_go();
  }
  void read(std::span<double> inputs) override {
    const std::scoped_lock lock(device.mutex);
    device.fail_or_go();
    if (!device.readable) throw picard::Failure("nothing to read");
    std::copy_n(device.inputs.begin(), inputs.size(), inputs.begin());
  }
  void write(std::span<const double> outputs) override {
    const std::scoped_lock lock(device.mutex);
    device.fail_or_go();
    device.written.assign(outputs.begin(), outputs.end());
  }
  void close() noexcept override {
    const std::scoped_lock lock(device.mutex);
    ++device.closed;
  }
};

/// The kinds that PICARD comes with, and this one.
DriverTypes types() {
  static const picard_driver_kind kind = picard::detail::driver_kind<Card>();
  static const std::vector<const DriverType*> all = [] {
    std::vector<const DriverType*> known(driver_types().begin(), driver_types().end());
    known.push_back(make_external_type(kind));
    return known;
  }();
  return all;
}

const std::string kRack =
    "[drivers.rack]\nkind = \"card\"\nplace = \"slot 1\"\npoll = \"1ms\"\nretry = \"20ms\"\nok = \"Good\"\n";
const std::string kChannels =
    "[inputs]\nLevel = { driver = \"rack\", channel = 0 }\nDoor = { driver = \"rack\", channel = 1, invert = true }\n"
    "[outputs]\nSpeed = { driver = \"rack\", channel = 2, safe = 7, initial = 8 }\n"
    "Motor = { driver = \"rack\", channel = 3, invert = true }\n";

class External : public testing::Test {
 protected:
  void SetUp() override {
    device.locked([] {
      device.inputs = {1.5, 0};
      device.written.clear();
      device.there = device.readable = true;
      device.failing = device.opened = device.closed = 0;
      return 0;
    });
    ImageBuilder b;
    b.global("Level", b.type(TypeId::kReal), {}, {.input = true});
    b.global("Door", b.type(TypeId::kBool), {}, {.input = true});
    b.global("Good", b.type(TypeId::kBool), {}, {.input = true});
    const auto speed = b.global("Speed", b.type(TypeId::kInt), {}, {});
    b.global("Motor", b.type(TypeId::kBool), {}, {});
    const auto hundred = b.constant<std::int16_t>(TypeId::kInt, 100);
    auto main = b.pou("Main", bytecode::PouKind::kProgram);
    main.op(bytecode::Opcode::kAdd16, {speed, hundred, hundred});
    b.task("T", 1'000'000, {main.finish()});
    core::Diagnostics diagnostics;
    auto verified = bytecode::verify(b.build(), diagnostics);
    for (const core::Diagnostic& d : diagnostics.all()) ADD_FAILURE() << diagnostics.render_one(d);
    resource_ = std::move(runtime::Resource::load(std::move(verified.value())).value());
  }
  /// The problems of the file, or empty and a driver.
  std::string make(const std::string& text) {
    core::Diagnostics diagnostics;
    configuration_ = read_configuration(text, "plc.toml", types(), diagnostics);
    if (configuration_) binding_ = bind(*configuration_, *resource_, diagnostics);
    std::string all;
    for (const core::Diagnostic& d : diagnostics.all()) {
      if (d.severity == core::Severity::kError) all += diagnostics.render_one(d) + '\n';
    }
    if (!all.empty()) return all;
    const BoundDriver& bound = binding_->drivers.front();
    driver_ = bound.config->type->make(bound, *configuration_, *resource_);
    return {};
  }
  std::string value(const std::string& path) {
    const runtime::Access access(*resource_);
    return access.read(*access.find(path), runtime::ValueStyle::kNames);
  }
  bool soon(const std::function<bool()>& condition) {
    for (int i = 0; i < 2000; ++i) {
      for (Sentence& sentence : driver_->service(0)) said_ += sentence.text + '\n';
      if (condition()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  bool shows(const std::string& path, const std::string& wanted) {
    return soon([&] { return value(path) == wanted; });
  }
  /// The device is there, and has what the program wants.
  void run_rack() {
    ASSERT_EQ(make(kRack + kChannels), "");
    ASSERT_EQ(driver_->check(), std::nullopt);
    ASSERT_EQ(driver_->open(), std::nullopt);
    resource_->program(0).execute({});
    driver_->start();
    ASSERT_TRUE(wrote({200, 1}));
  }
  bool wrote(const std::vector<double>& wanted) {
    return soon([&] { return device.locked([] { return device.written; }) == wanted; });
  }
  std::unique_ptr<runtime::Resource> resource_;
  std::optional<Configuration> configuration_;
  std::optional<Binding> binding_;
  std::unique_ptr<Driver> driver_;
  std::string said_;
};

TEST_F(External, ItsKeysAreCheckedLikeThoseOfOthers) {
  EXPECT_EQ(make("[drivers.a]\nkind = \"card\"\ngain = 10\n"),
            "plc.toml:1:10: error P7306: driver \"a\" has no \"place\"\n  help: add place = \"rack\"\n"
            "plc.toml:3:8: error P7305: \"gain\" is \"10\"; it takes a whole number from 1 to 9\n");
  EXPECT_EQ(
      make(kRack + "[inputs]\nLevel = { driver = \"rack\", channel = 1 }\nDoor = { driver = \"rack\", channel = 1 }\n"),
      "plc.toml:9:37: error P7310: input 1 of slot 1 is used already, by \"Level\" in line 8\n");
}

TEST_F(External, TheLibraryIsToldWhatTheFileSays) {
  ASSERT_EQ(make(kRack + "speed = \"slow\"\n" + kChannels), "");
  EXPECT_EQ(driver_->check(), std::nullopt);
  EXPECT_EQ(device.settings, "rack: slot 1 3=3 slow=0 2ms=2000000 true=1 in Level@0 in Door@1 out Speed@2 out Motor@3");
  EXPECT_EQ(device.opened, 0) << "nothing is touched";
  driver_.reset();
  SetUp();
  ASSERT_EQ(make(kRack + "gain = 9\n"), "");
  const auto problem = driver_->check();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code, core::Code::P7421);
  EXPECT_EQ(problem->message, "rack: a gain of 9 is too much");
}

TEST_F(External, ExchangesNumbersAndDrivesInitialAndSafeValues) {
  ASSERT_EQ(make(kRack + kChannels), "");
  ASSERT_EQ(driver_->check(), std::nullopt);
  ASSERT_EQ(driver_->open(), std::nullopt);
  EXPECT_EQ(device.written, (std::vector<double>{8, 1})) << "initial; FALSE inverted is 1";
  EXPECT_EQ(value("Level"), "1.5");
  EXPECT_EQ(value("Door"), "1");
  EXPECT_EQ(value("Good"), "1");
  resource_->program(0).execute({});
  driver_->start();
  EXPECT_TRUE(wrote({200, 1}));
  device.locked([] { return device.inputs = {-2.25, 1}; });
  EXPECT_TRUE(shows("Level", "-2.25"));
  EXPECT_TRUE(shows("Door", "0"));
  driver_->task_stopped(0);
  EXPECT_TRUE(wrote({7, 1})) << "safe";
  driver_->safe_state();
  driver_->close();
  EXPECT_EQ(device.closed, device.opened);
  EXPECT_EQ(said_, "");
}

TEST_F(External, OneErrorIsNoLossAndALostDeviceComesBack) {
  ASSERT_NO_FATAL_FAILURE(run_rack());
  device.locked([] { return device.failing = 3; });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(driver_->status().losses, 0u);
  device.locked([] { return device.there = false; });
  EXPECT_TRUE(shows("Good", "0"));
  EXPECT_EQ(value("Level"), "1.5") << "on_loss = hold";
  EXPECT_FALSE(driver_->status().connected);
  EXPECT_EQ(driver_->inputs(0).front().quality, Quality::kLost);
  device.locked([] {
    device.written.clear();
    return device.there = true;
  });
  EXPECT_TRUE(shows("Good", "1"));
  EXPECT_TRUE(wrote({200, 1})) << "what the program wants";
  EXPECT_NE(said_.find("rack: the device is lost: no acknowledge; its inputs keep their last values\n"),
            std::string::npos)
      << said_;
  EXPECT_TRUE(soon([&] { return said_.find("rack: the device is there after ") != std::string::npos; })) << said_;
  EXPECT_EQ(driver_->status().recoveries, 1u);
  driver_->close();
}

TEST_F(External, ADeviceThatTakesWritesAloneIsLostAndEndsSafe) {
  ASSERT_NO_FATAL_FAILURE(run_rack());
  device.locked([] { return device.readable = false; });
  EXPECT_TRUE(shows("Good", "0")) << "its inputs stand still";
  EXPECT_TRUE(soon([&] { return said_.find("rack: the device is lost: nothing to read") != std::string::npos; }))
      << said_;
  driver_->safe_state();
  driver_->close();
  EXPECT_EQ(device.written, (std::vector<double>{7, 1}));
  EXPECT_EQ(device.closed, device.opened);
  driver_->close();
  EXPECT_EQ(device.closed, device.opened) << "once is enough";
}

TEST_F(External, ADeviceThatIsNotThereEndsTheStartUnlessItMayWait) {
  device.there = false;
  ASSERT_EQ(make(kRack + kChannels), "");
  ASSERT_EQ(driver_->check(), std::nullopt);
  const auto problem = driver_->open();
  ASSERT_TRUE(problem);
  EXPECT_EQ(problem->code, core::Code::P7421);
  EXPECT_EQ(problem->message, "rack: the device cannot be opened: no acknowledge");
  EXPECT_EQ(device.closed, device.opened);
}

TEST_F(External, ALateDeviceIsTakenWhenItIsThere) {
  device.there = false;
  ASSERT_EQ(make(kRack + "wait = true\non_loss = \"zero\"\n" + kChannels), "");
  ASSERT_EQ(driver_->check(), std::nullopt);
  ASSERT_EQ(driver_->open(), std::nullopt);
  driver_->start();
  EXPECT_TRUE(soon([&] { return said_.find("control runs without it") != std::string::npos; })) << said_;
  EXPECT_EQ(value("Good"), "0");
  device.locked([] { return device.there = true; });
  EXPECT_TRUE(shows("Good", "1"));
  EXPECT_EQ(value("Level"), "1.5");
  device.locked([] { return device.there = false; });
  EXPECT_TRUE(shows("Level", "0")) << "on_loss = zero";
  driver_->close();
}

TEST_F(External, TheGuardianDrivesSafeValuesThroughItsCopy) {
  ASSERT_EQ(make(kRack + kChannels), "");
  ASSERT_EQ(driver_->check(), std::nullopt);
  ASSERT_EQ(driver_->open(), std::nullopt);
  EXPECT_TRUE(driver_->drive_safe());
  EXPECT_EQ(device.written, (std::vector<double>{7, 1}));
  device.failing = 2;  // the handle of before
  device.written.clear();
  EXPECT_TRUE(driver_->drive_safe());
  EXPECT_EQ(device.written, (std::vector<double>{7, 1}));
  EXPECT_EQ(device.opened, 2);
  device.readable = false;
  device.failing = 2;
  device.written.clear();
  EXPECT_TRUE(driver_->drive_safe()) << "inputs do not matter";
  EXPECT_EQ(device.written, (std::vector<double>{7, 1}));
  device.there = false;
  EXPECT_FALSE(driver_->drive_safe());
}

TEST(DeviceProblems, AreThoseThatAnotherStartMayNotFind) {
  for (const core::Code code :
       {core::Code::P7401, core::Code::P7404, core::Code::P7406, core::Code::P7410, core::Code::P7421})
    EXPECT_TRUE(is_about_devices(code)) << core::info(code).name;
  for (const core::Code code : {core::Code::P7402, core::Code::P7405, core::Code::P7420, core::Code::P7001})
    EXPECT_FALSE(is_about_devices(code)) << core::info(code).name;
}

TEST(DeviceNumbers, AreTheNearestThatTheTypeHas) {
  const auto through = [](TypeId type, double number) {
    std::byte value[8]{};
    store_number(type, number, value);
    return load_number(type, value);
  };
  EXPECT_EQ(through(TypeId::kInt, 40000), 32767);
  EXPECT_EQ(through(TypeId::kInt, -1e300), -32768);
  EXPECT_EQ(through(TypeId::kInt, 2.5), 2);
  EXPECT_EQ(through(TypeId::kInt, 3.5), 4);
  EXPECT_EQ(through(TypeId::kUint, -1), 0);
  EXPECT_EQ(through(TypeId::kByte, 255.4), 255);
  EXPECT_EQ(through(TypeId::kLint, 1e300), 9223372036854775807.0);
  EXPECT_EQ(through(TypeId::kUlint, 1e300), 18446744073709551615.0);
  EXPECT_EQ(through(TypeId::kDint, std::nan("")), 0);
  EXPECT_EQ(through(TypeId::kReal, 0.1), static_cast<double>(0.1f));
  EXPECT_EQ(through(TypeId::kLreal, 0.1), 0.1);
  EXPECT_EQ(through(TypeId::kBool, -0.5), 1);
  EXPECT_EQ(through(TypeId::kBool, std::nan("")), 0);
  EXPECT_EQ(through(TypeId::kBool, 0), 0);
}

TEST(ExternalKinds, ThatAreWrongAreRefused) {
  const picard_driver_kind good = picard::detail::driver_kind<Card>();
  EXPECT_EQ(complaint(good, driver_types()), "");
  const auto wrong = [&](const std::function<void(picard_driver_kind&)>& change) {
    picard_driver_kind kind = good;
    change(kind);
    return complaint(kind, driver_types());
  };
  EXPECT_EQ(wrong([](auto& k) { k.name = "gpio"; }), "kind \"gpio\": there is one of this name already");
  EXPECT_EQ(wrong([](auto& k) { k.name = "a b"; }), "a kind has no name of letters, digits, _ and -");
  EXPECT_EQ(wrong([](auto& k) { k.name = nullptr; }), "a kind has no name of letters, digits, _ and -");
  EXPECT_EQ(wrong([](auto& k) { k.write = nullptr; }), "kind \"card\": it lacks a function");
  EXPECT_EQ(wrong([](auto& k) { k.summary = nullptr; }), "kind \"card\": it lacks a text");
  EXPECT_EQ(wrong([](auto& k) { k.device = "bus"; }), "kind \"card\": there is no key \"bus\"");
  const auto with = [&](picard_key key) {
    return wrong([&](auto& k) {
      k.driver_keys = &key;
      k.driver_key_count = 1;
      k.device = "";
    });
  };
  EXPECT_EQ(with(picard::text("retry", "\"\"", "")), "kind \"card\": key \"retry\" is there already");
  EXPECT_EQ(with(picard::integer("n", 1, 9, "10", "")), "kind \"card\": 10 is no value of key \"n\"");
  EXPECT_EQ(with(picard::choice("n", "a|b", "\"c\"", "")), "kind \"card\": \"c\" is no value of key \"n\"");
  EXPECT_EQ(with(picard::text("n", "plain", "")), "kind \"card\": plain is no value of key \"n\"");
  EXPECT_EQ(with(picard::duration("n", "1 ms", "x", nullptr, "")), "kind \"card\": key \"n\" has no limits");
  EXPECT_EQ(with(picard::duration("n", "1ms", "1s", "\"2s\"", "")), "kind \"card\": \"2s\" is no value of key \"n\"");
  EXPECT_EQ(with(picard::boolean("n", "yes", "")), "kind \"card\": yes is no value of key \"n\"");
  EXPECT_EQ(with(picard::boolean("n", "true", nullptr)), "kind \"card\": key \"n\" lacks a text");
}

}  // namespace
}  // namespace plc::io
