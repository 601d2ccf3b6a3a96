#include "shadow/packed_records.h"

#include <array>
#include <cstdint>
#include <cstring>

#include "runtime/record/record.h"
#include "shadow/record_file.h"

namespace plc::shadow {
namespace {

using runtime::RecordHead;

/// What is stored of a head, in this order.
enum Column : std::size_t { kBytes, kKind, kEvents, kSlice, kCheck, kScan, kNow, kStart, kUtc, kColumns };
using Row = std::array<std::uint64_t, kColumns>;

Row row_of(const RecordHead& head) {
  Row row{};
  row[kBytes] = head.bytes;
  row[kKind] = static_cast<std::uint64_t>(head.kind) | std::uint64_t{head.flags} << 16;
  row[kEvents] = head.events;
  row[kSlice] = head.slice;
  row[kScan] = head.scan;
  row[kNow] = static_cast<std::uint64_t>(head.now_ns);
  row[kStart] = static_cast<std::uint64_t>(head.start_ns);
  row[kUtc] = static_cast<std::uint64_t>(head.utc_ns) - static_cast<std::uint64_t>(head.now_ns);
  return row;
}

RecordHead head_of(const Row& row, std::uint16_t check) {
  RecordHead head;
  head.bytes = static_cast<std::uint32_t>(row[kBytes]);
  head.kind = static_cast<runtime::RecordKind>(row[kKind] & 0xffff);
  head.flags = static_cast<std::uint16_t>(row[kKind] >> 16 | runtime::kShortCheck);
  head.events = static_cast<std::uint32_t>(row[kEvents]);
  head.slice = static_cast<std::uint32_t>(row[kSlice]);
  head.check = check;
  head.scan = row[kScan];
  head.now_ns = static_cast<core::TimeNs>(row[kNow]);
  head.start_ns = static_cast<core::TimeNs>(row[kStart]);
  head.utc_ns = static_cast<core::TimeNs>(row[kUtc] + row[kNow]);
  return head;
}

/// Small differences in both directions are small numbers.
std::uint64_t zigzag(std::uint64_t value) { return value << 1 ^ (value >> 63 != 0 ? ~std::uint64_t{0} : 0); }
std::uint64_t unzigzag(std::uint64_t value) { return value >> 1 ^ ((value & 1) != 0 ? ~std::uint64_t{0} : 0); }

void append(std::vector<std::byte>& out, std::uint64_t value) {
  while (value >= 0x80) {
    out.push_back(static_cast<std::byte>(value | 0x80));
    value >>= 7;
  }
  out.push_back(static_cast<std::byte>(value));
}

std::optional<std::uint64_t> take(std::span<const std::byte>& in) {
  std::uint64_t value = 0;
  for (unsigned shift = 0; shift < 64 && !in.empty(); shift += 7) {
    const auto byte = std::to_integer<std::uint64_t>(in.front());
    in = in.subspan(1);
    value |= (byte & 0x7f) << shift;
    if (byte < 0x80) return value;
  }
  return {};
}

/// `to` ^= the same part of the record before, when that is as long.
void exclude(std::byte* to, std::size_t bytes, std::span<const std::byte> before) {
  if (before.size() != bytes) return;
  for (std::size_t i = 0; i < bytes; ++i) to[i] ^= before[i];
}

}  // namespace

std::vector<std::byte> pack_records(std::span<const std::byte> records) {
  std::array<std::vector<std::byte>, kColumns> columns;
  std::vector<std::byte> taken_in;
  Row before{}, step{};
  std::span<const std::byte> entries_before;
  for_each_record(records, [&](std::span<const std::byte> record) {
    RecordHead head;
    std::memcpy(&head, record.data(), sizeof head);
    const Row row = row_of(head);
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (c == kCheck) continue;
      // Of the difference, what differs from the one before: times and parts go on by equal steps.
      const std::uint64_t difference = row[c] - before[c];
      append(columns[c], zigzag(difference - step[c]));
      step[c] = difference;
    }
    columns[kCheck].push_back(static_cast<std::byte>(head.check));
    columns[kCheck].push_back(static_cast<std::byte>(head.check >> 8));
    before = row;
    const auto entries = record.subspan(sizeof head);
    const std::size_t at = taken_in.size();
    taken_in.insert(taken_in.end(), entries.begin(), entries.end());
    exclude(taken_in.data() + at, entries.size(), entries_before);
    entries_before = entries;
    return true;
  });
  std::vector<std::byte> out;
  for (const auto& column : columns) {
    append(out, column.size());
    out.insert(out.end(), column.begin(), column.end());
  }
  out.insert(out.end(), taken_in.begin(), taken_in.end());
  return out;
}

std::optional<std::vector<std::byte>> unpack_records(std::span<const std::byte> packed, std::uint32_t scans,
                                                     std::uint32_t record_bytes) {
  std::array<std::span<const std::byte>, kColumns> columns;
  for (auto& column : columns) {
    const auto size = take(packed);
    if (!size || *size > packed.size()) return {};
    column = packed.first(static_cast<std::size_t>(*size));
    packed = packed.subspan(static_cast<std::size_t>(*size));
  }
  std::vector<std::byte> out;
  out.reserve(record_bytes);
  Row row{}, step{};
  std::size_t entries_before = 0, bytes_before = 0;
  bool any = false;
  for (std::uint32_t scan = 0; scan < scans; ++scan) {
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (c == kCheck) continue;
      const auto stored = take(columns[c]);
      if (!stored) return {};
      step[c] += unzigzag(*stored);
      row[c] += step[c];
    }
    auto& checks = columns[kCheck];
    if (checks.size() < 2) return {};
    const auto check =
        static_cast<std::uint16_t>(std::to_integer<unsigned>(checks[0]) | std::to_integer<unsigned>(checks[1]) << 8);
    checks = checks.subspan(2);
    const RecordHead head = head_of(row, check);
    if (row[kBytes] < sizeof head || row[kBytes] - sizeof head > packed.size() ||
        row[kBytes] > record_bytes - out.size()) {
      return {};
    }
    const std::size_t entries = head.bytes - sizeof head;
    const std::size_t at = out.size();
    out.resize(at + head.bytes);
    std::memcpy(&out[at], &head, sizeof head);
    if (entries != 0) {
      std::memcpy(&out[at + sizeof head], packed.data(), entries);
      if (any && entries == bytes_before) exclude(&out[at + sizeof head], entries, {&out[entries_before], entries});
    }
    packed = packed.subspan(entries);
    entries_before = at + sizeof head;
    bytes_before = entries;
    any = true;
  }
  if (!packed.empty() || out.size() != record_bytes) return {};
  return out;
}

}  // namespace plc::shadow
