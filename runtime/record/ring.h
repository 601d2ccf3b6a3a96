// RecordRing: records from one thread to another, each in one piece; nobody waits.
//
// In: room for the largest record, or none when the reader is behind. Out: whole records in their order. The memory is
// a file in memory that is mapped twice, one mapping after the other, so that a record that reaches over the end goes
// on at the start without anybody's knowledge. Threads: one writer (open, close), one reader (next); set-up before.
// Does not belong here: what records hold (record.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/result.h"

namespace plc::runtime {

class RecordRing {
 public:
  /// A ring of at least `bytes`, for records of at most `most_record_bytes`, of which it has room for two. P9001 when
  /// the system gives no such memory.
  static core::Result<std::unique_ptr<RecordRing>> make(std::size_t bytes, std::size_t most_record_bytes);
  ~RecordRing();
  RecordRing(const RecordRing&) = delete;
  RecordRing& operator=(const RecordRing&) = delete;

  [[nodiscard]] std::size_t most_record_bytes() const noexcept { return most_record_bytes_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }

  /// Writer: room for the largest record; null when the reader is too far behind. RT.
  std::byte* open() noexcept;
  /// Writer: what was written there is a record of so many bytes, a multiple of kRecordAlign. RT.
  void close(std::size_t bytes) noexcept;

  /// Reader: the oldest record; empty when there is none. The one before is given back.
  std::span<const std::byte> next() noexcept;

 private:
  RecordRing(std::byte* memory, std::size_t capacity, std::size_t most_record_bytes)
      : memory_(memory), capacity_(capacity), most_record_bytes_(most_record_bytes) {}

  std::byte* memory_;
  std::size_t capacity_;
  std::size_t most_record_bytes_;
  alignas(64) std::atomic<std::uint64_t> head_{0};  ///< bytes written since the start
  std::uint64_t tail_seen_ = 0;                     ///< tail_, as the writer saw it last
  alignas(64) std::atomic<std::uint64_t> tail_{0};  ///< bytes given back since the start
  std::uint64_t read_ = 0;                          ///< the reader: where the record after the one it has begins
};

}  // namespace plc::runtime
