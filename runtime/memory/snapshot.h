// Snapshot: a block of bytes that one thread publishes whole and others read whole, wait-free on both sides.
//
// readers + 2 buffers: the newest, one per reader, one to write. Each reader has a mailbox with the number of a buffer.
// The writer puts the newest one into every mailbox and looks at what was there: a number that the reader has taken is
// the buffer it reads from now on, one it has not taken is nobody's. So only the writer keeps books, nobody retries,
// and a reader that finds nothing new makes no atomic operation at all. Threads: one writer; each reader one thread at
// a time. Does not belong here: what the bytes mean.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/memory/arena.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class alignas(kTableAlign) Snapshot {
 public:
  /// All buffers zeroed; the first one counts as published. Lives in the arena. `readers`: at most so many subscribe.
  Snapshot(Arena& arena, std::size_t bytes, std::uint32_t readers);

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  /// A buffer to fill completely; its content is some older publication. RT: bounded by the number of readers.
  [[nodiscard]] std::byte* begin_write() noexcept;
  /// Makes the buffer of the last begin_write() the newest. RT: one atomic operation a reader.
  void publish() noexcept;
  /// What was published last. For the writer's thread only. RT.
  [[nodiscard]] const std::byte* published() const noexcept { return buffers_ + newest_ * stride_; }
  /// Fetches into the cache what publish() is going to need. RT.
  void expect_write() noexcept;

  /// One reader: its view of the snapshot.
  class Reader {
   public:
    Reader() = default;
    /// The newest publication; it stays as it is until the next acquire() of this reader. RT: at most one atomic
    /// operation.
    [[nodiscard]] const std::byte* acquire() noexcept;
    /// Fetches into the cache what acquire() is going to need, while others wait for theirs. RT.
    void expect() const noexcept { __builtin_prefetch(mailbox_, 1); }

   private:
    friend class Snapshot;
    std::atomic<std::uint32_t>* mailbox_ = nullptr;
    const std::byte* buffers_ = nullptr;
    std::size_t stride_ = 0;
  };
  /// A new reader. Set-up.
  [[nodiscard]] Reader subscribe();

 private:
  static constexpr std::uint32_t kFresh = 0x80000000u;  ///< the reader has not taken it
  void choose() noexcept;

  std::size_t bytes_;
  std::size_t stride_;
  std::uint32_t buffer_count_;
  std::uint32_t newest_ = 0;
  std::uint32_t writing_ = 0;
  std::uint32_t reader_count_ = 0;
  bool chosen_ = false;  ///< writing_ is nobody's
  std::byte* buffers_;
  /// By reader: the buffer it may read, besides the newest.
  std::span<std::uint32_t> held_;
  /// On as few cache lines as will hold them, apart from everything else: what the writer and a reader touch, they
  /// touch once a cycle, and each further line would be one more to wait for.
  std::span<std::atomic<std::uint32_t>> mailboxes_;
};

}  // namespace plc::runtime
