#include "ir/tests.h"

#include <algorithm>

namespace plc::ir {

const std::vector<TestCallInfo>& test_calls() {
  static const std::vector<TestCallInfo> kCalls = {
#define PLC_TEST_CALL(name, kind, arguments, summary) {name, TestCall::kind, arguments, summary},
#include "ir/test_calls.def"
  };
  return kCalls;
}

const TestCallInfo* test_call_named(std::string_view name) {
  const std::vector<TestCallInfo>& all = test_calls();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const TestCallInfo& one) { return core::iequals(one.name, name); });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace plc::ir
