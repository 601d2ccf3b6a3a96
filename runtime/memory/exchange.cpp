#include "runtime/memory/exchange.h"

#include <atomic>
#include <bit>
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

Exchange::Exchange(const bytecode::Image& image, GlobalTable& globals, std::byte* local)
    : image_(image), globals_(globals), local_(local) {}

void Exchange::add_leaves(std::uint32_t type, std::uint32_t offset) {
  const bytecode::ImageType& t = image_.types[type];
  const auto leaf_bytes = [this](std::uint32_t leaf) -> std::uint32_t {
    const bytecode::TypeKind kind = image_.types[leaf].kind;
    const bool whole = kind != bytecode::TypeKind::kArray && kind != bytecode::TypeKind::kStruct;
    return whole ? image_.types[leaf].size : 0;
  };
  switch (t.kind) {
    case bytecode::TypeKind::kScalar:
    case bytecode::TypeKind::kString:
    case bytecode::TypeKind::kRef:
      if (!leaves_.empty() && leaves_.back().bytes == t.size && ranges_.back().first_leaves < leaves_.size() &&
          leaves_.back().offset + leaves_.back().bytes * leaves_.back().count == offset) {
        ++leaves_.back().count;
      } else {
        leaves_.push_back({offset, t.size, 1});
      }
      return;
    case bytecode::TypeKind::kArray:
      if (leaf_bytes(t.element) != 0) {
        leaves_.push_back({offset, leaf_bytes(t.element), t.count});
        return;
      }
      for (std::uint32_t i = 0; i < t.count; ++i) add_leaves(t.element, offset + i * image_.types[t.element].size);
      return;
    case bytecode::TypeKind::kStruct:
      for (const bytecode::ImageField& field : t.fields) add_leaves(field.type, offset + field.offset);
      return;
  }
}

std::uint32_t Exchange::add_range(std::uint32_t first, std::uint32_t count, bool changed) {
  const std::vector<bytecode::ImageField>& fields = image_.types[image_.global_type].fields;
  Range range;
  if (count != 0) {
    const bytecode::ImageField& last = fields[first + count - 1];
    range.begin = fields[first].offset;
    range.end = last.offset + image_.types[last.type].size;
  }
  range.first_leaves = static_cast<std::uint32_t>(leaves_.size());
  ranges_.push_back(range);
  if (changed) {
    for (std::uint32_t i = first; i < first + count; ++i) add_leaves(fields[i].type, fields[i].offset);
    if (shadow_.size() == 0) {
      shadow_ = TableMemory(globals_.size());
      std::memcpy(shadow_.data(), local_, globals_.size());
    }
  }
  ranges_.back().last_leaves = static_cast<std::uint32_t>(leaves_.size());
  return static_cast<std::uint32_t>(ranges_.size() - 1);
}

// RT:
void Exchange::import(std::uint32_t range) noexcept {
  const Range& r = ranges_[range];
  copy_from_shared(local_ + r.begin, globals_.data() + r.begin, r.end - r.begin);
  if (shadow_.size() != 0 && r.end != r.begin) std::memcpy(shadow_.data() + r.begin, local_ + r.begin, r.end - r.begin);
}

// RT:
void Exchange::export_all(std::uint32_t range) noexcept {
  const Range& r = ranges_[range];
  copy_to_shared(globals_.data() + r.begin, local_ + r.begin, r.end - r.begin);
}

// RT:
void Exchange::export_changed(std::uint32_t range) noexcept {
  const Range& r = ranges_[range];
  std::byte* const shadow = shadow_.data();
  for (std::uint32_t i = r.first_leaves; i < r.last_leaves; ++i) {
    const Leaves& leaves = leaves_[i];
    const std::size_t total = std::size_t{leaves.bytes} * leaves.count;
    if (std::memcmp(local_ + leaves.offset, shadow + leaves.offset, total) == 0) continue;
    for (std::uint32_t n = 0; n < leaves.count; ++n) {
      const std::uint32_t at = leaves.offset + n * leaves.bytes;
      if (std::memcmp(local_ + at, shadow + at, leaves.bytes) == 0) continue;
      copy_to_shared(globals_.data() + at, local_ + at, leaves.bytes);
      std::memcpy(shadow + at, local_ + at, leaves.bytes);
    }
  }
}

void Exchange::reset() {
  if (shadow_.size() != 0) std::memcpy(shadow_.data(), local_, globals_.size());
}

}  // namespace plc::runtime
