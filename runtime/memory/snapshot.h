// Snapshot: a block of bytes that one thread publishes whole and others read whole, wait-free on both sides.
//
// readers + 2 buffers: the newest, one per reader, one to write. Each reader has a mailbox with the number of a buffer.
// The writer puts the newest one into every mailbox and looks at what was there: a number that the reader has taken is
// the buffer it reads from now on, one it has not taken is nobody's. So only the writer keeps books, nobody retries,
// and a reader that finds nothing new makes no atomic operation at all. Threads: one writer; each reader slot one
// thread at a time. Does not belong here: what the bytes mean.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "runtime/memory/table.h"

namespace plc::runtime {

class Snapshot {
 public:
  /// All buffers zeroed; the first one counts as published and taken.
  Snapshot(std::size_t bytes, std::uint32_t readers);

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  /// A buffer to fill completely; its content is some older publication. RT: bounded by the number of readers.
  [[nodiscard]] std::byte* begin_write() noexcept;
  /// Makes the buffer of the last begin_write() the newest. RT: one atomic operation a reader.
  void publish() noexcept;
  /// What was published last. For the writer's thread only. RT.
  [[nodiscard]] const std::byte* published() const noexcept { return buffer(newest_); }

  /// The newest publication; it stays as it is until the next acquire() of this reader. RT: at most one atomic
  /// operation.
  [[nodiscard]] const std::byte* acquire(std::uint32_t reader) noexcept;

  /// Fetch into the cache what acquire() and publish() are going to need, while others wait for their own. RT.
  void expect_read(std::uint32_t reader) const noexcept;
  void expect_write() noexcept;

 private:
  static constexpr std::uint32_t kFresh = 0x80000000u;  ///< the reader has not taken it
  struct alignas(kTableAlign) Mailbox {
    std::atomic<std::uint32_t> buffer{0};
  };
  [[nodiscard]] std::byte* buffer(std::uint32_t index) noexcept { return memory_.data() + index * stride_; }
  [[nodiscard]] const std::byte* buffer(std::uint32_t index) const noexcept { return memory_.data() + index * stride_; }
  void choose() noexcept;

  std::size_t bytes_;
  std::size_t stride_;
  std::uint32_t readers_;
  std::unique_ptr<Mailbox[]> mailboxes_;
  TableMemory memory_;
  // The writer's books.
  alignas(kTableAlign) std::uint32_t newest_ = 0;
  std::uint32_t writing_ = 0;
  bool chosen_ = false;              ///< writing_ is nobody's
  std::vector<std::uint32_t> held_;  ///< by reader: the buffer it may read, besides the newest
};

}  // namespace plc::runtime
