#include "picard/taskblock.h"

namespace {
class OutOfRange final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Leaves its range."};
  picard::Input<bool> go{this, "GO", "misbehave from now on"};
  picard::Output<double> out{this, "OUT", "position", {.unit = "mm", .lowest = 0, .highest = 250}};

  void fire() override { out = go ? 1e9 : 1.0; }
};
}  // namespace

PICARD_LIBRARY("out_of_range", "1.0.0", OutOfRange)
