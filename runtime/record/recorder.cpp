#include "runtime/record/recorder.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace plc::runtime {
namespace {

/// Above so many bytes the parts that differ are looked for; below, copying all of them takes less time.
constexpr std::uint32_t kWhole = 8192;
constexpr std::uint32_t kPart = 64;

}  // namespace

// RT:
std::uint64_t check_of_slice(std::span<const std::byte> table, std::uint32_t slice) noexcept {
  const std::size_t begin = std::min(std::size_t{slice} * kSliceBytes, table.size());
  return XXH3_64bits(table.data() + begin, std::min<std::size_t>(kSliceBytes, table.size() - begin));
}

Recorder::Recorder(RecordRing& ring, std::span<std::byte> table)
    : ring_(ring), table_(table), checkpoint_(table.size()) {}

// RT:
bool Recorder::ready() noexcept {
  if (state_ == State::kOpen) return true;
  if (state_ == State::kLeftOut) return false;
  state_ = State::kLeftOut;
  if (lost_ != 0) {
    RecordHead head;
    head.kind = RecordKind::kLost;
    head.events = lost_;
    head.scan = scan_;
    if (!put(head)) return false;
    lost_ = 0;
  }
  record_ = ring_.open();
  if (record_ == nullptr) return false;
  used_ = sizeof(RecordHead);
  state_ = State::kOpen;
  return true;
}

// RT:
std::byte* Recorder::add(EntryKind kind, std::uint32_t at, std::uint32_t detail, std::size_t bytes) noexcept {
  if (!ready()) return nullptr;
  const std::size_t room = sizeof(EntryHead) + padded(bytes);
  if (used_ + room > ring_.most_record_bytes()) {
    state_ = State::kLeftOut;
    return nullptr;
  }
  const EntryHead head{static_cast<std::uint32_t>(bytes), kind, at, detail};
  std::byte* const place = record_ + used_;
  std::memcpy(place, &head, sizeof head);
  used_ += room;
  return place + sizeof head;
}

// RT:
void Recorder::written(std::uint32_t at, std::uint32_t bytes) noexcept {
  if (std::byte* const place = add(EntryKind::kBytes, at, moment_, bytes)) std::memcpy(place, &table_[at], bytes);
}

// RT:
void Recorder::forced(std::uint32_t exports, std::uint32_t at, std::uint32_t bytes) noexcept {
  if (std::byte* const place = add(EntryKind::kForced, at, exports, bytes)) std::memcpy(place, &table_[at], bytes);
}

// RT:
void Recorder::copy(std::uint32_t at, const std::byte* from, std::uint32_t bytes) noexcept {
  std::byte* const to = &table_[at];
  if (bytes <= kWhole) {
    if (std::memcmp(to, from, bytes) == 0) return;
    std::memcpy(to, from, bytes);
    written(at, bytes);
    return;
  }
  std::uint32_t first = bytes;  // of the parts that differ and are not recorded yet; `bytes` = none
  for (std::uint32_t part = 0; part < bytes; part += kPart) {
    const std::uint32_t size = std::min(kPart, bytes - part);
    if (std::memcmp(to + part, from + part, size) != 0) {
      std::memcpy(to + part, from + part, size);
      first = std::min(first, part);
    } else if (first != bytes) {
      written(at + first, part - first);
      first = bytes;
    }
  }
  if (first != bytes) written(at + first, bytes - first);
}

// RT:
void Recorder::queue(bool done, std::span<const std::byte> element) noexcept {
  std::byte* const place = add(EntryKind::kQueue, done ? 1 : 0, 0, element.size());
  if (place != nullptr && !element.empty()) std::memcpy(place, element.data(), element.size());
}

// RT:
void Recorder::number(std::uint32_t answer) noexcept { add(EntryKind::kNumber, answer, 0, 0); }

// RT:
void Recorder::taskblock(std::uint32_t object, std::uint32_t status, std::span<const PortBytes> outputs) noexcept {
  std::size_t bytes = 0;
  for (const PortBytes& port : outputs) bytes += port.bytes;
  std::byte* place = add(EntryKind::kTaskblock, object, status, bytes);
  if (place == nullptr) return;
  for (const PortBytes& port : outputs) {
    std::memcpy(place, port.at, port.bytes);
    place += port.bytes;
  }
}

// RT:
bool Recorder::put(const RecordHead& head) noexcept {
  std::byte* const place = ring_.open();
  if (place == nullptr) return false;
  RecordHead whole = head;
  whole.bytes = sizeof whole;
  std::memcpy(place, &whole, sizeof whole);
  ring_.close(sizeof whole);
  return true;
}

// RT:
void Recorder::close(RecordHead head, const RecordedFault& fault) noexcept {
  if (fault.kind != 0) {
    head.flags |= kFaulted;
    if (std::byte* const place = add(EntryKind::kFault, fault.kind, 0, sizeof fault))
      std::memcpy(place, &fault, sizeof fault);
  }
  if (ready()) {
    head.bytes = static_cast<std::uint32_t>(used_);
    head.kind = RecordKind::kScan;
    head.scan = scan_;
    head.slice = slice_;
    head.check = check_of_slice(table_, slice_);
    std::memcpy(record_, &head, sizeof head);
    ring_.close(used_);
    bytes_in_all_.store(bytes_in_all_.load(std::memory_order_relaxed) + used_, std::memory_order_relaxed);
  } else {
    ++lost_;
    lost_in_all_.store(lost_in_all_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }
  slice_ = (std::size_t{slice_} + 1) * kSliceBytes < table_.size() ? slice_ + 1 : 0;
  ++scan_;
  scans_in_all_.store(scan_, std::memory_order_relaxed);
  state_ = State::kClosed;
  moment_ = 0;
  if (asked_.load(std::memory_order_acquire) == Asked::kYes) make_checkpoint();
}

// RT:
void Recorder::make_checkpoint() noexcept {
  if (ring_.open() == nullptr) return;
  RecordHead head;
  head.kind = RecordKind::kCheckpointed;
  head.scan = scan_;
  std::memcpy(checkpoint_.data(), table_.data(), table_.size());
  // The record, which is published after the copy, is what the reader waits for: from then on it may give back.
  asked_.store(Asked::kMade, std::memory_order_relaxed);
  if (!put(head)) asked_.store(Asked::kYes, std::memory_order_relaxed);
}

// RT:
void Recorder::changed() noexcept {
  ++lost_;
  state_ = State::kClosed;
  moment_ = 0;
}

bool Recorder::ask() noexcept {
  Asked asked = Asked::kNo;
  return asked_.compare_exchange_strong(asked, Asked::kYes, std::memory_order_acq_rel) || asked == Asked::kYes;
}

}  // namespace plc::runtime
