#include <cstdint>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Crashes final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Cannot be made."};
  Crashes() { *reinterpret_cast<volatile int*>(std::uintptr_t{0x10}) = 1; }

 private:
  void misbehave() override {}
};
}  // namespace

PICARD_LIBRARY("crashing_constructor", "1.0.0", Crashes)
