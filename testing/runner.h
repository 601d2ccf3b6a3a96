// Runner: runs the tests of one compilation in virtual time, each from a cold start.
//
// In: images of a project and of its tests. Out: for each test what failed, with place, expected and got. A test is a
// scan of the tests' task in the interpreter; what it calls (host.h) lets the project's tasks run in between, at their
// release instants, and virtual time go on. Threads: one. Does not belong here: which files, formats of reports.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compiler/compile.h"
#include "core/result.h"
#include "runtime/resource.h"
#include "runtime/sched/simulation.h"
#include "testing/host.h"
#include "testing/mirror.h"

namespace plc::tests {

/// One thing that was not as expected.
struct Failure {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  std::string what;      ///< "Main.pump.Running": what was looked at, or a sentence where nothing was expected
  std::string expected;  ///< empty where nothing was expected
  std::string got;
  std::string message;      ///< what the test says of it, or empty
  core::TimeNs at_ns = 0;   ///< virtual time
  std::uint64_t cycle = 0;  ///< release instants before it
};

struct TestResult {
  std::string name;
  std::string file;
  std::uint32_t line = 0;
  std::vector<Failure> failures;    ///< the first kMaxFailuresKept
  std::uint64_t failure_count = 0;  ///< all of them
  std::uint64_t checks = 0;         ///< assertions, or cells of a table
  std::uint64_t cycles = 0;         ///< release instants that ran
  core::TimeNs virtual_ns = 0;      ///< how far time went
  core::TimeNs took_ns = 0;         ///< on the machine's clock
  [[nodiscard]] bool passed() const { return failure_count == 0; }
};
inline constexpr std::size_t kMaxFailuresKept = 20;
void add_failure(TestResult& result, Failure failure);

struct RunnerOptions {
  runtime::ProgramOptions program;        ///< of the project's tasks
  core::TimeNs date_ns = 0;               ///< date and time at the start of each test, UTC
  std::uint64_t max_cycles = kMaxCycles;  ///< release instants that one test may run
  static constexpr std::uint64_t kMaxCycles = 10'000'000;
  /// Prepares the project's resource before it runs, for an engine other than the interpreter.
  std::function<std::optional<core::Problem>(runtime::Resource&)> prepare;
};

class Runner final : public HostListener {
 public:
  /// Loads the images of a compilation with tests and without errors. The registry has the project's taskblocks and
  /// host_library(), and must outlive the runner.
  static core::Result<std::unique_ptr<Runner>> make(compiler::Compilation compilation,
                                                    const taskblocks::Registry& registry, RunnerOptions options);

  [[nodiscard]] const std::vector<compiler::TestInfo>& tests() const { return tests_; }
  /// Runs one test from a cold start. P7803 when a taskblock of the project does not start.
  core::Result<TestResult> run(std::size_t test);

  /// Outcomes seen by all tests so far: 2 for each of the compilation's cover_sites.
  [[nodiscard]] const std::vector<bool>& seen() const { return seen_; }

  bool on_call(const HostCall& call) override;

 private:
  Runner() = default;
  std::optional<core::Problem> reset();
  /// Lets instants run while `more` says so; false when the test cannot go on.
  bool run_instants(const std::function<bool(core::TimeNs next, std::uint64_t ran)>& more);
  /// A failure of the whole test, not of a check in it.
  void fail_test(std::string what);
  bool advance_to(core::TimeNs end_ns);
  bool run_cycles(std::int64_t count);
  void note_faults();
  /// ASSERTs that did not hold since `before`.
  void note_events(const bytecode::Image& image, const std::vector<runtime::EventCount>& events,
                   const std::vector<runtime::EventCount>& before);
  void fail_assertion(const ir::Assertion& assertion);
  [[nodiscard]] std::string value_of(const std::string& hidden) const;
  [[nodiscard]] Failure failure_at(const core::SourceRef& at) const;
  void collect_coverage();

  std::vector<compiler::TestInfo> tests_;
  std::vector<ir::Assertion> assertions_;
  std::vector<std::string> files_;
  RunnerOptions options_;
  std::unique_ptr<runtime::Resource> project_;  ///< null when no task of the project runs anything
  std::unique_ptr<runtime::Resource> bench_;    ///< the tests
  std::unique_ptr<Mirror> mirror_;
  std::optional<runtime::Simulation> simulation_;
  std::uint32_t which_ = 0;                ///< place of the number of the test in the bench's table
  std::vector<runtime::Place> instances_;  ///< of the tests
  std::vector<bool> seen_;
  // the test that runs
  std::size_t test_ = 0;
  TestResult* result_ = nullptr;
  core::TimeNs now_ns_ = 0;
  core::TimeNs date_ns_ = 0;  ///< date and time at virtual time 0
  std::size_t faults_noted_ = 0;
  bool ended_ = false;  ///< by a call that said why
};

}  // namespace plc::tests
