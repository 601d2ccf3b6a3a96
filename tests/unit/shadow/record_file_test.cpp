// Files of recorded scans: what is written is read; what is cut or damaged is said, and the rest is read all the same.
#include "shadow/record_file.h"

#include <gtest/gtest.h>

#include <cstring>

#include "shadow/packed_records.h"

namespace plc::test {
namespace {

using shadow::BlockBuilder;
using shadow::RecordFile;

using Bytes = std::vector<std::byte>;

Bytes record(std::uint64_t scan, std::size_t more = 0) {
  runtime::RecordHead head;
  head.scan = scan;
  head.flags = runtime::kShortCheck;
  head.now_ns = static_cast<core::TimeNs>(scan) * 1000;
  head.bytes = static_cast<std::uint32_t>(sizeof head + more);
  Bytes bytes(head.bytes, std::byte{7});
  std::memcpy(bytes.data(), &head, sizeof head);
  return bytes;
}

Bytes block(std::uint32_t task, std::uint64_t first, std::uint64_t scans, std::size_t table = 100) {
  BlockBuilder builder;
  builder.begin(task, first, Bytes(table, static_cast<std::byte>(task)));
  for (std::uint64_t scan = first; scan < first + scans; ++scan) EXPECT_TRUE(builder.add(record(scan, scan % 4 * 16)));
  return builder.pack();
}

Bytes head() {
  return shadow::file_head({"PICARD test", "x86-64", 0x1234, 99, "Europe/Berlin", Bytes(50, std::byte{1})});
}

Bytes joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

TEST(RecordFile, WhatIsWrittenIsRead) {
  const auto file = RecordFile::read(joined({head(), block(0, 0, 10), block(1, 5, 3), block(0, 12, 1, 0)}), "f");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->head().product, "PICARD test");
  EXPECT_EQ(file->head().processor, "x86-64");
  EXPECT_EQ(file->head().arithmetic, 0x1234u);
  EXPECT_EQ(file->head().loop_budget, 99u);
  EXPECT_EQ(file->head().zone, "Europe/Berlin");
  EXPECT_EQ(file->head().image.size(), 50u);
  EXPECT_EQ(file->damaged_bytes(), 0u);
  ASSERT_EQ(file->blocks().size(), 3u);
  const shadow::BlockInfo& info = file->blocks()[1];
  EXPECT_EQ(info.task, 1u);
  EXPECT_EQ(info.first_scan, 5u);
  EXPECT_EQ(info.scans, 3u);
  EXPECT_EQ(info.first_ns, 5000);
  EXPECT_EQ(info.last_ns, 7000);
  const auto read = file->load(info);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->table, Bytes(100, std::byte{1}));
  std::uint64_t scan = 5;
  EXPECT_TRUE(shadow::for_each_record(read->records, [&scan](std::span<const std::byte> one) {
    EXPECT_EQ(Bytes(one.begin(), one.end()), record(scan, scan % 4 * 16));
    ++scan;
    return true;
  }));
  EXPECT_EQ(scan, 8u);
}

TEST(RecordFile, ABlockTakesScansThatFollowEachOther) {
  BlockBuilder builder;
  EXPECT_FALSE(builder.add(record(0))) << "not begun";
  builder.begin(0, 3, {});
  EXPECT_FALSE(builder.add(record(4)));
  EXPECT_TRUE(builder.add(record(3)));
  EXPECT_FALSE(builder.add(record(3)));
  EXPECT_TRUE(builder.add(record(4)));
}

TEST(RecordFile, CutAnywhereTheWholeBlocksAreRead) {
  const Bytes first = block(0, 0, 4, 20), second = block(0, 4, 4, 20);
  const Bytes whole = joined({head(), first, second});
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto file = RecordFile::read(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)), "f");
    if (size < head().size()) {
      EXPECT_FALSE(file) << size;
      EXPECT_TRUE(file || file.error().code == core::Code::P7630) << size;
      continue;
    }
    ASSERT_TRUE(file) << size;
    const std::size_t blocks = (size >= head().size() + first.size() ? 1u : 0u);
    EXPECT_EQ(file->blocks().size(), blocks) << size;
    const std::size_t rest = size - head().size() - blocks * first.size();
    EXPECT_EQ(file->damaged_bytes(), rest) << size;
  }
}

