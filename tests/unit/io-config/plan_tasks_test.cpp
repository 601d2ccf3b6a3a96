// plan_tasks(): what becomes of the keys of [scheduler] and [tasks.NAME], and which of them do not fit a project.
#include "io-drivers/config/plan_tasks.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io-drivers/config/keys.h"
#include "io-drivers/machine/driver_types.h"
#include "tests/support/image_builder.h"

namespace plc::io {
namespace {

using runtime::FaultPolicy;
using runtime::OverrunPolicy;
using runtime::TaskPlan;
using test::ImageBuilder;

constexpr core::TimeNs kMs = 1'000'000;

/// Slow (100 ms, priority 0), Fast (1 ms, priority 3), Stop (on an edge, priority 7).
bytecode::Image project(core::Coherence coherence = core::Coherence::kWaitFree) {
  ImageBuilder b;
  b.image.options.coherence = coherence;
  b.global("Go", b.boolean(), {}, {.input = true});
  b.task("Slow", 100 * kMs, {}, 0);
  b.task("Fast", kMs, {}, 3);
  b.task("Stop", 0, {}, 7, "Go");
  return b.build();
}
enum : std::size_t { kSlow, kFast, kStop };

struct Planned {
  std::optional<std::vector<TaskPlan>> plan;
  std::string problems;  ///< rendered, all of them

