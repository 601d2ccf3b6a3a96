#include "runtime/memory/snapshot.h"

#include <algorithm>

namespace plc::runtime {
namespace {

constexpr std::size_t round_up(std::size_t bytes) { return (bytes + kTableAlign - 1) / kTableAlign * kTableAlign; }

}  // namespace

Snapshot::Snapshot(Arena& arena, std::size_t bytes, std::uint32_t readers)
    : bytes_(bytes),
      stride_(round_up(bytes)),
      buffer_count_(readers + 2),
      buffers_(arena.take(stride_ * buffer_count_)),
      readers_(arena.array<Subscription>(readers)),
      newest_word_(arena.word()),
      arena_(arena) {}

Snapshot::Reader Snapshot::subscribe() {
  Subscription& reader = readers_[reader_count_++];
  reader.held = arena_.word();
  reader.held->store(newest_, std::memory_order_relaxed);
  Reader view;
  view.newest_ = newest_word_;
  view.held_ = reader.held;
  view.buffers_ = buffers_;
  view.stride_ = stride_;
  view.number_ = newest_;
  return view;
}

// RT: readers + 1 buffers are in use at most.
[[gnu::hot]] void Snapshot::choose() noexcept {
  if (chosen_) return;
  // Either a reader that is about to take a buffer sees the newest one, or what follows sees that it is about to.
  newest_word_->exchange(newest_, std::memory_order_seq_cst);
  const std::span<Subscription> readers = readers_.first(reader_count_);
  for (Subscription& reader : readers) {
    reader.number = reader.held->load(std::memory_order_seq_cst);
    if (reader.number == kTaking && reader.held->compare_exchange_strong(reader.number, newest_))
      reader.number = newest_;
  }
  const auto in_use = [this, readers] {
    bool used = writing_ == newest_;
    for (const Subscription& reader : readers) used = used || reader.number == writing_;
    return used;
  };
  while (in_use()) writing_ = writing_ + 1 == buffer_count_ ? 0 : writing_ + 1;
  chosen_ = true;
}

// RT:
[[gnu::hot]] std::byte* Snapshot::begin_write() noexcept {
  choose();
  return buffers_ + writing_ * stride_;
}

// RT:
[[gnu::hot]] void Snapshot::publish() noexcept {
  newest_ = writing_;
  chosen_ = false;
  // Release: the bytes are there when the number is.
  newest_word_->store(newest_, std::memory_order_release);
}

// RT:
void Snapshot::Reader::announce() noexcept { held_->exchange(kTaking, std::memory_order_seq_cst); }

// RT:
std::uint32_t Snapshot::Reader::look() const noexcept { return newest_->load(std::memory_order_seq_cst); }

// RT:
void Snapshot::Reader::claim(std::uint32_t newest) noexcept {
  std::uint32_t held = kTaking;
  // The writer may have been faster: then it is the newest of its.
  number_ = held_->compare_exchange_strong(held, newest, std::memory_order_acq_rel) ? newest : held;
}

// RT:
[[gnu::hot]] const std::byte* Snapshot::Reader::acquire() noexcept {
  if (newest_->load(std::memory_order_relaxed) != number_) {
    announce();
    claim(look());
  }
  return buffers_ + number_ * stride_;
}

}  // namespace plc::runtime
