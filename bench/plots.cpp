// Cost of a rung over the number of rungs, for every drawn workload, as one SVG document.
#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <iostream>

#include "bench/bench.h"
#include "bench/chart.h"

namespace plc::bench {
namespace {

struct Cache {
  const char* name;
  int key;       ///< of sysconf
  bool of_code;  ///< holds instructions only
};
constexpr Cache kCaches[] = {
    {"L1", _SC_LEVEL1_ICACHE_SIZE, true}, {"L2", _SC_LEVEL2_CACHE_SIZE, false}, {"L3", _SC_LEVEL3_CACHE_SIZE, false}};

/// Where native code no longer fits the first cache, and where it and the variables no longer fit the others.
std::vector<ChartMark> cache_marks(const ScanResult& largest, std::uint32_t rungs) {
  std::vector<ChartMark> marks;
  for (const Cache& cache : kCaches) {
    const double bytes = static_cast<double>(::sysconf(cache.key));
    if (bytes <= 0) continue;  // a virtual machine may not say
    const auto used = static_cast<double>(largest.code_bytes + (cache.of_code ? 0 : largest.table_bytes)) / rungs;
    const std::string size =
        bytes < 1048576 ? fmt::format("{:g} KiB", bytes / 1024) : fmt::format("{:g} MiB", bytes / 1048576);
    marks.push_back({fmt::format("{} {}", cache.name, size), bytes / used});
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
      if (size > std::min(plan.largest, 3 * workload.sizes.back())) break;
      const ScanResult result = measure_scan(workload, {size, plan.seed, 20, plan.batches});
      verdict.merge(result.verdict);
      if (!result.verdict.correct) return verdict;
      for (std::size_t s = 0; s < result.ns.size(); ++s) chart.lines[s].points.emplace_back(size, result.ns[s]);
      chart.marks = cache_marks(result, size);
    }
    charts.push_back(std::move(chart));
  }
  std::ofstream(plan.file) << draw(charts);
  return verdict;
}

}  // namespace plc::bench
