// The snapshot under pressure: more readers than cores, so that readers are preempted between looking and claiming.
#include "runtime/memory/snapshot.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>
#include <vector>

namespace plc::test {

/// A reader that takes a buffer step by step, and may be held up between any two of them.
struct HeldUp {
  explicit HeldUp(runtime::Snapshot& snapshot) : view(snapshot.subscribe()) {}
  /// True when it has a buffer again.
  bool step() {
    if (at == 0) view.announce();
    if (at == 1) newest = view.look();
    if (at == 2) view.claim(newest);
    at = (at + 1) % 3;
    return at == 0;
  }
  [[nodiscard]] const std::byte* held() const { return view.buffers_ + view.number_ * view.stride_; }

  runtime::Snapshot::Reader view;
  std::uint32_t newest = 0;
  int at = 0;
};

namespace {

using runtime::Snapshot;

std::uint64_t number_in(const std::byte* buffer) {
  std::uint64_t number = 0;
  std::memcpy(&number, buffer, sizeof number);
  return number;
}

TEST(Snapshot, AReaderThatIsHeldUpTakesANewestOneAllTheSame) {
  // It has said that it takes one, and has looked up which: then the writer goes on, as often as there are buffers.
  runtime::Arena arena;
  Snapshot snapshot(arena, 8, 1);
  HeldUp reader(snapshot);
  for (std::uint64_t number = 1; number < 4; ++number) {
    std::memcpy(snapshot.begin_write(), &number, 8);
    snapshot.publish();
  }
  reader.step();
  reader.step();
  for (std::uint64_t number = 4; number < 10; ++number) {
    std::memcpy(snapshot.begin_write(), &number, 8);
    snapshot.publish();
  }
  ASSERT_TRUE(reader.step());
  EXPECT_EQ(number_in(reader.held()), 3u) << "what the writer claimed for it when it saw it first";
  EXPECT_EQ(number_in(reader.view.acquire()), 9u);
}

/// Writer and readers take their steps in a random order, each reader held up anywhere for as long as it may be.
TEST(Snapshot, WhateverTheOrderOfTheStepsNobodyWritesWhatIsRead) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const std::uint32_t readers = 1 + seed % 4;
    runtime::Arena arena;
    Snapshot snapshot(arena, 8, readers);
    struct Reader {
      HeldUp steps;
      std::uint64_t from = 0;   ///< published last when it began to take one
      std::uint64_t value = 0;  ///< of the buffer it holds
    };
    std::vector<Reader> all;
    for (std::uint32_t i = 0; i < readers; ++i) all.push_back({HeldUp(snapshot)});
    std::uint64_t published = 0;
    std::byte* writing = nullptr;
    for (int i = 0; i < 2'000; ++i) {
      const auto who = static_cast<std::uint32_t>(random() % (readers + 2));
      if (who == readers) snapshot.choose();
      if (who == readers + 1 && writing == nullptr) {
        writing = snapshot.begin_write();
        const std::uint64_t garbage = ~std::uint64_t{0};
        std::memcpy(writing, &garbage, 8);
      } else if (who == readers + 1) {
        ++published;
        std::memcpy(writing, &published, 8);
        snapshot.publish();
        writing = nullptr;
      }
      if (who < readers) {
        Reader& reader = all[who];
        if (reader.steps.at == 0) reader.from = published;
        if (reader.steps.step()) {
          reader.value = number_in(reader.steps.held());
          ASSERT_GE(reader.value, reader.from) << "older than the newest when it began, seed " << seed;
          ASSERT_LE(reader.value, published) << "not published, seed " << seed;
        }
      }
      for (const Reader& reader : all) {
        ASSERT_TRUE(reader.steps.at != 0 || number_in(reader.steps.held()) == reader.value) << "seed " << seed;
      }
      ASSERT_EQ(number_in(snapshot.published()), published) << "seed " << seed;
    }
  }
}

constexpr std::size_t kWords = 512;

void fill(std::byte* buffer, std::uint64_t number) {
  for (std::size_t i = 0; i < kWords; ++i) std::memcpy(buffer + 8 * i, &number, 8);
}

TEST(Snapshot, TheNewestIsRead) {
  runtime::Arena arena;
  Snapshot snapshot(arena, 8, 2);
  std::array<Snapshot::Reader, 2> readers = {snapshot.subscribe(), snapshot.subscribe()};
  std::uint64_t value = 0;
  std::memcpy(&value, readers[0].acquire(), 8);
  EXPECT_EQ(value, 0u);
  for (std::uint64_t number = 1; number < 10; ++number) {
    std::memcpy(snapshot.begin_write(), &number, 8);
    std::memcpy(&value, readers[1].acquire(), 8);
    EXPECT_EQ(value, number - 1) << "read before it was published";
    snapshot.publish();
    std::memcpy(&value, snapshot.published(), 8);
    EXPECT_EQ(value, number);
    std::memcpy(&value, readers[1].acquire(), 8);
    EXPECT_EQ(value, number);
  }
}

/// False when the block holds words of two publications.
bool is_whole(const std::byte* words) {
  for (std::size_t i = 1; i < kWords; ++i) {
    if (std::memcmp(words, words + 8 * i, 8) != 0) return false;
  }
  return true;
}

/// Fills and publishes until told to stop.
class Writer {
 public:
  explicit Writer(Snapshot& snapshot)
      : thread_([this, &snapshot] {
          for (std::uint64_t number = 1; !stop_.load(std::memory_order_relaxed); ++number) {
            if (number % 3 == 0) snapshot.choose();  // as a task does ahead of its release
            fill(snapshot.begin_write(), number);
            snapshot.publish();
            published_.store(number, std::memory_order_relaxed);
          }
        }) {}
  std::uint64_t stop() {
    stop_ = true;
    thread_.join();
    return published_;
  }

 private:
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> published_{0};
  std::thread thread_;
};

constexpr auto kSomeTime = std::chrono::milliseconds(700);

class Readers : public testing::TestWithParam<std::uint32_t> {};

TEST_P(Readers, SnapshotNeverWritesAClaimedBuffer) {
  const std::uint32_t count = GetParam();
  runtime::Arena arena;
  Snapshot snapshot(arena, 8 * kWords, count);
  std::vector<Snapshot::Reader> views;
  for (std::uint32_t reader = 0; reader < count; ++reader) views.push_back(snapshot.subscribe());
  Writer writer(snapshot);
  std::atomic<std::uint64_t> mixed{0};
  std::atomic<std::uint64_t> backwards{0};
  std::vector<std::thread> readers;
  const auto end = std::chrono::steady_clock::now() + kSomeTime;
  for (std::uint32_t reader = 0; reader < count; ++reader) {
    readers.emplace_back([&, view = views[reader]]() mutable {
      std::uint64_t last = 0;
      while (std::chrono::steady_clock::now() < end) {
        const std::byte* const words = view.acquire();
        std::uint64_t first = 0;
        std::memcpy(&first, words, 8);
        if (!is_whole(words)) ++mixed;
        if (first < last) ++backwards;
        last = first;
      }
    });
  }
  for (std::thread& reader : readers) reader.join();
  EXPECT_GT(writer.stop(), 100u);
  EXPECT_EQ(mixed, 0u);
  EXPECT_EQ(backwards, 0u);
}

INSTANTIATE_TEST_SUITE_P(Snapshot, Readers, testing::Values(1u, 2u, 6u, 24u));

}  // namespace
}  // namespace plc::test
