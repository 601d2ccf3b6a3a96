// An instruction list as the tests of this folder write and run it.
#pragma once

#include <string>

#include "frontend-il/text.h"
#include "tests/support/drawn.h"

namespace plc::test {

struct Listed : Drawn {
  Listed(const std::string& variables, const std::string& body, const std::string& others = "")
      : Drawn(il::lower_body, variables, body, others) {
    diagnostics.mute(core::Code::P4501);
  }
};

}  // namespace plc::test
