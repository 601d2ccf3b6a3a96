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
      held_(arena.array<std::uint32_t>(readers, kTableAlign)),
      mailboxes_(arena.array<std::atomic<std::uint32_t>>(round_up(readers * 4) / 4, kTableAlign)) {
  buffers_ = arena.take(stride_ * buffer_count_);
}

Snapshot::Reader Snapshot::subscribe() {
  const std::uint32_t reader = reader_count_++;
  held_[reader] = newest_;
  mailboxes_[reader].store(newest_, std::memory_order_relaxed);
  Reader view;
  view.mailbox_ = &mailboxes_[reader];
  view.buffers_ = buffers_;
  view.stride_ = stride_;
  return view;
}

// RT: readers + 1 buffers are in use at most.
void Snapshot::choose() noexcept {
  if (chosen_) return;
  const auto in_use = [this] {
    const auto end = held_.begin() + reader_count_;
    return writing_ == newest_ || std::find(held_.begin(), end, writing_) != end;
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
  for (std::uint32_t reader = 0; reader < reader_count_; ++reader) {
    // Release: the bytes are there when the number is. Acquire: what the reader read of the buffer it gave up is read.
    const std::uint32_t before = mailboxes_[reader].exchange(newest_ | kFresh, std::memory_order_acq_rel);
    if ((before & kFresh) == 0) held_[reader] = before;
  }
}

// RT:
[[gnu::hot]] void Snapshot::expect_write() noexcept {
  choose();
  __builtin_prefetch(mailboxes_.data(), 1);
  __builtin_prefetch(buffers_ + writing_ * stride_, 1);
}

// RT:
[[gnu::hot]] const std::byte* Snapshot::Reader::acquire() noexcept {
  std::uint32_t number = mailbox_->load(std::memory_order_relaxed);
  // The number may be another fresh one by now, but never one that was taken: only this reader takes.
  if ((number & kFresh) != 0) number = mailbox_->fetch_and(~kFresh, std::memory_order_acq_rel);
  return buffers_ + (number & ~kFresh) * stride_;
}

}  // namespace plc::runtime
