// Snapshot: a block of bytes that one thread publishes whole and others read whole, wait-free on both sides.
//
// readers + 2 buffers: the newest, one per reader, one to write. The writer stores the number of the newest in one
// word; each reader has a word with the number of the buffer it holds. A reader that takes the newest one says first
// that it is about to, then looks up the number, and claims it by an atomic operation. Before the writer chooses a
// buffer for the next publication, a cycle later, it looks at these words, and claims the newest buffer in the name of
// a reader that is about to: whichever of the two comes first, both know what the reader has. So nobody retries;
// publishing is one store, and a reader that finds nothing new makes no atomic operation at all. After Chen and Burns
// (1997), with the writer's books done when its next cycle begins, where nothing waits for them. Threads: one writer;
// each reader one thread at a time. Does not belong here: what the bytes mean.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "runtime/memory/arena.h"
#include "runtime/memory/table.h"

namespace plc::test {
struct HeldUp;
}

namespace plc::runtime {

class alignas(kTableAlign) Snapshot {
 public:
  /// All buffers zeroed; the first one counts as published. Lives in the arena. `readers`: at most so many subscribe.
  Snapshot(Arena& arena, std::size_t bytes, std::uint32_t readers);

  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

  /// A buffer to fill completely; its content is some older publication. RT: bounded by the number of readers.
  [[nodiscard]] std::byte* begin_write() noexcept;
  /// Makes the buffer of the last begin_write() the newest. RT: one store.
  void publish() noexcept;
  /// What was published last. For the writer's thread only. RT.
  [[nodiscard]] const std::byte* published() const noexcept { return buffers_ + newest_ * stride_; }
  /// Does what begin_write() would do, ahead: when nothing that was stored waits to be seen by others. `fetch` first,
  /// other work between them. RT: one atomic operation, and one for each reader that is taking a buffer right now.
  void choose() noexcept;
  /// Fetches into the cache what choose() and begin_write() are going to need. RT.
  void fetch() const noexcept { __builtin_prefetch(newest_word_, 1); }

  /// One reader: its view of the snapshot.
  class Reader {
   public:
    Reader() = default;
    /// The newest publication; it stays as it is until the next acquire() of this reader. RT: at most two atomic
    /// operations.
    [[nodiscard]] const std::byte* acquire() noexcept;
    /// Fetches into the cache what acquire() is going to need, while others wait for theirs. RT.
    void fetch() const noexcept { __builtin_prefetch(held_, 1); }

   private:
    friend class Snapshot;
    friend struct plc::test::HeldUp;  // a reader that is held up between these
    /// Says that it is about to take the newest.
    void announce() noexcept;
    /// Which one that is.
    [[nodiscard]] std::uint32_t look() const noexcept;
    /// Takes `newest`, or what the writer has claimed for it meanwhile.
    void claim(std::uint32_t newest) noexcept;

    const std::atomic<std::uint32_t>* newest_ = nullptr;
    std::atomic<std::uint32_t>* held_ = nullptr;
    const std::byte* buffers_ = nullptr;
    std::size_t stride_ = 0;
    std::uint32_t number_ = 0;  ///< of the buffer it holds
  };
  /// A new reader. Set-up.
  [[nodiscard]] Reader subscribe();

 private:
  static constexpr std::uint32_t kTaking = 0xffffffffu;  ///< the reader is about to take the newest

  std::size_t bytes_;
  std::size_t stride_;
  std::uint32_t buffer_count_;
  std::uint32_t newest_ = 0;
  std::uint32_t writing_ = 0;
  std::uint32_t reader_count_ = 0;
  bool chosen_ = false;  ///< no reader has writing_
  std::byte* buffers_;
  struct Subscription {
    std::atomic<std::uint32_t>* held = nullptr;  ///< the reader's word
    std::uint32_t number = 0;                    ///< the buffer it may read, besides the newest
  };
  std::span<Subscription> readers_;
  std::atomic<std::uint32_t>* newest_word_;  ///< newest_, for the readers
  Arena& arena_;
};

}  // namespace plc::runtime
