// EventTable: how often each instruction raised an event, in bounded memory.
//
// In: record() from the task's thread when an event happens. Out: counts for any thread (relaxed atomics; a slot's key
// is published after its first count). Beyond kSlots instructions the rest shares one counter. Does not belong here:
// names of events, places in files (program.h).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "runtime/program.h"
#include "stdlib/library.h"

namespace plc::runtime {

class EventTable {
 public:
  /// RT: one writer.
  void record(std::uint32_t pou, std::uint32_t word, stdlib::Event event) noexcept {
    total_.store(total_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    const std::uint64_t key = (std::uint64_t{pou} << 32 | word) + 1;
    auto at = static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 56);
    for (std::size_t probe = 0; probe < kProbes; ++probe, at = (at + 1) % Program::kEventSlots) {
      Slot& slot = slots_[at];
      const std::uint64_t present = slot.key.load(std::memory_order_relaxed);
      if (present != 0 && present != key) continue;
      slot.last.store(event, std::memory_order_relaxed);
      slot.count.store(slot.count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
      if (present == 0) slot.key.store(key, std::memory_order_release);
      return;
    }
    other_.store(other_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  [[nodiscard]] std::vector<EventCount> counts() const {
    std::vector<EventCount> counts;
    for (const Slot& slot : slots_) {
      const std::uint64_t key = slot.key.load(std::memory_order_acquire);
      if (key == 0) continue;
      counts.push_back({static_cast<std::uint32_t>((key - 1) >> 32), static_cast<std::uint32_t>(key - 1),
                        slot.last.load(std::memory_order_relaxed), slot.count.load(std::memory_order_relaxed)});
    }
    return counts;
  }
  [[nodiscard]] std::uint64_t other() const noexcept { return other_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t total() const noexcept { return total_.load(std::memory_order_relaxed); }
  void clear() noexcept {
    for (Slot& slot : slots_) {
      slot.key.store(0, std::memory_order_relaxed);
      slot.count.store(0, std::memory_order_relaxed);
    }
    other_.store(0, std::memory_order_relaxed);
    total_.store(0, std::memory_order_relaxed);
  }

 private:
  static_assert(Program::kEventSlots == 256, "the hash takes the top eight bits");
  static constexpr std::size_t kProbes = 16;  // a full table must not make a storm of events slower than this
  struct Slot {
    std::atomic<std::uint64_t> key{0};
    std::atomic<std::uint64_t> count{0};
    std::atomic<stdlib::Event> last{stdlib::Event::kNone};
  };
  std::array<Slot, Program::kEventSlots> slots_;
  std::atomic<std::uint64_t> other_{0};
  std::atomic<std::uint64_t> total_{0};
};

}  // namespace plc::runtime
