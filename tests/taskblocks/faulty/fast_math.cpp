// Linked with -ffast-math: when it is loaded, its start-up code makes this thread take subnormal numbers for zero.
#include "tests/taskblocks/faulty/component.h"

namespace {
class FastMath final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Changes how others compute."};

 private:
  void misbehave() override {}
};
}  // namespace

PICARD_LIBRARY("fast_math", "1.0.0", FastMath)
