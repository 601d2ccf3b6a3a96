// History: the newest blocks of a plant that runs, in memory of a fixed size.
//
// In: blocks as files have them. Out: recordings of what there is. The oldest blocks go when there is no room. Threads:
// any, but no real-time one. Does not belong here: files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/clock.h"

namespace plc::shadow {

class History {
 public:
  explicit History(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

  /// `first_ns`, `last_ns`: `now` of its first and of its last scan.
  void add(core::TimeNs first_ns, core::TimeNs last_ns, std::span<const std::byte> block);
  [[nodiscard]] std::uint64_t bytes() const;
  /// `now` of the first and of the last scan that is here; nothing without one.
  [[nodiscard]] std::optional<core::TimeNs> begin_ns() const;
  [[nodiscard]] std::optional<core::TimeNs> end_ns() const;
  /// `head` (file_head()), all blocks, and those of `newest`: a recording as a file has it.
  [[nodiscard]] std::vector<std::byte> recording(std::span<const std::byte> head,
                                                 std::span<const std::vector<std::byte>> newest) const;

 private:
  const std::uint64_t most_bytes_;
  mutable std::mutex mutex_;
  std::uint64_t bytes_ = 0;
  struct Kept {
    core::TimeNs first_ns = 0, last_ns = 0;
    std::vector<std::byte> bytes;
  };
  std::deque<Kept> blocks_;
};

}  // namespace plc::shadow
