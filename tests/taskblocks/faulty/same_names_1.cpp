// With same_names_2.cpp: libraries of two authors who think alike.
#include "picard/taskblock.h"

struct Point {
  double x, y;
};
PICARD_STRUCT(Point, "POINT_2", x, y)

class Filter final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "FILTER_1", .group = "Same", .summary = "One filter."};
  picard::Output<Point> out{this, "OUT", "a point"};
  void fire() override { out->x = 1; }
};
PICARD_LIBRARY("same_names_1", "1.0.0", Filter)
