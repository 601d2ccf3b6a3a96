#include "taskblocks/motion/profile.h"

#include <algorithm>
#include <cmath>

namespace plc::blocks {

namespace {

/// What the clock cannot tell from nothing, in seconds.
constexpr double kTick = 1e-9;

bool positive(double value) noexcept { return std::isfinite(value) && value > 0; }

MotionState after(const MotionState& from, double jerk, double t) noexcept {
  return {from.position + t * (from.speed + t * (from.acceleration / 2 + t * jerk / 6)),
          from.speed + t * (from.acceleration + t * jerk / 2), from.acceleration + t * jerk};
}

/// The speed that is left when the acceleration is taken to zero at once.
double settled_speed(const MotionState& from, double jerk) noexcept {
  return from.speed + from.acceleration * std::fabs(from.acceleration) / (2 * jerk);
}

/// Changes of speed from a state to (speed, no acceleration) in the least time: at most three phases of constant jerk.
struct SpeedChange {
  std::array<double, 3> seconds{};
  std::array<double, 3> jerks{};

  SpeedChange(const MotionState& from, double speed, const MotionLimits& limits) noexcept {
    const double j = limits.jerk;
    const double sign = settled_speed(from, j) <= speed ? 1.0 : -1.0;
    const double a0 = sign * from.acceleration;
    const double gain = sign * (speed - from.speed);
    const double peak_squared = std::max(0.0, j * gain + a0 * a0 / 2);
    const double peak = std::sqrt(peak_squared);
    if (peak <= limits.acceleration) {
      seconds = {std::max(0.0, (peak - a0) / j), 0, peak / j};
      jerks = {sign * j, 0, -sign * j};
    } else {
      const double a = limits.acceleration;
      // WHY it may be negative: limits that were lowered while moving find a0 above them, and it has to go down first.
      const double ramp = a - a0;
      const double ramp_gain = std::fabs(ramp) / j * (a + a0) / 2;
      seconds = {std::fabs(ramp) / j, std::max(0.0, (gain - ramp_gain - a * a / (2 * j)) / a), a / j};
      jerks = {sign * std::copysign(j, ramp), 0, -sign * j};
    }
  }
  [[nodiscard]] double duration() const noexcept { return seconds[0] + seconds[1] + seconds[2]; }
  /// State after the first `t` seconds of it.
  [[nodiscard]] MotionState at(const MotionState& from, double t) const noexcept {
    MotionState state = from;
    for (std::size_t i = 0; i < 3; ++i) {
      const double part = std::min(t, seconds[i]);
      state = after(state, jerks[i], part);
      t -= part;
    }
    return state;
  }
  /// Appends the first `t` seconds.
  void append_to(Profile& profile, double t) const noexcept {
    for (std::size_t i = 0; i < 3; ++i) {
      const double part = std::min(t, seconds[i]);
      profile.append_jerk(part, jerks[i]);
      t -= part;
    }
  }
};

/// Where an axis comes to rest when it stops in the least time.
double rest_position(const MotionState& from, const MotionLimits& limits) noexcept {
  const SpeedChange stop(from, 0, limits);
  return stop.at(from, stop.duration()).position;
}

}  // namespace

bool MotionLimits::valid() const noexcept {
  return positive(speed) && positive(acceleration) && positive(deceleration) && positive(jerk);
}

void Profile::append(double seconds, double acceleration, double jerk) noexcept {
  end_.acceleration = acceleration;
  if (!(seconds > 0) || count_ == phases_.size()) return;
  phases_[count_++] = {end_, duration_, jerk};
  duration_ += seconds;
  end_ = after(end_, jerk, seconds);
}

MotionState Profile::at(double seconds) const noexcept {
  if (count_ == 0 || seconds >= duration_) return end_;
  std::size_t i = count_ - 1;
  while (i > 0 && phases_[i].begin > seconds) --i;
  return after(phases_[i].from, phases_[i].jerk, std::max(0.0, seconds - phases_[i].begin));
}

Profile stop_trapezoid(const MotionState& from, const MotionLimits& limits) noexcept {
  Profile profile(from);
  profile.append(std::fabs(from.speed) / limits.deceleration, -std::copysign(limits.deceleration, from.speed), 0);
  profile.rest_at(profile.end().position);
  return profile;
}

Profile plan_trapezoid(const MotionState& from, double target, const MotionLimits& limits) noexcept {
  const double a = limits.acceleration;
  const double d = limits.deceleration;
  const double braking = from.speed * std::fabs(from.speed) / (2 * d);
  const double sign = target - from.position - braking < 0 ? -1.0 : 1.0;
  // From here on the way that is left, and the speed, are counted in the direction in which the target lies.
  double v = sign * from.speed;
  double way = sign * (target - from.position);
  Profile profile(from);
  if (v < 0) {  // it goes away from the target: first to rest
    profile.append(-v / d, sign * d, 0);
    way += v * v / (2 * d);
    v = 0;
  } else if (v > limits.speed) {  // the limit was lowered
    profile.append((v - limits.speed) / d, -sign * d, 0);
    way -= (v * v - limits.speed * limits.speed) / (2 * d);
    v = limits.speed;
  }
  // peak^2 / (2 d) + (peak^2 - v^2) / (2 a) = way
  const double peak = std::clamp(std::sqrt(std::max(0.0, (2 * a * d * way + d * v * v) / (a + d))), v, limits.speed);
  profile.append((peak - v) / a, sign * a, 0);
  profile.append((way - peak * peak / (2 * d) - (peak * peak - v * v) / (2 * a)) / peak, 0, 0);
  profile.append(peak / d, -sign * d, 0);
  profile.rest_at(target);
  return profile;
}

Profile stop_s_curve(const MotionState& from, const MotionLimits& limits) noexcept {
  const SpeedChange stop(from, 0, limits);
  Profile profile(from);
  stop.append_to(profile, stop.duration());
  profile.rest_at(profile.end().position);
  return profile;
}

// The least time: push towards the target as hard as the limits allow for some time s, then stop as hard as they
// allow. The later the stop begins, the further it ends, so s is found by bisection; once s reaches full speed, the
// rest of the way is travelled at it and needs no search. The same idea, with the peak speed as what is searched for:
// R. Haschke, E. Weitnauer, H. Ritter, On-line planning of time-optimal, jerk-limited trajectories, IROS 2008.
Profile plan_s_curve(const MotionState& from, double target, const MotionLimits& limits) noexcept {
  const double sign = target < rest_position(from, limits) ? -1.0 : 1.0;
  const SpeedChange push(from, sign * limits.speed, limits);
  const MotionState fast = push.at(from, push.duration());
  const double cruising_way = sign * (target - rest_position(fast, limits));
  Profile profile(from);
  if (cruising_way >= 0) {
    push.append_to(profile, push.duration());
    profile.append(cruising_way / limits.speed, 0, 0);
  } else {
    double early = 0;
    double late = push.duration();
    for (int i = 0; i < 100; ++i) {
      const double middle = early + (late - early) / 2;
      if (middle <= early || middle >= late) break;
      const bool short_of = sign * (target - rest_position(push.at(from, middle), limits)) > 0;
      (short_of ? early : late) = middle;
    }
    push.append_to(profile, early);
  }
  const SpeedChange stop(profile.end(), 0, limits);
  stop.append_to(profile, stop.duration());
  profile.rest_at(target);
  return profile;
}

void Follower::step(std::chrono::nanoseconds now, double target, bool stop, const MotionLimits& limits) noexcept {
  const double elapsed = static_cast<double>((now - begin_).count()) * 1e-9;
  state_ = profile_.at(elapsed);

  refused_ = !std::isfinite(target) || !limits.valid();
  const bool stopping = stop || refused_;
  const MotionLimits& use = refused_ ? limits_ : limits;
  const bool changed = stopping != stopping_ || !(use == limits_) || (!stopping && target != target_);
  if (changed || !planned_) {
    if (!refused_) {
      limits_ = limits;
      known_ = true;
    }
    if (!stopping) target_ = target;
    stopping_ = stopping;
    // Without limits that ever made sense there was no motion that would have to end.
    if (known_) profile_ = stopping ? stop_(state_, limits_) : plan_(state_, target_, limits_);
    begin_ = now;
    planned_ = true;
    seconds_left_ = profile_.duration();
  } else {
    seconds_left_ = std::max(0.0, profile_.duration() - elapsed);
  }
  if (seconds_left_ < kTick) {
    seconds_left_ = 0;
    state_ = profile_.end();
  }
  done_ = !stopping_ && seconds_left_ <= 0;
}

}  // namespace plc::blocks
