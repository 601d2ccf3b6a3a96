// What compiling ST costs: a large project to its image, and garbage to its errors.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <vector>

#include "bench/measurements.h"
#include "bench/process.h"
#include "bench/scratch.h"
#include "bench/st_source.h"

namespace plc::bench {
namespace {

void write(const std::string& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// Compiles `text` to an image and prints what it cost.
void measure(const CompilePlan& plan, const Scratch& scratch, const std::string& text, Verdict& verdict) {
  const std::string path = scratch.file("project.st");
  write(path, text);
  std::vector<double> seconds;
  double peak_mb = 0;
  bool compiles = true;
  for (std::uint32_t i = 0; i < std::max(1u, plan.repetitions) && compiles; ++i) {
    const Cost cost = run({PLC_TOOL, "compile", path, "-o", scratch.file("project.pbc")});
    compiles = cost.ok;
    seconds.push_back(cost.wall_ms / 1e3);
    peak_mb = std::max(peak_mb, cost.peak_mb);
  }
  verdict.correct = verdict.correct && compiles;
  std::string line = fmt::format("{} lines, {:.1f} MB of ST to image: ", std::count(text.begin(), text.end(), '\n'),
                                 static_cast<double>(text.size()) / 1e6);
  if (!compiles) {
    line += "DOES NOT COMPILE";
  } else if (plan.limits) {
    line += fmt::format("{:.2f} s, {}; peak {:.0f} MB, {}", median(seconds),
                        limit_text(median(seconds), limit::kCompile, verdict), peak_mb,
                        limit_text(peak_mb, limit::kCompilePeak, verdict));
  } else {
    line += "compiles";
  }
  std::cout << line << std::endl;
}

}  // namespace

Verdict measure_compile(const CompilePlan& plan) {
  Verdict verdict;
  const Scratch scratch;
  measure(plan, scratch, make_project(plan.lines, plan.seed), verdict);
  measure(plan, scratch, make_statements(std::size_t{plan.garbage_mb} * 1'000'000, plan.seed), verdict);
  std::string line;
  for (int kind = 0; kind < kGarbageCount; ++kind) {
    const std::string garbage = scratch.file("garbage.st");
    write(garbage, make_garbage(static_cast<Garbage>(kind), std::size_t{plan.garbage_mb} * 1'000'000, plan.seed));
    const Cost cost = run({PLC_TOOL, "check", garbage}, true);
    // 1: problems were found and reported. Anything else is a crash or garbage taken for a program.
    const bool refused = cost.exit_code == 1;
    verdict.correct = verdict.correct && refused;
    line = fmt::format("{} MB, {}: {}", plan.garbage_mb, garbage_name(static_cast<Garbage>(kind)),
                       refused ? "refused" : fmt::format("EXIT CODE {}", cost.exit_code));
    if (plan.limits) {
      line += fmt::format(" in {:.2f} s, {}; peak {:.0f} MB", cost.wall_ms / 1e3,
                          limit_text(cost.wall_ms / 1e3, limit::kRefuse, verdict), cost.peak_mb);
    }
    std::cout << line << std::endl;
  }
  return verdict;
}

}  // namespace plc::bench
