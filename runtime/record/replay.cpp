#include "runtime/record/replay.h"

#include <algorithm>
#include <cstring>

namespace plc::runtime {

void Replay::begin(std::span<const std::byte> record) noexcept {
  head_ = {};
  record_ = record;
  at_ = sizeof head_;
  moment_ = 0;
  exports_ = 0;
  fits_ = record.size() >= sizeof head_;
  if (!fits_) {
    record_ = {};
    at_ = 0;
    return;
  }
  std::memcpy(&head_, record.data(), sizeof head_);
}

bool Replay::load(std::span<const std::byte> table) noexcept {
  if (!table.empty()) std::memcpy(table_.data(), table.data(), table.size());
  return types_ == nullptr || types_->mend(table_, 0, table_.size());
}

// RT:
void Replay::put(std::byte* to, std::span<const std::byte> bytes) noexcept {
  if (bytes.empty()) return;
  std::memcpy(to, bytes.data(), bytes.size());
  if (types_ == nullptr) return;
  // Values inside of a scan lie after the table, and are nobody's to record.
  const std::uintptr_t at = reinterpret_cast<std::uintptr_t>(to) - reinterpret_cast<std::uintptr_t>(table_.data());
  fits_ = at <= table_.size() && bytes.size() <= table_.size() - at && types_->mend(table_, at, bytes.size()) && fits_;
}

bool Replay::next_is(EntryKind kind, EntryHead& head) const noexcept {
  if (record_.size() - at_ < sizeof head) return false;
  std::memcpy(&head, record_.data() + at_, sizeof head);
  return head.kind == kind && padded(head.bytes) <= record_.size() - at_ - sizeof head;
}

bool Replay::take(EntryKind kind, EntryHead& head, std::span<const std::byte>& payload) noexcept {
  if (!next_is(kind, head)) {
    fits_ = false;
    return false;
  }
  payload = record_.subspan(at_ + sizeof head, head.bytes);
  at_ += sizeof head + padded(head.bytes);
  return true;
}

void Replay::apply() noexcept { apply(EntryKind::kBytes, moment_); }

void Replay::export_range() noexcept { apply(EntryKind::kForced, exports_++); }

void Replay::apply(EntryKind kind, std::uint32_t detail) noexcept {
  EntryHead head;
  std::span<const std::byte> payload;
  while (next_is(kind, head) && head.detail == detail) {
    take(kind, head, payload);
    if (head.at > table_.size() || payload.size() > table_.size() - head.at) {
      fits_ = false;
      return;
    }
    put(table_.data() + head.at, payload);
  }
}

void Replay::start() noexcept { apply(); }

void Replay::import() noexcept {
  ++moment_;
  apply();
}

bool Replay::queue(void* element, std::size_t bytes) noexcept {
  EntryHead head;
  std::span<const std::byte> payload;
  if (!take(EntryKind::kQueue, head, payload) || head.at == 0) return false;
  if (element == nullptr) return true;
  if (payload.size() != bytes) {
    fits_ = false;
    return false;
  }
  put(static_cast<std::byte*>(element), payload);
  return true;
}

std::uint32_t Replay::number() noexcept {
  EntryHead head;
  std::span<const std::byte> payload;
  return take(EntryKind::kNumber, head, payload) ? head.at : 0;
}

std::uint32_t Replay::taskblock(std::uint32_t object, std::span<const PortBytes> outputs) noexcept {
  EntryHead head;
  std::span<const std::byte> payload;
  if (!take(EntryKind::kTaskblock, head, payload)) return 0;
  std::size_t bytes = 0;
  for (const PortBytes& port : outputs) bytes += port.bytes;
  if (head.at != object || payload.size() != bytes) {
    fits_ = false;
    return 0;
  }
  const std::byte* from = payload.data();
  for (const PortBytes& port : outputs) {
    put(port.at, {from, port.bytes});
    from += port.bytes;
  }
  return head.detail;
}

RecordedFault Replay::fault() noexcept {
  EntryHead head;
  RecordedFault fault;
  if (!next_is(EntryKind::kFault, head)) return fault;
  std::span<const std::byte> payload;
  take(EntryKind::kFault, head, payload);
  if (payload.size() == sizeof fault) {
    std::memcpy(&fault, payload.data(), sizeof fault);
  } else {
    fits_ = false;
  }
  return fault;
}

}  // namespace plc::runtime
