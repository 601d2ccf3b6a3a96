#include "runtime/memory/snapshot.h"

#include <algorithm>

namespace plc::runtime {

Snapshot::Snapshot(std::size_t bytes, std::uint32_t readers)
    : bytes_(bytes),
      stride_((bytes + kTableAlign - 1) / kTableAlign * kTableAlign),
      readers_(readers),
      mailboxes_(std::make_unique<Mailbox[]>(readers)),
      memory_(stride_ * (readers + 2)),
      held_(readers, 0) {}

// RT: readers + 1 buffers are in use at most.
void Snapshot::choose() noexcept {
  if (chosen_) return;
  const auto in_use = [this] {
    return writing_ == newest_ || std::find(held_.begin(), held_.end(), writing_) != held_.end();
  };
  while (in_use()) writing_ = writing_ + 1 == readers_ + 2 ? 0 : writing_ + 1;
  chosen_ = true;
}

// RT:
std::byte* Snapshot::begin_write() noexcept {
  choose();
  return buffer(writing_);
}

// RT:
void Snapshot::publish() noexcept {
  newest_ = writing_;
  chosen_ = false;
  for (std::uint32_t reader = 0; reader < readers_; ++reader) {
    // Release: the bytes are there when the number is. Acquire: what the reader read of the buffer it gave up is read.
    const std::uint32_t before = mailboxes_[reader].buffer.exchange(newest_ | kFresh, std::memory_order_acq_rel);
    if ((before & kFresh) == 0) held_[reader] = before;
  }
}

// RT:
const std::byte* Snapshot::acquire(std::uint32_t reader) noexcept {
  std::atomic<std::uint32_t>& mailbox = mailboxes_[reader].buffer;
  std::uint32_t number = mailbox.load(std::memory_order_relaxed);
  // The number may be another fresh one by now, but never one that was taken: only this reader takes.
  if ((number & kFresh) != 0) number = mailbox.fetch_and(~kFresh, std::memory_order_acq_rel);
  return buffer(number & ~kFresh);
}

// RT:
void Snapshot::expect_read(std::uint32_t reader) const noexcept {
  __builtin_prefetch(&mailboxes_[reader], 1);
  // Which buffer it will be is not known yet: the start of each.
  for (std::uint32_t i = 0; i < readers_ + 2; ++i) __builtin_prefetch(buffer(i));
}

// RT:
void Snapshot::expect_write() noexcept {
  choose();
  for (std::uint32_t reader = 0; reader < readers_; ++reader) __builtin_prefetch(&mailboxes_[reader], 1);
  __builtin_prefetch(buffer(writing_), 1);
}

}  // namespace plc::runtime
