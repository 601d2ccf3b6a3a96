// INTERPOLATOR: set points of three axes from the segments in a queue.
#pragma once

#include <cstdint>

#include "interpolator.h"
#include "picard/taskblock.h"

namespace cnc {

class InterpolatorBlock final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "INTERPOLATOR",
      .group = "CNC",
      .summary = "Moves three axes along the segments in a queue, within their speeds and accelerations.",
      .details =
          "Needs a periodic task; each cycle gives one set point. Lines and arcs are followed exactly; the corner "
          "between two lines becomes an arc that is nowhere further than DEVIATION from the corner, with the radius "
          "that the feed needs and no larger one. Corners with an arc that is not tangent are passed as good as at "
          "rest. It looks ahead over 126 pieces of path, so that it can stop at the end of what is known. A cycle "
          "passes four of them at most: lines of 0.002 mm are travelled with 8 mm/s at 1 kHz.\n\n"
          "No axis exceeds MAX_SPEED and MAX_ACC, whatever happens: not in corners, not on arcs (where the speed is "
          "lowered), not when OVERRIDE changes, not on a stop.\n\n"
          "HOLD brakes on the path and goes on when it is gone. LIMIT does the same but stays (LIMITED) until RESET. "
          "RESET brakes and forgets all segments, also those in the queue; keep it TRUE until GCODE no longer runs, "
          "or more of the same program may come. OVERRIDE multiplies the feed, from 0 (a hold) to 2; rapids follow "
          "it below 1.\n\n"
          "Without ENABLE the drives are off: the set points are ACTUAL, so that the drives find themselves where they "
          "shall be when they come back, and the program is forgotten as by RESET.\n\n"
          "At an M-code the axes are at rest: CODE has it, STROBE becomes TRUE; the PLC acts and sets CODE_DONE; "
          "STROBE becomes FALSE; the PLC takes CODE_DONE back; the program goes on."};

  picard::QueueReader<Segment> path{this, "PATH", "the segments"};
  picard::Config<Vector> max_speed{this, "MAX_SPEED", "of X, Y and Z", {.unit = "mm/s"}};
  picard::Config<Vector> max_acc{this, "MAX_ACC", "acceleration of X, Y and Z", {.unit = "mm/s2"}};
  picard::Config<double> deviation{
      this, "DEVIATION", "of rounded corners", {.unit = "mm", .lowest = 1e-6, .initial = "0.01"}};
  picard::Config<Vector> home{this, "HOME", "position at the start", {.unit = "mm"}};
  picard::Input<double> override_factor{this, "OVERRIDE", "of the feed", {.lowest = 0, .highest = 2, .initial = "1.0"}};
  picard::Input<bool> hold{this, "HOLD", "feed hold"};
  picard::Input<bool> limit{this, "LIMIT", "a limit switch is met"};
  picard::Input<bool> reset{this, "RESET", "forget the rest of the program"};
  picard::Input<bool> enable{this, "ENABLE", "the drives are on", {.initial = "TRUE"}};
  picard::Input<double> actual[3]{{this, "ACTUAL_X", "where the axis is, for ENABLE", {.unit = "mm"}},
                                  {this, "ACTUAL_Y", "where the axis is, for ENABLE", {.unit = "mm"}},
                                  {this, "ACTUAL_Z", "where the axis is, for ENABLE", {.unit = "mm"}}};
  picard::Input<bool> code_done{this, "CODE_DONE", "the PLC has done what CODE asks for"};
  picard::Output<double> x{this, "X", "set point", {.unit = "mm"}};
  picard::Output<double> y{this, "Y", "set point", {.unit = "mm"}};
  picard::Output<double> z{this, "Z", "set point", {.unit = "mm"}};
  picard::Output<double> speed{this, "SPEED", "along the path", {.unit = "mm/s"}};
  picard::Output<double> spindle{this, "SPINDLE", "speed that the program asks for (S)", {.unit = "1/min"}};
  picard::Output<std::int32_t> line{this, "LINE", "of the part program, that is being travelled"};
  picard::Output<std::int32_t> code{this, "CODE", "the last M-code"};
  picard::Output<bool> strobe{this, "STROBE", "CODE waits for the PLC"};
  picard::Output<bool> held{this, "HELD", "at rest because of HOLD, LIMIT or RESET"};
  picard::Output<bool> limited{this, "LIMITED", "LIMIT was met; until RESET"};
  picard::Output<bool> done{this, "DONE", "the program is over"};

  void ready() override {
    if (!(period() > 0)) throw picard::Failure("INTERPOLATOR: its task must be periodic");
    const PathLimits limits{max_speed, max_acc, deviation, period()};
    if (!limits.valid()) {
      throw picard::Failure("INTERPOLATOR: MAX_SPEED and MAX_ACC of all three axes, and DEVIATION, must be above zero");
    }
    for (const double position : *home) {
      if (position * 0 != 0) throw picard::Failure("INTERPOLATOR: HOME must be finite numbers");
    }
    core_.start(limits, home);
  }

  void fire() override {
    Segment segment;
    const bool dropping = core_.resetting() || reset || !enable;
    for (int i = 0; i < kSegmentsPerCycle && (dropping || core_.wants_segment()) && path.pop(segment); ++i) {
      if (!dropping) core_.add(segment);
    }
    if (!enable) core_.place({actual[0], actual[1], actual[2]});
    core_.step({override_factor, hold, limit, reset, code_done}, path.count() == 0);
    x = core_.position()[0];
    y = core_.position()[1];
    z = core_.position()[2];
    speed = core_.speed();
    spindle = core_.spindle();
    line = core_.line();
    code = core_.code();
    strobe = core_.code_strobe();
    held = core_.held();
    limited = core_.limited();
    done = core_.program_done();
  }

 private:
  static constexpr int kSegmentsPerCycle = 8;
  Interpolator core_;
};

}  // namespace cnc
