#include "picard/taskblock.h"

struct Point {
  double x, y, z;
};
PICARD_STRUCT(Point, "POINT_3", x, y, z)

class Filter final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "FILTER_2", .group = "Same", .summary = "Another filter."};
  picard::Output<Point> out{this, "OUT", "a point"};
  void fire() override { out->z = 1; }
};
PICARD_LIBRARY("same_names_2", "1.0.0", Filter)
