// plc-test-programs: random ST programs through PICARD and, translated, through the C compiler; all variables equal
// after every scan (README.md of this folder).
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/programs/comparison.h"
#include "tools/cli.h"

namespace plc::programs {
namespace {

/// Drops statements, the large half first, for as long as the program still fails in the same way.
Outcome shrink(Program& program, const ComparisonPlan& plan, Outcome outcome) {
  for (std::size_t size = program.statements().size() / 2; size > 0;) {
    bool dropped = false;
    for (std::size_t at = 0; at < program.statements().size();) {
      const std::vector<Stmt*> all = program.statements();
      const std::size_t end = std::min(at + size, all.size());
      for (std::size_t i = at; i < end; ++i) all[i]->dropped = true;
      Outcome smaller = compare(program, plan);
      if (smaller.kind == outcome.kind) {
        outcome = std::move(smaller);
        dropped = true;
      } else {
        for (std::size_t i = at; i < end; ++i) all[i]->dropped = false;
        at += size;
      }
    }
    if (!dropped || size > 1) size /= 2;
  }
  return outcome;
}

int run(std::uint64_t first, std::uint64_t programs, std::uint64_t statements, bool shrinks,
        std::uint64_t most_failures, const ComparisonPlan& plan) {
  std::uint64_t made = 0, executed = 0, failures = 0;
  for (std::uint64_t seed = first; (programs == 0 || made < programs) && (statements == 0 || executed < statements);
       ++seed, ++made) {
    Program program = generate(seed);
    Outcome outcome = compare(program, plan);
    executed += outcome.statements;
    if (outcome.kind == Outcome::Kind::kSame) continue;
    static constexpr const char* kNames[] = {"same", "refused by the compiler", "no C", "fault", "different"};
    std::cout << fmt::format("seed {}: {}\n{}\n", seed, kNames[static_cast<int>(outcome.kind)], outcome.text);
    if (shrinks) {
      outcome = shrink(program, plan, outcome);
      std::cout << fmt::format("made smaller: {}\n{}\n", outcome.text, program.st());
    }
    std::cout << std::flush;
    if (++failures == most_failures) break;
  }
  std::cout << fmt::format("{} programs from seed {}, {} statements executed, {} failed\n", made, first, executed,
                           failures);
  return failures == 0 ? 0 : 1;
}

}  // namespace
}  // namespace plc::programs

int main(int argc, char** argv) {
  using namespace plc::programs;
  const plc::tools::Program tool(
      "plc-test-programs",
      "Random ST programs, compiled by PICARD and by the C compiler: all variables are equal after every scan.\n"
      "\n"
      "Examples:\n"
      "  plc-test-programs --programs 50            what ctest runs\n"
      "  plc-test-programs --statements 10000000    the long run\n"
      "  plc-test-programs --seed 7 --print st      one program\n"
      "\n"
      "Exit codes: 0 all equal, 1 a difference, 2 trouble with files.");
  std::uint64_t seed = 1, programs = 0, statements = 0, failures = 1;
  std::string print;
  bool keep = false, no_shrink = false;
  ComparisonPlan plan;
  tool.option("--seed", seed, "of the first program; the next have the next seeds").shows_default();
  tool.option("--programs", programs, "how many, 0 = no limit");
  tool.option("--statements", statements, "until this many were executed, 0 = no limit");
  tool.option("--scans", plan.scans, "of each program").shows_default();
  tool.option("--failures", failures, "stop after this many, 0 = never").shows_default();
  tool.option("--print", print, "only print the program of --seed: st or c").one_of({"st", "c"});
  tool.flag("--keep", keep, "leave the files of the last program and say where");
  tool.flag("--no-shrink", no_shrink, "do not make failing programs smaller");
  if (const auto code = tool.parse(argc, argv)) return *code;
  if (programs == 0 && statements == 0) programs = 1;
  plan.prelude = PLC_PROGRAMS_PRELUDE;
  if (!print.empty()) {
    const Program program = generate(seed);
    std::cout << (print == "st" ? program.st() : program.c(plan.prelude));
    return 0;
  }
  std::string folder = (std::filesystem::temp_directory_path() / "plc-programs-XXXXXX").string();
  if (::mkdtemp(folder.data()) == nullptr) return 2;
  plan.folder = folder;
  const int result = run(seed, programs, statements, !no_shrink, failures, plan);
  if (keep) {
    std::cout << folder << '\n';
  } else {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
  return result;
}
