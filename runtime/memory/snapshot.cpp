#include "runtime/memory/snapshot.h"

namespace plc::runtime {

Snapshot::Snapshot(std::size_t bytes, std::uint32_t readers)
    : bytes_(bytes),
      stride_((bytes + kTableAlign - 1) / kTableAlign * kTableAlign),
      readers_(readers),
      slots_(std::make_unique<Slot[]>(readers)),
      memory_(stride_ * (readers + 2)) {}

bool Snapshot::is_free(std::uint32_t index) const noexcept {
  if (index == newest_.load(std::memory_order_relaxed)) return false;
  for (std::uint32_t reader = 0; reader < readers_; ++reader) {
    // Acquire: what the reader read before it let go happened before we overwrite it.
    if (slots_[reader].holds.load(std::memory_order_acquire) == index) return false;
  }
  return true;
}

// RT: a slot that is choosing can only claim the newest buffer, which is never taken here.
std::byte* Snapshot::begin_write() noexcept {
  while (!is_free(writing_)) writing_ = writing_ + 1 == readers_ + 2 ? 0 : writing_ + 1;
  return buffer(writing_);
}

// RT:
void Snapshot::publish() noexcept {
  // Sequentially consistent against acquire(): either the reader sees this store, or we see that it is choosing.
  newest_.store(writing_, std::memory_order_seq_cst);
  for (std::uint32_t reader = 0; reader < readers_; ++reader) {
    std::uint32_t choosing = kChoosing;
    slots_[reader].holds.compare_exchange_strong(choosing, writing_, std::memory_order_seq_cst);
  }
}

// RT:
const std::byte* Snapshot::acquire(std::uint32_t reader) noexcept {
  std::atomic<std::uint32_t>& holds = slots_[reader].holds;
  holds.store(kChoosing, std::memory_order_seq_cst);
  const std::uint32_t newest = newest_.load(std::memory_order_seq_cst);
  std::uint32_t mine = kChoosing;
  // On failure `mine` is the buffer the writer handed over: published after `newest`.
  if (holds.compare_exchange_strong(mine, newest, std::memory_order_seq_cst)) mine = newest;
  return buffer(mine);
}

// RT:
void Snapshot::release(std::uint32_t reader) noexcept {
  slots_[reader].holds.store(kNothing, std::memory_order_release);
}

}  // namespace plc::runtime
