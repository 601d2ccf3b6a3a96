// RequestStream: requests for one unit out of all that is heard on a line: those of other units, their answers, noise.
//
// In: bytes, when they came. Out: frames that are whole, have their checksum and have ended, each once. A frame begins
// after a silence or after a frame that was understood, and nowhere else: the values of others may look like one. What
// is no frame is dropped up to the next silence. Pure, allocates nothing. Does not belong here: descriptors, answers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/clock.h"
#include "io-drivers/modbus-rtu/frame.h"

namespace plc::modbus_rtu {

inline constexpr std::uint8_t kBroadcast = 0;

class RequestStream {
 public:
  /// `silence_ns`: what is between frames (silence_ns() of the line).
  RequestStream(std::uint8_t unit, core::TimeNs silence_ns) : unit_(unit), silence_ns_(silence_ns) {}

  /// More bytes, read at `now_ns`; at most kRoom at a time.
  void add(std::span<const std::uint8_t> bytes, core::TimeNs now_ns);
  /// The next request for the unit or for all units, unit to checksum; empty: none now. It is valid until the next
  /// call. A request for the unit after which something else came is left out: nobody waits for its answer any more.
  std::span<const std::uint8_t> take(core::TimeNs now_ns);
  /// When take() has something to do although nothing came; nothing: never.
  [[nodiscard]] std::optional<core::TimeNs> due() const;
  /// Forgets what is there: the line was opened anew.
  void clear();

  /// Frames with a good checksum, those of others too.
  [[nodiscard]] std::uint64_t frames() const { return frames_; }
  /// Times that something was dropped that was no frame.
  [[nodiscard]] std::uint64_t damaged() const { return damaged_; }
  static constexpr std::size_t kRoom = 512;

 private:
  enum class What : std::uint8_t { kNothing, kMore, kNoFrame, kRequest, kAnswer };
  struct Found {
    What what = What::kNothing;
    std::size_t begin = 0, size = 0;
  };
  [[nodiscard]] std::span<const std::uint8_t> rest() const { return std::span(bytes_).subspan(at_, size_ - at_); }
  [[nodiscard]] Found look() const;
  [[nodiscard]] Found look_at(std::size_t begin) const;
  [[nodiscard]] bool is_for_us(std::uint8_t unit) const { return unit == unit_ || unit == kBroadcast; }
  /// The line was silent for long enough: what is there is one frame, or nothing.
  std::span<const std::uint8_t> end_of_all();

  std::uint8_t unit_;
  core::TimeNs silence_ns_;
  std::array<std::uint8_t, kMaxFrame + kRoom> bytes_ = {};
  std::size_t at_ = 0, size_ = 0;  ///< what was not understood yet
  core::TimeNs last_ns_ = 0;       ///< when the last byte came
  bool lost_ = false;              ///< more came than fits: nothing counts up to a silence
  std::uint8_t asked_unit_ = 0;    ///< other unit whose answer may follow; 0 = none
  std::uint8_t asked_function_ = 0;
  std::uint64_t frames_ = 0, damaged_ = 0;
};

}  // namespace plc::modbus_rtu