  [[nodiscard]] const TaskPlan& of(std::size_t task) const { return plan.value().at(task); }
};

/// The plan that `toml` makes on a machine with processors 0, 1, 2 and 5.
Planned planned(const std::string& toml, core::Coherence coherence = core::Coherence::kWaitFree,
                std::vector<int> cpus = {0, 1, 2, 5}, FaultPolicy on_fault = FaultPolicy::kSafeState) {
  core::Diagnostics diagnostics;
  const auto configuration = read_configuration(toml, "plc.toml", driver_types(), diagnostics);
  EXPECT_TRUE(configuration.has_value()) << toml;
  Planned result;
  if (configuration) result.plan = plan_tasks(*configuration, project(coherence), cpus, on_fault, diagnostics);
  for (const core::Diagnostic& d : diagnostics.all()) result.problems += diagnostics.render_one(d) + "\n";
  return result;
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(PlanTasks, NothingSaidIsWhatTheImageDeclares) {
  const Planned p = planned("");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  ASSERT_EQ(p.plan->size(), 3u);
  EXPECT_EQ(p.of(kSlow).priority, 0);
  EXPECT_EQ(p.of(kFast).priority, 3);
  EXPECT_EQ(p.of(kStop).priority, 7);
  for (const TaskPlan& task : *p.plan) {
    EXPECT_EQ(task.cpu, -1);
    EXPECT_EQ(task.offset_ns, 0);
    EXPECT_EQ(task.deadline_ns, 0);
    EXPECT_FALSE(task.execution_ns.has_value());
    EXPECT_EQ(task.watchdog_ns, 0);
    EXPECT_EQ(task.overrun, OverrunPolicy::kSkip);
    EXPECT_EQ(task.on_fault, FaultPolicy::kSafeState);
  }
}

/// With one assertion a key: a new key of [tasks.NAME] must be added here.
TEST(PlanTasks, EveryKeyOfATask) {
  const Planned p = planned(
      "[tasks.fast]\n"  // names are those of IEC 61131-3: case does not count
      "priority = 9\ncpu = 5\noffset = \"250us\"\nlead = \"15us\"\ndeadline = \"900us\"\nexecution = "
      "\"350us\"\nwatchdog = \"5ms\"\n"
      "overrun = \"fault\"\non_fault = \"stop\"\n");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  const TaskPlan& fast = p.of(kFast);
  EXPECT_EQ(fast.priority, 9);
  EXPECT_EQ(fast.cpu, 5);
  EXPECT_EQ(fast.offset_ns, 250'000);
  EXPECT_EQ(fast.lead_ns, 15'000);
  EXPECT_EQ(fast.deadline_ns, 900'000);
  EXPECT_EQ(fast.execution_ns, 350'000);
  EXPECT_EQ(fast.watchdog_ns, 5 * kMs);
  EXPECT_EQ(fast.overrun, OverrunPolicy::kFault);
  EXPECT_EQ(fast.on_fault, FaultPolicy::kStop);
  int keys = 0;
  for (const Keys all(driver_types()); const KeyInfo& key : all.rows()) keys += key.table == TableId::kTask ? 1 : 0;
  EXPECT_EQ(keys, 9) << "keys that this test does not know";
  // Nothing of it is the others'.
  EXPECT_EQ(p.of(kSlow).watchdog_ns, 0);
  EXPECT_EQ(p.of(kSlow).cpu, -1);
  EXPECT_FALSE(p.of(kSlow).lead_ns.has_value());
  EXPECT_EQ(p.of(kStop).on_fault, FaultPolicy::kSafeState);
}

TEST(PlanTasks, TheCommandLineSpeaksForTasksThatDeclareNoPolicy) {
  const Planned p = planned("[tasks.Fast]\non_fault = \"safe-state\"\n[tasks.Slow]\nwatchdog = \"1s\"\n",
                            core::Coherence::kWaitFree, {0}, FaultPolicy::kContinue);
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  EXPECT_EQ(p.of(kFast).on_fault, FaultPolicy::kSafeState);
  EXPECT_EQ(p.of(kSlow).on_fault, FaultPolicy::kContinue) << "a table without the key";
  EXPECT_EQ(p.of(kStop).on_fault, FaultPolicy::kContinue) << "no table";
}

TEST(PlanTasks, RateMonotonicPriorities) {
  const Planned p = planned("[scheduler]\npriorities = \"rate-monotonic\"\n");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  EXPECT_EQ(p.of(kFast).priority, 0);
  EXPECT_EQ(p.of(kSlow).priority, 1);
  EXPECT_EQ(p.of(kStop).priority, 2) << "event tasks come last";
}

TEST(PlanTasks, APriorityOfATaskCountsBeforeRateMonotonicOnes) {
  const Planned p = planned("[scheduler]\npriorities = \"rate-monotonic\"\n[tasks.Stop]\npriority = 0\n");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  EXPECT_EQ(p.of(kFast).priority, 0);
  EXPECT_EQ(p.of(kSlow).priority, 1);
  EXPECT_EQ(p.of(kStop).priority, 0);
}

TEST(PlanTasks, ProcessorOfAllAndOfOne) {
  const Planned p = planned("[scheduler]\ncpu = 2\n[tasks.Fast]\ncpu = 1\n[tasks.Stop]\noffset = \"1ms\"\n");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  EXPECT_EQ(p.of(kSlow).cpu, 2);
  EXPECT_EQ(p.of(kFast).cpu, 1);
  EXPECT_EQ(p.of(kStop).cpu, 2);
}

TEST(PlanTasks, LeadOfAllAndOfOne) {
  const Planned nothing = planned("");
  for (const std::size_t task : {kSlow, kFast, kStop}) EXPECT_FALSE(nothing.of(task).lead_ns.has_value());
  const Planned p = planned("[scheduler]\nlead = \"20us\"\n[tasks.Fast]\nlead = \"0s\"\n");
  ASSERT_TRUE(p.plan.has_value()) << p.problems;
  EXPECT_EQ(p.of(kSlow).lead_ns, 20'000);
  EXPECT_EQ(p.of(kFast).lead_ns, 0);
  EXPECT_FALSE(p.of(kStop).lead_ns.has_value()) << "it has no interval";
  const Planned most = planned("[tasks.Fast]\nlead = \"250us\"\n[tasks.Stop]\nlead = \"0s\"\n");
  ASSERT_TRUE(most.plan.has_value()) << most.problems;
  EXPECT_EQ(most.of(kFast).lead_ns, kMs / 4);
}

TEST(PlanTasks, P7608WhenALeadDoesNotFitTheInterval) {
  const Planned own = planned("[modbus]\nlisten = \"off\"\n[tasks.Fast]\nlead = \"251us\"\n");
  EXPECT_FALSE(own.plan.has_value());
  EXPECT_TRUE(contains(own.problems, "plc.toml:3:")) << own.problems;
  EXPECT_TRUE(contains(own.problems,
                       "P7608: a lead of 251000 ns is more than a quarter of the interval of task "
                       "\"Fast\", 1000000 ns"))
      << own.problems;
  EXPECT_TRUE(contains(own.problems, "at most 250000 ns")) << own.problems;
  // It fits Slow, and not Fast.
  const Planned all = planned("[scheduler]\nlead = \"1ms\"\n");
  EXPECT_FALSE(all.plan.has_value());
  EXPECT_TRUE(contains(all.problems, "plc.toml:1:")) << all.problems;
  EXPECT_TRUE(contains(all.problems, "\"Fast\"")) << all.problems;
  EXPECT_FALSE(contains(all.problems, "\"Slow\"")) << all.problems;
  const Planned event = planned("[tasks.Stop]\nlead = \"1us\"\n");
  EXPECT_FALSE(event.plan.has_value());
  EXPECT_TRUE(contains(event.problems, "P7608: task \"Stop\" has no interval")) << event.problems;
}

TEST(PlanTasks, P7601NamesTheTaskThatIsMeant) {
  const Planned p = planned("[modbus]\nlisten = \"off\"\n[tasks.Fsat]\nwatchdog = \"5ms\"\n");
  EXPECT_FALSE(p.plan.has_value());
  EXPECT_TRUE(contains(p.problems, "plc.toml:3:")) << p.problems;
  EXPECT_TRUE(contains(p.problems, "P7601: the project has no task \"Fsat\"")) << p.problems;
  EXPECT_TRUE(contains(p.problems, "Fast")) << p.problems;
}

TEST(PlanTasks, P7601ListsTasksWhenNoneIsLikeIt) {
  const Planned p = planned("[tasks.Housekeeping]\n");
  EXPECT_FALSE(p.plan.has_value());
  EXPECT_TRUE(contains(p.problems, "it has: Slow, Fast, Stop")) << p.problems;
}

TEST(PlanTasks, P7602ForEveryKeyThatNamesAProcessor) {
  for (const char* toml : {"[scheduler]\ncpu = 3\n", "[tasks.Fast]\ncpu = 3\n"}) {
    const Planned p = planned(toml);
    EXPECT_FALSE(p.plan.has_value()) << toml;
    EXPECT_TRUE(contains(p.problems, "plc.toml:2:7: ")) << p.problems;
    EXPECT_TRUE(contains(p.problems, "P7602: processor 3 is not available")) << p.problems;
    EXPECT_TRUE(contains(p.problems, "this process may use: 0 to 2, 5")) << p.problems;
  }
}

TEST(PlanTasks, AllProblemsAreReported) {
  const Planned p = planned("[scheduler]\ncpu = 3\n[tasks.Fast]\ncpu = 4\n[tasks.No]\n");
  EXPECT_TRUE(contains(p.problems, "processor 3 ")) << p.problems;
  EXPECT_TRUE(contains(p.problems, "processor 4 ")) << p.problems;
  EXPECT_TRUE(contains(p.problems, "P7601")) << p.problems;
}

TEST(PlanTasks, CeilingsBindEveryTaskToOneProcessor) {
  struct Way {
    const char* toml;
    int cpu;
  };
  // None is named: the first that may be used. One task names one: it is that of all.
  for (const Way& way : {Way{"", 1}, Way{"[scheduler]\ncpu = 5\n", 5}, Way{"[tasks.Stop]\ncpu = 2\n", 2},
                         Way{"[scheduler]\ncpu = 2\n[tasks.Fast]\ncpu = 2\n", 2}}) {
    const Planned p = planned(way.toml, core::Coherence::kPriorityCeiling, {1, 2, 5});
    ASSERT_TRUE(p.plan.has_value()) << p.problems;
    for (const TaskPlan& task : *p.plan) EXPECT_EQ(task.cpu, way.cpu) << way.toml;
  }
}

TEST(PlanTasks, P7603WhenTasksUnderCeilingsNameTwoProcessors) {
  for (const char* toml :
       {"[tasks.Fast]\ncpu = 1\n[tasks.Slow]\ncpu = 2\n", "[scheduler]\ncpu = 2\n[tasks.Fast]\ncpu = 1\n"}) {
    const Planned p = planned(toml, core::Coherence::kPriorityCeiling);
    EXPECT_FALSE(p.plan.has_value()) << toml;
    EXPECT_TRUE(contains(p.problems, "P7603")) << p.problems;
    EXPECT_TRUE(contains(p.problems, "plc.toml")) << p.problems;
    for (const core::Coherence other : {core::Coherence::kWaitFree, core::Coherence::kGlobalLock}) {
      EXPECT_TRUE(planned(toml, other).plan.has_value()) << toml;
    }
  }
}

TEST(PlanTasks, AvailableProcessorsAscend) {
  const std::vector<int> cpus = available_cpus();
  ASSERT_FALSE(cpus.empty());
  for (std::size_t i = 1; i < cpus.size(); ++i) EXPECT_LT(cpus[i - 1], cpus[i]);
}

}  // namespace
}  // namespace plc::io
