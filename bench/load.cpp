// From project file to the end of the first scan, against xmllint on the same file; memory of large projects.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "bench/drawing.h"
#include "bench/measurements.h"
#include "bench/process.h"
#include "bench/program.h"
#include "bench/scratch.h"

namespace plc::bench {
namespace {

/// The number before " MB resident" in what `plc sim --stats` prints; 0 when it is not there.
double resident_mb(const std::string& output) {
  const std::size_t end = output.find(" MB resident");
  if (end == std::string::npos) return 0;
  const std::size_t begin = output.rfind(' ', end - 1);
  return std::stod(output.substr(begin + 1, end - begin - 1));
}

struct Size {
  std::uint32_t rungs = 0;
  std::string path;
  double file_mb = 0;
  std::vector<double> plc_ms, plc_cpu_ms, xmllint_ms, ratios;
  double peak_mb = 0;
};

Size make_size(std::uint32_t rungs, std::uint64_t seed, const Scratch& scratch) {
  Size size;
  size.rungs = rungs;
  size.path = scratch.file(fmt::format("plain_{}.xml", rungs));
  {
    std::ofstream out(size.path, std::ios::binary);
    write_plcopen(make_program({Kind::kPlain, rungs, seed}), out);
  }
  size.file_mb = static_cast<double>(std::filesystem::file_size(size.path)) / 1e6;
  return size;
}

bool repeat(Size& size, bool with_xmllint) {
  const Cost plc = run({PLC_TOOL, "sim", size.path, "--cycles", "1"});
  size.plc_ms.push_back(plc.wall_ms);
  size.plc_cpu_ms.push_back(plc.cpu_ms);
  size.peak_mb = std::max(size.peak_mb, plc.peak_mb);
  if (!plc.ok) std::cerr << fmt::format("plc sim {} failed\n", size.path);
  if (!with_xmllint) return plc.ok;
  const Cost xmllint = run({"xmllint", "--noout", size.path});
  if (!xmllint.ok) std::cerr << "xmllint failed: is libxml2-utils installed?\n";
  size.xmllint_ms.push_back(xmllint.wall_ms);
  size.ratios.push_back(plc.wall_ms / xmllint.wall_ms);
  return plc.ok && xmllint.ok;
}

void print(const Size& size) {
  std::cout << fmt::format(
      "{:>7} rungs plain, {:.1f} MB: to the end of the first scan {:.1f} ms ({:.1f} ms CPU), peak {:.0f} MB",
      size.rungs, size.file_mb, median(size.plc_ms), median(size.plc_cpu_ms), size.peak_mb);
  if (!size.xmllint_ms.empty()) {
    std::cout << fmt::format("; xmllint {:.1f} ms, ratio {:.2f}", median(size.xmllint_ms), median(size.ratios));
  }
  std::cout << '\n';
}

/// What is resident once a program runs as native code.
Verdict measure_resident(const Size& size) {
  constexpr int kRuns = 3;
  Verdict verdict;
  std::vector<double> resident_kb;
  for (int i = 0; i < kRuns; ++i) {
    const Cost sim = run({PLC_TOOL, "sim", size.path, "--engine", "native", "--cycles", "1", "--stats"});
    verdict.correct = verdict.correct && sim.ok;
    resident_kb.push_back(resident_mb(sim.output) * 1024 / size.rungs);
  }
  if (!verdict.correct) std::cerr << fmt::format("plc sim {} failed\n", size.path);
  std::cout << fmt::format("{:>7} rungs plain: resident {:.2f} kB a rung, {}\n", size.rungs, median(resident_kb),
                           limit_text(median(resident_kb), limit::kResident, verdict));
  return verdict;
}

}  // namespace

Verdict measure_load(const LoadPlan& plan) {
  Verdict verdict;
  const Scratch scratch;
  Size small = make_size(1'000, plan.seed, scratch);
  Size middle = make_size(10'000, plan.seed, scratch);
  for (std::uint32_t i = 0; i < plan.repetitions && verdict.correct; ++i) {
    verdict.correct = repeat(small, true) && repeat(middle, true);
  }
  print(small);
  print(middle);
  std::cout << fmt::format("  ratio to xmllint at 10,000 rungs {:.2f}, {}; peak {:.0f} MB, {}\n", median(middle.ratios),
                           limit_text(median(middle.ratios), limit::kFirstScan, verdict), middle.peak_mb,
                           limit_text(middle.peak_mb, limit::kPeak, verdict));
  if (!verdict.correct) return verdict;
  verdict.merge(measure_resident(middle));

  Size large = make_size(100'000, plan.seed, scratch);
  // WHY processor time: the sizes take from milliseconds to seconds, so that other work on the machine would hit them
  // unequally.
  const std::uint32_t rounds = std::max(5u, plan.repetitions / 2);
  for (std::uint32_t i = 0; i < rounds && verdict.correct; ++i) {
    verdict.correct = repeat(small, false) && repeat(middle, false) && repeat(large, false);
  }
  const auto per_rung = [](const Size& to, const Size& from) {
    return (median(to.plc_cpu_ms) - median(from.plc_cpu_ms)) / (to.rungs - from.rungs);
  };
  const double marginal = per_rung(large, middle) / per_rung(middle, small);
  print(large);
  std::cout << fmt::format("  marginal cost 10k..100k to 1k..10k {:.2f}, {}\n", marginal,
                           limit_text(marginal, limit::kMarginalLoad, verdict));
  verdict.merge(measure_resident(large));
  return verdict;
}

}  // namespace plc::bench
