// plc-gen-st: writes a project in ST made from a seed (see st_source.h).
#include <iostream>

#include "bench/st_source.h"
#include "tools/cli.h"

int main(int argc, char** argv) {
  const plc::tools::Program program(
      "plc-gen-st",
      "Writes a project in ST made from a seed to standard output.\nExample: plc-gen-st --lines 100000 > project.st");
  std::uint32_t lines = 1000;
  std::uint64_t seed = 1;
  program.option("--lines", lines, "at least this many").range(100u, 10'000'000u).shows_default();
  program.option("--seed", seed, "equal seeds give equal files").shows_default();
  if (const auto code = program.parse(argc, argv)) return *code;
  std::cout << plc::bench::make_project(lines, seed) << std::flush;
  return std::cout ? 0 : 2;
}
