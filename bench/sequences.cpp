// What an evaluation of a large chart costs against that of its active step alone: a ring of many steps with one token,
// and a ring of one step. Both judge one transition, drive one action or none, and rest or go on in each scan. Moving
// has no limit: each scan executes another step's code, which comes from further away and is predicted by nothing,
// while a ring of one step executes the same again.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/measurements.h"
#include "bench/side.h"
#include "core/clock.h"

namespace plc::bench {
namespace {

constexpr std::uint32_t kSteps = 1'000;
constexpr std::uint32_t kScansPerBatch = 5'000;

/// A ring of steps, each with an action of its own, or none has one.
Source ring(std::uint32_t steps, bool actions) {
  std::string variables = "  go : BOOL;\n", body;
  for (std::uint32_t i = 0; i < steps; ++i) {
    variables += fmt::format("  q{} : BOOL;\n", i);
    const std::string action = actions ? fmt::format("    q{}(N);\n", i) : std::string();
    body += fmt::format("  {} S{}:\n{}  END_STEP\n", i == 0 ? "INITIAL_STEP" : "STEP", i, action);
    body += fmt::format("  TRANSITION FROM S{} TO S{}\n    := go;\n  END_TRANSITION\n", i, (i + 1) % steps);
  }
  Source source;
  source.extension = "st";
  source.project = fmt::format(
      "PROGRAM Main\nVAR\n{}END_VAR\n{}END_PROGRAM\nCONFIGURATION C\nRESOURCE R ON Plc\n"
      "  TASK T(INTERVAL := T#1ms, PRIORITY := 0);\n  PROGRAM main WITH T : Main;\nEND_RESOURCE\nEND_CONFIGURATION\n",
      variables, body);
  source.variables.push_back({"main.go", {}});
  for (std::uint32_t i = 0; i < steps; ++i)
    source.variables.push_back(
        {fmt::format("main.{}{}", actions ? "q" : "S", actions ? std::to_string(i) : fmt::format("{}.X", i)), {}});
  return source;
}

/// One ring that runs.
class Ring {
 public:
  Ring(std::uint32_t steps, bool actions, Engine engine) : steps_(steps) {
    const Source source = ring(steps, actions);
    const auto image = compile_project(source);
    side_ = image ? make_plc_side(*image, source, engine) : nullptr;
    if (side_ == nullptr) throw std::runtime_error("the project of the chart benchmark does not compile");
  }
  /// Nanoseconds of a scan, as the mean of a batch.
  double timed(bool moves) {
    *side_->variables()[0] = moves ? 1 : 0;
    const core::MonotonicClock clock;
    const core::TimeNs begin = clock.now_ns();
    for (std::uint32_t i = 0; i < kScansPerBatch; ++i) good_ = side_->scan(now_ += 1'000'000) && good_;
    const auto took = static_cast<double>(clock.now_ns() - begin);
    if (moves) token_ = (token_ + kScansPerBatch) % steps_;
    check(moves);
    return took / kScansPerBatch;
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  /// The action of the active step is TRUE, or its X, and no other. The last transition is decided and not yet taken
  /// over.
  void check(bool moves) {
    const std::uint32_t active = moves ? (token_ + steps_ - 1) % steps_ : token_;
    for (std::uint32_t i = 0; i < steps_; ++i) good_ = good_ && (*side_->variables()[1 + i] == 1) == (i == active);
  }

  std::uint32_t steps_;
  std::uint32_t token_ = 0;  ///< where it is once what was decided is taken over
  std::unique_ptr<Side> side_;
  core::TimeNs now_ = 0;
  bool good_ = true;
};

Verdict measure(Engine engine, bool moves, bool actions, std::uint32_t batches) {
  Verdict verdict;
  Ring one(1, actions, engine), many(kSteps, actions, engine);
  std::vector<double> alone, together, ratios;
  for (std::uint32_t i = 0; i < std::max(batches, 1u); ++i) {
    alone.push_back(one.timed(moves));
    together.push_back(many.timed(moves));
    ratios.push_back(together.back() / alone.back());
  }
  verdict.correct = one.good() && many.good();
  std::cout << fmt::format(
      "  {}, token {}, {}: 1 step {:.0f} ns, {} steps {:.0f} ns, {:.2f} times, {}; {}\n",
      engine == Engine::kNative ? "native" : "interpreter", moves ? "moves" : "rests",
      actions ? "an action at each step" : "no actions", median(alone), kSteps, median(together), median(ratios),
      engine == Engine::kNative && !moves && batches != 0 ? limit_text(median(ratios), limit::kLargeChart, verdict)
                                                          : std::string("no limit"),
      verdict.correct ? "results right" : "RESULTS WRONG");
  return verdict;
}

}  // namespace

Verdict measure_charts(std::uint32_t batches) {
  Verdict verdict;
  for (const Engine engine : {Engine::kInterpreter, Engine::kNative}) {
    for (const bool moves : {false, true}) {
      for (const bool actions : {false, true}) verdict.merge(measure(engine, moves, actions, batches));
    }
  }
  return verdict;
}

}  // namespace plc::bench