TEST(RecordFile, WithAnyBitFlippedTheOtherBlocksAreRead) {
  const Bytes whole = joined({head(), block(0, 0, 4, 20), block(1, 0, 4, 20)});
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      Bytes bytes = whole;
      bytes[at] ^= static_cast<std::byte>(1u << bit);
      const auto file = RecordFile::read(bytes, "f");
      if (at < head().size()) {
        EXPECT_FALSE(file) << at;
        continue;
      }
      ASSERT_TRUE(file) << at;
      EXPECT_EQ(file->blocks().size(), 1u) << at;
      EXPECT_GT(file->damaged_bytes(), 0u) << at;
    }
  }
}

TEST(RecordFile, BytesThatAreNoRecordsEndTheWay) {
  Bytes records = joined({record(0), record(1)});
  std::size_t seen = 0;
  const auto count = [&seen](std::span<const std::byte>) { return ++seen, true; };
  EXPECT_FALSE(shadow::for_each_record(std::span(records).first(records.size() - 1), count));
  EXPECT_EQ(seen, 1u);
  const std::uint32_t none = 0;
  std::memcpy(records.data(), &none, sizeof none);
  EXPECT_FALSE(shadow::for_each_record(records, count));
}

TEST(PackedRecords, ComeBackButForMostOfTheirChecks) {
  std::uint32_t random = 1;
  const auto next = [&random] { return random = random * 1'664'525 + 1'013'904'223; };
  for (int round = 0; round < 200; ++round) {
    Bytes records;
    const std::uint32_t scans = next() % 40;
    std::size_t entries = 0;
    for (std::uint32_t scan = 0; scan < scans; ++scan) {
      // Often of one length, with few bytes that differ.
      if (next() >> 30 == 0) entries = (next() >> 24) % 5 * runtime::kRecordAlign;
      runtime::RecordHead head;
      head.bytes = static_cast<std::uint32_t>(sizeof head + entries);
      head.flags = static_cast<std::uint16_t>(next() >> 31);
      head.events = next() >> 29;
      head.slice = scan % 3;
      head.check = std::uint64_t{next()} << 32 | next();
      head.scan = 77 + scan;
      head.now_ns = scan * 1'000'000 + (next() >> 20);
      head.start_ns = round == 7 ? -5 : 3;
      head.utc_ns = round % 2 == 0 ? 0 : 1'700'000'000'000'000'000 + head.now_ns + (next() >> 26);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&head);
      records.insert(records.end(), bytes, bytes + sizeof head);
      for (std::size_t i = 0; i < entries; ++i)
        records.push_back(static_cast<std::byte>(next() >> 29 == 0 ? next() >> 24 : i));
    }
    const Bytes packed = shadow::pack_records(records);
    auto back = shadow::unpack_records(packed, scans, static_cast<std::uint32_t>(records.size()));
    ASSERT_TRUE(back) << round;
    std::uint32_t scan = 0;
    std::size_t at = 0;
    EXPECT_TRUE(shadow::for_each_record(*back, [&](std::span<const std::byte> one) {
      runtime::RecordHead head, was;
      std::memcpy(&head, one.data(), sizeof head);
      std::memcpy(&was, &records[at], sizeof was);
      was.check &= 0xffff;
      was.flags |= runtime::kShortCheck;
      EXPECT_EQ(std::memcmp(&head, &was, sizeof head), 0) << round << " " << scan;
      EXPECT_TRUE(std::equal(one.begin() + sizeof head, one.end(),
                             records.begin() + static_cast<std::ptrdiff_t>(at + sizeof head)));
      at += one.size();
      ++scan;
      return true;
    }));
    EXPECT_EQ(scan, scans);
    // Anything else is refused, and read within its bounds.
    EXPECT_FALSE(shadow::unpack_records(packed, scans + 1, static_cast<std::uint32_t>(records.size())));
    EXPECT_FALSE(shadow::unpack_records(packed, scans, static_cast<std::uint32_t>(records.size()) + 16));
    for (std::size_t cut = 0; cut < packed.size(); cut += 7)
      static_cast<void>(
          shadow::unpack_records(std::span(packed).first(cut), scans, static_cast<std::uint32_t>(records.size())));
  }
}

}  // namespace
}  // namespace plc::test
