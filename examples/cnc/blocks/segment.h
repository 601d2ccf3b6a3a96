// What the interpreter puts into the queue and the interpolator takes out: one step of a part program, with everything
// that is modal in the text already applied.
#pragma once

#include <array>
#include <cstdint>

#include "picard/taskblock.h"

namespace cnc {

/// Along the path everything is in mm, s and rad; positions are absolute.
struct Segment {
  enum Kind : std::int32_t {
    kRapid = 0,  ///< straight to `end`, as fast as the axes can
    kLine = 1,   ///< straight to `end` with `feed`
    kArc = 2,    ///< around `centre` by `sweep`, Z evenly along with it
    kDwell = 3,  ///< at rest for `seconds`
    kCode = 4,   ///< at rest, `code` is given to the PLC, which has to confirm it
    kEnd = 5     ///< the program is over
  };
  std::int32_t kind = kEnd;
  std::int32_t line = 0;  ///< of the part program, from 1
  std::int32_t code = 0;  ///< the M-code
  std::array<double, 3> end{};
  std::array<double, 2> centre{};  ///< X and Y
  double sweep = 0;                ///< positive counter-clockwise, seen from above; a full circle is 2 pi
  double feed = 0;                 ///< mm/s along the path
  double seconds = 0;
  double spindle = 0;  ///< 1/min, the S there is at this point
};

}  // namespace cnc

PICARD_STRUCT(cnc::Segment, "CNC_SEGMENT", kind, line, code, end, centre, sweep, feed, seconds, spindle)
