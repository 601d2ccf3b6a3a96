#include <string>

#include "tests/taskblocks/faulty/component.h"

namespace {
class Allocates final : public faulty::Component {
 public:
  static constexpr picard::Info info{.name = "FAULTY", .group = "Faulty", .summary = "Allocates memory."};

 private:
  void misbehave() override { text_.append(100, 'x'); }
  std::string text_;
};
}  // namespace

PICARD_LIBRARY("allocates", "1.0.0", Allocates)
