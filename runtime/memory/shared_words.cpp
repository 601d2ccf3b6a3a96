#include "runtime/memory/shared_words.h"

#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>

namespace plc::runtime {
namespace {

/// Moves one word of T. The local side belongs to the thread; only the shared side is atomic.
template <class T, bool kToShared>
void move_word(std::byte* local, std::byte* shared) noexcept {
  std::atomic_ref<T> word(*reinterpret_cast<T*>(shared));
  T value;
  if constexpr (kToShared) {
    std::memcpy(&value, local, sizeof value);
    word.store(value, std::memory_order_relaxed);
  } else {
    value = word.load(std::memory_order_relaxed);
    std::memcpy(local, &value, sizeof value);
  }
}

// Words grow to 8 bytes at the head and shrink at the tail. Leaves and words are both aligned to their power-of-two
// size, so a word either contains a leaf or lies apart from it, and starts no later than it: no leaf is moved in two
// halves.
template <bool kToShared>
void move_words(std::byte* local, std::byte* shared, std::size_t bytes) noexcept {
  std::size_t at = 0;
  const auto misalignment = reinterpret_cast<std::uintptr_t>(shared) & 7u;
  if (misalignment != 0) {
    while (at < bytes) {
      const std::uintptr_t address = reinterpret_cast<std::uintptr_t>(shared) + at;
      if ((address & 7u) == 0) break;
      std::size_t width = std::size_t{1} << std::countr_zero(address);
      while (width > bytes - at) width /= 2;
      if (width == 4) {
        move_word<std::uint32_t, kToShared>(local + at, shared + at);
      } else if (width == 2) {
        move_word<std::uint16_t, kToShared>(local + at, shared + at);
      } else {
        move_word<std::uint8_t, kToShared>(local + at, shared + at);
      }
      at += width;
    }
  }
  for (; bytes - at >= 8; at += 8) move_word<std::uint64_t, kToShared>(local + at, shared + at);
  if (bytes - at >= 4) {
    move_word<std::uint32_t, kToShared>(local + at, shared + at);
    at += 4;
  }
  if (bytes - at >= 2) {
    move_word<std::uint16_t, kToShared>(local + at, shared + at);
    at += 2;
  }
  if (bytes - at >= 1) move_word<std::uint8_t, kToShared>(local + at, shared + at);
}

}  // namespace

// RT:
void copy_from_shared(std::byte* to, const std::byte* shared, std::size_t bytes) noexcept {
  // An atomic load needs a non-const object to refer to in C++20; nothing is written through it.
  move_words<false>(to, const_cast<std::byte*>(shared), bytes);
}
// RT:
void copy_to_shared(std::byte* shared, const std::byte* from, std::size_t bytes) noexcept {
  move_words<true>(const_cast<std::byte*>(from), shared, bytes);
}

// RT:
bool replace_shared(std::byte* shared, const std::byte* expected, const std::byte* value, std::size_t bytes) noexcept {
  const auto replace = [&]<class T>(T old) {
    T wanted;
    std::memcpy(&old, expected, sizeof old);
    std::memcpy(&wanted, value, sizeof wanted);
    return std::atomic_ref<T>(*reinterpret_cast<T*>(shared))
        .compare_exchange_strong(old, wanted, std::memory_order_relaxed);
  };
  switch (bytes) {
    case 1:
      return replace(std::uint8_t{});
    case 2:
      return replace(std::uint16_t{});
    case 4:
      return replace(std::uint32_t{});
    default:
      return replace(std::uint64_t{});
  }
}

}  // namespace plc::runtime
