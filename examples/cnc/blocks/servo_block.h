// SERVO: position loop of one axis, with the axis itself simulated.
#pragma once

#include <cmath>

#include "axis.h"
#include "picard/taskblock.h"

namespace cnc {

class ServoBlock final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "SERVO",
      .group = "CNC",
      .summary = "Position loop with feed-forward, and a simulated axis with drive, encoder and limit switches.",
      .details =
          "COMMAND = GAIN (SET - ACTUAL) + SPEED_SHARE dSET/dt + ACC_TIME d2SET/dt2. The simulated drive follows "
          "COMMAND with TIME_CONSTANT, the axis integrates, the encoder counts steps of RESOLUTION: ACTUAL = steps "
          "of 1 / (s (1 + s TIME_CONSTANT)) COMMAND. SPEED_SHARE = 1 and ACC_TIME = TIME_CONSTANT make up for the "
          "drive; without them the axis lags by speed / GAIN.\n\n"
          "EXCESS is set when FOLLOWING_ERROR was above MAX_ERROR or SET no number, and stays until ENABLE is FALSE. "
          "With EXCESS, or without ENABLE, COMMAND is 0 and the drive stops by itself; with ENABLE again SET must be "
          "ACTUAL, or the axis goes there without a ramp. AT_LOW and AT_HIGH are the limit switches: ACTUAL is at "
          "LOW or HIGH, or beyond. Needs a periodic task."};

  picard::Input<double> set{this, "SET", "set point", {.unit = "mm"}};
  picard::Input<bool> enable{this, "ENABLE", "the loop is closed", {.initial = "TRUE"}};
  picard::Input<double> gain{this, "GAIN", "of the position loop", {.unit = "1/s", .lowest = 0, .initial = "50.0"}};
  picard::Input<double> speed_share{this, "SPEED_SHARE", "feed-forward of the speed", {.initial = "1.0"}};
  picard::Input<double> acc_time{
      this, "ACC_TIME", "feed-forward of the acceleration", {.unit = "s", .initial = "0.005"}};
  picard::Config<double> time_constant{
      this, "TIME_CONSTANT", "of the simulated drive", {.unit = "s", .lowest = 1e-6, .initial = "0.005"}};
  picard::Config<double> resolution{
      this, "RESOLUTION", "one step of the encoder", {.unit = "mm", .lowest = 1e-9, .initial = "0.001"}};
  picard::Config<double> home{this, "HOME", "position at the start", {.unit = "mm"}};
  picard::Config<double> low{this, "LOW", "place of the lower limit switch", {.unit = "mm", .initial = "-1.0E6"}};
  picard::Config<double> high{this, "HIGH", "place of the upper limit switch", {.unit = "mm", .initial = "1.0E6"}};
  picard::Config<double> max_error{
      this, "MAX_ERROR", "highest following error", {.unit = "mm", .lowest = 0, .initial = "1.0"}};
  picard::Output<double> actual{this, "ACTUAL", "what the encoder says", {.unit = "mm"}};
  picard::Output<double> command{this, "COMMAND", "to the drive", {.unit = "mm/s"}};
  picard::Output<double> following_error{this, "FOLLOWING_ERROR", "SET - ACTUAL", {.unit = "mm"}};
  picard::Output<bool> excess{this, "EXCESS", "FOLLOWING_ERROR was too large"};
  picard::Output<bool> at_low{this, "AT_LOW", "lower limit switch"};
  picard::Output<bool> at_high{this, "AT_HIGH", "upper limit switch"};

  void ready() override {
    if (!(period() > 0)) throw picard::Failure("SERVO: its task must be periodic");
    if (!(time_constant > 0 && std::isfinite(time_constant) && resolution > 0 && std::isfinite(resolution))) {
      throw picard::Failure("SERVO: TIME_CONSTANT and RESOLUTION must be above zero");
    }
    if (!std::isfinite(home) || !(low < high))
      throw picard::Failure("SERVO: LOW must be below HIGH, and HOME a number");
    axis_.start(time_constant, resolution, period(), home);
    loop_.start(home);
  }

  void fire() override {
    axis_.step(command);  // what was commanded in the last cycle
    actual = axis_.encoder();
    following_error = set - actual;
    at_low = actual <= low;
    at_high = actual >= high;
    excess = enable && (excess || !(std::fabs(following_error) <= max_error));
    if (enable && !excess) {
      const double wanted = loop_.step(set, actual, period(), gain, speed_share, acc_time);
      command = std::isfinite(wanted) ? wanted : 0;
    } else {
      loop_.start(actual);
      command = 0;
    }
  }

 private:
  SimulatedAxis axis_;
  PositionLoop loop_;
};

}  // namespace cnc
