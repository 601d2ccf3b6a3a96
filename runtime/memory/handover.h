// Handover: what is kept of one task over a restart, handed from the task to the one who stores it.
//
// In: places in the task's table, and the question of the reader. Out: their bytes as they were at the end of one scan.
// One block of memory that belongs to one side at a time: the reader asks, the task answers at the end of its next
// scan, the reader has the block until it asks again. So the task copies as often as somebody stores, not in every
// scan, and neither side waits. Threads: offer() on the task's thread, or on another one after it has ended; the rest
// on one thread. Does not belong here: which variables these are (retain/), files.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "runtime/memory/table.h"

namespace plc::runtime {

class Handover {
 public:
  /// Bytes that lie side by side in the task's table and in the block.
  struct Run {
    std::uint32_t from = 0;  ///< bytes from the start of the task's table
    std::uint32_t to = 0;    ///< bytes from the start of the block
    std::uint32_t bytes = 0;
  };
  /// `bytes` of the block; every run lies inside of both. Set-up.
  Handover(std::vector<Run> runs, std::size_t bytes) : runs_(std::move(runs)), block_(bytes), bytes_(bytes) {}

  /// Copies if it was asked to; true when it did. `now_ns`: of the scan that has ended. RT: bounded by the runs.
  bool offer(const std::byte* table, core::TimeNs now_ns) noexcept {
    if (turn_.load(std::memory_order_acquire) != Turn::kAsked) return false;
    for (const Run& run : runs_) std::memcpy(block_.data() + run.to, table + run.from, run.bytes);
    now_ns_ = now_ns;
    turn_.store(Turn::kAnswered, std::memory_order_release);
    return true;
  }

  /// The block is the task's until answered(). Nothing happens while a question is open, or its answer not taken.
  void ask() noexcept {
    if (turn_.load(std::memory_order_relaxed) == Turn::kIdle) turn_.store(Turn::kAsked, std::memory_order_release);
  }
  [[nodiscard]] bool answered() const noexcept { return turn_.load(std::memory_order_acquire) == Turn::kAnswered; }
  /// The answer; while answered().
  [[nodiscard]] std::span<const std::byte> block() const noexcept { return {block_.data(), bytes_}; }
  /// The `now` of the scan that it is of; while answered().
  [[nodiscard]] core::TimeNs now_ns() const noexcept { return now_ns_; }
  /// The answer has been taken. While answered().
  void taken() noexcept { turn_.store(Turn::kIdle, std::memory_order_relaxed); }

 private:
  enum class Turn : std::uint8_t { kIdle, kAsked, kAnswered };

  std::vector<Run> runs_;
  TableMemory block_;
  std::size_t bytes_;
  core::TimeNs now_ns_ = 0;
  std::atomic<Turn> turn_{Turn::kIdle};
};

}  // namespace plc::runtime
