// Response-time analysis: the examples of the literature, and its word held against a simulated schedule.
#include "runtime/sched/analysis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <tuple>
#include <vector>

namespace plc::test {
namespace {

using core::TimeNs;
using runtime::analyze_schedule;
using runtime::Schedulability;
using runtime::TaskLoad;
using runtime::Verdict;

constexpr TimeNs kMax = std::numeric_limits<TimeNs>::max();

TaskLoad task(std::int32_t priority, TimeNs execution, TimeNs period, TimeNs deadline = 0, TimeNs blocking = 0,
              TimeNs jitter = 0) {
  TaskLoad t;
  t.priority = priority;
  t.execution_ns = execution;
  t.period_ns = period;
  t.deadline_ns = deadline;
  t.blocking_ns = blocking;
  t.jitter_ns = jitter;
  return t;
}

/// Responses by task, -1 = none.
std::vector<TimeNs> responses(const std::vector<TaskLoad>& tasks) {
  std::vector<TimeNs> out;
  for (const runtime::TaskTiming& t : analyze_schedule(tasks).tasks) out.push_back(t.response_ns.value_or(-1));
  return out;
}

using Times = std::vector<TimeNs>;

// --- Examples
// ---------------------------------------------------------------------------------------------------------

TEST(Analysis, BoundsOfLiuAndLayland) {
  EXPECT_DOUBLE_EQ(runtime::liu_layland_bound(0), 1);
  EXPECT_DOUBLE_EQ(runtime::liu_layland_bound(1), 1);
  EXPECT_NEAR(runtime::liu_layland_bound(2), 0.828427, 1e-6);
  EXPECT_NEAR(runtime::liu_layland_bound(3), 0.779763, 1e-6);
  EXPECT_NEAR(runtime::liu_layland_bound(4), 0.756828, 1e-6);
  EXPECT_NEAR(runtime::liu_layland_bound(5), 0.743492, 1e-6);
  EXPECT_NEAR(runtime::liu_layland_bound(1'000'000), std::log(2.0), 1e-6);
}

// Two tasks at the bound: C1 = T2 - T1 and C2 = 2 T1 - T2 fill the processor until T1 + C1 = T2 and leave no room,
// the worst case being T2 / T1 = sqrt(2).
TEST(Analysis, LiuAndLaylandWorstCaseOfTwoTasks) {
  const Schedulability s = analyze_schedule(std::vector{task(0, 414'214, 1'000'000), task(1, 585'786, 1'414'214)});
  EXPECT_EQ(s.tasks[1].response_ns, 1'000'000);
  EXPECT_NEAR(s.cpus[0].utilization, s.cpus[0].liu_layland_bound, 1e-6);
  EXPECT_NEAR(*s.cpus[0].breakdown_factor, 1, 2e-6);
}

// The example before their theorem: 1 every 2 and 1 every 5. With the first task on top the second one's time can
// double and no more; the other way round nothing can grow.
TEST(Analysis, ExampleOfLiuAndLayland) {
  const auto fits = [](std::vector<TaskLoad> tasks) {
    return analyze_schedule(tasks).cpus[0].verdict == Verdict::kFits;
  };
  EXPECT_TRUE(fits({task(0, 1, 2), task(1, 1, 5)}));
  EXPECT_TRUE(fits({task(0, 1, 2), task(1, 2, 5)}));
  EXPECT_FALSE(fits({task(0, 1, 2), task(1, 3, 5)}));
  EXPECT_TRUE(fits({task(1, 1, 2), task(0, 1, 5)}));
  EXPECT_FALSE(fits({task(1, 1, 2), task(0, 2, 5)}));
  EXPECT_FALSE(fits({task(1, 2, 2), task(0, 1, 5)}));
}

// 20/100, 40/150, 100/350 passes the bound; with 40 in place of 20 only the exact test shows that it fits.
TEST(Analysis, ExampleOfLehoczkyShaDing) {
  const Schedulability light = analyze_schedule(std::vector{task(0, 20, 100), task(1, 40, 150), task(2, 100, 350)});
  EXPECT_NEAR(light.cpus[0].utilization, 0.752, 1e-3);
  EXPECT_LT(light.cpus[0].utilization, light.cpus[0].liu_layland_bound);
  EXPECT_EQ(light.cpus[0].verdict, Verdict::kFits);
  EXPECT_TRUE(light.cpus[0].bounds_apply);

  const Schedulability s = analyze_schedule(std::vector{task(0, 40, 100), task(1, 40, 150), task(2, 100, 350)});
  EXPECT_NEAR(s.cpus[0].utilization, 0.952, 1e-3);
  EXPECT_GT(s.tasks[2].level_load, s.tasks[2].level_bound);
  EXPECT_LT(s.tasks[1].level_load, s.tasks[1].level_bound);
  EXPECT_EQ(s.tasks[0].response_ns, 40);
  EXPECT_EQ(s.tasks[1].response_ns, 80);
  EXPECT_EQ(s.tasks[2].response_ns, 300);
  EXPECT_EQ(s.tasks[2].margin_ns, 50);
  EXPECT_EQ(s.cpus[0].verdict, Verdict::kFits);
  EXPECT_FALSE(s.cpus[0].not_rate_monotonic);
}

TEST(Analysis, ExamplesOfBurnsAndWellings) {
  EXPECT_EQ(responses({task(2, 12, 50), task(1, 10, 40), task(0, 10, 30)}), (Times{52, 20, 10}));  // misses 50
  EXPECT_EQ(responses({task(2, 40, 80), task(1, 10, 40), task(0, 5, 20)}), (Times{80, 15, 5}));    // load 1
  EXPECT_EQ(responses({task(0, 3, 7), task(1, 3, 12), task(2, 5, 20)}), (Times{3, 6, 20}));
  EXPECT_EQ(analyze_schedule(std::vector{task(1, 12, 50), task(0, 20, 35)}).cpus[0].verdict, Verdict::kFits);
}

// The second task's jobs respond after 114, 102, 116, 104, 118, 106, 94: the worst is neither the
// first nor the last.
TEST(Analysis, ExampleOfLehoczkyWithADeadlineBeyondThePeriod) {
  const std::vector<TaskLoad> tasks{task(0, 26, 70), task(1, 62, 100, 120)};
  EXPECT_EQ(responses(tasks), (Times{26, 118}));
  EXPECT_EQ(analyze_schedule(tasks).cpus[0].verdict, Verdict::kFits);
  EXPECT_EQ(responses({task(0, 52, 100), task(1, 52, 140, 200)}), (Times{52, 156}));
}

TEST(Analysis, BlockingDelaysItsTaskOnly) {
  // 20 of the first task's blocking, 10 of the second's: each pays its own, not that of the one above.
  const std::vector<TaskLoad> tasks{task(0, 40, 100, 0, 20), task(1, 40, 150, 0, 10), task(2, 100, 350)};
  EXPECT_EQ(responses(tasks), (Times{60, 90, 300}));
  const Schedulability s = analyze_schedule(tasks);
  EXPECT_EQ(responses({task(0, 4, 20, 0, 3), task(0, 5, 20)}), (Times{12, 12}));  // unless they share a queue
  EXPECT_NEAR(s.tasks[0].level_load, 0.4 + 0.2, 1e-9);
  EXPECT_NEAR(s.tasks[1].level_load, 0.4 + 40.0 / 150 + 10.0 / 150, 1e-9);
}

TEST(Analysis, JitterOfATaskAboveBringsItsJobsTogether) {
  EXPECT_EQ(responses({task(0, 2, 10), task(1, 5, 20)}), (Times{2, 7}));
  EXPECT_EQ(responses({task(0, 2, 10, 0, 0, 4), task(1, 5, 20)}), (Times{6, 9}));  // released at 0 and 6
}

// A job of the second task, released at 6, finds two of its own before it and the third task's; all of them wait for
// the first task twice. Both are released together at first, and would be done by 9.
TEST(Analysis, EqualPrioritiesQueue) {
  EXPECT_EQ(responses({task(0, 5, 10), task(1, 1, 3, 50), task(1, 3, 100)}), (Times{5, 10, 10}));
  EXPECT_EQ(responses({task(3, 4, 20), task(3, 5, 30), task(3, 6, 40)}), (Times{15, 15, 15}));
}

TEST(Analysis, ProcessorsDoNotMeet) {
  std::vector<TaskLoad> tasks{task(0, 6, 10), task(0, 6, 10), task(1, 7, 20)};
  tasks[1].cpu = -1;
  const Schedulability s = analyze_schedule(tasks);
  ASSERT_EQ(s.cpus.size(), 2u);
  EXPECT_EQ(s.cpus[0].cpu, -1);
  EXPECT_EQ(s.cpus[0].tasks, std::vector<std::uint32_t>{1});
  EXPECT_EQ(s.cpus[1].tasks, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(s.tasks[1].response_ns, 6);
  EXPECT_EQ(s.tasks[2].response_ns, 19);
}

TEST(Analysis, NamesThePairThatIsNotRateMonotonic) {
  const auto pair = [](std::vector<TaskLoad> tasks) { return analyze_schedule(tasks).cpus[0].not_rate_monotonic; };
  EXPECT_FALSE(pair({task(5, 1, 10), task(7, 1, 20), task(7, 1, 20)}));
  EXPECT_EQ(pair({task(1, 1, 10), task(0, 1, 20)}), (std::pair{1u, 0u}));
  EXPECT_EQ(pair({task(0, 1, 30), task(1, 1, 40), task(2, 1, 35)}), (std::pair{1u, 2u}));
  EXPECT_EQ(pair({task(1, 1, 10), task(1, 1, 20)}), (std::pair{1u, 0u}));  // the shorter one may have to wait
}

TEST(Analysis, BreakdownFactor) {
  // Alone: until the period is full. With a lower task: 3 f + 2 f <= 10 twice in 20 and so on.
  EXPECT_DOUBLE_EQ(*analyze_schedule(std::vector{task(0, 250'000, 1'000'000)}).cpus[0].breakdown_factor, 4);
  EXPECT_DOUBLE_EQ(*analyze_schedule(std::vector{task(0, 2'000'000, 1'000'000)}).cpus[0].breakdown_factor, 0.5);
  // Harmonic periods fill the processor: 0.25 + 0.25 may double.
  const std::vector<TaskLoad> harmonic{task(0, 250'000, 1'000'000), task(1, 500'000, 2'000'000)};
  EXPECT_DOUBLE_EQ(*analyze_schedule(harmonic).cpus[0].breakdown_factor, 2);
  // Blocking does not grow: 250 f + 500 <= 1000.
  EXPECT_DOUBLE_EQ(*analyze_schedule(std::vector{task(0, 250'000, 1'000'000, 0, 500'000)}).cpus[0].breakdown_factor, 2);
  // Blocking alone is too much.
  EXPECT_DOUBLE_EQ(*analyze_schedule(std::vector{task(0, 250, 1'000, 0, 2'000)}).cpus[0].breakdown_factor, 0);
  EXPECT_DOUBLE_EQ(*analyze_schedule(std::vector{task(0, 0, 1'000)}).cpus[0].breakdown_factor, 1e6);
}

// --- Edges
// ------------------------------------------------------------------------------------------------------------

TEST(Analysis, NothingToAnalyze) {
  const Schedulability s = analyze_schedule({});
  EXPECT_TRUE(s.tasks.empty());
  EXPECT_TRUE(s.cpus.empty());
}

TEST(Analysis, NoExecutionTimeCountsAsOneNanosecond) {
  EXPECT_EQ(responses({task(0, 0, 10), task(1, 0, 10), task(2, -5, 10)}), (Times{1, 2, 3}));
}

TEST(Analysis, OverloadHasNoResponseTime) {
  const Schedulability s = analyze_schedule(std::vector{task(0, 6, 10), task(1, 5, 10, kMax), task(2, 1, 1'000)});
  EXPECT_EQ(s.tasks[0].verdict, Verdict::kFits);
  EXPECT_EQ(s.tasks[1].verdict, Verdict::kDoesNotFit);
  EXPECT_FALSE(s.tasks[1].response_ns);
  EXPECT_EQ(s.tasks[2].verdict, Verdict::kDoesNotFit);
  EXPECT_EQ(s.cpus[0].verdict, Verdict::kDoesNotFit);
  EXPECT_LT(*s.cpus[0].breakdown_factor, 1);
}

TEST(Analysis, FreewheelingTakesWhatIsLeft) {
  const Schedulability below = analyze_schedule(std::vector{task(0, 6, 10), task(1, 5'000'000, 0)});
  EXPECT_EQ(below.tasks[1].verdict, Verdict::kNoDeadline);
  EXPECT_EQ(below.cpus[0].verdict, Verdict::kFits);
  EXPECT_TRUE(below.cpus[0].bounds_apply);
  // Above, it comes every kFreewheelNs at most; longer scans than that shift its grid, and nobody knows.
  const Schedulability above = analyze_schedule(std::vector{task(1, 200'000, 2'000'000), task(0, 900'000, 0)});
  EXPECT_EQ(above.tasks[0].response_ns, 200'000 + 2 * 900'000);
  EXPECT_FALSE(above.cpus[0].bounds_apply);
  EXPECT_FALSE(analyze_schedule(std::vector{task(0, 6, 10), task(0, 1, 0)}).cpus[0].bounds_apply);
  const Schedulability longer = analyze_schedule(std::vector{task(1, 200'000, 2'000'000), task(0, 1'900'000, 0)});
  EXPECT_EQ(longer.tasks[0].verdict, Verdict::kUnknown);
  EXPECT_EQ(longer.cpus[0].verdict, Verdict::kUnknown);
  EXPECT_FALSE(longer.cpus[0].breakdown_factor);
}

TEST(Analysis, EventsOfUnknownDistance) {
  std::vector<TaskLoad> tasks{task(0, 1, 10), task(1, 1, 0, 50), task(2, 4, 10), task(2, 8, 9)};
  tasks[1].event = true;
  Schedulability s = analyze_schedule(tasks);
  EXPECT_EQ(s.tasks[0].verdict, Verdict::kFits);
  EXPECT_EQ(s.tasks[1].verdict, Verdict::kUnknown);
  EXPECT_EQ(s.tasks[2].verdict, Verdict::kDoesNotFit);  // whatever the events do
  tasks.pop_back();
  s = analyze_schedule(tasks);
  EXPECT_EQ(s.tasks[2].verdict, Verdict::kUnknown);
  EXPECT_FALSE(s.tasks[2].response_ns);
  tasks[1].period_ns = 5;  // known now
  EXPECT_EQ(responses(tasks), (Times{1, 2, 7}));
}

TEST(Analysis, HugeNumbers) {
  for (const TimeNs a : {TimeNs{1}, kMax / 3, kMax / 2, kMax - 1, kMax}) {
    for (const TimeNs b : {TimeNs{1}, kMax / 3, kMax / 2, kMax - 1, kMax}) {
      for (const TimeNs jitter : {TimeNs{0}, kMax / 2, kMax}) {
        const Schedulability s = analyze_schedule(
            std::vector{task(0, a, b, 0, 0, jitter), task(1, b, kMax, kMax, b), task(1, 1, kMax, a, a, jitter)});
        for (const runtime::TaskTiming& t : s.tasks) {
          EXPECT_GT(t.response_ns.value_or(1), 0);
        }
      }
    }
  }
  // Load just below and at 100 % with periods that do not meet in 64 bits: the work is bounded, and what fits is said.
  const TimeNs p = 999'999'937;
  const TimeNs q = 1'000'000'007;
  const Schedulability s = analyze_schedule(std::vector{task(0, p - 1, p), task(1, 1, q, 2 * q)});
  EXPECT_EQ(s.tasks[1].response_ns, p);
  const Schedulability full = analyze_schedule(std::vector{task(0, p - 1, p), task(1, 1, p - 1, kMax)});
  EXPECT_EQ(full.tasks[1].verdict, Verdict::kUnknown);
}

// --- Against a simulated schedule
// -------------------------------------------------------------------------------------

struct Scenario {
  std::vector<TimeNs> offsets;        ///< by task; empty = all 0
  std::size_t loses_ties = SIZE_MAX;  ///< the task that queues last among those released together
  TimeNs blocker = 0;                 ///< what runs first from 0 on, whatever is released
  std::function<TimeNs(std::size_t task, TimeNs arrival)> late{};  ///< from arrival to release; none = 0
  TimeNs horizon = 0;
  bool stop_at_miss = false;
};

struct Simulated {
  std::vector<TimeNs> longest;
  bool missed = false;
};

/// One time unit after the other, by definition and without thought.
Simulated simulate(const std::vector<TaskLoad>& tasks, const Scenario& scenario) {
  struct Job {
    std::size_t task;
    TimeNs arrival, release, left;
  };
  Simulated result;
  result.longest.assign(tasks.size(), 0);
  std::vector<TimeNs> next(tasks.size(), 0);
  if (!scenario.offsets.empty()) next = scenario.offsets;
  std::vector<Job> jobs;
  const auto deadline = [&tasks](std::size_t i) {
    return tasks[i].deadline_ns > 0 ? tasks[i].deadline_ns : tasks[i].period_ns;
  };
  for (TimeNs now = 0; now < scenario.horizon && !(scenario.stop_at_miss && result.missed); ++now) {
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (next[i] != now) continue;
      const TimeNs late = scenario.late ? scenario.late(i, now) : 0;
      jobs.push_back({i, now, now + late, tasks[i].execution_ns});
      next[i] += tasks[i].period_ns;
    }
    const auto before = [&](const Job& a, const Job& b) {
      const auto key = [&](const Job& j) {
        return std::tuple(tasks[j.task].priority, j.release, j.task == scenario.loses_ties, j.task, j.arrival);
      };
      return key(a) < key(b);
    };
    auto running = jobs.end();
    for (auto job = jobs.begin(); job != jobs.end(); ++job) {
      if (job->release <= now && (running == jobs.end() || before(*job, *running))) running = job;
    }
    if (now < scenario.blocker || running == jobs.end()) continue;
    if (--running->left != 0) continue;
    result.longest[running->task] = std::max(result.longest[running->task], now + 1 - running->arrival);
    result.missed |= now + 1 - running->arrival > deadline(running->task);
    jobs.erase(running);
  }
  // What starves never ends, and misses all the same.
  for (const Job& job : jobs) result.missed |= scenario.horizon - job.arrival > deadline(job.task);
  return result;
}

constexpr TimeNs kPeriods[] = {4, 5, 6, 8, 10, 12, 15, 20, 24, 30};
constexpr TimeNs kHyperperiod = 120;

struct SetShape {
  bool equal_priorities = false;
  bool jitter = false;
};

std::vector<TaskLoad> random_set(std::mt19937& random, const SetShape& shape) {
  const auto pick = [&random](TimeNs low, TimeNs high) {
    return std::uniform_int_distribution<TimeNs>(low, high)(random);
  };
  const auto count = static_cast<std::size_t>(pick(1, 5));
  std::vector<TaskLoad> tasks;
  for (std::size_t i = 0; i < count; ++i) {
    const TimeNs period = kPeriods[pick(0, std::size(kPeriods) - 1)];
    const TimeNs execution = std::max<TimeNs>(1, pick(1, 2 * period) / static_cast<TimeNs>(count + 1));
    const TimeNs deadline = pick(0, 2) == 0 ? pick(execution, 3 * period) : 0;
    const auto priority = static_cast<std::int32_t>(shape.equal_priorities ? pick(0, 2) : static_cast<TimeNs>(i));
    tasks.push_back(
        task(priority, execution, period, deadline, 0, shape.jitter && pick(0, 1) == 0 ? pick(1, period) : 0));
  }
  std::shuffle(tasks.begin(), tasks.end(), random);
  return tasks;
}

TimeNs demand(const std::vector<TaskLoad>& tasks) {
  TimeNs sum = 0;
  for (const TaskLoad& t : tasks) sum += kHyperperiod / t.period_ns * t.execution_ns;
  return sum;
}

// Everything released at once is the worst case of distinct priorities: the responses are equal, not only bounded.
TEST(AnalysisAgainstSimulation, DistinctPrioritiesToTheNanosecond) {
  std::mt19937 random(1);
  int fits = 0, misses = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::vector<TaskLoad> tasks = random_set(random, {});
    const Schedulability s = analyze_schedule(tasks);
    const bool overload = demand(tasks) > kHyperperiod;
    Scenario scenario;
    scenario.horizon = overload ? 100 * kHyperperiod : kHyperperiod;
    scenario.stop_at_miss = overload;
    const Simulated run = simulate(tasks, scenario);
    ASSERT_EQ(run.missed, s.cpus[0].verdict == Verdict::kDoesNotFit) << "set " << i;
    (run.missed ? misses : fits) += 1;
    if (overload) continue;
    for (std::size_t t = 0; t < tasks.size(); ++t) ASSERT_EQ(s.tasks[t].response_ns, run.longest[t]) << "set " << i;
    if (s.cpus[0].bounds_apply &&
        (s.cpus[0].utilization <= s.cpus[0].liu_layland_bound || s.cpus[0].hyperbolic_product <= 2)) {
      EXPECT_FALSE(run.missed) << "set " << i;
    }
  }
  EXPECT_GT(fits, 500);
  EXPECT_GT(misses, 500);
}

TEST(AnalysisAgainstSimulation, WhatFitsNeverMisses) {
  std::mt19937 random(2);
  int fits = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::vector<TaskLoad> tasks = random_set(random, {.equal_priorities = true, .jitter = i % 2 == 0});
    const Schedulability s = analyze_schedule(tasks);
    fits += s.cpus[0].verdict == Verdict::kFits ? 1 : 0;
    for (int k = 0; k < 4; ++k) {
      Scenario scenario;
      for (const TaskLoad& t : tasks)
        scenario.offsets.push_back(k == 0 ? 0 : static_cast<TimeNs>(random()) % t.period_ns);
      scenario.loses_ties = random() % tasks.size();
      scenario.late = [&](std::size_t t, TimeNs) {
        return std::uniform_int_distribution<TimeNs>(0, tasks[t].jitter_ns)(random);
      };
      scenario.horizon = 3 * kHyperperiod;
      const Simulated run = simulate(tasks, scenario);
      for (std::size_t t = 0; t < tasks.size(); ++t) {
        ASSERT_LE(run.longest[t], s.tasks[t].response_ns.value_or(kMax)) << "set " << i;
        if (s.tasks[t].verdict != Verdict::kFits) continue;
        ASSERT_LE(run.longest[t], s.tasks[t].deadline_ns) << "set " << i;
      }
    }
  }
  EXPECT_GT(fits, 500);
}

// The worst of all offsets and ties is what the analysis says of tasks that queue.
TEST(AnalysisAgainstSimulation, EqualPrioritiesOverAllOffsets) {
  std::mt19937 random(3);
  constexpr TimeNs kShort[] = {3, 4, 6, 8, 12};  // all meet after 24
  int beyond_synchronous = 0;
  for (int i = 0; i < 1500; ++i) {
    std::vector<TaskLoad> tasks;
    double load = 0;
    for (int t = 0; t < 3; ++t) {
      const TimeNs period = kShort[random() % std::size(kShort)];
      tasks.push_back(task(t == 0 ? 0 : 1, 1 + static_cast<TimeNs>(random()) % (t == 0 ? 6 : 3), period, 24));
      load += static_cast<double>(tasks.back().execution_ns) / static_cast<double>(period);
    }
    if (load > 1 + 1e-9) continue;
    std::vector<TimeNs> worst(tasks.size(), 0), synchronous(tasks.size(), 0);
    for (std::size_t loser = 0; loser < tasks.size(); ++loser) {
      for (TimeNs a = 0; a < tasks[0].period_ns; ++a) {
        for (TimeNs b = 0; b < tasks[1].period_ns; ++b) {
          for (TimeNs c = 0; c < tasks[2].period_ns; ++c) {
            const Simulated run = simulate(tasks, {.offsets = {a, b, c}, .loses_ties = loser, .horizon = 72});
            for (std::size_t t = 0; t < tasks.size(); ++t) {
              worst[t] = std::max(worst[t], run.longest[t]);
              if (a + b + c == 0) synchronous[t] = std::max(synchronous[t], run.longest[t]);
            }
          }
        }
      }
    }
    ASSERT_EQ(responses(tasks), worst) << "set " << i;
    beyond_synchronous += worst != synchronous ? 1 : 0;
  }
  EXPECT_GT(beyond_synchronous, 0);
}

TEST(AnalysisAgainstSimulation, BlockingAtTheStartOfABusyPeriod) {
  std::mt19937 random(4);
  for (int i = 0; i < 1000; ++i) {
    std::vector<TaskLoad> tasks = random_set(random, {});
    const std::size_t blocked = random() % tasks.size();
    tasks[blocked].blocking_ns = 1 + static_cast<TimeNs>(random() % 8);
    const runtime::TaskTiming timing = analyze_schedule(tasks).tasks[blocked];
    std::erase_if(tasks, [&, p = tasks[blocked].priority](const TaskLoad& t) { return t.priority > p; });
    if (demand(tasks) >= kHyperperiod) continue;  // blocking never ends at a load of 1
    const auto self = std::find_if(tasks.begin(), tasks.end(), [](const TaskLoad& t) { return t.blocking_ns > 0; });
    Scenario scenario;
    scenario.blocker = self->blocking_ns;
    scenario.horizon = 10 * kHyperperiod;
    const Simulated run = simulate(tasks, scenario);
    ASSERT_EQ(timing.response_ns, run.longest[static_cast<std::size_t>(self - tasks.begin())]) << "set " << i;
  }
}

// All jobs of the task as late as they may be; the others as late as it takes to come together with its first one, and
// from then on in time.
TEST(AnalysisAgainstSimulation, JitterAtItsWorst) {
  std::mt19937 random(6);
  int compared = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::vector<TaskLoad> tasks = random_set(random, {.jitter = true});
    if (demand(tasks) >= kHyperperiod) continue;  // jitter of a full processor is never made up for
    const Schedulability s = analyze_schedule(tasks);
    TimeNs together = 0;
    for (const TaskLoad& t : tasks) together = std::max(together, t.jitter_ns);
    Scenario scenario;
    for (const TaskLoad& t : tasks) scenario.offsets.push_back(together - t.jitter_ns);
    scenario.horizon = 10 * kHyperperiod;
    for (std::size_t own = 0; own < tasks.size(); ++own) {
      scenario.late = [&](std::size_t t, TimeNs arrival) {
        return t == own ? tasks[t].jitter_ns : std::max<TimeNs>(together - arrival, 0);
      };
      ASSERT_EQ(s.tasks[own].response_ns, simulate(tasks, scenario).longest[own]) << "set " << i;
      ++compared;
    }
  }
  EXPECT_GT(compared, 500);
}

// What the breakdown factor says fits does, and a little more does not.
TEST(AnalysisAgainstSimulation, BreakdownFactorIsTheLargest) {
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    std::vector<TaskLoad> tasks = random_set(random, {.equal_priorities = true});
    for (TaskLoad& t : tasks) {
      t.execution_ns *= 1'000'000;
      t.period_ns *= 1'000'000;
      t.deadline_ns *= 1'000'000;
    }
    const double factor = *analyze_schedule(tasks).cpus[0].breakdown_factor;
    const auto verdict_at = [&](double f) {
      std::vector<TaskLoad> grown = tasks;
      for (TaskLoad& t : grown)
        t.execution_ns = static_cast<TimeNs>(std::ceil(static_cast<double>(t.execution_ns) * f - 1e-3));
      return analyze_schedule(grown).cpus[0].verdict;
    };
    EXPECT_EQ(verdict_at(factor), Verdict::kFits) << "set " << i;
    EXPECT_EQ(verdict_at(factor + 2e-6), Verdict::kDoesNotFit) << "set " << i;
  }
}

}  // namespace
}  // namespace plc::test
