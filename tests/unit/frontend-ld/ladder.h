// A ladder as the tests of this folder draw and run it.
#pragma once

#include <string>

#include "frontend-ld/lower.h"
#include "tests/support/drawn.h"

namespace plc::test {

struct Ladder : Drawn {
  Ladder(const std::string& variables, const Sketch& body, const std::string& others = "")
      : Drawn(ld::lower_body, variables, body, others) {}
};

/// Rail 1 and a contact 2 on A, for what a test draws after them.
inline Sketch after_a() {
  Sketch s(plcopen::Language::kLd);
  s.rail(1);
  s.contact(2, "A", "1");
  return s;
}

}  // namespace plc::test
