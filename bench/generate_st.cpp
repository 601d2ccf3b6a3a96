// plc-gen-st: writes a project in ST made from a seed (see st_source.h).
#include <CLI/CLI.hpp>
#include <iostream>

#include "bench/st_source.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Writes a project in ST made from a seed to standard output.\nExample: plc-gen-st --lines 100000 > project.st",
      "plc-gen-st"};
  std::uint32_t lines = 1000;
  std::uint64_t seed = 1;
  app.add_option("--lines", lines, "at least this many")->check(CLI::Range(100u, 10'000'000u))->capture_default_str();
  app.add_option("--seed", seed, "equal seeds give equal files")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::cout << plc::bench::make_project(lines, seed) << std::flush;
  return std::cout ? 0 : 2;
}
