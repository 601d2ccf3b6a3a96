// Files of recorded scans: what plc-run and plc sim write, and plc replay reads (docs/adr/0054).
//
// A file is a head, which has the image, and blocks. A block belongs to one task: the table before its first scan, and
// the records of scans that follow each other, compressed. Blocks of several tasks are mixed, in the order in which
// they were written; each is whole or not there, and has a checksum. What is damaged is left out and said; what follows
// is found again. Numbers are little-endian. Does not belong here: executing scans (replica.h), threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "runtime/record/record.h"

namespace plc::shadow {

inline constexpr std::uint32_t kRecordFileVersion = 2;

/// What a recording is of.
struct RecordingHead {
  std::string product;           ///< that recorded it, "PICARD 0.1.0"
  std::string processor;         ///< kind of processor, "x86-64"
  std::uint64_t arithmetic = 0;  ///< fingerprint of the C library's functions (arithmetic.h): equal = equal results
  std::uint32_t loop_budget = 0;
  std::string zone;              ///< of local time in programs, as core::TimeZone::load() takes it
  std::vector<std::byte> image;  ///< as plc compile writes it
};

/// Where a block is, and what it has.
struct BlockInfo {
  std::uint64_t at = 0;  ///< byte of the file
  std::uint32_t task = 0;
  std::uint32_t scans = 0;
  std::uint64_t first_scan = 0;
  core::TimeNs first_ns = 0, last_ns = 0;  ///< `now` of the first and of the last scan
  std::uint32_t table_bytes = 0;
  std::uint32_t record_bytes = 0;
  std::uint32_t stored_bytes = 0;  ///< after its head
};

/// The scans of a block.
struct Block {
  std::vector<std::byte> table;    ///< before the first scan
  std::vector<std::byte> records;  ///< as in rings, one after the other
};

/// One block of a task as it grows.
class BlockBuilder {
 public:
  /// Begins with the table as it is before scan `first_scan`.
  void begin(std::uint32_t task, std::uint64_t first_scan, std::span<const std::byte> table);
  /// The record of the next scan. False, and nothing happened, when it is of another one.
  bool add(std::span<const std::byte> record);
  [[nodiscard]] bool open() const noexcept { return open_; }
  [[nodiscard]] bool empty() const noexcept { return info_.scans == 0; }
  [[nodiscard]] std::size_t record_bytes() const noexcept { return block_.records.size(); }
  /// Task, first scan, scans and times; the rest is not known before pack().
  [[nodiscard]] const BlockInfo& info() const noexcept { return info_; }
  [[nodiscard]] const Block& block() const noexcept { return block_; }
  /// The block as a file has it, as far as it has grown. Empty when it could not be compressed.
  [[nodiscard]] std::vector<std::byte> pack() const;
  /// Nothing is open after that.
  void close();

 private:
  bool open_ = false;
  BlockInfo info_;
  Block block_;
};

/// The head as a file has it.
std::vector<std::byte> file_head(const RecordingHead& head);

/// A file that is read.
class RecordFile {
 public:
  /// P7001 when it cannot be opened; P7630 when it is no such file, damaged in its head, or of another version.
  static core::Result<RecordFile> open(const std::string& path);
  /// The same, from bytes.
  static core::Result<RecordFile> read(std::vector<std::byte> bytes, const std::string& name);

  [[nodiscard]] const RecordingHead& head() const noexcept { return head_; }
  [[nodiscard]] const std::vector<BlockInfo>& blocks() const noexcept { return blocks_; }
  /// Bytes that belong to no whole block: cut or damaged.
  [[nodiscard]] std::uint64_t damaged_bytes() const noexcept { return damaged_bytes_; }
  /// The scans of a block. Nothing when what is compressed is not what its head says.
  [[nodiscard]] std::optional<Block> load(const BlockInfo& info) const;

 private:
  std::vector<std::byte> bytes_;
  RecordingHead head_;
  std::vector<BlockInfo> blocks_;
  std::uint64_t damaged_bytes_ = 0;
};

/// Calls visit(record) for each record of `records` as long as it returns true. False when bytes are left that are no
/// record.
template <class Visit>
bool for_each_record(std::span<const std::byte> records, Visit&& visit) {
  while (!records.empty()) {
    runtime::RecordHead head;
    if (records.size() < sizeof head) return false;
    std::memcpy(&head, records.data(), sizeof head);
    if (head.bytes < sizeof head || head.bytes > records.size()) return false;
    if (!visit(records.first(head.bytes))) return true;
    records = records.subspan(head.bytes);
  }
  return true;
}

}  // namespace plc::shadow
