#include <atomic>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Spins final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Never comes to an end."};

 private:
  void misbehave() override {
    static std::atomic<bool> never{false};
    while (!never) {
    }
  }
};
}  // namespace

PICARD_LIBRARY("spins", "1.0.0", Spins)
