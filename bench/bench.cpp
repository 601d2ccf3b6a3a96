// plc-bench: what loading and scanning programs costs, side by side with xmllint and with C compiled by -O2; what ST
// costs to compile; what calling taskblocks costs; what clients of the Modbus server get, side by side with libmodbus.
#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <string>
#include <vector>

#include "bench/limits.h"
#include "bench/measurements.h"
#include "bench/scan.h"
#include "bench/workload.h"
#include "tools/cli.h"

namespace plc::bench {

namespace {

std::string names_of_workloads() {
  std::string names;
  for (const Workload& workload : workloads()) names += std::string(names.empty() ? "" : ", ") + workload.name;
  return names;
}

struct Scans {
  std::vector<std::string> only;     ///< names of workloads; none = all
  std::vector<std::uint32_t> sizes;  ///< none = those of each workload
  ScanPlan plan;
};

Verdict scans(const Scans& wanted) {
  Verdict verdict;
  std::cout << "Scan: ns per rung (or as README.md says), medians; the C is gcc -O2 with a barrier after each rung, "
               "plain C without\n"
            << scan_head() << std::flush;
  for (const Workload& workload : workloads()) {
    const auto& only = wanted.only;
    if (!only.empty() && std::find(only.begin(), only.end(), workload.name) == only.end()) continue;
    for (const std::uint32_t size : wanted.sizes.empty() ? workload.sizes : wanted.sizes) {
      ScanPlan plan = wanted.plan;
      plan.size = size;
      verdict.merge(measure_scan(workload, plan).verdict);
    }
  }
  return verdict;
}

void print_limits() {
  std::cout << "| measured | against | at most |\n| --- | --- | --- |\n";
  for (const Limit* const limit : limit::kAll) {
    std::cout << fmt::format("| {} | {} | {} {} |\n", limit->measured, limit->against, limit->most, limit->unit);
  }
}

/// Small programs of every workload, results only.
Verdict check_scans(std::uint64_t seed) {
  Verdict verdict;
  std::cout << scan_head();
  for (const Workload& workload : workloads()) {
    // The seed decides what is drawn; elsewhere it makes other numbers only.
    for (std::uint64_t i = 0; i < (workload.barriers ? 3 : 1); ++i) {
      verdict.merge(measure_scan(workload, {workload.small_size, seed + i, 200, 0}).verdict);
    }
  }
  return verdict;
}

}  // namespace
}  // namespace plc::bench

