#include "runtime/memory/journal.h"

#include <bit>
#include <cstring>

namespace plc::runtime {

Journal::Journal(Arena& arena, std::size_t capacity)
    : memory_(arena.take(std::bit_ceil(capacity))), capacity_(std::bit_ceil(capacity)), mask_(capacity_ - 1) {}

std::size_t Journal::room_for(const Entry& entry) noexcept {
  return sizeof(Record) + padded(entry.bytes) * (entry.masked ? 2 : 1);
}

bool Journal::fits(std::size_t room, std::size_t largest) const noexcept {
  const std::uint64_t used = written_ - tail_.load(std::memory_order_acquire);
  // Records are not split at the end of the ring: less than the largest one may be lost there.
  return used + room + largest <= capacity_;
}

void Journal::append(const Entry& entry, const std::byte* value, const std::byte* mask) noexcept {
  const std::size_t room = room_for(entry);
  const std::size_t left = capacity_ - static_cast<std::size_t>(written_ & mask_);
  if (left < room) {
    Record skip;
    skip.entry.bytes = kSkip;
    skip.size = static_cast<std::uint32_t>(left);
    std::memcpy(memory_ + (written_ & mask_), &skip, sizeof skip);
    written_ += left;
  }
  std::byte* const place = memory_ + (written_ & mask_);
  const Record record{entry, static_cast<std::uint32_t>(room)};
  std::memcpy(place, &record, sizeof record);
  std::memcpy(place + sizeof record, value, entry.bytes);
  if (entry.masked) std::memcpy(place + sizeof record + padded(entry.bytes), mask, entry.bytes);
  written_ += room;
}

Journal::Record Journal::load(const std::byte* place) noexcept {
  Record record;
  std::memcpy(&record, place, sizeof record);
  return record;
}

void Journal::clear() noexcept {
  written_ = drained_ = 0;
  head_.store(0, std::memory_order_relaxed);
  tail_.store(0, std::memory_order_relaxed);
}

}  // namespace plc::runtime
