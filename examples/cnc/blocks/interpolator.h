// Set points of three axes along the segments of a part program: looks ahead over what is queued, goes as fast as feed,
// axes and corners allow, and stops for a feed hold or a limit switch on the path and within the accelerations.
//
// In: segments, one after the other; once a cycle the command. Out: position, speed, M-codes for the PLC.
// Threads: one. Not here: queues, ports.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "element.h"

namespace cnc {

class Interpolator {
 public:
  /// What the machine wants in this cycle.
  struct Command {
    double override_factor = 1;  ///< of the feed, 1 = as programmed; rapids are never faster than 1
    bool hold = false;           ///< come to rest on the path, go on when it is gone
    bool limit = false;          ///< come to rest on the path and stay, until reset
    bool reset = false;          ///< come to rest and forget the rest of the program
    bool code_done = false;      ///< the PLC's answer to `code_strobe`
  };

  /// `limits` are valid().
  void start(const PathLimits& limits, const Vector& position) noexcept;

  /// The drives were off, and the axes are here: forgets the program.
  void place(const Vector& position) noexcept;

  /// Is there room for one more segment?
  [[nodiscard]] bool wants_segment() const noexcept { return count_ + kMostOfASegment <= kCapacity; }
  /// RT: bounded.
  void add(const Segment& segment) noexcept;

  /// One cycle of `limits.period` seconds. `dry`: there is no further segment to be had now. A reset ends when it is.
  /// RT: bounded by the number of elements that a cycle can touch, and by the look-ahead.
  void step(const Command& command, bool dry) noexcept;

  [[nodiscard]] const Vector& position() const noexcept { return position_; }
  [[nodiscard]] double speed() const noexcept { return speed_; }       ///< mm/s along the path
  [[nodiscard]] double spindle() const noexcept { return spindle_; }   ///< 1/min
  [[nodiscard]] std::int32_t line() const noexcept { return line_; }   ///< of the part program
  [[nodiscard]] std::int32_t code() const noexcept { return code_; }   ///< the last M-code
  [[nodiscard]] bool code_strobe() const noexcept { return strobe_; }  ///< it waits for the PLC
  [[nodiscard]] bool held() const noexcept { return held_; }           ///< at rest because of a hold or limit
  [[nodiscard]] bool limited() const noexcept { return limited_; }     ///< a limit was met; until reset
  [[nodiscard]] bool program_done() const noexcept { return done_; }   ///< the end was reached; until the next segment
  /// Segments that come now belong to what was reset: take them and drop them.
  [[nodiscard]] bool resetting() const noexcept { return resetting_; }
  [[nodiscard]] std::size_t elements() const noexcept { return count_; }

 private:
  static constexpr std::size_t kCapacity = 128;
  /// The segment before it, a rounding, itself when it is no motion.
  static constexpr std::size_t kMostOfASegment = 3;
  /// So long the last segment waits for its successor before it is travelled to its end and stop.
  static constexpr double kPatience = 0.05;

  struct Phase {
    double acceleration = 0;
    double seconds = 0;
  };

  void push(const Element& element) noexcept;
  void close_pending() noexcept;
  Element& at(std::size_t i) noexcept { return elements_[(head_ + i) % kCapacity]; }
  [[nodiscard]] double cap(const Element& element) const noexcept;
  void look_ahead() noexcept;
  [[nodiscard]] Phase phase(const Element& element, double most_seconds) const noexcept;
  void travel(double seconds) noexcept;
  bool pass_special(const Command& command) noexcept;
  void drop_head() noexcept;
  void forget() noexcept;

  PathLimits limits_;
  std::array<Element, kCapacity> elements_{};
  std::array<double, kCapacity> exits_{};  ///< mm/s at the end of at(i), so that all that follows can be braked for
  std::size_t head_ = 0;
  std::size_t count_ = 0;
  Element pending_;  ///< the last segment, whose end the next one may round
  double pending_length_ = 0;
  bool has_pending_ = false;
  double dry_seconds_ = 0;
  Vector added_to_{};  ///< end of the last segment

  double way_ = 0;  ///< mm, on at(0)
  double speed_ = 0;
  double factor_ = 1;
  bool braking_ = false;
  Vector position_{};
  double waited_ = 0;
  double spindle_ = 0;
  std::int32_t line_ = 0;
  std::int32_t code_ = 0;
  bool strobe_ = false;
  bool answered_ = false;  ///< the PLC has confirmed, and takes its answer back next
  bool held_ = false;
  bool limited_ = false;
  bool done_ = false;
  bool resetting_ = false;
};

}  // namespace cnc
