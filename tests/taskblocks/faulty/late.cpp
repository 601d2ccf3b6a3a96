#include <thread>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Late final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY",
                                     .group = "Faulty",
                                     .summary = "Takes longer than it declares.",
                                     .budget = std::chrono::milliseconds(5)};

 private:
  void misbehave() override { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }
};
}  // namespace

PICARD_LIBRARY("late", "1.0.0", Late)
