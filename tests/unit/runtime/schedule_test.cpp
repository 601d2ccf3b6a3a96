// Tasks of an image on a machine: which meet, who holds up whom under each coherence protocol, and what cannot fit.
#include "runtime/sched/schedule.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "runtime/sched/task.h"
#include "tests/support/image_builder.h"

namespace plc::test {
namespace {

using core::Coherence;
using core::TimeNs;
using runtime::certain_misses;
using runtime::CostKind;
using runtime::CostTable;
using runtime::make_schedule;
using runtime::Schedule;
using runtime::TaskPlan;
using runtime::Verdict;

struct OneTask {
  TimeNs period_ns = 0;
  std::int32_t priority = 0;
  TimeNs execution_ns = 0;  ///< measured; 0 = not
  int cpu = -1;
  TimeNs offset_ns = 0;
  std::string single{};
  std::optional<TimeNs> lead_ns = 0;  ///< nothing = the default
};

struct Tasks {
  Image image;
  std::vector<TaskPlan> plan;
  explicit Tasks(const std::vector<OneTask>& tasks) {
    for (const OneTask& task : tasks) {
      image.tasks.push_back({"T" + std::to_string(plan.size()), task.period_ns, task.priority, task.single, 0});
      TaskPlan one;
      one.priority = task.priority;
      one.cpu = task.cpu;
      one.offset_ns = task.offset_ns;
      one.lead_ns = task.lead_ns;
      if (task.execution_ns != 0) one.execution_ns = task.execution_ns;
      plan.push_back(one);
    }
    bytecode::ImagePou body;
    body.kind = PouKind::kTask;
    body.code = {bytecode::opcode_word(Opcode::kReturn)};
    image.types.emplace_back();
    image.types[0].kind = TypeKind::kStruct;
    image.pous.push_back(body);
  }
  [[nodiscard]] Schedule schedule(const CostTable& costs = {}, double margin = 1) const {
    return make_schedule(image, plan, costs, margin);
  }
};

TEST(Schedule, ALeadIsProcessorTimeOfEveryRelease) {
  const Tasks tasks({{1'000'000, 0, 300'000, -1, 0, "", 50'000}, {2'000'000, 1, 900'000, -1, 0, "", std::nullopt}});
  const Schedule s = tasks.schedule();
  EXPECT_EQ(s.tasks[0].lead_ns, 50'000);
  EXPECT_EQ(s.tasks[1].lead_ns, 50'000) << "the default";
  EXPECT_EQ(s.tasks[0].execution_ns, 300'000) << "the scan is the scan";
  EXPECT_EQ(s.processors[0].timings[0].response_ns, 350'000);
  EXPECT_EQ(s.processors[0].timings[1].response_ns, 950'000 + 2 * 350'000);
}

TEST(Schedule, MeasuredTimesCountAsTheyAreAndEstimatesWithTheirMargin) {
  const Tasks tasks({{1'000'000, 0, 300'000}, {2'000'000, 1}});
  CostTable costs;
  costs[CostKind::kScan] = {1000, 1};
  costs[CostKind::kRelease] = {20, 20};
  const Schedule s = tasks.schedule(costs, 0.5);
  EXPECT_EQ(s.release_ns, 30);
  EXPECT_TRUE(s.tasks[0].measured);
  EXPECT_EQ(s.tasks[0].execution_ns, 300'000);
  EXPECT_FALSE(s.tasks[1].measured);
  EXPECT_EQ(s.tasks[1].estimate_ns, 1000);
  EXPECT_EQ(s.tasks[1].execution_ns, 1500);
  ASSERT_EQ(s.processors.size(), 1u);
  EXPECT_EQ(s.processors[0].cpu, -1);
  EXPECT_EQ(s.processors[0].timings[1].response_ns, 300'000 + 1500 + 2 * 30);
}

// SCHED_FIFO has 80 levels for tasks: from 79 on, none precedes another.
TEST(Schedule, PrioritiesThatThreadsCannotTellApartAreOne) {
  const Tasks tasks({{10'000'000, 100, 1'000'000}, {10'000'000, 200, 2'000'000}});
  const Schedule s = tasks.schedule();
  EXPECT_EQ(s.tasks[0].priority, s.tasks[1].priority);
  EXPECT_EQ(s.processors[0].timings[0].response_ns, 3'000'000);
  EXPECT_EQ(s.processors[0].timings[1].response_ns, 3'000'000);
}

TEST(Schedule, ATaskThatIsBoundToNoProcessorMayMeetAllOthers) {
  const Tasks tasks({{10'000'000, 1, 1'000'000, 0}, {10'000'000, 1, 2'000'000, 3}, {10'000'000, 0, 4'000'000}});
  const Schedule s = tasks.schedule();
  ASSERT_EQ(s.processors.size(), 2u);
  EXPECT_EQ(s.processors[0].cpu, 0);
  EXPECT_EQ(s.processors[0].tasks, (std::vector<std::uint32_t>{2, 0}));
  EXPECT_EQ(s.processors[0].timings[1].response_ns, 5'000'000);
  EXPECT_EQ(s.processors[1].cpu, 3);
  EXPECT_EQ(s.processors[1].tasks, (std::vector<std::uint32_t>{2, 1}));
  EXPECT_EQ(s.processors[1].timings[1].response_ns, 6'000'000);
}

TEST(Schedule, EventTasksComeAsOftenAsTheirTriggerIsLookedAt) {
  const Tasks tasks({{0, 0, 200'000, -1, 0, "go"}, {10'000'000, 1, 1'000'000}});
  const Schedule s = tasks.schedule();
  EXPECT_EQ(s.processors[0].timings[0].deadline_ns, runtime::kFreewheelNs);
  EXPECT_EQ(s.processors[0].timings[1].response_ns, 1'000'000 + 2 * 200'000);
}

// ---- coherence --------------------------------------------------------------------------------------------------

/// Three tasks, "Fast", "Middle" and "Slow", and what each writes alone: 100, 1,000 and 10,000 bytes. All read all. A
/// byte takes 1 ns, all else nothing.
struct Exchange {
  Image image;
  std::vector<TaskPlan> plan;
  CostTable costs;

  explicit Exchange(Coherence coherence, std::vector<int> cpus = {0, 0, 0}) {
    ImageBuilder b;
    const std::uint32_t byte = b.type(TypeId::kByte);
    std::uint32_t bytes = 100;
    for (std::uint32_t t = 0; t < 3; ++t, bytes *= 10)
      b.global("g" + std::to_string(t), b.array(byte, bytes), {}, {.owner = t});
    for (std::uint32_t t = 0; t < 3; ++t) {
      PouBuilder body = b.pou("Body", PouKind::kTask);
      if (coherence == Coherence::kGlobalLock) body.op(Opcode::kLock);
      if (coherence == Coherence::kPriorityCeiling && t != 0) body.op(Opcode::kRaisePriority, {0, 3});
      body.op(Opcode::kReadN, {0, 3});
      if (coherence == Coherence::kPriorityCeiling && t != 0) body.op(Opcode::kReschedule);
      if (coherence == Coherence::kGlobalLock) body.op(Opcode::kUnlock).op(Opcode::kLock);
      if (coherence == Coherence::kPriorityCeiling && t != 0) body.op(Opcode::kRaisePriority, {t, 1});
      body.op(Opcode::kWriteN, {t, 1});
      if (coherence == Coherence::kPriorityCeiling && t != 0) body.op(Opcode::kReschedule);
      if (coherence == Coherence::kGlobalLock) body.op(Opcode::kUnlock);
      bodies.push_back(body.finish());
    }
    image = b.build();
    image.options.coherence = coherence;
    for (std::uint32_t t = 0; t < 3; ++t) {
      image.globals[t].writers = 1;
      image.tasks.push_back({"T", 10'000'000 * (t + 1), static_cast<std::int32_t>(t), {}, bodies[t]});
      plan.push_back({static_cast<std::int32_t>(t), cpus[t]});
    }
    costs[CostKind::kImportByte] = costs[CostKind::kExportByte] = {1, 1};
  }
  Schedule schedule() { return make_schedule(image, plan, costs, 0); }
  std::vector<TimeNs> blocking() {
    std::vector<TimeNs> out;
    for (const runtime::TaskDemand& task : schedule().tasks) out.push_back(task.blocking_ns);
    return out;
  }
  std::vector<std::uint32_t> bodies;
};

using Times = std::vector<TimeNs>;

TEST(Blocking, NobodyWaitsForSnapshots) { EXPECT_EQ(Exchange(Coherence::kWaitFree).blocking(), (Times{0, 0, 0})); }

// Imports: 11,000, 10,100 and 1,100 bytes; exports: 100, 1,000 and 10,000. Each scan takes the lock twice.
TEST(Blocking, TheLockIsHeldForTheLongestCopy) {
  EXPECT_EQ(Exchange(Coherence::kGlobalLock).blocking(), (Times{2 * 10'100, 2 * 10'000, 0}));
}

TEST(Blocking, TheLockIsHeldOnOtherProcessorsToo) {
  Exchange e(Coherence::kGlobalLock, {0, 0, 1});
  const Schedule s = e.schedule();
  EXPECT_EQ(s.tasks[0].waiting_ns, 2 * 10'000);
  EXPECT_EQ(s.tasks[1].waiting_ns, 2 * 10'000);
  EXPECT_EQ(s.tasks[2].waiting_ns, 2 * (11'000 + 10'100));
  EXPECT_EQ(s.tasks[0].blocking_ns, 2 * 10'100);
  EXPECT_EQ(s.tasks[2].blocking_ns, 0);
}

// All read all, so every ceiling is the fast task's: it waits for one copy, the longest of the others.
TEST(Blocking, CeilingsHoldUpOnce) {
  EXPECT_EQ(Exchange(Coherence::kPriorityCeiling).blocking(), (Times{10'100, 10'000, 0}));
}

// What only the slower two share holds up the fast one no longer.
TEST(Blocking, TasksThatShareNothingAreNotHeldUp) {
  Exchange e(Coherence::kPriorityCeiling);
  // "Fast" reads and writes its own bytes only, and the others no longer read those.
  e.image.pous[e.bodies[0]].code = {bytecode::opcode_word(Opcode::kWriteN), 0, 1,
                                    bytecode::opcode_word(Opcode::kReturn)};
  for (const std::uint32_t t : {1u, 2u}) {
    std::vector<std::uint32_t>& code = e.image.pous[e.bodies[t]].code;
    for (std::size_t w = 0; w + 2 < code.size(); ++w) {
      const bool all = code[w + 1] == 0 && code[w + 2] == 3;
      const bool range =
          code[w] == bytecode::opcode_word(Opcode::kReadN) || code[w] == bytecode::opcode_word(Opcode::kRaisePriority);
      if (all && range) code[w + 1] = 1, code[w + 2] = 2;
    }
  }
  EXPECT_EQ(e.blocking(), (Times{0, 10'000, 0}));
}

// ---- refusing ---------------------------------------------------------------------------------------------------

using Missed = std::vector<std::uint32_t>;
Missed misses(const std::vector<OneTask>& tasks, const std::vector<int>& cpus) {
  const Tasks t(tasks);
  return certain_misses(t.image, t.plan, cpus);
}

TEST(CertainMisses, OfMeasuredTasksOnOneProcessor) {
  const OneTask fast{10, 0, 6, 0};
  EXPECT_EQ(misses({fast, {20, 1, 8, 0}}, {0, 1}), Missed{});
  EXPECT_EQ(misses({fast, {20, 1, 9, 0}}, {0, 1}), Missed{1});
  EXPECT_EQ(misses({fast, {20, 1, 9, 1}}, {0, 1}), Missed{});
  EXPECT_EQ(misses({fast, {20, 1, 0, 0}}, {0, 1}), Missed{});           // was not measured
  EXPECT_EQ(misses({fast, {20, 1, 9, 0, 0, "go"}}, {0, 1}), Missed{});  // may never come
  EXPECT_EQ(misses({fast, {0, 1, 500, 0}}, {0, 1}), Missed{});          // has no deadline
  EXPECT_EQ(misses({fast, {20, 1, 21, 1}}, {0, 1}), Missed{1});         // alone
}

TEST(CertainMisses, OffsetsMayKeepTasksApart) {
  // 5 every 10 and 4 every 10 with a deadline of 5: together it misses, half an interval apart it does not.
  Tasks t({{10, 0, 5, 0}, {10, 1, 4, 0}});
  t.plan[1].deadline_ns = 5;
  EXPECT_EQ(certain_misses(t.image, t.plan, std::vector{0}), Missed{1});
  t.plan[1].offset_ns = 5;
  EXPECT_EQ(certain_misses(t.image, t.plan, std::vector{0}), Missed{});
  t.plan[1].execution_ns = 6;  // but not when there is more to do than time
  t.plan[1].deadline_ns = 0;
  EXPECT_EQ(certain_misses(t.image, t.plan, std::vector{0}), Missed{1});
}

TEST(CertainMisses, TasksThatMayRunAnywhereNeedRoomSomewhere) {
  const std::vector<OneTask> tasks = {{10, 0, 8}, {10, 1, 8}};
  EXPECT_EQ(misses(tasks, {0, 1}), Missed{});
  EXPECT_EQ(misses(tasks, {0}), Missed{1});
  EXPECT_EQ(misses({{10, 0, 8}, {10, 1, 8}, {10, 2, 8}}, {0, 1}), (Missed{0, 1, 2}));
}

}  // namespace
}  // namespace plc::test
