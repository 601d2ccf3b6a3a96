// Faults of one task while others run: watchdog, loop budget, overrun, and a task that cannot be stopped. What the
// fault touches goes safe, and nothing else notices.
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>

#include "runtime/sched/realtime.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::FaultKind;
using runtime::FaultPolicy;
using runtime::OverrunPolicy;
using runtime::RealtimeScheduler;

constexpr core::TimeNs kMs = 1'000'000;
constexpr std::uint32_t kFast = 0;
constexpr std::uint32_t kBad = 1;

/// A fast task that counts, and a bad one that sets its output to 1 and then loops as long as its budget allows.
struct Plant {
  ImageBuilder b;
  std::uint32_t dint = b.type(TypeId::kDint);
  Word count = b.global("count", dint, {}, {.owner = kFast});
  Word output = b.global("output", dint, {}, {.owner = kBad});
  std::unique_ptr<runtime::Resource> resource;
  runtime::RealtimeOptions options;

  explicit Plant(std::uint32_t loop_budget) {
    const Word one = b.constant<std::int32_t>(TypeId::kDint, 1);
    PouBuilder counter = b.pou("Counter", PouKind::kProgram);
    counter.op(Opcode::kAdd32, {count, count, one});
    PouBuilder spinner = b.pou("Spinner", PouKind::kProgram);
    spinner.op(Opcode::kMove32, {output, one});
    const std::uint32_t top = spinner.here();
    spinner.op(Opcode::kAdd32, {output, output, one});
    spinner.op(Opcode::kLoopJump, {top});
    b.task("Fast", kMs, {counter.finish()}, 0);
    b.task("Bad", 10 * kMs, {spinner.finish()}, 1);
    runtime::ProgramOptions program;
    program.loop_budget = loop_budget;
    resource = load(b, program);
    options.plan = runtime::default_plan(resource->image());
    options.safe_values = {{bytecode::offset_of(output), dint, bytes_of<std::int32_t>(-7)}};
    options.lock_memory = false;
  }
  std::int32_t read(Word global) const {
    std::int32_t value = 0;
    resource->globals().read(bytecode::offset_of(global), 4, reinterpret_cast<std::byte*>(&value));
    return value;
  }
};

/// When tasks were stopped, and how the fast one goes on.
struct Witness : runtime::CycleListener {
  void before_scan(const runtime::ReleaseContext& context) noexcept override {
    if (context.task == kBad && bad_began == 0) bad_began = context.now_ns;
  }
  void after_scan(const runtime::ReleaseContext& context) noexcept override { ++after[context.task]; }
  void safe_state() noexcept override { ++safe; }
  void task_stopped(std::uint32_t task) noexcept override {
    ++stopped[task];
    stopped_at = clock.now_ns();
  }
  core::MonotonicClock clock;
  std::atomic<core::TimeNs> bad_began{0}, stopped_at{0};
  std::atomic<int> after[2]{}, stopped[2]{}, safe{0};
};

bool within(std::chrono::seconds limit, const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

TEST(Watchdog, TakesTheOutputsOfATaskThatSpins) {
  Plant plant(4'000'000'000u);
  constexpr core::TimeNs kWatchdog = 100 * kMs;
  plant.options.plan[kBad].watchdog_ns = kWatchdog;
  Witness witness;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.add_listener(witness);
  scheduler.start();
  ASSERT_TRUE(within(std::chrono::seconds(20), [&] { return witness.stopped[kBad] != 0; }));
  EXPECT_EQ(plant.read(plant.output), -7) << "the declared safe value";
  EXPECT_LT(witness.stopped_at - witness.bad_began, 2 * kWatchdog) << "within one period after the limit";
  const std::vector<runtime::TaskFault> faults = scheduler.new_faults();
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].task, kBad);
  EXPECT_EQ(faults[0].fault.kind, FaultKind::kWatchdog);
  EXPECT_EQ(plant.resource->image().pous[faults[0].fault.pou].name, "Spinner") << "the place";
  EXPECT_TRUE(scheduler.new_faults().empty());
  // The others go on, and the bad task's scan has no effect when it ends.
  const std::uint64_t before = scheduler.statistics(kFast).scans;
  EXPECT_TRUE(within(std::chrono::seconds(20), [&] { return scheduler.statistics(kFast).scans > before + 50; }));
  scheduler.request_stop();
  EXPECT_TRUE(scheduler.join().empty()) << "loops are cut short";
  EXPECT_EQ(plant.read(plant.output), -7);
  EXPECT_EQ(witness.after[kBad], 0) << "its devices are no longer its own";
  EXPECT_EQ(witness.stopped[kBad], 1);
  EXPECT_EQ(scheduler.statistics(kBad).faults, 1u);
}

