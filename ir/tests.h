// Tests of a project: what TEST blocks call that nothing else may, and what a run of them has to know of each call.
//
// In: filled in by frontend-st while it lowers the tests (module.pous with Pou::test). Out: read by compiler/tests,
// handed to who runs them. A test runs in an image of its own, beside that of the project: its names of globals and
// programs stand for copies, which the runner keeps equal to the project's. Does not belong here: running (testing/).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "core/source_ref.h"
#include "core/text.h"

namespace plc::ir {

/// Statements of tests, in the order of test_calls.def.
enum class TestCall : std::uint8_t {
#define PLC_TEST_CALL(name, kind, arguments, summary) kind,
#include "ir/test_calls.def"
  kTestBegins,  ///< made by the compiler before the first statement of a test
};

struct TestCallInfo {
  std::string_view name;       ///< "ASSERT_EQ"
  TestCall call;               ///< what it is
  std::string_view arguments;  ///< "expected, actual"
  std::string_view summary;    ///< a sentence
};
/// Every row of test_calls.def.
const std::vector<TestCallInfo>& test_calls();
/// The row of this name, in any letter case; null when there is none.
const TestCallInfo* test_call_named(std::string_view name);

/// One call of an ASSERT_ in a text.
struct Assertion {
  TestCall call = TestCall::kAssertTrue;
  core::SourceRef at;
  std::uint32_t test = 0;  ///< into Module::pous
  std::string text;        ///< the value that is looked at, as written
  std::string message;     ///< what the test says of it, or empty
  /// Hidden variables of the test that hold the values when the assertion fails; empty where it has none.
  std::string expected, got, tolerance;
};

/// The type of the component through which a test talks to its runner, and the name of its instance in each test.
inline constexpr const char* kTestHostType = "PICARD_TEST_HOST";
inline constexpr const char* kTestHostName = "#host";
/// Inputs of the component: which call, which assertion, whether it holds, how many cycles, how long.
inline constexpr const char* kTestHostCall = "CALL";
inline constexpr const char* kTestHostSite = "SITE";
inline constexpr const char* kTestHostHolds = "HOLDS";
inline constexpr const char* kTestHostCycles = "CYCLES";
inline constexpr const char* kTestHostSpan = "SPAN";
inline constexpr const char* kTestHostDate = "DATE_UTC";

/// What the tests of a module have beside their bodies.
struct TestBench {
  /// Program instances by name, and programs with one instance by theirs: globals that only tests see (Global::mirror).
  std::unordered_map<std::string, std::uint32_t, core::NameHash, core::NameEqual> programs;
  std::vector<Assertion> assertions;
  bool runs_tasks = false;  ///< the project has a task with a program
};

}  // namespace plc::ir
