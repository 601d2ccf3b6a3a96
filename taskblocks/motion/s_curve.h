// S_CURVE: point-to-point motion of one axis with limited speed, acceleration and jerk.
#pragma once

#include "picard/taskblock.h"
#include "taskblocks/motion/profile.h"

namespace plc::blocks {

class SCurve final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "S_CURVE",
      .group = "Motion",
      .summary = "Moves to a target with limited speed, acceleration and jerk.",
      .details =
          "Time-optimal in up to seven phases of constant jerk: acceleration grows with MAX_JERK to MAX_ACC, falls "
          "to zero at MAX_SPEED, and the same downwards; short ways leave phases out. The axis is at TARGET exactly, "
          "at rest. A way D that reaches all limits takes D / MAX_SPEED + MAX_SPEED / MAX_ACC + MAX_ACC / MAX_JERK "
          "seconds, one that reaches none 4 (D / (2 MAX_JERK))^(1/3). Lengths are in any unit u.\n\n"
          "TARGET and the limits may change while it moves, with any speed and acceleration: the plan is made anew "
          "from there. A target that is passed by then is reached by stopping and coming back. Limits hold at every "
          "moment; a limit that was lowered while moving holds as soon as MAX_JERK allows.\n\n"
          "STOP comes to rest in the least time and rests where that ends; without STOP it goes on to TARGET.\n\n"
          "The first cycle gives START. A change shows in POSITION one cycle later. Time is that of the task's "
          "clock, so event tasks get the position of the moment in which they run.\n\n"
          "A limit that is not above zero, or a target or limit that is not a number, sets ERROR and stops the axis "
          "within the last limits that were right."};

  picard::Input<double> target{this, "TARGET", "where to go", {.unit = "u"}};
  picard::Input<double> max_speed{this, "MAX_SPEED", "highest speed", {.unit = "u/s", .initial = "1.0"}};
  picard::Input<double> max_acc{this, "MAX_ACC", "highest acceleration", {.unit = "u/s2", .initial = "1.0"}};
  picard::Input<double> max_jerk{this, "MAX_JERK", "highest jerk", {.unit = "u/s3", .initial = "10.0"}};
  picard::Input<bool> stop{this, "STOP", "come to rest and stay"};
  picard::Config<double> start{this, "START", "position at the start", {.unit = "u"}};
  picard::Output<double> position{this, "POSITION", "set point", {.unit = "u"}};
  picard::Output<double> speed{this, "SPEED", "its derivative", {.unit = "u/s"}};
  picard::Output<double> acceleration{this, "ACC", "and the derivative of that", {.unit = "u/s2"}};
  picard::Output<bool> done{this, "DONE", "at TARGET, at rest"};
  picard::Output<double> time_left{this, "TIME_LEFT", "until it is at rest", {.unit = "s"}};
  picard::Output<bool> error{this, "ERROR", "TARGET or a limit makes no sense"};

  void ready() override {
    if (start * 0 != 0) throw picard::Failure("S_CURVE: START is not a finite number");
    follower_.start_at(start);
  }

  void fire() override {
    follower_.step(now(), target, stop, {max_speed, max_acc, max_acc, max_jerk});
    position = follower_.state().position;
    speed = follower_.state().speed;
    acceleration = follower_.state().acceleration;
    done = follower_.done();
    time_left = follower_.seconds_left();
    error = follower_.refused();
  }

 private:
  Follower follower_{plan_s_curve, stop_s_curve};
};

}  // namespace plc::blocks
