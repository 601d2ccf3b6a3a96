#include "runtime/record/replay.h"

#include <algorithm>
#include <cstring>

namespace plc::runtime {

void Replay::begin(std::span<const std::byte> record) noexcept {
  head_ = {};
  record_ = record;
  at_ = sizeof head_;
  moment_ = 0;
  fits_ = record.size() >= sizeof head_;
  if (!fits_) {
    record_ = {};
    at_ = 0;
    return;
  }
  std::memcpy(&head_, record.data(), sizeof head_);
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

void Replay::apply() noexcept {
  EntryHead head;
  std::span<const std::byte> payload;
  while (next_is(EntryKind::kBytes, head) && head.detail == moment_) {
    take(EntryKind::kBytes, head, payload);
    if (head.at > table_.size() || payload.size() > table_.size() - head.at) {
      fits_ = false;
      return;
    }
    if (!payload.empty()) std::memcpy(table_.data() + head.at, payload.data(), payload.size());
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
  if (bytes != 0) std::memcpy(element, payload.data(), bytes);
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
    std::memcpy(port.at, from, port.bytes);
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
