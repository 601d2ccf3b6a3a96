// Time is injected: everything that knows time takes a Clock. MonotonicClock in production, VirtualClock in tests and
// simulation. All times are nanoseconds since the clock's own origin; wall-clock steps never move it. The date and time
// of day are another clock, a Calendar: it can be set, so nothing is measured with it.
#pragma once

#include <cstdint>

namespace plc::core {

using TimeNs = std::int64_t;

class Clock {
 public:
  virtual ~Clock() = default;
  /// Nanoseconds since the origin. RT: one vDSO call at most.
  [[nodiscard]] virtual TimeNs now_ns() const noexcept = 0;
  /// Blocks until now_ns() >= deadline_ns or an interruption. RT: the one blocking call a task makes.
  virtual void sleep_until_ns(TimeNs deadline_ns) noexcept = 0;
};

/// CLOCK_MONOTONIC; sleeps with clock_nanosleep(TIMER_ABSTIME).
class MonotonicClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now_ns() const noexcept override;
  void sleep_until_ns(TimeNs deadline_ns) noexcept override;
};

/// Starts at 0 and moves only when told to; sleeping jumps to the deadline. One thread.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] TimeNs now_ns() const noexcept override { return now_ns_; }
  void sleep_until_ns(TimeNs deadline_ns) noexcept override {
    if (deadline_ns > now_ns_) now_ns_ = deadline_ns;
  }

 private:
  TimeNs now_ns_ = 0;
};

/// Date and time, UTC in nanoseconds since 1970-01-01. Steps forwards and backwards, as NTP and people set it.
class Calendar {
 public:
  virtual ~Calendar() = default;
  /// RT: one vDSO call at most. Any thread.
  [[nodiscard]] virtual TimeNs utc_ns() const noexcept = 0;
};

/// CLOCK_REALTIME.
class SystemCalendar final : public Calendar {
 public:
  [[nodiscard]] TimeNs utc_ns() const noexcept override;
};

}  // namespace plc::core
