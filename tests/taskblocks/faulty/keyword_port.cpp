#include "picard/taskblock.h"

namespace {
class KeywordPort final : public picard::Taskblock {
 public:
  static constexpr picard::Info info{
      .name = "FAULTY", .group = "Faulty", .summary = "Has a port that nobody can name."};
  picard::Input<bool> program{this, "PROGRAM", "a keyword of declarations"};
  void fire() override {}
};
}  // namespace

PICARD_LIBRARY("keyword_port", "1.0.0", KeywordPort)
