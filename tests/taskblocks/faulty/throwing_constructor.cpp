#include <stdexcept>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Throws final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Cannot be made."};
  Throws() { throw std::runtime_error("no such device"); }

 private:
  void misbehave() override {}
};
}  // namespace

PICARD_LIBRARY("throwing_constructor", "1.0.0", Throws)
