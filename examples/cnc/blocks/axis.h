// A servo axis: the position loop with feed-forward, and a simulated drive with its machine to try it on.
//
// In: set points, once a period. Not here: ports, paths.
#pragma once

#include <cmath>

namespace cnc {

/// The plant: a drive that follows its speed command with a time constant, an axis that integrates the speed, an
/// encoder with steps. Transfer function of command to position: 1 / (s (1 + s T)).
class SimulatedAxis {
 public:
  /// `time_constant` and `period` in s, `resolution` in mm; all above zero.
  void start(double time_constant, double resolution, double period, double position) noexcept {
    resolution_ = resolution;
    period_ = period;
    time_constant_ = time_constant;
    decay_ = std::exp(-period / time_constant);
    position_ = position;
    speed_ = 0;
  }
  /// One period with a constant command, in mm/s: exact.
  void step(double command) noexcept {
    position_ += command * period_ + (speed_ - command) * time_constant_ * (1 - decay_);
    speed_ = command + (speed_ - command) * decay_;
  }
  [[nodiscard]] double position() const noexcept { return position_; }
  [[nodiscard]] double speed() const noexcept { return speed_; }
  [[nodiscard]] double encoder() const noexcept { return std::round(position_ / resolution_) * resolution_; }

 private:
  double resolution_ = 1;
  double period_ = 1;
  double time_constant_ = 1;
  double decay_ = 0;
  double position_ = 0;
  double speed_ = 0;
};

/// Proportional position loop; what the set point's speed and acceleration ask for is fed forward, so that the loop has
/// only what is left to do.
class PositionLoop {
 public:
  void start(double set_point) noexcept { before_ = before_that_ = set_point; }
  /// Speed command in mm/s. `gain` in 1/s; `speed_share` and `acceleration_time` (s) are what is fed forward of the set
  /// point's speed and acceleration: 1 and the drive's time constant make up for the drive.
  [[nodiscard]] double step(double set_point, double actual, double period, double gain, double speed_share,
                            double acceleration_time) noexcept {
    const double acceleration = (set_point - 2 * before_ + before_that_) / (period * period);
    // The command is for the period to come, in which the set point will be this fast, and not as fast as in the last.
    const double speed = (set_point - before_) / period + acceleration * period;
    before_that_ = before_;
    before_ = set_point;
    return gain * (set_point - actual) + speed_share * speed + acceleration_time * acceleration;
  }

 private:
  double before_ = 0;
  double before_that_ = 0;
};

}  // namespace cnc
