// Journal: writes from outside that wait for the task that exports the variables (docs/adr/0012).
//
// In: batches of (offset, value, mask) from one thread at a time. Out: the same, in order, whole batches only, on the
// task's thread. Neither side waits; a journal that is full refuses. Does not belong here: who owns what.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "runtime/memory/arena.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class Journal {
 public:
  struct Entry {
    std::uint32_t offset = 0;  ///< of the leaf in the global table
    std::uint32_t type = 0;    ///< index into Image::types
    std::uint32_t bytes = 0;   ///< of the value
    bool masked = false;       ///< a mask of the same size follows the value
  };

  /// `capacity` bytes at least; rounded up to a power of two.
  Journal(Arena& arena, std::size_t capacity);

  // Writer
  /// Room that one entry takes.
  static std::size_t room_for(const Entry& entry) noexcept;
  /// Whether entries of `room` bytes in all fit now, the one of greatest room taking `largest`.
  [[nodiscard]] bool fits(std::size_t room, std::size_t largest) const noexcept;
  /// Adds an entry that fits; the reader does not see it before commit().
  void append(const Entry& entry, const std::byte* value, const std::byte* mask) noexcept;
  void commit() noexcept { head_.store(written_, std::memory_order_release); }

  // Reader
  /// False when drain() would find nothing: one look at one cache line. RT.
  [[nodiscard]] bool pending() const noexcept { return head_.load(std::memory_order_relaxed) != drained_; }
  /// Calls apply(entry, value, mask or null) for everything committed. RT: bounded by the capacity.
  template <class Apply>
  void drain(Apply&& apply) noexcept {
    const std::uint64_t end = head_.load(std::memory_order_acquire);
    std::uint64_t at = tail_.load(std::memory_order_relaxed);
    while (at != end) {
      const std::byte* const place = memory_ + (at & mask_);
      const Record record = load(place);
      if (record.entry.bytes != kSkip) {
        const std::byte* const value = place + sizeof(Record);
        apply(record.entry, value, record.entry.masked ? value + padded(record.entry.bytes) : nullptr);
      }
      at += record.size;
    }
    tail_.store(at, std::memory_order_release);
    drained_ = at;
  }
  /// Forgets everything. Not while the task runs.
  void clear() noexcept;

 private:
  static constexpr std::uint32_t kSkip = 0xffffffffu;  ///< Entry::bytes of what fills up the end of the ring
  /// Records take multiples of their head, so that what is left at the end of the ring has room for one.
  struct alignas(32) Record {
    Entry entry;
    std::uint32_t size = 0;  ///< of the whole record; the next one follows
  };
  static constexpr std::size_t padded(std::size_t bytes) noexcept {
    return (bytes + sizeof(Record) - 1) / sizeof(Record) * sizeof(Record);
  }
  static Record load(const std::byte* place) noexcept;

  std::byte* memory_;
  std::size_t capacity_;
  std::uint64_t mask_;
  std::uint64_t written_ = 0;
  alignas(kTableAlign) std::atomic<std::uint64_t> head_{0};  ///< bytes committed since the start
  std::uint64_t drained_ = 0;                                ///< tail_, for the reader, beside what it looks at
  alignas(kTableAlign) std::atomic<std::uint64_t> tail_{0};  ///< bytes consumed since the start
};

}  // namespace plc::runtime
