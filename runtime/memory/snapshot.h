// Snapshot: a block of bytes that one thread publishes whole and others read whole, wait-free on both sides.
//
// readers + 2 buffers: the newest, one per reader, one to write. A reader announces that it chooses, looks which buffer
// is the newest and claims that one; a writer that publishes in between hands its new buffer to every reader still
// choosing. So a reader never retries, and a writer always finds a buffer that nobody reads (after Chen and Burns, "A
// three-slot asynchronous reader/writer mechanism for multiprocessor real-time systems", York 1997, extended to many
// readers). Threads: one writer; each reader slot one thread at a time. Does not belong here: what the bytes mean.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "runtime/memory/table.h"

namespace plc::runtime {

class Snapshot {
 public:
  /// All buffers zeroed; the first one counts as published.
  Snapshot(std::size_t bytes, std::uint32_t readers);

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  /// A buffer to fill completely; its content is some older publication. RT: as many loads as there are readers,
  /// squared at worst.
  [[nodiscard]] std::byte* begin_write() noexcept;
  /// Makes the buffer of the last begin_write() the newest. RT.
  void publish() noexcept;
  /// What was published last. For the writer's thread only. RT.
  [[nodiscard]] const std::byte* published() const noexcept { return buffer(newest_.load(std::memory_order_relaxed)); }

  /// Claims the newest publication for `reader` until release(). RT: three atomic operations.
  [[nodiscard]] const std::byte* acquire(std::uint32_t reader) noexcept;
  /// RT.
  void release(std::uint32_t reader) noexcept;

 private:
  static constexpr std::uint32_t kNothing = 0xffffffffu;   ///< the slot's reader holds no buffer
  static constexpr std::uint32_t kChoosing = 0xfffffffeu;  ///< it is between announcing and claiming
  struct alignas(kTableAlign) Slot {
    std::atomic<std::uint32_t> holds{kNothing};
  };
  [[nodiscard]] bool is_free(std::uint32_t index) const noexcept;
  [[nodiscard]] std::byte* buffer(std::uint32_t index) noexcept { return memory_.data() + index * stride_; }
  [[nodiscard]] const std::byte* buffer(std::uint32_t index) const noexcept { return memory_.data() + index * stride_; }

  std::size_t bytes_;
  std::size_t stride_;
  std::uint32_t readers_;
  std::uint32_t writing_ = 0;
  alignas(kTableAlign) std::atomic<std::uint32_t> newest_{0};
  std::unique_ptr<Slot[]> slots_;
  TableMemory memory_;
};

}  // namespace plc::runtime
