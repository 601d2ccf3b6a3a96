// TRAPEZOID: point-to-point motion of one axis with limited speed, acceleration and deceleration.
#pragma once

#include "picard/taskblock.h"
#include "taskblocks/motion/profile.h"

namespace plc::blocks {

class Trapezoid final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "TRAPEZOID",
      .group = "Motion",
      .summary = "Moves to a target with limited speed, acceleration and deceleration.",
      .details =
          "Time-optimal: speeds up with MAX_ACC, travels at MAX_SPEED, slows down with MAX_DEC and is at TARGET "
          "exactly, at rest. A way D too short for MAX_SPEED is travelled with the peak speed sqrt(2 D MAX_ACC "
          "MAX_DEC / (MAX_ACC + MAX_DEC)). Lengths are in any unit u.\n\n"
          "TARGET and the limits may change while it moves: the plan is made anew from where the axis is. A target "
          "that is passed by then is reached by stopping and coming back. A speed above a limit that was lowered "
          "goes down with MAX_DEC. SPEED is never above MAX_SPEED otherwise, and neither are differences of "
          "POSITION.\n\n"
          "STOP slows down with MAX_DEC and rests where that ends; without STOP it goes on to TARGET.\n\n"
          "The first cycle gives START. A change shows in POSITION one cycle later. Time is that of the task's "
          "clock, so event tasks get the position of the moment in which they run.\n\n"
          "A limit that is not above zero, or a target or limit that is not a number, sets ERROR and stops the axis "
          "within the last limits that were right."};

  picard::Input<double> target{this, "TARGET", "where to go", {.unit = "u"}};
  picard::Input<double> max_speed{this, "MAX_SPEED", "highest speed", {.unit = "u/s", .initial = "1.0"}};
  picard::Input<double> max_acc{
      this, "MAX_ACC", "acceleration while the speed goes up", {.unit = "u/s2", .initial = "1.0"}};
  picard::Input<double> max_dec{
      this, "MAX_DEC", "acceleration while the speed goes down", {.unit = "u/s2", .initial = "1.0"}};
  picard::Input<bool> stop{this, "STOP", "come to rest and stay"};
  picard::Config<double> start{this, "START", "position at the start", {.unit = "u"}};
  picard::Output<double> position{this, "POSITION", "set point", {.unit = "u"}};
  picard::Output<double> speed{this, "SPEED", "its derivative", {.unit = "u/s"}};
  picard::Output<double> acceleration{this, "ACC", "and the derivative of that", {.unit = "u/s2"}};
  picard::Output<bool> done{this, "DONE", "at TARGET, at rest"};
  picard::Output<double> time_left{this, "TIME_LEFT", "until it is at rest", {.unit = "s"}};
  picard::Output<bool> error{this, "ERROR", "TARGET or a limit makes no sense"};

  void ready() override {
    if (start * 0 != 0) throw picard::Failure("TRAPEZOID: START is not a finite number");
    follower_.start_at(start);
  }

  void fire() override {
    // Jerk is no limit here, but must be a valid one.
    follower_.step(now(), target, stop, {max_speed, max_acc, max_dec, 1.0});
    position = follower_.state().position;
    speed = follower_.state().speed;
    acceleration = follower_.state().acceleration;
    done = follower_.done();
    time_left = follower_.seconds_left();
    error = follower_.refused();
  }

 private:
  Follower follower_{plan_trapezoid, stop_trapezoid};
};

}  // namespace plc::blocks
