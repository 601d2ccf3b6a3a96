#include <stdexcept>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Throws final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Throws."};

 private:
  void misbehave() override { throw std::runtime_error("pressure sensor gone"); }
};
}  // namespace

PICARD_LIBRARY("throws", "1.0.0", Throws)
