#include "shadow/history.h"

#include <algorithm>

namespace plc::shadow {

void History::add(core::TimeNs first_ns, core::TimeNs last_ns, std::span<const std::byte> block) {
  const std::lock_guard lock(mutex_);
  blocks_.push_back({first_ns, last_ns, {block.begin(), block.end()}});
  bytes_ += block.size();
  while (bytes_ > most_bytes_ && !blocks_.empty()) {
    bytes_ -= blocks_.front().bytes.size();
    blocks_.pop_front();
  }
}

std::uint64_t History::bytes() const {
  const std::lock_guard lock(mutex_);
  return bytes_;
}

std::optional<core::TimeNs> History::begin_ns() const {
  const std::lock_guard lock(mutex_);
  std::optional<core::TimeNs> begin;
  for (const Kept& block : blocks_) begin = std::min(begin.value_or(block.first_ns), block.first_ns);
  return begin;
}

std::optional<core::TimeNs> History::end_ns() const {
  const std::lock_guard lock(mutex_);
  std::optional<core::TimeNs> end;
  for (const Kept& block : blocks_) end = std::max(end.value_or(block.last_ns), block.last_ns);
  return end;
}

std::vector<std::byte> History::recording(std::span<const std::byte> head,
                                          std::span<const std::vector<std::byte>> newest) const {
  const std::lock_guard lock(mutex_);
  std::size_t bytes = head.size() + static_cast<std::size_t>(bytes_);
  for (const auto& block : newest) bytes += block.size();
  std::vector<std::byte> file;
  file.reserve(bytes);
  file.insert(file.end(), head.begin(), head.end());
  for (const Kept& block : blocks_) file.insert(file.end(), block.bytes.begin(), block.bytes.end());
  for (const auto& block : newest) file.insert(file.end(), block.begin(), block.end());
  return file;
}

}  // namespace plc::shadow
