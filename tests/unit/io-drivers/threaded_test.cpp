// A driver that is slow does not slow the task it serves.
#include "io-drivers/threaded.h"

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/memory/global_ports.h"
#include "runtime/sched/realtime.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

/// Counts into an input, sees an output, takes 20 ms for either.
class SlowDevice final : public io::Driver {
 public:
  struct Seen {
    std::atomic<std::int32_t> reads{0};
    std::atomic<std::int32_t> output{-1};
    std::atomic<bool> safe{false};
    std::atomic<bool> closed{false};
    std::atomic<bool> late{false};  ///< an exchange after it was made safe
  };
  SlowDevice(runtime::Resource& resource, Seen& seen) : seen_(seen), resource_(resource) {
    const runtime::Access access(resource);
    in_ = *access.find("in");
    out_ = *access.find("out");
    const std::uint32_t fields[] = {0};
    inputs_.emplace(resource.globals(), fields);
    outputs_.emplace(resource.globals());
  }
  [[nodiscard]] std::string_view name() const override { return "slow"; }
  [[nodiscard]] io::Timing timing() const override { return io::Timing::kBounded; }
  [[nodiscard]] std::uint32_t task() const override { return 0; }
  std::optional<core::Problem> open() override { return std::nullopt; }
  std::vector<io::Sentence> service(core::TimeNs) override { return {}; }
  [[nodiscard]] io::DriverStatus status() const override { return {}; }
  [[nodiscard]] std::vector<io::InputStatus> inputs(core::TimeNs) const override { return {}; }
  bool drive_safe() noexcept override { return true; }
  [[nodiscard]] bool has_outputs() const override { return true; }
  void close() noexcept override { seen_.closed = true; }
  void before_scan(const runtime::ReleaseContext&) noexcept override {
    if (seen_.safe) seen_.late = true;
    clock_.sleep_until_ns(clock_.now_ns() + 20'000'000);
    const std::int32_t value = ++seen_.reads;
    inputs_->set(in_.offset, in_.type, reinterpret_cast<const std::byte*>(&value));
    inputs_->publish();
  }
  void after_scan(const runtime::ReleaseContext&) noexcept override {
    std::int32_t value = 0;
    outputs_->take();
    outputs_->read(out_.offset, sizeof value, reinterpret_cast<std::byte*>(&value));
    clock_.sleep_until_ns(clock_.now_ns() + 20'000'000);
    seen_.output = value;
  }
  void safe_state() noexcept override { seen_.safe = true; }

 private:
  Seen& seen_;
  runtime::Resource& resource_;
  runtime::Place in_, out_;
  std::optional<runtime::GlobalInputs> inputs_;
  std::optional<runtime::GlobalReader> outputs_;
  core::MonotonicClock clock_;
};

/// A task of 1 ms whose program copies `in` to `out`.
auto copy_in_to_out() {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word in = b.global("in", dint, {}, {.input = true});
  const Word out = b.global("out", dint);
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  main.op(Opcode::kMove32, {out, in});
  b.task("Cyclic", 1'000'000, {main.finish()});
  return load(b);
}

TEST(Threaded, ASlowDeviceLeavesItsTaskAlone) {
  const auto resource = copy_in_to_out();
  ASSERT_NE(resource, nullptr);
  SlowDevice::Seen seen;
  io::ThreadedDriver driver(std::make_unique<SlowDevice>(*resource, seen), 1'000'000);
  ASSERT_FALSE(driver.open().has_value());
  runtime::RealtimeOptions options;
  options.realtime_priority = false;
  options.lock_memory = false;
  runtime::RealtimeScheduler scheduler(*resource, options);
  driver.start();
  scheduler.add_listener(driver);
  scheduler.start();
  core::MonotonicClock clock;
  const core::TimeNs patience = clock.now_ns() + 20'000'000'000;
  while (seen.output < 3 && clock.now_ns() < patience) clock.sleep_until_ns(clock.now_ns() + 1'000'000);
  const std::uint64_t scans = scheduler.statistics(0).scans;
  const std::int32_t reads = seen.reads;
  scheduler.request_stop();
  scheduler.join();
  driver.close();
  EXPECT_GE(seen.output, 3) << "an input came through the program to the output";
  EXPECT_GT(scans, 4 * static_cast<std::uint64_t>(reads)) << "the task waited for the device";
  EXPECT_TRUE(seen.safe);
  EXPECT_FALSE(seen.late) << "the thread went on after the safe state";
  EXPECT_TRUE(seen.closed);
  EXPECT_EQ(driver.timing(), io::Timing::kThreaded);
}

TEST(Threaded, ALongPollHoldsUpNoEnd) {
  const auto resource = copy_in_to_out();
  ASSERT_NE(resource, nullptr);
  SlowDevice::Seen seen;
  io::ThreadedDriver driver(std::make_unique<SlowDevice>(*resource, seen), 600'000'000'000);
  driver.start();
  core::MonotonicClock clock;
  const core::TimeNs patience = clock.now_ns() + 20'000'000'000;
  while (seen.output < 0 && clock.now_ns() < patience) clock.sleep_until_ns(clock.now_ns() + 1'000'000);
  const core::TimeNs began = clock.now_ns();
  driver.safe_state();
  driver.close();
  EXPECT_LT(clock.now_ns() - began, 300'000'000'000);
  EXPECT_TRUE(seen.safe);
  EXPECT_TRUE(seen.closed);
}

/// Told to the end, it waits until two of its kind are.
class MeetingDriver final : public io::Driver {
 public:
  struct Seen {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<std::string> told;
  };
  MeetingDriver(Seen& seen, std::string name, io::Timing timing)
      : seen_(seen), name_(std::move(name)), timing_(timing) {}
  [[nodiscard]] std::string_view name() const override { return name_; }
  [[nodiscard]] io::Timing timing() const override { return timing_; }
  [[nodiscard]] std::uint32_t task() const override { return 0; }
  std::optional<core::Problem> open() override { return std::nullopt; }
  std::vector<io::Sentence> service(core::TimeNs) override { return {}; }
  [[nodiscard]] io::DriverStatus status() const override { return {}; }
  [[nodiscard]] std::vector<io::InputStatus> inputs(core::TimeNs) const override { return {}; }
  bool drive_safe() noexcept override { return true; }
  [[nodiscard]] bool has_outputs() const override { return true; }
  void close() noexcept override {
    std::unique_lock lock(seen_.mutex);
    seen_.told.push_back(name_);
    seen_.changed.notify_all();
    const bool waits = timing_ == io::Timing::kThreaded;
    if (waits) seen_.changed.wait_for(lock, std::chrono::seconds(60), [&] { return seen_.told.size() == 3; });
  }
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext&) noexcept override {}
  void safe_state() noexcept override {}

 private:
  Seen& seen_;
  std::string name_;
  io::Timing timing_;
};

TEST(Driver, TheEndOfOneDoesNotWaitForAnother) {
  MeetingDriver::Seen seen;
  MeetingDriver a(seen, "a", io::Timing::kThreaded), b(seen, "b", io::Timing::kThreaded);
  MeetingDriver panel(seen, "panel", io::Timing::kBounded);
  io::Driver* const all[] = {&a, &b, &panel};
  const auto began = std::chrono::steady_clock::now();
  io::for_all_at_once(all, [](io::Driver& driver) { driver.close(); });
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(50));
  ASSERT_EQ(seen.told.size(), 3u);
  EXPECT_EQ(seen.told[0], "panel") << "what cannot hang comes first";
}

}  // namespace
}  // namespace plc::test
