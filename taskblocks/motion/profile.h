// Point-to-point motion of one axis, planned while it moves: time-optimal profiles to a target or to rest from any
// state, and a follower that plans anew when what is wanted changes.
//
// In: numbers. Threads: one. Not here: ports (trapezoid.h, s_curve.h), several axes.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>

namespace plc::blocks {

/// Where an axis is, in units of length (u), u/s and u/s2.
struct MotionState {
  double position = 0;
  double speed = 0;
  double acceleration = 0;
};

/// All positive and finite. A profile with limited jerk uses `acceleration` for both directions.
struct MotionLimits {
  double speed = 1;         ///< u/s
  double acceleration = 1;  ///< u/s2, of the magnitude of the speed going up
  double deceleration = 1;  ///< u/s2, of it going down
  double jerk = 1;          ///< u/s3

  bool operator==(const MotionLimits&) const = default;
  [[nodiscard]] bool valid() const noexcept;
};

/// Phases of constant jerk, one after the other, from a state.
class Profile {
 public:
  Profile() = default;
  explicit Profile(const MotionState& start) noexcept : end_(start) {}

  /// The state at the end goes on for `seconds` with this acceleration, which may be another one than before, and
  /// jerk. Phases without duration leave no trace.
  void append(double seconds, double acceleration, double jerk) noexcept;
  /// As append(), from the acceleration there is.
  void append_jerk(double seconds, double jerk) noexcept { append(seconds, end_.acceleration, jerk); }
  /// The end is exactly there, at rest: planning knows it better than the sum of rounded phases does.
  void rest_at(double position) noexcept { end_ = {position, 0, 0}; }

  /// State `seconds` after the start; before it the start, after the end the end.
  [[nodiscard]] MotionState at(double seconds) const noexcept;
  [[nodiscard]] const MotionState& end() const noexcept { return end_; }
  [[nodiscard]] double duration() const noexcept { return duration_; }

 private:
  struct Phase {
    MotionState from;
    double begin = 0;  ///< seconds since the start of the profile
    double jerk = 0;
  };
  std::array<Phase, 8> phases_{};
  std::size_t count_ = 0;
  double duration_ = 0;
  MotionState end_{};
};

/// Limited speed, acceleration and deceleration; the acceleration of `from` does not matter.
/// RT: bounded.
[[nodiscard]] Profile plan_trapezoid(const MotionState& from, double target, const MotionLimits& limits) noexcept;
[[nodiscard]] Profile stop_trapezoid(const MotionState& from, const MotionLimits& limits) noexcept;

/// Limited speed, acceleration and jerk.
/// RT: bounded: a bisection over the doubles of one interval.
[[nodiscard]] Profile plan_s_curve(const MotionState& from, double target, const MotionLimits& limits) noexcept;
[[nodiscard]] Profile stop_s_curve(const MotionState& from, const MotionLimits& limits) noexcept;

/// Follows a target that may change at any time.
class Follower {
 public:
  using Plan = Profile (*)(const MotionState&, double, const MotionLimits&) noexcept;
  using Stop = Profile (*)(const MotionState&, const MotionLimits&) noexcept;
  Follower(Plan plan, Stop stop) noexcept : plan_(plan), stop_(stop) {}

  void start_at(double position) noexcept { profile_ = Profile({position, 0, 0}); }
  /// The state at `now` is that of the plan so far; when target, stop or limits are others than before, a new plan
  /// begins there. A target or limits that make no sense stop the axis within the last limits that did.
  /// RT: bounded.
  void step(std::chrono::nanoseconds now, double target, bool stop, const MotionLimits& limits) noexcept;

  [[nodiscard]] const MotionState& state() const noexcept { return state_; }
  [[nodiscard]] bool refused() const noexcept { return refused_; }
  /// At the target, at rest.
  [[nodiscard]] bool done() const noexcept { return done_; }
  [[nodiscard]] double seconds_left() const noexcept { return seconds_left_; }

 private:
  Plan plan_;
  Stop stop_;
  Profile profile_;
  MotionState state_;
  MotionLimits limits_;
  double target_ = 0;
  std::chrono::nanoseconds begin_{};
  double seconds_left_ = 0;
  bool planned_ = false;  ///< `target_`, `stopping_` and `limits_` are those of `profile_`
  bool known_ = false;    ///< `limits_` were valid once
  bool stopping_ = false;
  bool refused_ = false;
  bool done_ = false;
};

}  // namespace plc::blocks
