// What it costs a task that 1 MB of its variables is kept over a restart: in scans in which nobody asks, and in the one
// of a hundred that answers.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/measurements.h"
#include "bench/scratch.h"
#include "compiler/compile.h"
#include "core/clock.h"
#include "native/compile.h"
#include "retain/gather.h"
#include "runtime/resource.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kElements = 262'144;    ///< DINTs: 1 MB
constexpr std::uint32_t kScansPerAnswer = 100;  ///< a task of 1 ms, an interval of 100 ms
constexpr double kIntervalNs = 1e8;

/// A program of 1 MB that works on some of it in each scan.
std::string source() {
  return fmt::format(
      "PROGRAM Main\nVAR RETAIN a : ARRAY [0..{}] OF DINT; n : DINT; END_VAR\nVAR i : DINT; END_VAR\n"
      "n := n + 1;\nFOR i := 0 TO 999 DO a[i] := a[i] + n; END_FOR;\na[{}] := n;\nEND_PROGRAM\n"
      "CONFIGURATION C\nRESOURCE R ON Plc\n  TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n"
      "  PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n",
      kElements - 1, kElements - 1);
}

std::unique_ptr<runtime::Resource> load() {
  const Scratch scratch;
  const std::string path = scratch.file("retain.st");
  std::ofstream(path) << source();
  compiler::Compilation compilation;
  compiler::compile({path, {}, compiler::Goal::kRun}, compilation);
  if (!compilation.ok()) throw std::runtime_error("the project of the retain benchmark does not compile");
  auto loaded = runtime::Resource::load(std::move(*compilation.image));
  if (!loaded) throw std::runtime_error(loaded.error().message);
  // Where there is no native engine, the interpreter tells the same.
  if (auto compiled = native::compile((*loaded)->program(0))) (*loaded)->program(0).install(std::move(*compiled));
  return std::move(*loaded);
}

}  // namespace

Verdict measure_retain(const RetainPlan& plan) {
  Verdict verdict;
  const auto plain = load(), keeps = load();
  const retain::Kept kept = retain::find_kept(*keeps);
  retain::Gatherer gatherer(*keeps, kept);
  std::vector<std::byte> values(kept.layout.bytes);
  const core::MonotonicClock clock;
  bool good = true;
  const auto scan = [&](runtime::Resource& resource) {
    runtime::Program& program = resource.program(0);
    good = !program.execute({0}) && good;
    program.offer_kept();
  };
  const auto timed = [&](runtime::Resource& resource) {
    const core::TimeNs begin = clock.now_ns();
    for (std::uint32_t i = 0; i < kScansPerAnswer; ++i) scan(resource);
    return static_cast<double>(clock.now_ns() - begin) / kScansPerAnswer;
  };
  std::vector<double> idle, answers;
  for (std::uint32_t batch = 0; batch < std::max(plan.batches, 1u); ++batch) {
    const double without = timed(*plain);
    idle.push_back(timed(*keeps) / without);
    gatherer.ask();
    runtime::Program& program = keeps->program(0);
    good = !program.execute({0}) && good;
    const core::TimeNs begin = clock.now_ns();
    good = program.offer_kept() && good;
    answers.push_back(static_cast<double>(clock.now_ns() - begin));
    gatherer.take(values);
    good = !plain->program(0).execute({0}) && good;
  }
  // What was answered is what the task has.
  std::vector<std::byte> own(values.size());
  gatherer.copy_initial(own);
  verdict.correct = good && own == values && kept.layout.bytes > 1'000'000;
  std::cout << fmt::format("  {} bytes kept: {}\n", kept.layout.bytes,
                           verdict.correct ? "results right" : "RESULTS WRONG");
  if (!verdict.correct || plan.batches == 0) return verdict;
  const double share = 100 * median(answers) / kIntervalNs;
  std::cout << fmt::format("  scans in which nobody asks: {:.3f} times those that keep nothing, {}\n", median(idle),
                           limit_text(median(idle), limit::kRetainIdle, verdict));
  std::cout << fmt::format("  the answer, once in 100 ms: {:.0f} us after the outputs, {:.3f} % of the time, {}\n",
                           median(answers) / 1000, share, limit_text(share, limit::kRetainShare, verdict));
  return verdict;
}

}  // namespace plc::bench
