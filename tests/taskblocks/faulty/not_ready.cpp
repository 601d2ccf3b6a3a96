#include <csignal>

#include "tests/taskblocks/faulty/component.h"

namespace {
class NotReady : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Is not ready."};
  void ready() override { throw picard::Failure("no licence on this machine"); }

 private:
  void misbehave() override {}
};

class CrashesBefore final : public NotReady {
 public:
  static constexpr picard::Info info{.name = "CRASHES_BEFORE", .group = "Faulty", .summary = "Crashes in ready()."};
  void ready() override { std::raise(SIGSEGV); }
};
}  // namespace

PICARD_LIBRARY("not_ready", "1.0.0", NotReady, CrashesBefore)
