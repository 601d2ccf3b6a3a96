// Fuzzes the reader of recordings and the replay of records that nobody vouches for: no crash, nothing outside of a
// table, and what does not fit is said.
//
// Input: a first byte. Odd: the rest is a file. 2: the rest are packed records, after their number and length (u16
// each). Else: the second byte chooses a random program, which uses every kind
// of instruction; then come bytes over the table of its first task (u16 place, u8 length, bytes; a length of 0 ends
// them), and the rest are records, for which heads are made so that they follow each other.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>

#include "shadow/packed_records.h"
#include "shadow/player.h"
#include "tests/support/random_image.h"

namespace {

using namespace plc;
using Bytes = std::vector<std::byte>;

/// A program, as the head of a file, and the table that its first task begins with.
struct Recorded {
  explicit Recorded(std::uint64_t seed) {
    const bytecode::Image image = test::RandomImage(seed).make(40);
    head = shadow::file_head({"", "", 0, 1000, "UTC", bytecode::save(image)});
    core::Diagnostics diagnostics;
    const auto set = shadow::ReplicaSet::make({"", "", 0, 1000, "UTC", bytecode::save(image)}, diagnostics);
    if (!set) std::abort();
    runtime::TaskTable& whole = (*set)->resource().program(0).table();
    table.assign(whole.data(), whole.data() + whole.layout().total);
  }
  Bytes head, table;
};

void play(const Bytes& bytes) {
  const auto file = shadow::RecordFile::read(bytes, "recording");
  if (!file) return;
  core::Diagnostics diagnostics;
  auto player = shadow::Player::make(*file, diagnostics);
  if (!player) return;
  for (int scan = 0; scan < 300; ++scan) {
    if (!(*player)->step()) return;
  }
}

/// What can be executed of any bytes: heads of scans, one after the other, each with the entries that are there.
void add_records(std::span<const std::byte> bytes, shadow::BlockBuilder& block) {
  std::uint64_t scan = block.info().first_scan;
  while (bytes.size() > 1) {
    // Half of 0..255 units of 16 bytes.
    const std::size_t wanted = std::size_t{std::to_integer<std::uint8_t>(bytes[0])} / 2 * runtime::kRecordAlign;
    bytes = bytes.subspan(1);
    const std::size_t size = std::min(wanted, bytes.size() / runtime::kRecordAlign * runtime::kRecordAlign);
    Bytes record(sizeof(runtime::RecordHead) + size);
    runtime::RecordHead head;
    head.bytes = static_cast<std::uint32_t>(record.size());
    head.scan = scan++;
    head.now_ns = static_cast<core::TimeNs>(head.scan) * 10'000'000;
    std::memcpy(record.data(), &head, sizeof head);
    if (size != 0) std::memcpy(record.data() + sizeof head, bytes.data(), size);
    bytes = bytes.subspan(size);
    if (!block.add(record)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = std::as_bytes(std::span(data, size));
  if (size < 2) return 0;
  if ((data[0] & 1) != 0) {
    play({input.begin() + 1, input.end()});
    return 0;
  }
  if (data[0] == 2) {
    std::uint16_t counts[2] = {};
    if (size < 1 + sizeof counts) return 0;
    std::memcpy(counts, data + 1, sizeof counts);
    const auto records = shadow::unpack_records(input.subspan(1 + sizeof counts), counts[0], counts[1]);
    if (!records) return 0;
    // Each record is whole, and together they are as long as was said.
    std::uint32_t found = 0;
    if (records->size() != counts[1] || !shadow::for_each_record(*records, [&](auto) { return ++found != 0; }))
      std::abort();
    if (found != counts[0]) std::abort();
    return 0;
  }
  static std::map<std::uint8_t, Recorded> programs;
  const Recorded& program = programs.try_emplace(data[1], data[1]).first->second;
  Bytes table = program.table;
  std::span<const std::byte> rest = input.subspan(2);
  while (rest.size() >= 3 && rest[2] != std::byte{0}) {
    std::uint16_t at = 0;
    std::memcpy(&at, rest.data(), sizeof at);
    const std::size_t count = std::min<std::size_t>(std::to_integer<std::uint8_t>(rest[2]), rest.size() - 3);
    for (std::size_t i = 0; i < count; ++i) table[(at + i) % table.size()] = rest[3 + i];
    rest = rest.subspan(3 + count);
  }
  rest = rest.subspan(std::min<std::size_t>(3, rest.size()));
  shadow::BlockBuilder block;
  block.begin(0, 0, table);
  add_records(rest, block);
  Bytes file = program.head;
  const Bytes packed = block.pack();
  file.insert(file.end(), packed.begin(), packed.end());
  play(file);
  return 0;
}
