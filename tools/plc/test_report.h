// What plc test prints: lines for people, TAP for harnesses, JUnit's XML for build servers.
//
// In: results of suites. Out: texts. Does not belong here: running (testing/).
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "testing/runner.h"

namespace plc::tools {

/// The tests of one project, or the runs of one case.
struct Suite {
  std::string name;
  std::vector<tests::TestResult> results;
  std::vector<std::string> errors;  ///< why tests of it could not run, a line each; the first is printed in reports
};

struct TestTotals {
  std::size_t tests = 0, failed = 0, broken = 0;  ///< broken: suites that could not run
  std::uint64_t checks = 0;
  [[nodiscard]] bool good() const { return failed == 0 && broken == 0; }
};
TestTotals totals_of(const std::vector<Suite>& suites);

/// "main.st:12:3: Main.Lamp: expected TRUE, got FALSE, after 1.2s, cycle 60: the lamp is on"
std::string failure_text(const tests::Failure& failure);

/// A line for each test and one for each failure of it.
void print_suite(const Suite& suite, std::ostream& out);
/// "12 tests, 1 failed, 40 checks".
std::string totals_text(const TestTotals& totals);
/// Test Anything Protocol, version 14.
void print_tap(const std::vector<Suite>& suites, std::ostream& out);
/// The XML that build servers know from JUnit.
std::string junit_xml(const std::vector<Suite>& suites);

}  // namespace plc::tools