TEST(Watchdog, UnderContinueTheScanGoesOnWithoutItsPriority) {
  Plant plant(30'000'000);
  plant.options.plan[kBad].watchdog_ns = 5 * kMs;
  plant.options.plan[kBad].on_fault = FaultPolicy::kContinue;
  Witness witness;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.add_listener(witness);
  scheduler.start();
  ASSERT_TRUE(within(std::chrono::seconds(30), [&] { return scheduler.statistics(kBad).scans >= 3; }));
  scheduler.request_stop();
  EXPECT_TRUE(scheduler.join().empty());
  std::size_t timeouts = 0;
  for (const runtime::TaskFault& f : scheduler.faults()) timeouts += f.fault.kind == FaultKind::kWatchdog ? 1 : 0;
  EXPECT_GE(timeouts, 3u) << "each scan is found once";
  EXPECT_LE(timeouts, scheduler.statistics(kBad).scans) << "and once only";
  EXPECT_EQ(witness.stopped[kBad], 0);
}

TEST(Watchdog, UnderStopEverythingStops) {
  Plant plant(4'000'000'000u);
  plant.options.plan[kBad].watchdog_ns = 20 * kMs;
  plant.options.plan[kBad].on_fault = FaultPolicy::kStop;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.start();
  EXPECT_TRUE(within(std::chrono::seconds(20), [&] { return scheduler.stop_requested(); }));
  EXPECT_TRUE(scheduler.join().empty());
  EXPECT_EQ(plant.read(plant.output), -7);
}

TEST(Watchdog, LeavesTasksAloneThatAreInTime) {
  Plant plant(10);
  plant.options.plan[kFast].watchdog_ns = 2000 * kMs;
  plant.options.plan[kBad].on_fault = FaultPolicy::kContinue;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.start();
  EXPECT_TRUE(within(std::chrono::seconds(30), [&] { return scheduler.statistics(kFast).scans >= 300; }));
  scheduler.request_stop();
  scheduler.join();
  EXPECT_EQ(scheduler.statistics(kFast).faults, 0u);
}

TEST(Faults, AnExhaustedLoopBudgetStopsItsTaskAlone) {
  Plant plant(1000);
  Witness witness;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.add_listener(witness);
  scheduler.start();
  ASSERT_TRUE(within(std::chrono::seconds(20), [&] { return witness.stopped[kBad] != 0; }));
  const std::uint64_t before = scheduler.statistics(kFast).scans;
  EXPECT_TRUE(within(std::chrono::seconds(20), [&] { return scheduler.statistics(kFast).scans > before + 20; }));
  EXPECT_EQ(plant.read(plant.output), -7);
  ASSERT_EQ(scheduler.faults().size(), 1u);
  EXPECT_EQ(scheduler.faults()[0].fault.kind, FaultKind::kLoopBudget);
}

TEST(Faults, AnOverrunIsAFaultWhereDeclared) {
  Plant plant(30'000'000);  // some 30 ms
  plant.options.plan[kBad].overrun = OverrunPolicy::kFault;
  plant.options.plan[kBad].on_fault = FaultPolicy::kContinue;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.start();
  ASSERT_TRUE(within(std::chrono::seconds(20), [&] { return scheduler.statistics(kBad).scans >= 2; }));
  scheduler.request_stop();
  scheduler.join();
  std::uint64_t overruns = 0;
  for (const runtime::TaskFault& f : scheduler.faults()) overruns += f.fault.kind == FaultKind::kOverrun ? 1 : 0;
  EXPECT_GE(overruns, 1u);
  // The scan that the stop cuts may be late as well: counted, but nobody's fault.
  EXPECT_LE(overruns, scheduler.statistics(kBad).overruns);
  EXPECT_GE(overruns + 1, scheduler.statistics(kBad).overruns);
  EXPECT_EQ(scheduler.statistics(kFast).faults, 0u) << "skipping is no fault";
}

/// A device that does not come back.
struct Blocked : runtime::CycleListener {
  void before_scan(const runtime::ReleaseContext&) noexcept override {}
  void after_scan(const runtime::ReleaseContext& context) noexcept override {
    while (context.task == kFast) ::pause();
  }
  void safe_state() noexcept override { safe = true; }
  bool safe = false;
};

TEST(Faults, ATaskThatCannotBeStoppedDoesNotKeepTheOutputsFromTheirSafeState) {
  const pid_t child = ::fork();
  if (child == 0) {
    Plant plant(10);
    Blocked device;
    RealtimeScheduler scheduler(*plant.resource, plant.options);
    scheduler.add_listener(device);
    scheduler.start();
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    scheduler.request_stop();
    ::_exit(scheduler.join() == std::vector<std::uint32_t>{kFast} && device.safe ? 42 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 42);
}

TEST(Plan, OffsetsShiftTheFirstRelease) {
  Plant plant(10);
  plant.options.plan[kBad].offset_ns = 3 * kMs;
  plant.options.plan[kBad].on_fault = FaultPolicy::kContinue;
  struct Releases : runtime::CycleListener {
    void before_scan(const runtime::ReleaseContext& context) noexcept override {
      if (context.cycle == 0) first[context.task] = context.release_ns;
    }
    void after_scan(const runtime::ReleaseContext&) noexcept override {}
    void safe_state() noexcept override {}
    std::atomic<core::TimeNs> first[2]{};
  } releases;
  RealtimeScheduler scheduler(*plant.resource, plant.options);
  scheduler.add_listener(releases);
  scheduler.start();
  ASSERT_TRUE(within(std::chrono::seconds(20), [&] { return releases.first[0] != 0 && releases.first[1] != 0; }));
  EXPECT_EQ(releases.first[kBad] - releases.first[kFast], 3 * kMs);
}

TEST(Plan, TasksWithAnIntervalHaveALead) {
  ImageBuilder b;
  b.global("go", b.boolean(), {}, {.input = true});
  b.task("Quick", kMs / 10, {}, 0);
  b.task("Usual", kMs, {}, 1);
  b.task("Slow", 1000 * kMs, {}, 2);
  b.task("Free", 0, {}, 3);
  b.task("Event", 0, {}, 4, "go");
  const bytecode::Image image = b.build();
  const auto lead = [&image](std::size_t task, std::optional<core::TimeNs> planned = std::nullopt) {
    runtime::TaskPlan plan;
    plan.lead_ns = planned;
    return runtime::lead_of(image.tasks[task], plan);
  };
  EXPECT_EQ(lead(0), 5'000) << "5 % of the interval";
  EXPECT_EQ(lead(1), 50'000);
  EXPECT_EQ(lead(2), 50'000) << "at most so much";
  EXPECT_EQ(lead(1, 0), 0);
  EXPECT_EQ(lead(1, 250'000), 250'000);
  EXPECT_EQ(lead(3, 5'000), 0);
  EXPECT_EQ(lead(4, 5'000), 0);
}

TEST(Plan, RateMonotonicPriorities) {
  ImageBuilder b;
  b.task("Slow", 100 * kMs, {}, 0);
  b.task("Free", 0, {}, 3);
  b.task("Fast", kMs, {}, 9);
  b.task("AlsoSlow", 100 * kMs, {}, 2);
  b.task("Event", 0, {}, 1, "go");
  const bytecode::Image image = b.build();
  std::vector<runtime::TaskPlan> plan = runtime::default_plan(image);
  EXPECT_EQ(plan[0].priority, 0);
  runtime::make_rate_monotonic(image, plan);
  EXPECT_EQ(plan[2].priority, 0) << "the shortest interval";
  EXPECT_EQ(plan[0].priority, 1);
  EXPECT_EQ(plan[3].priority, 1) << "equal intervals, equal priorities";
  EXPECT_EQ(plan[4].priority, 2) << "without an interval: last, as declared";
  EXPECT_EQ(plan[1].priority, 3);
}

}  // namespace
}  // namespace plc::test
