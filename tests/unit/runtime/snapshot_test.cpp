// The snapshot under pressure: more readers than cores, so that readers are preempted between looking and claiming.
#include "runtime/memory/snapshot.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <thread>
#include <vector>

namespace plc::test {
namespace {

using runtime::Snapshot;

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
  explicit Writer(Snapshot& snapshot) : thread_([this, &snapshot] {
    for (std::uint64_t number = 1; !stop_.load(std::memory_order_relaxed); ++number) {
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

TEST(Snapshot, AClaimedBufferIsNeverWritten) {
  constexpr std::uint32_t kReaders = 6;
  runtime::Arena arena;
  Snapshot snapshot(arena, 8 * kWords, kReaders);
  std::vector<Snapshot::Reader> views;
  for (std::uint32_t reader = 0; reader < kReaders; ++reader) views.push_back(snapshot.subscribe());
  Writer writer(snapshot);
  std::atomic<std::uint64_t> mixed{0};
  std::atomic<std::uint64_t> backwards{0};
  std::vector<std::thread> readers;
  const auto end = std::chrono::steady_clock::now() + kSomeTime;
  for (std::uint32_t reader = 0; reader < kReaders; ++reader) {
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

}  // namespace
}  // namespace plc::test
