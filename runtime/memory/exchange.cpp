#include "runtime/memory/exchange.h"

#include <algorithm>
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

Exchange::Exchange(GlobalTable& globals, std::uint32_t task, std::byte* local)
    : globals_(globals), task_(task), local_(local) {
  globals_.attach(*this);
}

Exchange::~Exchange() { globals_.detach(*this); }

std::uint32_t Exchange::add_range(std::uint32_t first, std::uint32_t count, bool exports) {
  Range range;
  range.first = first;
  range.count = count;
  range.exports = exports;
  ranges_.push_back(std::move(range));
  return static_cast<std::uint32_t>(ranges_.size() - 1);
}

void Exchange::prepare() {
  held_.assign(globals_.owners_.size(), nullptr);
  sources_.clear();
  const auto reads = [this](std::uint32_t owner) {
    if (std::find(sources_.begin(), sources_.end(), owner) == sources_.end()) sources_.push_back(owner);
  };
  std::size_t exports = 0;
  bool by_leaf = false;
  for (Range& range : ranges_) {
    range.stretches.clear();
    range.leaves.clear();
    bool neighbour = false;  // the field before this one is the end of the last stretch
    for (std::uint32_t f = range.first; f < range.first + range.count; ++f) {
      const GlobalTable::Field& field = globals_.fields_[f];
      if (field.begin == field.end) {
        neighbour = false;
        continue;
      }
      const bool owned = field.kind == GlobalTable::Kind::kOwned;
      if (owned && (field.owner == task_) == range.exports) {
        if (!range.exports) reads(field.owner);
        if (neighbour && range.stretches.back().owner == field.owner) {
          range.stretches.back().end = field.end;
        } else {
          range.stretches.push_back({field.owner, field.begin, field.end, field.at});
        }
      }
      neighbour = owned && (field.owner == task_) == range.exports;
      if (owned || field.kind == GlobalTable::Kind::kConstant) continue;
      by_leaf = true;
      for (std::uint32_t l = field.first_leaves; l < field.last_leaves; ++l) {
        range.leaves.push_back(l);
        const GlobalTable::Leaves& leaves = globals_.leaves_[l];
        for (std::uint32_t c = leaves.first_copy; c < leaves.last_copy; ++c) reads(globals_.copies_[c].owner);
      }
    }
    exports += range.exports ? 1 : 0;
  }
  in_parts_ = exports > 1;
  if (by_leaf && shadow_.size() == 0) shadow_ = TableMemory(globals_.size());
  reset();
}

void Exchange::reset() {
  if (shadow_.size() != 0) std::memcpy(shadow_.data(), local_, globals_.size());
  imported_.assign(globals_.leaves_.size(), kNotImported);
}

// RT:
void Exchange::apply(const Journal::Entry& entry, const std::byte* value, const std::byte* mask) noexcept {
  globals_.merge(local_ + entry.offset, entry.type, value, mask);
}

// RT:
void Exchange::begin() noexcept {
  writing_ = nullptr;
  stamp_ = 0;
  globals_.owners_[task_].journal->drain([this](const Journal::Entry& entry, const std::byte* value,
                                                const std::byte* mask) noexcept { apply(entry, value, mask); });
  for (const std::uint32_t owner : sources_) held_[owner] = globals_.owners_[owner].snapshot->acquire(task_);
}

// RT:
void Exchange::import_leaves(std::uint32_t index) noexcept {
  const GlobalTable::Leaves& leaves = globals_.leaves_[index];
  const std::size_t total = std::size_t{leaves.bytes} * leaves.count;
  std::byte* const to = local_ + leaves.offset;
  std::byte* const shadow = shadow_.data() + leaves.offset;
  if (leaves.first_copy == leaves.last_copy) {
    copy_from_shared(to, globals_.overlapping_.data() + leaves.offset, total);
    std::memcpy(shadow, to, total);
    return;
  }
  const std::uint64_t version = globals_.version(held_, leaves);
  if (version == imported_[index]) {
    std::memcpy(to, shadow, total);  // what a cycle that faulted changed and did not export is undone
    return;
  }
  for (std::uint32_t i = 0; i < leaves.count; ++i) {
    globals_.read_shared(held_, leaves, i, to + std::size_t{leaves.bytes} * i);
  }
  std::memcpy(shadow, to, total);
  imported_[index] = version;
}

// RT:
void Exchange::import(std::uint32_t range) noexcept {
  const Range& r = ranges_[range];
  for (const Stretch& s : r.stretches) {
    std::memcpy(local_ + s.begin, held_[s.owner] + s.at, s.end - s.begin);
  }
  for (const std::uint32_t l : r.leaves) import_leaves(l);
}

// RT:
void Exchange::open_snapshot() noexcept {
  Snapshot& snapshot = *globals_.owners_[task_].snapshot;
  writing_ = snapshot.begin_write();
  // A body that leaves a range out this time publishes that range as it was.
  if (in_parts_) std::memcpy(writing_, snapshot.published(), globals_.owners_[task_].shared_at);
}

// RT:
void Exchange::export_leaves(const GlobalTable::Leaves& leaves) noexcept {
  std::byte* const local = local_ + leaves.offset;
  std::byte* const shadow = shadow_.data() + leaves.offset;
  if (std::memcmp(local, shadow, std::size_t{leaves.bytes} * leaves.count) == 0) return;
  for (std::uint32_t i = 0; i < leaves.count; ++i) {
    const std::size_t at = std::size_t{leaves.bytes} * i;
    if (std::memcmp(local + at, shadow + at, leaves.bytes) == 0) continue;
    if (leaves.first_copy == leaves.last_copy) {
      copy_to_shared(globals_.overlapping_.data() + leaves.offset + at, local + at, leaves.bytes);
    } else {
      if (writing_ == nullptr) open_snapshot();
      if (stamp_ == 0) stamp_ = globals_.next_stamp();
      const GlobalTable::Stamped place = globals_.stamped(task_, leaves, i);
      std::memcpy(place.value, local + at, leaves.bytes);
      std::memcpy(place.stamp, &stamp_, sizeof stamp_);
      std::memcpy(place.newest, &stamp_, sizeof stamp_);
    }
    std::memcpy(shadow + at, local + at, leaves.bytes);
  }
}

// RT:
void Exchange::export_range(std::uint32_t range) noexcept {
  const Range& r = ranges_[range];
  if (!r.stretches.empty() && writing_ == nullptr) open_snapshot();
  for (const Stretch& s : r.stretches) {
    std::memcpy(writing_ + s.at, local_ + s.begin, s.end - s.begin);
  }
  for (const std::uint32_t l : r.leaves) export_leaves(globals_.leaves_[l]);
}

// RT:
void Exchange::end() noexcept {
  GlobalTable::Owner& own = globals_.owners_[task_];
  if (writing_ != nullptr) {
    const std::size_t shared = own.snapshot->bytes() - own.shared_at;
    if (shared != 0) std::memcpy(writing_ + own.shared_at, own.image.data(), shared);
    own.snapshot->publish();
  }
  for (const std::uint32_t owner : sources_) globals_.owners_[owner].snapshot->release(task_);
}

// RT:
bool Exchange::read_bool(std::uint32_t offset) noexcept {
  for (std::size_t owner = 0; owner < held_.size(); ++owner) {
    held_[owner] = globals_.owners_[owner].snapshot->acquire(task_);
  }
  std::byte value{};
  globals_.read_held(held_, offset, 1, &value);
  globals_.let_go(task_);
  return value != std::byte{0};
}

}  // namespace plc::runtime
