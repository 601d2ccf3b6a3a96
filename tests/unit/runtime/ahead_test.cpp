// What a task does ahead of its release leaves no trace.
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "runtime/memory/process_image.h"
#include "tests/unit/runtime/exchange_support.h"

namespace plc::test {
namespace {

/// Everything that changes globals, once with and once without what tasks do ahead of their releases.
class Ahead : public testing::TestWithParam<core::Coherence> {
 protected:
  struct World {
    Tables t;
    std::uint32_t dint = t.b.type(TypeId::kDint);
    std::uint32_t mine[2] = {t.global("mine0", t.b.array(dint, 20), {.owner = 0}),
                             t.global("mine1", t.b.array(dint, 20), {.owner = 1})};
    std::uint32_t outside = t.global("outside", dint, {.input = true});
    std::uint32_t in = t.global("in", dint, {.input = true});
    std::uint32_t shared = t.global("shared", t.b.array(dint, 4));
    std::uint32_t text = t.global("text", t.b.string(9));
    std::uint32_t bit, whole;
    std::unique_ptr<GlobalInputs> inputs;
    std::unique_ptr<runtime::ProcessImage> image;
    std::unique_ptr<HandTask> tasks[2];

    explicit World(core::Coherence coherence) {
      t.b.image.options.coherence = coherence;
      t.b.image.options.profile = core::AddressProfile::kOverlay;
      bit = t.global("bit", t.b.boolean(), {.address = "%QX0.3", .owner = 0});
      whole = t.global("whole", t.b.type(TypeId::kWord), {.address = "%QW0", .owner = 1});
      GlobalTable& globals = t.build();
      for (std::uint32_t task = 0; task < 2; ++task) tasks[task] = std::make_unique<HandTask>(globals, task);
      const std::uint32_t field[] = {globals.field_of(in)};
      inputs = std::make_unique<GlobalInputs>(globals, field);
      image = std::make_unique<runtime::ProcessImage>(globals.image(), globals);
    }
    [[nodiscard]] std::vector<std::byte> published() const {
      std::vector<std::byte> all(t.globals->size());
      t.globals->copy(all.data());
      return all;
    }
    [[nodiscard]] std::vector<std::byte> local(std::uint32_t task) const {
      std::vector<std::byte> all(t.globals->size());
      for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = tasks[task]->get<std::byte>(i);
      return all;
    }
    void write(std::uint32_t offset, std::int32_t value) {
      EXPECT_EQ(t.write<std::int32_t>(offset, dint, value), WriteResult::kDone);
    }
    void input(std::int32_t value) {
      inputs->set(in, dint, reinterpret_cast<const std::byte*>(&value));
      inputs->publish();
    }
    void safe(std::uint32_t task, std::int32_t value) {
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      const std::array<GlobalWrite, 2> values = {{{mine[task], dint, bytes, nullptr}, {shared, dint, bytes, nullptr}}};
      tasks[task]->exchange().publish_safe(values);
    }
    /// What a program does; some of it every time, some only now and then.
    void compute(std::uint32_t task, std::uint32_t round) {
      HandTask& me = *tasks[task];
      for (std::uint32_t i = 0; i < 20; ++i)
        me.put(mine[task] + 4 * i, me.get<std::int32_t>(mine[1 - task] + 4 * i) + static_cast<std::int32_t>(round));
      me.put(mine[task], me.get<std::int32_t>(outside) + me.get<std::int32_t>(in));
      if (round % 3 == 0) me.put(shared + 4 * (round % 4), static_cast<std::int32_t>(round));
      if (round % 5 == 0) me.put(bit, static_cast<std::uint8_t>(round / 5 % 2));
      if (round % 7 == 0) me.put(whole, static_cast<std::uint16_t>(round));
    }
  };
};

TEST_P(Ahead, LeavesNoTrace) {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    World with(GetParam()), without(GetParam());
    std::uint64_t ahead = 0;
    for (std::uint32_t round = 1; round <= 150; ++round) {
      const std::uint32_t task = random() % 2;
      const std::uint32_t what = random() % 8;
      for (const std::uint32_t other : {task, 1 - task}) {
        if (random() % 2 == 0) continue;
        // Nothing, some ranges, all of them.
        constexpr std::size_t kBytes[] = {0, 40, 100'000};
        with.tasks[other]->exchange().expect(kBytes[random() % 3]);
        ++ahead;
      }
      const auto value = static_cast<std::int32_t>(random() % 1000);
      const std::uint32_t place = random() % 4;
      for (World* const world : {&with, &without}) {
        if (what == 0) world->write(world->mine[task] + 4 * place, value);
        if (what == 1) world->write(world->shared + 4 * place, value);
        if (what == 2) world->write(world->outside, value);
        if (what == 3) world->input(value);
        if (what == 4) world->safe(task, value);
        if (what < 5) continue;
        world->tasks[task]->begin();
      }
      ASSERT_TRUE(what < 5 || with.local(task) == without.local(task)) << "at the start of a cycle, seed " << seed;
      for (World* const world : {&with, &without}) {
        if (what < 5) continue;
        world->compute(task, round);
        if (what != 5) world->tasks[task]->export_only();  // else it ended in a fault
        world->tasks[task]->finish();
        world->image->sync();
      }
      ASSERT_EQ(with.published(), without.published()) << "seed " << seed << ", round " << round;
      ASSERT_TRUE(what < 5 || with.local(task) == without.local(task)) << "at the end of a cycle, seed " << seed;
    }
    EXPECT_GT(ahead, 100u);
  }
}

TEST_P(Ahead, BringsWhatOthersPublishAsLongAsTheBytesReach) {
  World world(GetParam());
  world.tasks[1]->begin();
  world.tasks[1]->put<std::int32_t>(world.mine[1], 7);
  world.tasks[1]->end();
  HandTask& task = *world.tasks[0];
  task.exchange().expect(1);
  EXPECT_EQ(task.get<std::int32_t>(world.mine[1]), 0);
  task.exchange().expect(100'000);
  // The common table is not looked at outside of critical sections.
  EXPECT_EQ(task.get<std::int32_t>(world.mine[1]), GetParam() == core::Coherence::kWaitFree ? 7 : 0);
}

TEST_P(Ahead, NobodyCanRevokeATaskBetweenItsCycles) {
  World world(GetParam());
  world.tasks[0]->exchange().expect(100'000);
  EXPECT_FALSE(world.tasks[0]->exchange().revoke());
  world.tasks[0]->begin();
  EXPECT_TRUE(world.tasks[0]->exchange().revoke());
}

INSTANTIATE_TEST_SUITE_P(Protocols, Ahead,
                         testing::Values(core::Coherence::kWaitFree, core::Coherence::kPriorityCeiling,
                                         core::Coherence::kGlobalLock));

}  // namespace
}  // namespace plc::test
