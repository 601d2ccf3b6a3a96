// plc calibrate: measures what instructions, functions and blocks take on this machine.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "io-drivers/config/calibration.h"
#include "runtime/sched/estimate.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/plc/measure.h"
#include "tools/plc/probes.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

using runtime::CostKind;
using runtime::CostTable;

struct Calibrate {
  std::string output;
  std::uint32_t repetitions = 200;
};

void print_costs(const CostTable& costs) {
  std::vector<std::vector<std::string>> rows = {{"cost", "first", "in loops", "counted"}};
  for (std::size_t k = 0; k < runtime::kCostKinds; ++k) {
    const auto kind = static_cast<CostKind>(k);
    rows.push_back({std::string(runtime::info(kind).key), fmt::format("{:.2f} ns", costs[kind].first),
                    fmt::format("{:.2f} ns", costs[kind].again), std::string(runtime::info(kind).unit)});
  }
  print_table(rows, std::cout);
}

/// "3,412 functions: 1.2 to 950 ns, half of them up to 4.1 ns".
void print_named(const char* what, const std::map<std::string, double, std::less<>>& named) {
  std::vector<double> all;
  for (const auto& [name, ns] : named) all.push_back(ns);
  std::sort(all.begin(), all.end());
  std::cout << fmt::format("{} {}: {:.1f} to {:.1f} ns, half of them up to {:.1f} ns\n", all.size(), what, all.front(),
                           all.back(), all[all.size() / 2]);
}

/// Estimates, without margin, against measured times of programs that no cost came from.
std::optional<core::Problem> print_accuracy(const CostTable& costs, Meter& meter) {
  std::vector<std::vector<std::string>> rows = {{"program", "estimate", "measured", "ratio"}};
  const std::vector<Sample> all = samples();
  std::vector<std::unique_ptr<runtime::Resource>> resources;
  std::vector<Meter::Subject> subjects;
  for (const Sample& sample : all) {
    auto resource = meter.load(sample.text);
    if (!resource) return resource.error();
    subjects.push_back({resource->get(), false});
    resources.push_back(std::move(*resource));
  }
  const std::vector<runtime::Cost> measured = meter.scans(subjects);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double estimate = runtime::estimate_task(resources[i]->image(), 0, costs).scan.first;
    rows.push_back({all[i].name, duration_text(estimate), duration_text(measured[i].first),
                    fmt::format("{:.2f}", estimate / measured[i].first)});
  }
  std::cout << "\nEstimates of programs, and what they take:\n";
  print_table(rows, std::cout);
  return std::nullopt;
}

int run(const Calibrate& calibrate_options) {
  Meter meter(calibrate_options.repetitions);
  std::cout << fmt::format("{}: {} repetitions each\n", machine_text(), calibrate_options.repetitions);
  const auto costs = calibrate(meter, [](std::string_view what) { std::cout << "measuring: " << what << std::endl; });
  if (!costs) return complain(costs.error()), kExitErrors;
  std::cout << '\n';
  print_costs(*costs);
  std::cout << '\n';
  print_named("functions", costs->functions);
  print_named("function blocks", costs->blocks);
  if (const auto problem = print_accuracy(*costs, meter)) return complain(*problem), kExitErrors;
  if (calibrate_options.output.empty()) return kExitOk;
  std::string why;
  if (!write_file(calibrate_options.output, io::calibration_text(*costs), why)) {
    complain("plc calibrate", fmt::format("{} cannot be written: {}", calibrate_options.output, why));
    return kExitUsage;
  }
  std::cout << fmt::format("\n{}: name it in plc.toml, [scheduler] calibration\n", calibrate_options.output);
  return kExitOk;
}

}  // namespace

void add_calibrate(Command program) {
  static Calibrate options;
  const Command command = program.sub(
      "calibrate",
      "Measures on this machine what each kind of instruction and every function and block of the library takes, for\n"
      "the estimates of plc explain --schedule and plc-run. Takes some seconds of one processor; let nothing else "
      "run.\n"
      "\n"
      "Examples:\n"
      "  plc calibrate                      shows the costs, and how well they add up\n"
      "  plc calibrate -o machine.toml      keeps them: calibration = \"machine.toml\" in [scheduler] of plc.toml");
  command.option("-o,--output=FILE", options.output, "file to write");
  command.option("--repetitions=N", options.repetitions, "of each measurement; few are quick and rough")
      .shows_default()
      .range(1u, 100'000u);
  command.on_run([] { return run(options); });
}

}  // namespace plc::tools