int main(int argc, char** argv) {
  using namespace plc::bench;
  using plc::tools::Command;
  const plc::tools::Program program(
      "plc-bench",
      "Measures what PICARD costs beside something known, both in turns in one run, and checks every result.\n"
      "\n"
      "Examples:\n"
      "  bench/run                 all that follows but plots, historian, modbus, devices, engineering and coherence; "
      "the "
      "machine "
      "should do "
      "nothing "
      "else\n"
      "  bench/run scan            the table: interpreter and native code beside C, for every workload and size\n"
      "  bench/run scan --only arithmetic --only mixed --size 1000 --batches 20\n"
      "                            some rows of it, quickly\n"
      "  bench/run plots           cost of a rung over the number of rungs, into docs/guides/scan_*.svg; five minutes\n"
      "  bench/run load            file to first scan beside xmllint, memory\n"
      "  bench/run taskblocks      taskblocks and their wires beside plain calls\n"
      "  bench/run retain          1 MB of retained variables beside none\n"
      "  bench/run record          scans that are recorded beside such that are not, replay; three minutes\n"
      "  bench/run probes          values at all places of 1,000 and 10,000 drawn rungs, in a replica\n"
      "  bench/run historian       a day of 1,000 tags at 10 Hz: size, zooms; some minutes, 5 GB of disk\n"
      "  bench/run compile         100,000 lines of ST to image, 10 MB of garbage to errors\n"
      "  bench/run modbus          100 clients against the Modbus server, beside libmodbus; two minutes\n"
      "  bench/run devices         64 Modbus devices beside a task of 1 ms, and without; two minutes, as root\n"
      "  bench/run engineering     50 browsers, calls and wrong passwords beside a task of 1 ms; two minutes\n"
      "  bench/run coherence       globals between tasks under the three protocols, beside memcpy; two minutes, as "
      "root\n"
      "  bench/run check           small programs, results only: what CI runs\n"
      "  bench/run limits          what each figure may be at most\n"
      "\n"
      "A row of the table: ns per rung (or what the workload counts) of each side, then ratios; \"within 1.15\" or\n"
      "\"MISSED 1.15\" says what the limit is. alive: variables that changed while all sides were compared, byte by\n"
      "byte, scan by scan. bench/README.md tells what each workload does, and what its C does and does not do.\n"
      "\n"
      "Exit codes: 0 results right and all ratios within their limits, 1 a limit missed, 2 a result wrong.");
  std::uint64_t seed = 1;
  std::uint32_t repetitions = 7, batches = 100;
  program.option("--seed", seed, "of what is generated").shows_default();
  program.option("--repetitions", repetitions, "of each load, interleaved; medians are printed").shows_default();
  program.option("--batches", batches, "of scans per side, interleaved; medians are printed").shows_default();
  const Command scan = program.sub("scan", "interpreter and native code against C, one row per workload and size");
  Scans wanted;
  scan.option("--only=NAME", wanted.only, "names of workloads: " + names_of_workloads())
      .check(
          [](const std::string& name) { return find_workload(name) == nullptr ? "there is no workload " + name : ""; });
  scan.option("--size", wanted.sizes, "sizes instead of those of the table").range(10u, 1'000'000u);
  PlotPlan plot_plan;
  plot_plan.folder = PLC_PLOTS;
  const Command plots = program.sub("plots", "cost of a rung over the number of rungs, as SVG files");
  plots.option("--only=NAME", plot_plan.only, "plain, blocks, arithmetic, mixed")
      .one_of({"plain", "blocks", "arithmetic", "mixed"});
  plots.option("--folder=FOLDER", plot_plan.folder, "where the SVG files go: scan_plain.svg and others")
      .shows_default();
  const Command load = program.sub("load", "file to first scan against xmllint, memory");
  ModbusPlan modbus_plan;
  modbus_plan.torture = PLC_TORTURE;
  const Command modbus = program.sub("modbus", "clients as fast as they can, against libmodbus");
  modbus.option("--seconds", modbus_plan.seconds, "of load").shows_default();
  modbus.option("--connections", modbus_plan.connections, "at a time").shows_default();
  modbus.option("--torture", modbus_plan.torture, "tool that plays hostile clients").shows_default();
  DevicesPlan devices_plan;
  const Command devices = program.sub("devices", "Modbus devices beside a task of 1 ms, and without");
  devices.option("--seconds", devices_plan.seconds, "of each side, in each round").shows_default();
  devices.option("--rounds", devices_plan.rounds, "of both sides in turn").shows_default();
  devices.option("--devices", devices_plan.devices, "at a time").shows_default().range(1u, 64u);
  devices.flag("--share", devices_plan.share, "the task shares its processor with all that serves devices");
  EngineeringPlan engineering_plan;
  const Command engineering = program.sub("engineering", "the engineering server of plc-run beside a task of 1 ms");
  engineering.option("--seconds", engineering_plan.seconds, "of each side, in each round").shows_default();
  engineering.option("--rounds", engineering_plan.rounds, "of all sides in turn").shows_default();
  engineering.option("--clients", engineering_plan.clients, "that see values").shows_default();
  engineering.option("--variables", engineering_plan.variables, "that each of them sees").shows_default();
  CoherencePlan coherence_plan;
  const Command coherence = program.sub("coherence", "exchange of globals under the three protocols");
  coherence.option("--cycles", coherence_plan.cycles, "of the fast task in each row").shows_default();
  coherence.option("--sizes", coherence_plan.sizes, "variables in each direction").shows_default();
  coherence.option("--plot=FILE", coherence_plan.plot, "SVG file to draw the p99.9 of each row into");
  const Command taskblocks = program.sub("taskblocks", "calls of taskblocks, and wires between them");
  const Command charts = program.sub("charts", "evaluations of sequential function charts, large and small");
  const Command retain = program.sub("retain", "what retained variables cost the scan");
  const Command record = program.sub("record", "what recording costs the scan, and how fast replay is");
  RecordPlan record_plan;
  record.option("--seconds", record_plan.seconds, "of each run of plc-run").shows_default();
  record.option("--rounds", record_plan.rounds, "of plc-run with and without recording, in turn").shows_default();
  record.option("--day", record_plan.day_scans, "scans of a long recording").shows_default();
  const Command probes = program.sub("probes", "a replica that somebody looks at");
  const Command historian = program.sub("historian", "a day of a historian, simulated");
  HistorianPlan historian_plan;
  historian.option("--hours", historian_plan.hours, "that are simulated").shows_default();
  historian.option("--tags", historian_plan.tags, "at 10 Hz").shows_default();
  const Command compile = program.sub("compile", "ST to image, garbage to errors");
  CompilePlan compile_plan;
  compile.option("--lines", compile_plan.lines, "of the project").shows_default();
  compile.option("--garbage-mb", compile_plan.garbage_mb, "of each kind").shows_default();
  const Command check = program.sub("check", "small programs of every workload, results only");
  const Command limits = program.sub("limits", "what each figure may be at most, as the table of README.md");
  program.runs_alone();
  for (const Command& command : {scan, plots, load, taskblocks, charts, retain, record, probes, historian, compile,
                                 modbus, devices, engineering, coherence, check})
    command.falls_through();
  if (const auto code = program.parse(argc, argv)) return *code;
  compile_plan.seed = seed;
  compile_plan.repetitions = repetitions;
  const auto any = {scan,   plots,  load,   modbus, devices, engineering, coherence, taskblocks,
                    charts, retain, record, probes, compile, historian,   check,     limits};
  const bool everything = std::none_of(any.begin(), any.end(), [](Command command) { return command.chosen(); });
  try {
    Verdict verdict;
    if (limits.chosen()) {
      print_limits();
    } else if (check.chosen()) {
      verdict.merge(measure_taskblocks({0}));
      verdict.merge(measure_charts(0));
      verdict.merge(measure_retain({0}));
      verdict.merge(measure_record({0}));
      verdict.merge(measure_probes(0));
      verdict.merge(measure_historian({0, 0}));
      verdict.merge(measure_compile({seed, 3000, 1, 1, false}));
      verdict.merge(check_scans(seed));
    } else if (plots.chosen()) {
      plot_plan.seed = seed;
      plot_plan.batches = batches;
      verdict.merge(plot_scans(plot_plan));
    } else if (historian.chosen()) {
      std::cout << "Historian: a day of tags at 10 Hz, simulated\n";
      verdict.merge(measure_historian(historian_plan));
    } else if (coherence.chosen()) {
      verdict.merge(measure_coherence(coherence_plan));
    } else if (modbus.chosen()) {
      verdict.merge(measure_modbus(modbus_plan));
    } else if (engineering.chosen()) {
      verdict.merge(measure_engineering(engineering_plan));
    } else if (devices.chosen()) {
      verdict.merge(measure_devices(devices_plan));
    } else {
      if (everything || scan.chosen()) {
        wanted.plan.seed = seed;
        wanted.plan.batches = batches;
        verdict.merge(scans(wanted));
      }
      if (everything || load.chosen()) {
        std::cout << "Load: project file to the end of the first scan, against xmllint --noout, interleaved\n";
        verdict.merge(measure_load({seed, repetitions}));
      }
      if (everything || taskblocks.chosen()) {
        std::cout << "Taskblocks: RUNTB against a plain indirect call, interleaved\n";
        verdict.merge(measure_taskblocks({batches}));
      }
      if (everything || charts.chosen()) {
        std::cout << "Charts: one token in a ring of steps, interleaved\n";
        verdict.merge(measure_charts(batches));
      }
      if (everything || retain.chosen()) {
        std::cout << "Retained variables: 1 MB of them, against none, interleaved\n";
        verdict.merge(measure_retain({batches}));
      }
      if (everything || record.chosen()) {
        std::cout << "Recording: scans with and without, interleaved; replay\n";
        record_plan.batches = batches;
        verdict.merge(measure_record(record_plan));
      }
      if (everything || probes.chosen()) {
        std::cout << "Probes: replicas of drawn rungs with a value at every place, interleaved with none\n";
        verdict.merge(measure_probes(batches));
      }
      if (everything || compile.chosen()) {
        std::cout << "Compile: plc compile and plc check on .st files\n";
        verdict.merge(measure_compile(compile_plan));
      }
    }
    return !verdict.correct ? 2 : verdict.within_limits ? 0 : 1;
  } catch (const std::exception& error) {
    std::cerr << "plc-bench: " << error.what() << '\n';
    return 2;
  }
}
