// Arena: memory for what one thread after the other touches in every cycle, side by side.
//
// A task that wakes up finds its caches and translations cold; what lies on few pages is warm again sooner. So what is
// small lies apart from what is large. In: sizes, while setting up. Out: zeroed places that live as long as the arena.
// Does not belong here: large tables that are used on their own (table.h).
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory_resource>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "runtime/memory/table.h"

namespace plc::runtime {

class Arena {
 public:
  Arena() : words_(kPage, &pages_), small_(kFirstBytes, &pages_), large_(kFirstBytes, &pages_) {}
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Zeroed; never null, throws std::bad_alloc.
  std::byte* take(std::size_t bytes, std::size_t align = kTableAlign) {
    std::pmr::memory_resource& memory = bytes <= kLargestSmall ? small_ : large_;
    auto* const at = static_cast<std::byte*>(memory.allocate(bytes == 0 ? 1 : bytes, align));
    std::memset(at, 0, bytes);
    return at;
  }
  /// A word that several processors touch in every cycle, on a cache line of nothing else. All of them lie side by
  /// side: a task waits for one line that another processor has changed instead of one for each of its owners and
  /// readers.
  std::atomic<std::uint32_t>* word() {
    return ::new (words_.allocate(sizeof(std::atomic<std::uint32_t>), alignof(std::atomic<std::uint32_t>)))
        std::atomic<std::uint32_t>(0);
  }
  /// One object.
  template <class T, class... Args>
  T* make(Args&&... args) {
    static_assert(std::is_trivially_destructible_v<T>);
    return ::new (take(sizeof(T), std::max(alignof(T), kTableAlign))) T(std::forward<Args>(args)...);
  }
  /// `count` objects as T{} makes them.
  template <class T>
  std::span<T> array(std::size_t count, std::size_t align = alignof(T)) {
    static_assert(std::is_trivially_destructible_v<T>);
    auto* const first = reinterpret_cast<T*>(take(count * sizeof(T), align));
    for (std::size_t i = 0; i < count; ++i) ::new (first + i) T{};
    return {first, count};
  }
  /// A copy of the values.
  template <class T>
  std::span<const T> copy(std::span<const T> values) {
    const std::span<T> to = array<T>(values.size());
    std::copy(values.begin(), values.end(), to.begin());
    return to;
  }

 private:
  static constexpr std::size_t kPage = 4096;
  static constexpr std::size_t kFirstBytes = 16 * kPage;
  static constexpr std::size_t kLargestSmall = 512;
  /// Whole pages.
  class Pages final : public std::pmr::memory_resource {
    void* do_allocate(std::size_t bytes, std::size_t align) override {
      return ::operator new (bytes, std::align_val_t{std::max(align, kPage)});
    }
    void do_deallocate(void* at, std::size_t, std::size_t align) override {
      ::operator delete (at, std::align_val_t{std::max(align, kPage)});
    }
    [[nodiscard]] bool do_is_equal(const memory_resource& other) const noexcept override { return this == &other; }
  };
  Pages pages_;
  std::pmr::monotonic_buffer_resource words_;
  std::pmr::monotonic_buffer_resource small_;
  std::pmr::monotonic_buffer_resource large_;
};

}  // namespace plc::runtime
