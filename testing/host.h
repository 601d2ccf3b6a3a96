// The component through which a test talks to its runner: every call of ir/test_calls.def that is not plain code.
//
// In: inputs that the compiler fills in (ir/tests.h), one fire() for each call. Out: the same as a call of the runner.
// Threads: that of the test. Does not belong here: what the calls do (runner.h).
#pragma once

#include <cstdint>

#include "core/clock.h"
#include "ir/tests.h"
#include "picard/abi.h"

namespace plc::tests {

/// What a test says with one call.
struct HostCall {
  ir::TestCall call = ir::TestCall::kAssertTrue;
  std::uint32_t site = 0;    ///< of assertions: into TestImage::assertions
  bool holds = false;        ///< of assertions
  std::int64_t cycles = 0;   ///< RUN_CYCLES
  core::TimeNs span_ns = 0;  ///< ADVANCE_TIME
  core::TimeNs utc_ns = 0;   ///< SET_CLOCK
};

class HostListener {
 public:
  virtual ~HostListener() = default;
  /// False: the test ends here.
  virtual bool on_call(const HostCall& call) = 0;
};

/// The library with the component, for the registry that tests are compiled and loaded with.
const picard_library* host_library();

/// While it lives, components that this thread makes talk to `listener`.
class HostScope {
 public:
  explicit HostScope(HostListener& listener);
  ~HostScope();
  HostScope(const HostScope&) = delete;
  HostScope& operator=(const HostScope&) = delete;
};

}  // namespace plc::tests
