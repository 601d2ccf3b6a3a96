// Release grid, statistics, virtual-time and real-time schedulers.
#include <sched.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cfenv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <optional>
#include <thread>

#include "runtime/sched/realtime.h"
#include "runtime/sched/simulation.h"
#include "runtime/sched/statistics.h"
#include "runtime/sched/stay_awake.h"
#include "runtime/sched/thread_settings.h"
#include "tests/unit/runtime/run_support.h"

namespace plc::test {
namespace {

using runtime::FaultPolicy;
using runtime::Instant;
using runtime::ReleaseGrid;
using runtime::Simulation;

/// A program that appends `digit` to the decimal number in `order`, and counts itself in `n`.
std::uint32_t writer(ImageBuilder& b, const std::string& name, Word order, std::int64_t digit) {
  PouBuilder pou = b.pou(name, PouKind::kProgram);
  const Word n = pou.variable("n", b.type(TypeId::kDint));
  pou.op(Opcode::kAdd32, {n, n, b.constant<std::int32_t>(TypeId::kDint, 1)});
  pou.op(Opcode::kMul64, {order, order, b.constant<std::int64_t>(TypeId::kLint, 10)});
  pou.op(Opcode::kAdd64, {order, order, b.constant<std::int64_t>(TypeId::kLint, digit)});
  return pou.finish();
}

std::uint32_t endless(ImageBuilder& b, const std::string& name) {
  PouBuilder pou = b.pou(name, PouKind::kProgram);
  const Word n = pou.variable("n", b.type(TypeId::kDint));
  const std::uint32_t top = pou.here();
  pou.op(Opcode::kAdd32, {n, n, n});
  pou.op(Opcode::kLoopJump, {top});
  return pou.finish();
}

struct Outputs : runtime::CycleListener {
  void before_scan(const runtime::ReleaseContext&) noexcept override { ++before; }
  void after_scan(const runtime::ReleaseContext&) noexcept override { ++after; }
  void safe_state() noexcept override { ++safe; }
  std::atomic<int> before{0}, after{0}, safe{0};
};

TEST(ReleaseGrid, StaysOnTheGridAfterAnOverrun) {
  ReleaseGrid grid(100, 10);
  EXPECT_EQ(grid.advance(105), 0u);
  EXPECT_EQ(grid.next_ns(), 110);
  EXPECT_EQ(grid.advance(137), 2u);
  EXPECT_EQ(grid.next_ns(), 140);
  EXPECT_EQ(grid.advance(150), 1u);  // an instant that is now has passed
  EXPECT_EQ(grid.next_ns(), 160);
}

TEST(Histogram, PercentilesAreAtMostOneStepAbove) {
  runtime::Histogram h;
  EXPECT_EQ(h.percentile_ns(0.5), 0);
  EXPECT_EQ(h.min_ns(), 0);
  for (std::int64_t i = 1; i <= 100'000; ++i) h.record(i);
  EXPECT_EQ(h.count(), 100'000u);
  EXPECT_EQ(h.min_ns(), 1);
  EXPECT_EQ(h.max_ns(), 100'000);
  EXPECT_NEAR(h.mean_ns(), 50'000.5, 0.01);
  for (const double p : {0.0001, 0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto exact = static_cast<std::int64_t>(std::llround(p * 100'000));
    EXPECT_GE(h.percentile_ns(p), exact) << p;
    EXPECT_LE(h.percentile_ns(p), exact + exact / 64) << p;
  }
  EXPECT_EQ(h.percentile_ns(1.0), 100'000);
  h.record(-5);
  h.record(INT64_MAX);
  EXPECT_EQ(h.min_ns(), 0);
  EXPECT_EQ(h.percentile_ns(1.0), INT64_MAX);
}

TEST(Histogram, BucketsHoldEveryValueInOrder) {
  runtime::Histogram h;
  EXPECT_TRUE(h.buckets().empty());
  // Around the border of every step, where rounding would go wrong.
  std::vector<std::int64_t> values = {0, INT64_MAX};
  for (int octave = 0; octave < 63; ++octave) {
    for (const std::int64_t near : {-1, 0, 1}) values.push_back((std::int64_t{1} << octave) + near);
  }
  for (const std::int64_t value : values) h.record(value);
  const auto buckets = h.buckets();
  std::sort(values.begin(), values.end());
  std::size_t at = 0;
  std::int64_t lower = 0;
  for (const auto& bucket : buckets) {
    EXPECT_GE(bucket.upper_ns, lower);
    for (std::uint64_t i = 0; i < bucket.count; ++i, ++at) {
      ASSERT_LT(at, values.size());
      EXPECT_GE(values[at], lower);
      EXPECT_LE(values[at], bucket.upper_ns);
      EXPECT_LE(bucket.upper_ns - values[at], values[at] / 64);
    }
    if (bucket.upper_ns != INT64_MAX) lower = bucket.upper_ns + 1;
  }
  EXPECT_EQ(at, values.size());
  h.clear();
  EXPECT_TRUE(h.buckets().empty());
  EXPECT_EQ(h.count(), 0u);
}

TEST(Histogram, CanBeReadWhileItIsWritten) {
  runtime::Histogram h;
  std::atomic<bool> done{false};
  std::thread reader([&] {
    while (!done) {
      const std::uint64_t count = h.count();
      std::uint64_t held = 0;
      for (const auto& bucket : h.buckets()) held += bucket.count;
      EXPECT_GE(held, count);
      if (count == 0) continue;
      EXPECT_GE(h.min_ns(), 1000);
      EXPECT_LE(h.max_ns(), 1999);
      for (const double p : {0.0, 0.5, 0.999}) {
        const std::int64_t value = h.percentile_ns(p);
        EXPECT_GE(value, 1000);
        EXPECT_LE(value, 1999);
      }
    }
  });
  for (std::int64_t i = 0; i < 300'000; ++i) h.record(1000 + i * 7 % 1000);
  done = true;
  reader.join();
  EXPECT_EQ(h.count(), 300'000u);
}

TEST(Simulation, DueTasksRunInPriorityOrderAtTheirInstants) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  const std::uint32_t slow = writer(b, "Slow", order, 1);
  const std::uint32_t fast = writer(b, "Fast", order, 2);
  const std::uint32_t tie = writer(b, "Tie", order, 3);
  b.task("SlowTask", 20'000'000, {slow}, 5);
  b.task("FastTask", 10'000'000, {fast}, 0);
  b.task("TieTask", 20'000'000, {tie}, 5);
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  Simulation simulation(*r);
  std::vector<core::TimeNs> times;
  std::vector<std::string> orders;
  simulation.after_instant([&](const Instant& i) {
    times.push_back(i.now_ns);
    orders.push_back(value_of(*r, "order"));
    set(*r, "order", "0");
  });
  EXPECT_EQ(simulation.run_until(40'000'000), 4u);
  EXPECT_EQ(times, (std::vector<core::TimeNs>{0, 10'000'000, 20'000'000, 30'000'000}));
  EXPECT_EQ(orders, (std::vector<std::string>{"213", "2", "213", "2"}));
  EXPECT_EQ(simulation.scans(0), 2u);
  EXPECT_EQ(simulation.scans(1), 4u);
}

TEST(Simulation, EventTaskRunsOnRisingEdges) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.global("go", b.boolean(), {}, {.input = true, .list = "GVL"});
  const std::uint32_t cyclic = writer(b, "Cyclic", order, 1);
  const std::uint32_t event = writer(b, "Event", order, 2);
  b.task("Cyc", 10'000'000, {cyclic}, 1);
  b.task("Evt", 0, {event}, 0, "GVL.go");
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  Simulation simulation(*r);
  const char* const levels[] = {"0", "1", "1", "0", "1"};
  simulation.before_instant([&](const Instant& i) { set(*r, "GVL.go", levels[i.cycle]); });
  std::vector<std::size_t> ran;
  simulation.after_instant([&](const Instant& i) { ran.push_back(i.ran.size()); });
  EXPECT_EQ(simulation.run_cycles(5), 5u);
  EXPECT_EQ(ran, (std::vector<std::size_t>{1, 2, 1, 1, 2}));
  EXPECT_EQ(value_of(*r, "order"), "1211121");
}

TEST(Simulation, FreewheelingTasksRunEveryMillisecond) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("Free", 0, {writer(b, "Free", order, 1)});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  Simulation simulation(*r);
  EXPECT_EQ(simulation.run_until(5'000'000), 5u);
}

TEST(Simulation, FaultPolicies) {
  for (const FaultPolicy policy : {FaultPolicy::kContinue, FaultPolicy::kSafeState, FaultPolicy::kStop}) {
    ImageBuilder b;
    const Word order = b.global("order", b.type(TypeId::kLint));
    b.task("Bad", 10'000'000, {endless(b, "Endless")}, 0);
    b.task("Good", 10'000'000, {writer(b, "Good", order, 1)}, 1);
    auto r = load(b, {.loop_budget = 10});
    ASSERT_NE(r, nullptr);
    Outputs outputs;
    Simulation simulation(*r, {.on_fault = policy});
    simulation.add_listener(outputs);
    const std::uint64_t instants = simulation.run_cycles(3);
    ASSERT_FALSE(simulation.faults().empty());
    EXPECT_EQ(simulation.faults()[0].task, 0u);
    EXPECT_EQ(simulation.stopped(), policy == FaultPolicy::kStop);
    EXPECT_EQ(instants, policy == FaultPolicy::kStop ? 1u : 3u);
    EXPECT_EQ(simulation.fault_count(), policy == FaultPolicy::kContinue ? 3u : 1u);
    EXPECT_EQ(simulation.scans(1), policy == FaultPolicy::kStop ? 0u : 3u);
    EXPECT_EQ(outputs.safe, policy == FaultPolicy::kContinue ? 0 : 1);
    EXPECT_EQ(outputs.before, outputs.after);
  }
}

TEST(Exchange, TasksThatShareAGlobalPublishOnlyWhatTheyChanged) {
  ImageBuilder b;
  const std::uint32_t dint = b.type(TypeId::kDint);
  const Word values = b.global("values", b.array(dint, 2));
  const Word idle = b.global("idle", b.type(TypeId::kByte));
  PouBuilder first = b.pou("First", PouKind::kProgram);
  first.op(Opcode::kAdd32, {values, values, b.constant<std::int32_t>(TypeId::kDint, 1)});
  const std::uint32_t first_pou = first.finish();
  PouBuilder second = b.pou("Second", PouKind::kProgram);
  second.op(Opcode::kMove8, {idle, idle});
  second.op(Opcode::kAdd32, {values + 4, values + 4, b.constant<std::int32_t>(TypeId::kDint, 10)});
  const std::uint32_t second_pou = second.finish();
  b.task("A", 10'000'000, {first_pou});
  b.task("B", 10'000'000, {second_pou});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  struct Meddler : runtime::CycleListener {
    explicit Meddler(runtime::Resource& resource) : r(resource) {}
    void before_scan(const runtime::ReleaseContext&) noexcept override {}
    void after_scan(const runtime::ReleaseContext& c) noexcept override {
      if (c.task == 0) set(r, "idle", "5");
    }
    void safe_state() noexcept override {}
    runtime::Resource& r;
  } meddler(*r);
  Simulation simulation(*r);
  simulation.add_listener(meddler);
  simulation.run_cycles(3);
  EXPECT_EQ(value_of(*r, "values"), "[3, 30]");
  EXPECT_EQ(value_of(*r, "idle"), "5");
}

TEST(Realtime, RunsTasksUntilStoppedAndLeavesOutputsSafe) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.global("go", b.boolean(), {}, {.input = true});
  b.task("Two", 2'000'000, {writer(b, "P", order, 1)}, 0);
  b.task("Five", 5'000'000, {writer(b, "Q", order, 1)}, 200);
  b.task("Free", 0, {writer(b, "F", order, 1)}, 3);
  b.task("Event", 0, {writer(b, "E", order, 1)}, 3, "go");
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  Outputs outputs;
  runtime::RealtimeScheduler scheduler(*r, {.realtime_priority = false, .lock_memory = false});
  scheduler.add_listener(outputs);
  EXPECT_FALSE(scheduler.start().realtime_priority);
  EXPECT_TRUE(scheduler.report().refused.empty());
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const auto wait_for = [&](auto condition) {
    while (!condition() && std::chrono::steady_clock::now() < deadline)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return condition();
  };
  EXPECT_TRUE(wait_for([&] { return scheduler.statistics(0).scans >= 20 && scheduler.statistics(1).scans >= 5; }));
  EXPECT_TRUE(wait_for([&] { return scheduler.statistics(2).scans >= 5; }));
  EXPECT_EQ(scheduler.statistics(3).scans, 0u);
  set(*r, "go", "1");
  EXPECT_TRUE(wait_for([&] { return scheduler.statistics(3).scans == 1; }));
  scheduler.request_stop();
  scheduler.join();
  EXPECT_EQ(outputs.safe, 1);
  EXPECT_EQ(outputs.before, outputs.after);
  EXPECT_EQ(value_of(*r, "P0.n"), std::to_string(scheduler.statistics(0).scans.load()));
  const runtime::TaskStatistics& s = scheduler.statistics(0);
  for (const runtime::Histogram* h : {&s.latency, &s.scan_time, &s.response}) {
    EXPECT_EQ(h->count(), s.scans);
    EXPECT_LE(h->min_ns(), h->max_ns());
  }
  EXPECT_GE(s.response.min_ns(), s.latency.min_ns() + s.scan_time.min_ns());
  EXPECT_LE(s.response.max_ns(), s.latency.max_ns() + s.scan_time.max_ns());
  EXPECT_NEAR(s.response.mean_ns(), s.latency.mean_ns() + s.scan_time.mean_ns(), 1e-3);
  EXPECT_TRUE(scheduler.faults().empty());
}

TEST(StayAwake, TheKernelKnowsTheWishWhileItHolds) {
  runtime::StayAwake awake;
  const int error = awake.request();
  if (error != 0) GTEST_SKIP() << "/dev/cpu_dma_latency: " << std::strerror(error);
  EXPECT_EQ(awake.request(), 0) << "once is enough";
  // Others may have wishes, too, but none below 0.
  std::int32_t longest_us = -1;
  std::ifstream device("/dev/cpu_dma_latency", std::ios::binary);
  device.read(reinterpret_cast<char*>(&longest_us), sizeof longest_us);
  EXPECT_EQ(longest_us, 0);
  awake.release();
  EXPECT_EQ(awake.request(), 0);
}

TEST(Realtime, TheFirstReleaseIsTheSameInstantWhenEveryThreadIsReady) {
  constexpr std::uint32_t kTasks = 12;
  static std::atomic<core::TimeNs> last_ready;
  last_ready = 0;
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  for (std::uint32_t i = 0; i < kTasks; ++i) {
    const std::string name = "T" + std::to_string(i);
    b.task(name, 20'000'000, {writer(b, "P" + name, order, 1)});
  }
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  struct First : runtime::CycleListener {
    void before_scan(const runtime::ReleaseContext& c) noexcept override {
      if (c.cycle == 0) release[c.task] = c.release_ns;
    }
    void after_scan(const runtime::ReleaseContext&) noexcept override {}
    void safe_state() noexcept override {}
    std::array<std::atomic<core::TimeNs>, kTasks> release{};
  } first;
  runtime::RealtimeOptions options;
  options.realtime_priority = false;
  options.lock_memory = false;
  // Later than any fixed delay.
  options.on_thread_start = [](std::uint32_t task) {
    if (task == 7) std::this_thread::sleep_for(std::chrono::milliseconds(60));
    const core::TimeNs now = core::MonotonicClock().now_ns();
    core::TimeNs last = last_ready;
    while (last < now && !last_ready.compare_exchange_weak(last, now)) {
    }
  };
  runtime::RealtimeScheduler scheduler(*r, options);
  scheduler.add_listener(first);
  scheduler.start();
  for (std::uint32_t i = 0; i < kTasks; ++i) {
    while (scheduler.statistics(i).scans == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  scheduler.request_stop();
  scheduler.join();
  for (const auto& release : first.release) EXPECT_EQ(release, first.release[0]);
  EXPECT_GT(first.release[0], last_ready);
}

TEST(Realtime, TasksRoundToTheNearestWhoeverStartsThem) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("T", 2'000'000, {writer(b, "P", order, 1)});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  static std::atomic<int> rounds;
  rounds = -1;
  runtime::RealtimeOptions options;
  options.realtime_priority = false;
  options.lock_memory = false;
  options.on_thread_start = [](std::uint32_t) { rounds = std::fegetround(); };
  std::fesetround(FE_UPWARD);
  {
    runtime::RealtimeScheduler scheduler(*r, options);
    scheduler.start();
  }
  std::fesetround(FE_TONEAREST);
  EXPECT_EQ(rounds, FE_TONEAREST);
}

TEST(Realtime, AFaultingTaskLeavesTheOthersRunning) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("Bad", 2'000'000, {endless(b, "Endless")});
  b.task("Good", 2'000'000, {writer(b, "Good", order, 1)});
  auto r = load(b, {.loop_budget = 10});
  ASSERT_NE(r, nullptr);
  runtime::RealtimeScheduler scheduler(*r, {.realtime_priority = false, .lock_memory = false});
  scheduler.start();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while ((scheduler.statistics(1).scans < 10 || scheduler.faults().empty()) &&
         std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_GE(scheduler.statistics(1).scans, 10u);
  scheduler.request_stop();
  scheduler.join();
  ASSERT_EQ(scheduler.faults().size(), 1u);
  EXPECT_EQ(scheduler.faults()[0].task, 0u);
  EXPECT_EQ(scheduler.statistics(0).scans, 1u);
}

/// When scans of one task begin, and how long its thread was awake between them.
struct Releases : runtime::CycleListener {
  void before_scan(const runtime::ReleaseContext& c) noexcept override {
    const core::TimeNs awake = thread_time();
    if (clock.now_ns() < c.release_ns || c.now_ns < c.release_ns) ++early;
    if (c.cycle != 0) between.record(awake - slept_at);
  }
  void after_scan(const runtime::ReleaseContext&) noexcept override { slept_at = thread_time(); }
  void safe_state() noexcept override {}
  static core::TimeNs thread_time() noexcept {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec * core::TimeNs{1'000'000'000} + t.tv_nsec;
  }
  core::MonotonicClock clock;
  std::atomic<int> early{0};
  core::TimeNs slept_at = 0;
  runtime::Histogram between;
};

/// A task of 4 ms that runs 50 scans. Nothing where the system grants no real-time priority but it is wished.
std::unique_ptr<Releases> releases(std::optional<core::TimeNs> lead_ns, bool realtime_priority) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("Four", 4'000'000, {writer(b, "P", order, 1)});
  auto r = load(b);
  auto found = std::make_unique<Releases>();
  runtime::RealtimeOptions options;
  options.plan = runtime::default_plan(r->image());
  options.plan[0].lead_ns = lead_ns;
  options.realtime_priority = realtime_priority;
  options.lock_memory = false;
  runtime::RealtimeScheduler scheduler(*r, options);
  scheduler.add_listener(*found);
  if (scheduler.start().realtime_priority != realtime_priority) return nullptr;
  while (scheduler.statistics(0).scans < 50) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  scheduler.request_stop();
  scheduler.join();
  EXPECT_EQ(found->early, 0) << "a cycle began before its release";
  return found;
}

TEST(Realtime, ALeadIsSpentAwakeAndNoCycleBeginsBeforeItsRelease) {
  constexpr core::TimeNs kLead = 800'000;
  const auto ahead = releases(kLead, true);
  if (ahead == nullptr) GTEST_SKIP() << "no real-time priority";
  EXPECT_GT(ahead->between.percentile_ns(0.5), kLead / 2);
  EXPECT_LT(releases(0, true)->between.percentile_ns(0.5), kLead / 2);
  EXPECT_LT(releases(std::nullopt, true)->between.percentile_ns(0.5), kLead / 2);
}

TEST(Realtime, WithoutRealTimePriorityNobodyWaitsAwake) {
  constexpr core::TimeNs kLead = 800'000;
  EXPECT_LT(releases(kLead, false)->between.percentile_ns(0.5), kLead / 2);
}

/// Binds the calling thread to the first processor that it may use, while this lives.
struct OnFirstCpu {
  OnFirstCpu() {
    sched_getaffinity(0, sizeof before, &before);
    int first = -1;
    for (int cpu = 0; cpu < CPU_SETSIZE && other < 0; ++cpu) {
      if (CPU_ISSET(cpu, &before)) (first < 0 ? first : other) = cpu;
    }
    static_cast<void>(runtime::bind_to_cpu(pthread_self(), first));
  }
  ~OnFirstCpu() { sched_setaffinity(0, sizeof before, &before); }
  OnFirstCpu(const OnFirstCpu&) = delete;
  OnFirstCpu& operator=(const OnFirstCpu&) = delete;

  cpu_set_t before{};
  int other = -1;  ///< one that it may use as well
};

TEST(Realtime, AStopDoesNotWaitForALead) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("Slow", 40'000'000'000, {writer(b, "P", order, 1)});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  runtime::RealtimeOptions options;
  options.plan = runtime::default_plan(r->image());
  options.plan[0].offset_ns = 5'000'000'000;
  options.plan[0].lead_ns = 10'000'000'000;  // awake from the start on
  // Nothing else runs on the processor of a task that waits awake, not even the clock of a thread that sleeps there.
  const OnFirstCpu elsewhere;
  if (elsewhere.other < 0) GTEST_SKIP() << "one processor";
  options.plan[0].cpu = elsewhere.other;
  options.lock_memory = false;
  runtime::RealtimeScheduler scheduler(*r, options);
  if (!scheduler.start().realtime_priority) GTEST_SKIP() << "no real-time priority";
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const auto begin = std::chrono::steady_clock::now();
  scheduler.request_stop();
  EXPECT_TRUE(scheduler.join().empty());
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2));
  EXPECT_EQ(scheduler.statistics(0).scans, 0u);
}

TEST(Realtime, OverrunsAreCountedAndTheGridIsKept) {
  ImageBuilder b;
  const Word order = b.global("order", b.type(TypeId::kLint));
  b.task("Two", 2'000'000, {writer(b, "P", order, 1)});
  auto r = load(b);
  ASSERT_NE(r, nullptr);
  struct Slow : runtime::CycleListener {
    void before_scan(const runtime::ReleaseContext& c) noexcept override {
      if (first < 0) first = c.release_ns;
      off_grid = off_grid || (c.release_ns - first) % 2'000'000 != 0;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    void after_scan(const runtime::ReleaseContext&) noexcept override {}
    void safe_state() noexcept override {}
    core::TimeNs first = -1;
    bool off_grid = false;
  } slow;
  runtime::RealtimeScheduler scheduler(*r, {.realtime_priority = false, .lock_memory = false});
  scheduler.add_listener(slow);
  scheduler.start();
  while (scheduler.statistics(0).scans < 5) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  scheduler.request_stop();
  scheduler.join();
  EXPECT_FALSE(slow.off_grid);
  EXPECT_GE(scheduler.statistics(0).overruns, 5u);
  EXPECT_GE(scheduler.statistics(0).missed, 10u);
}

}  // namespace
}  // namespace plc::test
