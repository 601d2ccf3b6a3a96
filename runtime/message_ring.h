// MessageRing: what components tell the operator, on its way from where nothing may wait to who prints it.
//
// In: fixed-size messages, from any thread. Out: the same, in the order in which their places were taken, to one
// thread. Neither side waits: a ring that is full, or a place that several threads want at once, costs the message, and
// that is counted. Does not belong here: printing, severities' meaning.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/clock.h"
#include "core/diagnostics.h"
#include "picard/abi.h"

namespace plc::runtime {

/// One message as who prints it has it.
struct TaskblockMessage {
  core::Severity severity = core::Severity::kNote;
  std::string taskblock;    ///< "LOWPASS main.filter"
  std::uint64_t scan = 0;   ///< scans of the task before the one in which it was told
  core::TimeNs utc_ns = 0;  ///< date and time of that scan; 0 before the first
  std::string text;
};

class MessageRing {
 public:
  static constexpr std::uint64_t kPlaces = 128;
  struct Message {
    core::TimeNs utc_ns = 0;
    std::uint64_t scan = 0;
    std::uint32_t object = 0;
    core::Severity severity = core::Severity::kNote;
    char text[PICARD_TEXT_BYTES]{};
  };

  MessageRing() noexcept {
    for (std::uint64_t i = 0; i < kPlaces; ++i) places_[i].turn.store(i, std::memory_order_relaxed);
  }

  /// RT: at most kTries steps. Any thread. `text` is cut at PICARD_TEXT_BYTES - 1 bytes.
  void push(const Message& message, const char* text) noexcept {
    std::uint64_t at = head_.load(std::memory_order_relaxed);
    for (int tries = 0; tries < kTries; ++tries) {
      Place& place = places_[at % kPlaces];
      if (place.turn.load(std::memory_order_acquire) != at) {
        const std::uint64_t head = head_.load(std::memory_order_relaxed);
        if (head == at) break;  // full
        at = head;
        continue;
      }
      if (!head_.compare_exchange_weak(at, at + 1, std::memory_order_relaxed)) continue;
      place.message = message;
      std::size_t length = 0;
      while (length + 1 < PICARD_TEXT_BYTES && text[length] != '\0') ++length;
      std::memcpy(place.message.text, text, length);
      place.message.text[length] = '\0';
      place.turn.store(at + 1, std::memory_order_release);
      return;
    }
    lost_.fetch_add(1, std::memory_order_relaxed);
  }

  /// Calls take(message) for what has come, at most a whole ring. One thread.
  template <class Take>
  void drain(Take&& take) {
    for (std::uint64_t i = 0; i < kPlaces; ++i) {
      Place& place = places_[tail_ % kPlaces];
      if (place.turn.load(std::memory_order_acquire) != tail_ + 1) return;
      take(place.message);
      place.turn.store(tail_ + kPlaces, std::memory_order_release);
      ++tail_;
    }
  }
  /// Messages that were lost since the last call.
  std::uint64_t take_lost() noexcept { return lost_.exchange(0, std::memory_order_relaxed); }

 private:
  static constexpr int kTries = 8;
  /// `turn`: p = free for message number p; p + 1 = that message is in it.
  struct alignas(64) Place {
    std::atomic<std::uint64_t> turn{0};
    Message message;
  };
  std::array<Place, kPlaces> places_;
  alignas(64) std::atomic<std::uint64_t> head_{0};
  std::atomic<std::uint64_t> lost_{0};
  alignas(64) std::uint64_t tail_ = 0;
};

}  // namespace plc::runtime
