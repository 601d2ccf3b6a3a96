#include "tests/taskblocks/faulty/component.h"

namespace {
class Good final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Has no faults at all."};

 private:
  void misbehave() override {}
};
}  // namespace

PICARD_LIBRARY("good", "1.0.0", Good)
