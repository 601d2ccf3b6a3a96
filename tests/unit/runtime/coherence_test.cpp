// Nothing tears and nothing mixes under any protocol: tasks that exchange as fast as they can, on two processors and on
// one.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <thread>

#include "runtime/sched/priority.h"
#include "runtime/sched/thread_settings.h"
#include "tests/unit/runtime/exchange_support.h"

namespace plc::test {
namespace {

using runtime::bind_to_cpu;
using runtime::fifo_priority;
using runtime::set_fifo;
using runtime::set_own_priority;

/// Exchanges per size of group; PLC_EXCHANGES raises it for longer runs.
std::uint64_t exchanges() {
  const char* const text = std::getenv("PLC_EXCHANGES");
  return text == nullptr ? 60'000 : std::strtoull(text, nullptr, 10);
}

/// Two tasks that own a group each, a reader and a writer from outside, all as fast as they can, on two cores. Every
/// publication fills its group with one number, so any mixture of two shows.
class Consistency : public testing::TestWithParam<std::tuple<core::Coherence, std::uint32_t>> {};

TEST_P(Consistency, NothingTearsAndNothingMixes) {
  const auto [coherence, size] = GetParam();
  Tables t;
  t.b.image.options.coherence = coherence;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  const std::uint32_t text = t.b.string(28);
  const std::uint32_t group = t.b.array(lint, size);
  const std::uint32_t first = t.global("first", group, {.owner = 0});
  const std::uint32_t second = t.global("second", group, {.owner = 1});
  const std::uint32_t outside = t.global("outside", group, {.input = true});
  const std::uint32_t asked = t.global("asked", t.b.array(lint, 3), {.owner = 0});
  const std::uint32_t shared = t.global("shared", text);
  GlobalTable& globals = t.build();
  HandTask a(globals, 0);
  HandTask b(globals, 1);
  GlobalReader reader(globals);
  constexpr std::int64_t kStop = -1;
  const std::uint64_t rounds = std::max<std::uint64_t>(exchanges() / (1 + size / 100), 50);
  std::atomic<std::uint64_t> done{0};
  std::atomic<std::uint64_t> bad{0};
  std::atomic<bool> stop{false};

  // The number a group is filled with, or kStop when it is not one number.
  const auto number = [](const std::byte* values, std::uint32_t count) {
    std::int64_t head;
    std::memcpy(&head, values, sizeof head);
    for (std::uint32_t i = 1; i < count; ++i) {
      if (std::memcmp(values, values + 8u * i, 8) != 0) return kStop;
    }
    return head;
  };
  const auto expect = [&bad](bool good) {
    if (!good) bad.fetch_add(1, std::memory_order_relaxed);
  };
  // A string whose characters are all its length: "", "\1", "\2\2", ..
  const auto string_is_whole = [](const std::byte* value) {
    core::StringHeader header;
    std::memcpy(&header, value, sizeof header);
    for (std::uint16_t i = 0; i < header.length; ++i) {
      if (std::to_integer<std::uint16_t>(value[sizeof header + i]) != header.length) return false;
    }
    return header.length <= 28 && header.capacity == 28;
  };
  const auto cycle = [&](HandTask& task, std::uint32_t mine, std::uint32_t theirs) {
    std::vector<std::byte> copy(8u * size);
    std::int64_t newest = 0;
    std::int64_t newest_outside = 0;
    for (std::uint64_t round = 1; round <= rounds; ++round) {
      if (round % 2 == 0) task.exchange().expect(100'000);
      task.begin();
      for (std::uint32_t i = 0; i < size; ++i) {
        const auto value = task.get<std::int64_t>(theirs + 8 * i);
        std::memcpy(copy.data() + 8u * i, &value, 8);
      }
      const std::int64_t seen = number(copy.data(), size);
      expect(seen >= newest);
      newest = seen;
      for (std::uint32_t i = 0; i < size; ++i) {
        const auto value = task.get<std::int64_t>(outside + 8 * i);
        std::memcpy(copy.data() + 8u * i, &value, 8);
      }
      const std::int64_t from_outside = number(copy.data(), size);
      expect(from_outside >= newest_outside);
      newest_outside = from_outside;
      if (mine == first) {
        expect(task.get<std::int64_t>(asked) == task.get<std::int64_t>(asked + 8) &&
               task.get<std::int64_t>(asked) == task.get<std::int64_t>(asked + 16));
      }
      struct {
        std::byte bytes[32];
      } string = task.get<decltype(string)>(shared);
      expect(string_is_whole(string.bytes));
      const auto length = static_cast<std::uint16_t>(round % 29);
      const core::StringHeader header{28, length};
      std::memcpy(string.bytes, &header, sizeof header);
      for (std::uint16_t i = 0; i < length; ++i) string.bytes[sizeof header + i] = static_cast<std::byte>(length);
      task.put(shared, string);
      for (std::uint32_t i = 0; i < size; ++i) task.put<std::int64_t>(mine + 8 * i, static_cast<std::int64_t>(round));
      task.end();
      done.fetch_add(1, std::memory_order_relaxed);
    }
  };
  std::thread one([&] { cycle(a, first, second); });
  std::thread two([&] { cycle(b, second, first); });
  std::thread three([&] {
    std::vector<std::byte> copy(8u * size);
    std::byte string[32];
    while (!stop) {
      reader.take();
      for (const std::uint32_t where : {first, second, outside}) {
        reader.read(where, 8 * size, copy.data());
        expect(number(copy.data(), size) >= 0);
      }
      reader.read(shared, sizeof string, string);
      expect(string_is_whole(string));
      done.fetch_add(1, std::memory_order_relaxed);
    }
  });
  std::thread four([&] {
    std::vector<std::byte> table(globals.size());
    for (std::int64_t round = 1; !stop; ++round) {
      std::vector<GlobalWrite> batch;
      const auto* const value = reinterpret_cast<const std::byte*>(&round);
      for (std::uint32_t i = 0; i < size; ++i) batch.push_back({outside + 8 * i, lint, value, nullptr});
      for (std::uint32_t i = 0; i < 3; ++i) batch.push_back({asked + 8 * i, lint, value, nullptr});
      const WriteResult result = globals.write(batch);
      expect(result != WriteResult::kRefused);
      if (result == WriteResult::kBusy) std::this_thread::yield();
      globals.copy(table.data());
      expect(number(table.data() + first, size) >= 0 && number(table.data() + outside, size) >= 0);
      expect(number(table.data() + asked, 3) >= 0 && string_is_whole(table.data() + shared));
      done.fetch_add(1, std::memory_order_relaxed);
    }
  });
  one.join();
  two.join();
  stop = true;
  three.join();
  four.join();
  EXPECT_EQ(bad, 0u);
  EXPECT_GE(done, 2 * rounds);
  RecordProperty("exchanges", std::to_string(done));
}

// Priority ceilings need one processor and priorities: below.
INSTANTIATE_TEST_SUITE_P(Groups, Consistency,
                         testing::Combine(testing::Values(core::Coherence::kWaitFree, core::Coherence::kGlobalLock),
                                          testing::Values(1u, 10u, 100u, 1'000u, 10'000u)));

/// What a task's thread has under the protocol; the priorities of these tasks are 0, 1, 2. Below the kernel's threads.
constexpr std::int32_t lowered(std::int32_t priority) { return 60 + priority; }
void set_lowered(std::int32_t priority) noexcept { set_own_priority(lowered(priority)); }

/// Three tasks of one processor, the more urgent ones preempting the others at any instant, in exchanges above all.
/// Each publishes its group filled with the number of its round.
class Ceilings : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Ceilings, NothingMixesOnOneProcessor) {
  const std::uint32_t size = GetParam();
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  const std::uint32_t lint = t.b.type(TypeId::kLint);
  std::array<std::uint32_t, 3> group{};
  for (std::uint32_t task = 0; task < 3; ++task) {
    group[task] = t.global("g" + std::to_string(task), t.b.array(lint, size), {.owner = task});
  }
  GlobalTable& globals = t.build(3);
  std::array<HandTask, 3> tasks{{{globals, 0, set_lowered}, {globals, 1, set_lowered}, {globals, 2, set_lowered}}};
  std::atomic<std::uint64_t> bad{0};
  std::array<std::atomic<std::uint64_t>, 3> done{};
  std::atomic<bool> stop{false};
  std::atomic<int> refused{0};
  const int cpu = sched_getcpu();
  const auto run = [&](std::uint32_t me) {
    if (bind_to_cpu(pthread_self(), cpu) != 0 ||
        set_fifo(pthread_self(), fifo_priority(lowered(static_cast<std::int32_t>(me)))) != 0) {
      ++refused;
      return;
    }
    HandTask& task = tasks[me];
    std::array<std::int64_t, 3> newest{};
    for (std::int64_t round = 1; !stop.load(std::memory_order_relaxed); ++round) {
      const auto began = std::chrono::steady_clock::now();
      task.begin();
      for (std::uint32_t other = 0; other < 3; ++other) {
        const auto head = task.get<std::int64_t>(group[other]);
        bool whole = head >= newest[other];
        for (std::uint32_t i = 1; i < size; ++i) whole = whole && task.get<std::int64_t>(group[other] + 8 * i) == head;
        if (!whole) ++bad;
        newest[other] = head;
      }
      for (std::uint32_t i = 0; i < size; ++i) task.put<std::int64_t>(group[me] + 8 * i, round);
      task.end();
      ++done[me];
      // The more urgent come again while the others exchange, and leave them time to: on an emulated processor a round
      // may take as long as a pause. The least urgent leaves some to the kernel, which may need it to wake this test.
      const auto took = std::chrono::steady_clock::now() - began;
      constexpr std::array<int, 3> kPauseUs = {20, 70, 5};
      std::this_thread::sleep_for(
          std::max<std::chrono::nanoseconds>(std::chrono::microseconds(kPauseUs[me]), me == 2 ? took / 4 : 3 * took));
    }
  };
  std::array<std::thread, 3> threads;
  for (std::uint32_t i = 0; i < 3; ++i) threads[i] = std::thread(run, i);
  const std::uint64_t wanted = std::max<std::uint64_t>(exchanges() / 20 / (1 + size / 100), 50);
  const auto begin = std::chrono::steady_clock::now();
  while (refused == 0 && (done[0] < wanted || done[1] < wanted || done[2] < wanted)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    if (std::chrono::steady_clock::now() - begin > std::chrono::minutes(5)) break;
  }
  stop = true;
  for (std::thread& thread : threads) thread.join();
  if (refused != 0) GTEST_SKIP() << "no real-time priority";
  EXPECT_EQ(bad, 0u);
  for (const auto& count : done) EXPECT_GE(count, wanted);
}

INSTANTIATE_TEST_SUITE_P(Groups, Ceilings, testing::Values(1u, 10u, 100u, 1'000u, 10'000u));

/// Records what the protocol does to the priority.
std::vector<std::int32_t> raised;
void record_priority(std::int32_t priority) noexcept { raised.push_back(priority); }

TEST(CeilingProtocol, EveryGroupIsCopiedAtTheCeilingOfWhatItHolds) {
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  const std::uint32_t dint = t.b.type(TypeId::kDint);
  t.global("mine", dint, {.owner = 1});
  GlobalTable& globals = t.build(2);
  EXPECT_EQ(globals.ceiling(0), 0) << "task 0 imports it";
  HandTask urgent(globals, 0, record_priority);
  HandTask slow(globals, 1, record_priority);
  raised.clear();
  urgent.begin();
  urgent.end();
  EXPECT_TRUE(raised.empty()) << "nobody is more urgent";
  slow.begin();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{0, 1})) << raised.size();
  slow.end();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{0, 1, 0, 1})) << raised.size();
}

TEST(CeilingProtocol, PrioritiesOfTheMachineCountNotThoseOfTheImage) {
  Tables t;
  t.b.image.options.coherence = core::Coherence::kPriorityCeiling;
  t.global("mine", t.b.type(TypeId::kDint), {.owner = 1});
  t.build(2);
  const std::array<std::int32_t, 2> swapped = {7, 3};
  GlobalTable globals(t.verified->image(), swapped);
  EXPECT_EQ(globals.ceiling(0), 3);
  EXPECT_EQ(globals.priority(0), 7);
  HandTask first(globals, 0, record_priority);
  raised.clear();
  first.begin();
  EXPECT_TRUE(raised == (std::vector<std::int32_t>{3, 7}));
}

}  // namespace
}  // namespace plc::test
