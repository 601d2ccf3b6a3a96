// Tasks on threads of their own, with an HMI that writes at random: each scan of each task is recorded, and executed
// again alone while they run, in the other engine.
#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

#include "runtime/sched/realtime.h"
#include "tests/support/failing_taskblock.h"
#include "tests/support/random_values.h"
#include "tests/support/replayed.h"

namespace plc::test {
namespace {

using bytecode::Opcode;
using core::TypeId;

/// A task that mixes all globals with what it has, and writes some of them: those it alone writes, and one that all do.
void add_task(ImageBuilder& b, const std::string& name, core::TimeNs period_ns, Word own, Word array,
              std::span<const Word> globals, std::int32_t priority, const std::string& single) {
  PouBuilder main = b.pou("P" + name, PouKind::kProgram);
  const Word sum = main.variable("sum", b.type(TypeId::kDint));
  const Word factor = b.constant<std::int32_t>(TypeId::kDint, 1'103'515'245);
  for (const Word global : globals) {
    main.op(Opcode::kMul32, {sum, sum, factor});
    main.op(Opcode::kAdd32, {sum, sum, global});
  }
  const std::uint32_t array_type = b.array(b.type(TypeId::kDint), 1500);
  const Word index = main.variable("index", b.type(TypeId::kInt));
  const Word element = main.variable("element", b.type(TypeId::kDint));
  main.op(Opcode::kAdd16, {index, index, b.constant<std::int16_t>(TypeId::kInt, 7)});
  main.op(Opcode::kAnd16, {index, index, b.constant<std::int16_t>(TypeId::kInt, 1023)});
  main.path(Opcode::kLoadAt, {element, array, array_type}, {{PathStep::kIndex, index}});
  main.op(Opcode::kAdd32, {sum, sum, element});
  main.op(Opcode::kMove32, {own, sum});
  // The last of the globals is one that all tasks write.
  main.op(Opcode::kAdd32, {globals.back(), globals.back(), sum});
  b.task(name, period_ns, {main.finish()}, priority, single);
}

struct Plant {
  explicit Plant(core::Coherence coherence, core::AddressProfile profile) {
    b.image.options.coherence = coherence;
    b.image.options.profile = profile;
    const std::uint32_t dint = b.type(TypeId::kDint);
    const Word array = b.global("array", b.array(dint, 1500), {}, {.input = true});
    std::vector<Word> globals;
    for (std::uint32_t task = 0; task < 4; ++task)
      globals.push_back(b.global("of" + std::to_string(task), dint, {}, {.owner = task}));
    globals.push_back(b.global("hmi", dint, {}, {.input = true}));
    // Under the other profile the HMI writes half of it, too.
    globals.push_back(b.global("shared", dint, {}, {.address = "%MD0"}));
    b.global("half", b.type(TypeId::kInt), {}, {.input = true, .address = "%MW1"});
    b.global("trigger", b.boolean(), {}, {.input = true});
    add_task(b, "Fast", 1'000'000, globals[0], array, globals, 0, {});
    add_task(b, "Slow", 3'000'000, globals[1], array, globals, 1, {});
    add_task(b, "Event", 0, globals[2], array, globals, 2, "trigger");
    add_task(b, "Free", 0, globals[3], array, globals, 3, {});
  }
  ImageBuilder b;
};

/// Scans in all; PLC_REPLAY_SCANS asks for more.
std::uint64_t wanted_scans() {
  const char* const text = std::getenv("PLC_REPLAY_SCANS");
  return text != nullptr ? std::strtoull(text, nullptr, 10) : 3'000;
}

void run(core::Coherence coherence, core::AddressProfile profile = core::AddressProfile::kSeparate) {
  Plant plant(coherence, profile);
  core::Diagnostics diagnostics;
  const auto image = bytecode::verify(plant.b.build(), diagnostics);
  ASSERT_TRUE(image) << diagnostics.all().front().message;
  std::string problem;
  const auto engines = Engines::load(*image, problem, {}, {native_code()});
  ASSERT_NE(engines, nullptr) << problem;
  runtime::Resource& resource = (*engines)[0];
  const auto replayed = Replayed::make(*image, resource, {}, interpreter(), problem);
  ASSERT_NE(replayed, nullptr) << problem;

  runtime::RealtimeOptions options;
  options.realtime_priority = coherence == core::Coherence::kPriorityCeiling;
  options.lock_memory = false;
  // Priorities keep tasks of one processor apart; plc-run binds them as well.
  if (options.realtime_priority) {
    options.plan = runtime::default_plan(resource.image());
    const int cpu = sched_getcpu();
    for (runtime::TaskPlan& task : options.plan) task.cpu = cpu;
  }
  std::atomic<bool> ends{false};
  std::thread hmi;
  std::uint64_t scans = 0;
  std::string different;
  {
    runtime::RealtimeScheduler scheduler(resource, options);
    if (scheduler.start().problem) GTEST_SKIP() << "no real-time priorities here";
    hmi = std::thread([&] {
      Random random(7);
      const bytecode::Image& i = resource.image();
      const auto& fields = i.types[i.global_type].fields;
      while (!ends) {
        std::vector<std::int32_t> values(8);
        std::vector<runtime::GlobalWrite> batch;
        for (std::int32_t& value : values) {
          value = static_cast<std::int32_t>(random.below(1u << 30));
          const auto& field = fields[random.below(fields.size())];
          if (i.types[field.type].kind == TypeKind::kArray) {
            const auto element = static_cast<std::uint32_t>(random.below(1500));
            batch.push_back({field.offset + 4 * element, i.types[field.type].element,
                             reinterpret_cast<const std::byte*>(&value), nullptr});
          } else {
            if (i.types[field.type].size == 1) value &= 1;
            if (field.name == "shared" && random.once_in(2)) continue;
            batch.push_back({field.offset, field.type, reinterpret_cast<const std::byte*>(&value), nullptr});
          }
        }
        static_cast<void>(resource.globals().write(batch));
        std::this_thread::sleep_for(std::chrono::microseconds(random.below(700)));
      }
    });
    const std::uint64_t wanted = wanted_scans();
    while (scans < wanted && different.empty()) {
      scans = 0;
      for (std::uint32_t t = 0; t < resource.task_count() && different.empty(); ++t) {
        different = replayed->follow(t);
        scans += replayed->recorder(t).scans();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    scheduler.request_stop();
    EXPECT_TRUE(scheduler.join().empty());
  }
  ends = true;
  hmi.join();
  EXPECT_EQ(different, "");
  for (std::uint32_t t = 0; t < resource.task_count(); ++t) {
    EXPECT_EQ(replayed->follow(t), "");
    EXPECT_EQ(replayed->difference(t), "") << "task " << t;
    EXPECT_EQ(replayed->recorder(t).lost(), 0u);
    EXPECT_GT(replayed->recorder(t).scans(), 0u) << "task " << t;
  }
}

TEST(ReplayThreads, WaitFree) { run(core::Coherence::kWaitFree); }
TEST(ReplayThreads, GlobalLock) { run(core::Coherence::kGlobalLock); }
TEST(ReplayThreads, PriorityCeiling) { run(core::Coherence::kPriorityCeiling); }
TEST(ReplayThreads, AddressesThatOverlap) { run(core::Coherence::kWaitFree, core::AddressProfile::kOverlay); }

}  // namespace
}  // namespace plc::test
