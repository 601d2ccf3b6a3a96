// RecordRing: records from one thread to another, each in one piece; nobody waits.
//
// In: room for the largest record, or none when the reader is behind. Out: whole records in their order. The memory is
// a file in memory that is mapped twice, one mapping after the other, so that a record that reaches over the end goes
// on at the start without anybody's knowledge. It may be a file that outlives the process. Threads: one writer (open,
// close), one reader (next); set-up before. Does not belong here: what records hold (record.h).
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/result.h"

namespace plc::runtime {

/// The last page of a ring's file, for who reads it when the writer's process is gone.
struct RingEnd {
  std::uint64_t capacity = 0;  ///< bytes before this page: the ring
  std::uint64_t most_record_bytes = 0;
  alignas(64) std::atomic<std::uint64_t> head{0};  ///< bytes written since the start
  alignas(64) std::atomic<std::uint64_t> tail{0};  ///< bytes given back since the start
};

class RecordRing {
 public:
  /// A ring of at least `bytes`, for records of at most `most_record_bytes`, of which it has room for two. `file`: of
  /// file_bytes(), in memory, which the ring maps and does not close; -1: one of its own. P9001 when the system gives
  /// no such memory.
  static core::Result<std::unique_ptr<RecordRing>> make(std::size_t bytes, std::size_t most_record_bytes,
                                                        int file = -1);
  /// The size of the file of such a ring.
  static std::size_t file_bytes(std::size_t bytes, std::size_t most_record_bytes);
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
  /// Reader: where the record begins that next() gives next, in bytes since the start.
  [[nodiscard]] std::uint64_t position() const noexcept { return read_; }

 private:
  RecordRing(std::byte* memory, RingEnd* end)
      : memory_(memory), end_(end), capacity_(end->capacity), most_record_bytes_(end->most_record_bytes) {}

  std::byte* memory_;  ///< the ring, the ring again, and the page with `end_`
  RingEnd* end_;
  std::size_t capacity_;
  std::size_t most_record_bytes_;
  alignas(64) std::uint64_t tail_seen_ = 0;  ///< the writer: end_->tail, as it saw it last
  alignas(64) std::uint64_t read_ = 0;       ///< the reader: where the record after the one it has begins
};

}  // namespace plc::runtime
