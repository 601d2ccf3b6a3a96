// Records of scans: the ring that they go through, what is left out when it is full, checkpoints.
#include <gtest/gtest.h>

#include <atomic>
#include <cfenv>
#include <cstring>
#include <thread>
#include <vector>

#include "runtime/record/recorder.h"
#include "runtime/record/replay.h"
#include "runtime/record/ring.h"

namespace plc::test {
namespace {

using runtime::EntryHead;
using runtime::EntryKind;
using runtime::Recorder;
using runtime::RecordHead;
using runtime::RecordKind;
using runtime::RecordRing;

std::unique_ptr<RecordRing> ring_of(std::size_t bytes, std::size_t most) {
  auto ring = RecordRing::make(bytes, most);
  EXPECT_TRUE(ring) << ring.error().message;
  return std::move(*ring);
}

RecordHead head_of(std::span<const std::byte> record) {
  RecordHead head;
  std::memcpy(&head, record.data(), sizeof head);
  return head;
}

/// A record of `bytes` that counts.
void put(std::byte* to, std::uint32_t bytes, std::uint64_t scan) {
  RecordHead head;
  head.bytes = bytes;
  head.scan = scan;
  std::memset(to, static_cast<int>(scan % 251), bytes);
  std::memcpy(to, &head, sizeof head);
}

TEST(RecordRing, RecordsOfEverySizeComeInOnePieceAtEveryPlace) {
  constexpr std::size_t kMost = 1024;
  const auto ring = ring_of(4096, kMost);
  std::uint64_t written = 0, read = 0;
  for (std::uint32_t bytes = sizeof(RecordHead); written < 3000; bytes += 16) {
    if (bytes > kMost) bytes = sizeof(RecordHead);
    std::byte* to = nullptr;
    while ((to = ring->open()) == nullptr) {
      const auto record = ring->next();
      ASSERT_FALSE(record.empty());
      ASSERT_EQ(head_of(record).scan, read);
      for (std::size_t i = sizeof(RecordHead); i < record.size(); ++i)
        ASSERT_EQ(record[i], static_cast<std::byte>(read % 251));
      ++read;
    }
    put(to, bytes, written++);
    ring->close(bytes);
  }
  EXPECT_GT(read, 2900u);
}

TEST(RecordRing, HasRoomForTwoOfTheLargest) {
  const auto ring = ring_of(1, 10'000);
  for (std::uint64_t n = 0; n < 2; ++n) {
    std::byte* const to = ring->open();
    ASSERT_NE(to, nullptr);
    put(to, 10'000, n);
    ring->close(10'000);
  }
  EXPECT_EQ(ring->open(), nullptr);
  EXPECT_EQ(head_of(ring->next()).scan, 0u);
  EXPECT_EQ(ring->open(), nullptr) << "what is being read is not given back yet";
  EXPECT_EQ(head_of(ring->next()).scan, 1u);
  EXPECT_NE(ring->open(), nullptr);
  EXPECT_TRUE(ring->next().empty());
}

TEST(RecordRing, OneThreadWritesAndAnotherReads) {
  const auto ring = ring_of(8192, 512);
  constexpr std::uint64_t kRecords = 200'000;
  std::thread writer([&] {
    for (std::uint64_t n = 0; n < kRecords;) {
      std::byte* const to = ring->open();
      if (to == nullptr) {
        std::this_thread::yield();
        continue;
      }
      const auto bytes = static_cast<std::uint32_t>(sizeof(RecordHead) + n % 29 * 16);
      put(to, bytes, n++);
      ring->close(bytes);
    }
  });
  for (std::uint64_t n = 0; n < kRecords;) {
    const auto record = ring->next();
    if (record.empty()) {
      std::this_thread::yield();
      continue;
    }
    EXPECT_EQ(head_of(record).scan, n);
    EXPECT_EQ(record.size(), sizeof(RecordHead) + n % 29 * 16);
    if (!record.empty() && record.size() > sizeof(RecordHead)) {
      EXPECT_EQ(record.back(), static_cast<std::byte>(n % 251));
    }
    ++n;
  }
  writer.join();
}

/// A table of 1,300 bytes, a ring and a recorder.
struct Bench {
  explicit Bench(std::size_t most = 4096, std::size_t bytes = 64 * 1024)
      : ring(ring_of(bytes, most)), table(10'000), recorder(*ring, table) {}
  void scan() { recorder.close({}, {}); }
  RecordHead next() {
    const auto record = ring->next();
    last.assign(record.begin(), record.end());
    return record.empty() ? RecordHead{.bytes = 0} : head_of(record);
  }
  std::unique_ptr<RecordRing> ring;
  std::vector<std::byte> table;
  std::vector<std::byte> last;
  Recorder recorder;
};

TEST(Recorder, NotesOnlyWhatDiffers) {
  Bench b;
  std::vector<std::byte> from(9000);
  b.recorder.copy(100, from.data(), 1000);
  b.recorder.copy(0, from.data(), 9000);
  b.scan();
  EXPECT_EQ(b.next().bytes, sizeof(RecordHead));
  // Of large stretches the parts, joined where they are neighbours.
  from[0] = from[64] = from[8999] = std::byte{7};
  b.recorder.copy(1000, from.data(), 9000);
  b.scan();
  EXPECT_EQ(b.next().bytes, sizeof(RecordHead) + 2 * sizeof(EntryHead) + 128 + runtime::padded(9000 % 64));
  EXPECT_EQ(b.table[1000], std::byte{7});
  EXPECT_EQ(b.table[9999], std::byte{7});
}

TEST(Recorder, WhatIsWrittenIsReadInItsOrder) {
  Bench b;
  std::vector<std::byte> replica = b.table;
  const std::byte early{1}, late{2}, element{3};
  b.recorder.copy(10, &early, 1);
  b.recorder.next_import();
  b.recorder.next_import();
  b.recorder.copy(10, &late, 1);
  b.recorder.queue(true, {&element, 1});
  b.recorder.queue(false, {});
  b.recorder.number(77);
  b.table[500] = std::byte{9};
  const runtime::PortBytes port{&b.table[500], 1};
  b.recorder.taskblock(4, 2, {&port, 1});
  RecordHead head;
  head.now_ns = 123;
  head.events = 5;
  b.recorder.close(head, {1, 2, 3, 4});
  const RecordHead read = b.next();
  EXPECT_EQ(read.now_ns, 123);
  EXPECT_EQ(read.events, 5u);
  runtime::Replay replay;
  replay.set_table(replica);
  replay.begin(b.last);
  replay.start();
  EXPECT_EQ(replica[10], early);
  replay.import();
  EXPECT_EQ(replica[10], early) << "the first import brought nothing";
  replay.import();
  EXPECT_EQ(replica[10], late);
  std::byte taken{};
  EXPECT_TRUE(replay.queue(&taken, 1));
  EXPECT_EQ(taken, element);
  EXPECT_FALSE(replay.queue(&taken, 1));
  EXPECT_EQ(replay.number(), 77u);
  const runtime::PortBytes out{&replica[500], 1};
  EXPECT_EQ(replay.taskblock(4, {&out, 1}), 2u);
  EXPECT_EQ(replica[500], std::byte{9});
  EXPECT_FALSE(replay.finished());
  EXPECT_EQ(replay.fault(), (runtime::RecordedFault{1, 2, 3, 4}));
  EXPECT_TRUE(replay.finished());
  // Another question than the one that was asked.
  replay.begin(b.last);
  replay.start();
  EXPECT_EQ(replay.number(), 0u);
  EXPECT_FALSE(replay.finished());
}

TEST(Recorder, AFullRingLosesRecordsAndSaysHowMany) {
  Bench b(1024, 4096);
  std::byte value{1};
  std::uint64_t scans = 0;
  while (b.recorder.lost() == 0) {
    value ^= std::byte{3};
    b.recorder.copy(0, &value, 1);
    b.scan();
    ++scans;
  }
  value ^= std::byte{3};
  b.recorder.copy(0, &value, 1);
  EXPECT_EQ(b.table[0], value) << "the scan goes on as ever";
  b.scan();
  EXPECT_EQ(b.recorder.lost(), 2u);
  std::uint64_t read = 0;
  for (RecordHead head = b.next(); head.bytes != 0; head = b.next(), ++read) EXPECT_EQ(head.scan, read);
  EXPECT_EQ(read, scans - 1);
  b.scan();
  const RecordHead gap = b.next();
  EXPECT_EQ(gap.kind, RecordKind::kLost);
  EXPECT_EQ(gap.events, 2u);
  EXPECT_EQ(b.next().scan, scans + 1);
}

TEST(Recorder, AScanThatTakesInTooMuchIsLeftOut) {
  Bench b(1024, 64 * 1024);
  std::vector<std::byte> much(2000, std::byte{1});
  b.recorder.copy(0, much.data(), 2000);
  b.recorder.number(1);
  b.scan();
  EXPECT_TRUE(b.ring->next().empty());
  EXPECT_EQ(b.table[1999], std::byte{1});
  b.scan();
  EXPECT_EQ(b.next().kind, RecordKind::kLost);
  EXPECT_EQ(b.next().scan, 1u);
  // The largest that fits: head, one entry.
  much.assign(1024 - sizeof(RecordHead) - sizeof(EntryHead), std::byte{2});
  b.recorder.copy(0, much.data(), static_cast<std::uint32_t>(much.size()));
  b.scan();
  EXPECT_EQ(b.next().bytes, 1024u);
  EXPECT_EQ(b.recorder.lost(), 1u);
}

TEST(Recorder, AChangeThatIsNoScanIsAGap) {
  Bench b;
  b.scan();
  b.recorder.number(3);
  b.recorder.changed();
  b.scan();
  EXPECT_EQ(b.next().kind, RecordKind::kScan);
  EXPECT_EQ(b.next().kind, RecordKind::kLost);
  const RecordHead after = b.next();
  EXPECT_EQ(after.kind, RecordKind::kScan);
  EXPECT_EQ(after.bytes, sizeof(RecordHead)) << "what was taken in before it does not count";
}

TEST(Recorder, ACheckpointIsTheTableBetweenTwoScans) {
  Bench b;
  b.scan();
  EXPECT_TRUE(b.recorder.ask());
  EXPECT_TRUE(b.recorder.ask()) << "asked already";
  b.table[42] = std::byte{1};
  b.scan();
  EXPECT_FALSE(b.recorder.ask()) << "not given back";
  b.table[42] = std::byte{2};
  b.scan();
  EXPECT_EQ(b.next().scan, 0u);
  EXPECT_EQ(b.next().scan, 1u);
  const RecordHead head = b.next();
  EXPECT_EQ(head.kind, RecordKind::kCheckpointed);
  EXPECT_EQ(head.scan, 2u);
  EXPECT_EQ(b.recorder.checkpoint()[42], std::byte{1});
  b.recorder.give_back();
  EXPECT_TRUE(b.recorder.ask());
}

TEST(Recorder, ACheckpointCanBeGivenBackAsSoonAsItIsThere) {
  Bench b;
  std::atomic<bool> ends{false};
  std::thread task([&] {
    while (!ends.load(std::memory_order_relaxed)) b.scan();
  });
  EXPECT_TRUE(b.recorder.ask());
  bool asked = true;
  for (int made = 0; made < 1000 && asked;) {
    const auto record = b.ring->next();
    if (record.empty()) std::this_thread::yield();
    if (record.empty() || head_of(record).kind != RecordKind::kCheckpointed) continue;
    b.recorder.give_back();
    asked = b.recorder.ask();
    ++made;
  }
  ends = true;
  task.join();
  EXPECT_TRUE(asked);
}

TEST(Recorder, ChecksTheWholeTableSliceBySlice) {
  Bench b;
  std::vector<std::uint32_t> slices;
  std::vector<std::uint64_t> checks;
  for (int scan = 0; scan < 40; ++scan) {
    b.scan();
    const RecordHead head = b.next();
    slices.push_back(head.slice);
    checks.push_back(head.check);
  }
  // 10,000 bytes are 20 slices, the last one short.
  for (std::size_t n = 0; n < slices.size(); ++n) EXPECT_EQ(slices[n], n % 20);
  EXPECT_EQ(checks[0], checks[20]);
  EXPECT_NE(checks[0], checks[19]);
  b.table[9999] = std::byte{1};
  for (std::uint32_t n = 0; n < 20; ++n) {
    b.scan();
    EXPECT_EQ(b.next().check == checks[n], n != 19) << n;
  }
}

TEST(Replay, AnyBytesAreReadWithinTheirBounds) {
  Bench b;
  std::byte value{5};
  b.recorder.copy(9999, &value, 1);
  b.recorder.queue(true, {&value, 1});
  b.scan();
  b.next();
  for (std::size_t at = 0; at < b.last.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      for (const std::size_t size : {b.last.size(), at}) {
        std::vector<std::byte> bytes(b.last.begin(), b.last.begin() + static_cast<std::ptrdiff_t>(size));
        if (at < size) bytes[at] ^= static_cast<std::byte>(1u << bit);
        std::vector<std::byte> table(10'000);
        runtime::Replay replay;
        replay.set_table(table);
        replay.begin(bytes);
        replay.start();
        std::byte element{};
        static_cast<void>(replay.queue(&element, 1));
        static_cast<void>(replay.fault());
        EXPECT_FALSE(size < b.last.size() && replay.finished());
      }
    }
  }
}

}  // namespace
}  // namespace plc::test
