// Cost of a rung over the number of rungs, as one SVG document for each drawn workload that has a plot.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "bench/chart.h"
#include "bench/measurements.h"
#include "bench/scan.h"

namespace plc::bench {
namespace {

struct Cache {
  int level = 0;
  char holds = 'U';  ///< 'I' instructions only, 'D' data only, 'U' both
  double kib = 0;
};

/// Those of the first processor, as Linux tells them. In some virtual machines it does not: then what the processor
/// says of itself, but of its L3, which may be that of many processors.
std::vector<Cache> caches() {
  std::vector<Cache> found;
  for (int index = 0;; ++index) {
    const std::string folder = fmt::format("/sys/devices/system/cpu/cpu0/cache/index{}/", index);
    Cache cache;
    std::string type;
    std::ifstream(folder + "level") >> cache.level;
    std::ifstream(folder + "type") >> type;
    std::ifstream(folder + "size") >> cache.kib;  // "32K"
    if (cache.level == 0) break;
    if (type.empty() || cache.kib <= 0) continue;
    cache.holds = type.front();
    found.push_back(cache);
  }
  if (!found.empty()) return found;
  for (const auto& [name, level, holds] : {std::tuple(_SC_LEVEL1_DCACHE_SIZE, 1, 'D'),
                                           {_SC_LEVEL1_ICACHE_SIZE, 1, 'I'},
                                           {_SC_LEVEL2_CACHE_SIZE, 2, 'U'}}) {
    if (const long bytes = ::sysconf(name); bytes > 0)
      found.push_back({level, holds, static_cast<double>(bytes) / 1024});
  }
  return found;
}

constexpr const char* kColours[kSides] = {"#2563eb", "#7c3aed", "#16a34a", "#dc2626"};
constexpr const char* kLines[kSides] = {"C", "C without barriers", "interpreter", "native"};

struct Plot {
  const char* workload;
  std::vector<std::uint32_t> sizes;
  /// The C compiler takes a millisecond for a rung, and four without barriers: up to here that is quick.
  std::uint32_t largest_c, largest_plain_c;
};

/// Where what each side goes through, by that of `result`, fills the caches.
std::vector<ChartMark> cache_marks(const ScanResult& result, std::uint32_t size) {
  std::vector<ChartMark> marks;
  const std::vector<Cache> known = caches();
  for (std::size_t s = 0; s < kSides; ++s) {
    const Footprint& footprint = result.footprints[s];
    for (const Cache& cache : known) {
      const std::size_t bytes = (cache.holds == 'D' ? 0 : footprint.code) + (cache.holds == 'I' ? 0 : footprint.data);
      const char* const holds = cache.holds == 'I' ? "I" : cache.holds == 'D' ? "D" : "";
      // What does not grow with the program never fills it: no mark within the axis.
      marks.push_back({fmt::format("L{}{}", cache.level, holds),
                       cache.kib * 1024 * size / static_cast<double>(std::max<std::size_t>(bytes, 1)), kColours[s],
                       kSides - 1 - s});
    }
  }
  return marks;
}

std::string sizes_text(const std::vector<Cache>& known) {
  std::string out = "caches:";
  for (const Cache& cache : known) {
    out +=
        fmt::format(" L{}{} {:g} KiB", cache.level, cache.holds == 'U' ? "" : std::string(1, cache.holds), cache.kib);
  }
  return out;
}

}  // namespace

Verdict plot_scans(const PlotPlan& plan) {
  // Marks are by the bytes of this many rungs: by fewer, what comes once would count; by more, the step at the first
  // cache is passed.
  constexpr std::uint32_t kMarked = 5'000;
  const std::vector<std::uint32_t> short_axis = {50, 100, 200, 500, 1'000, 2'000, 5'000, 10'000};
  const std::vector<Plot> plots = {
      {"plain", {50, 100, 200, 500, 1'000, 2'000, 5'000, 10'000, 20'000, 50'000, 100'000, 200'000}, 100'000, 5'000},
      {"blocks", short_axis, 10'000, 2'000},
      {"arithmetic", short_axis, 10'000, 2'000},
      {"mixed", short_axis, 10'000, 2'000},
  };
  Verdict verdict;
  std::cout << sizes_text(caches()) << '\n' << scan_head() << std::flush;
  for (const Plot& plot : plots) {
    const auto& only = plan.only;
    if (!only.empty() && std::find(only.begin(), only.end(), plot.workload) == only.end()) continue;
    Workload workload = *find_workload(plot.workload);
    workload.limits = {};  // those are for `scan`, at its sizes
    Chart chart{fmt::format("{}: cost of a {}, and where each curve leaves the caches", workload.name, workload.unit),
                fmt::format("{}s", workload.unit),
                fmt::format("ns per {}", workload.unit),
                {},
                {}};
    for (std::size_t s = 0; s < kSides; ++s) chart.lines.push_back({kLines[s], kColours[s], s == kPlainC, {}});
    for (const std::uint32_t size : plot.sizes) {
      const ScanResult result = measure_scan(
          workload, {size, plan.seed, 20, plan.batches, size <= plot.largest_c, size <= plot.largest_plain_c});
      verdict.merge(result.verdict);
      if (!verdict.correct) return verdict;
      std::string bytes;
      for (std::size_t s = 0; s < kSides; ++s) {
        if (result.ns[s] == 0) continue;
        chart.lines[s].points.emplace_back(size, result.ns[s]);
        bytes += fmt::format("; {} {:.1f} + {:.1f}", kLines[s], static_cast<double>(result.footprints[s].code) / size,
                             static_cast<double>(result.footprints[s].data) / size);
      }
      std::cout << fmt::format("{:>20} bytes of code + data per {}{}\n", "", workload.unit, bytes);
      if (size == kMarked) chart.marks = cache_marks(result, size);
    }
    std::ofstream out(plan.folder + fmt::format("/scan_{}.svg", workload.name));
    out << draw({chart});
    if (!out.flush()) throw std::runtime_error(plan.folder + " cannot be written to");
  }
  return verdict;
}

}  // namespace plc::bench
