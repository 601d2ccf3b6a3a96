// plc-gen-ladder: writes a ladder made from a seed as a PLCopen project and as C (see ladder.h).
#include <CLI/CLI.hpp>

#include <fstream>
#include <iostream>
#include <string>

#include "bench/ladder.h"

int main(int argc, char** argv) {
  CLI::App app{"Writes a ladder made from a seed as a PLCopen project and, with the same logic, as C.\n"
               "Example: plc-gen-ladder --rungs 10000 --xml ladder.xml --c ladder.c",
               "plc-gen-ladder"};
  plc::bench::Shape shape;
  std::string xml, c;
  app.add_option("--rungs", shape.rungs, "how many rungs")->check(CLI::Range(1u, 1'000'000u))->capture_default_str();
  app.add_flag("--nested", shape.nested, "1 to 12 contacts nested up to three deep, set/reset coils, some blocks");
  app.add_option("--seed", shape.seed, "equal seeds give equal files")->capture_default_str();
  app.add_option("--xml", xml, "file for the PLCopen project");
  app.add_option("--c", c, "file for the C source");
  CLI11_PARSE(app, argc, argv);

  const plc::bench::Ladder ladder = plc::bench::make_ladder(shape);
  const auto write = [&](const std::string& path, auto writer) {
    if (path.empty()) return true;
    std::ofstream out(path, std::ios::binary);
    writer(ladder, out);
    out.flush();
    if (!out) std::cerr << path << ": cannot be written\n";
    return static_cast<bool>(out);
  };
  return write(xml, plc::bench::write_plcopen) && write(c, plc::bench::write_c) ? 0 : 2;
}
