// Cost of a rung over the number of rungs, for every drawn workload, as one SVG document.
#include <fmt/format.h>

#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/chart.h"

namespace plc::bench {
namespace {

struct Cache {
  int level = 0;
  bool of_code = false;  ///< holds instructions only
  double kib = 0;
};

/// Those of the first processor that hold instructions, as Linux tells them. WHY not sysconf: in virtual machines its
/// L3 may be that of many processors.
std::vector<Cache> caches() {
  std::vector<Cache> found;
  for (int index = 0;; ++index) {
    const std::string folder = fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/", index);
    Cache cache;
    std::string type;
    std::ifstream(folder + "level") >> cache.level;
    std::ifstream(folder + "type") >> type;
    std::ifstream(folder + "size") >> cache.kib;  // "32K"
    if (cache.level == 0) return found;
    cache.of_code = type == "Instruction";
    if (type != "Data" && cache.kib > 0) found.push_back(cache);
  }
}

/// Where native code no longer fits the first cache, and where it and the variables no longer fit the others.
std::vector<ChartMark> cache_marks(const ScanResult& largest, std::uint32_t rungs) {
  std::vector<ChartMark> marks;
  for (const Cache& cache : caches()) {
    const auto used = static_cast<double>(largest.code_bytes + (cache.of_code ? 0 : largest.table_bytes)) / rungs;
    const std::string size =
        cache.kib < 1024 ? fmt::format("{:g} KiB", cache.kib) : fmt::format("{:g} MiB", cache.kib / 1024);
    marks.push_back({fmt::format("L{} {}", cache.level, size), cache.kib * 1024 / used});
  }
  return marks;
}

}  // namespace

Verdict plot_scans(const PlotPlan& plan) {
  Verdict verdict;
  std::vector<Chart> charts;
  std::cout << scan_head() << std::flush;
  for (const Workload& workload : workloads()) {
    if (!workload.barriers) continue;
    Chart chart{fmt::format("{}: cost of a {}", workload.name, workload.unit),
                fmt::format("{}s", workload.unit),
                fmt::format("ns per {}", workload.unit),
                {{"C", "#2563eb", false, {}},
                 {"C without barriers", "#2563eb", true, {}},
                 {"interpreter", "#16a34a", false, {}},
                 {"native", "#dc2626", false, {}}},
                {}};
    for (const std::uint32_t size : {100u, 300u, 1'000u, 3'000u, 10'000u, 30'000u, 100'000u}) {
      if (size > std::min(plan.largest, workload.sizes.back())) break;
      const ScanResult result = measure_scan(workload, {size, plan.seed, 20, plan.batches});
      verdict.merge(result.verdict);
      if (!result.verdict.correct) return verdict;
      for (std::size_t s = 0; s < result.ns.size(); ++s) chart.lines[s].points.emplace_back(size, result.ns[s]);
      chart.marks = cache_marks(result, size);
      std::cout << fmt::format("{:>20} {:.0f} bytes of native code per {}, {:.1f} of variables\n", "",
                               static_cast<double>(result.code_bytes) / size, workload.unit,
                               static_cast<double>(result.table_bytes) / size);
    }
    charts.push_back(std::move(chart));
  }
  std::ofstream(plan.file) << draw(charts);
  return verdict;
}

}  // namespace plc::bench
