// Three ways to end a process, which the runtime cannot contain.
#include <cstdint>
#include <cstdlib>

#include "tests/taskblocks/faulty/component.h"

namespace {
class WildPointer final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Writes through a wild pointer."};

 private:
  void misbehave() override { *reinterpret_cast<volatile int*>(std::uintptr_t{0x10}) = 1; }
};

class Aborts final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "ABORTS", .group = "Faulty", .summary = "Fails an assertion."};

 private:
  void misbehave() override { std::abort(); }
};

class Recurses final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "RECURSES", .group = "Faulty", .summary = "Uses up the stack."};

 private:
  static int deeper(volatile int* from) {
    volatile int here[1024];
    here[0] = *from + 1;
    return here[0] == 0 ? 0 : deeper(here) + here[0];
  }
  void misbehave() override {
    volatile int start = 1;
    out = deeper(&start);
  }
};
}  // namespace

PICARD_LIBRARY("crashes", "1.0.0", WildPointer, Aborts, Recurses)
