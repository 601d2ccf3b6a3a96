// plc-gen-workload: writes a workload of the benchmark, made from a seed, as a project and as C (see workload.h).
#include <fstream>
#include <iostream>
#include <string>

#include "bench/workload.h"
#include "tools/cli.h"

int main(int argc, char** argv) {
  using namespace plc::bench;
  std::string names;
  for (const Workload& workload : workloads()) names += std::string(names.empty() ? "" : ", ") + workload.name;
  const plc::tools::Program program(
      "plc-gen-workload",
      "Writes a workload of the benchmark, made from a seed, as a project and, with the same logic, as C.\n"
      "Example: plc-gen-workload --only mixed --size 10000 --project mixed.xml --c mixed.c");
  std::string name = "plain", project, c;
  std::uint32_t size = 1000;
  std::uint64_t seed = 1;
  program.option("--only", name, names).shows_default();
  program.option("--size", size, "how many rungs, chains or the like").range(10u, 1'000'000u).shows_default();
  program.option("--seed", seed, "equal seeds give equal files").shows_default();
  program.option("--project", project, "file for the project: PLCopen, of the workloads with .st in their name ST");
  program.option("--c", c, "file for the C source");
  if (const auto code = program.parse(argc, argv)) return *code;

  const Workload* const workload = find_workload(name);
  if (workload == nullptr) {
    std::cerr << "plc-gen-workload: there is no workload " << name << "; there are " << names << '\n';
    return 2;
  }
  const Source source = workload->make(size, seed);
  const auto write = [](const std::string& path, const auto& texts) {
    if (path.empty()) return true;
    std::ofstream out(path, std::ios::binary);
    for (const std::string& text : texts) out << text;
    out.flush();
    if (!out) std::cerr << path << ": cannot be written\n";
    return static_cast<bool>(out);
  };
  return write(project, std::initializer_list<std::string>{source.project}) && write(c, source.c) ? 0 : 2;
}
