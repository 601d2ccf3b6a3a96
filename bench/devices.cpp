// Modbus devices beside a task of 1 ms: how late its scans are and how long they take, with the devices and without.
#include <fmt/format.h>
#include <sched.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>

#include "bench/device_servers.h"
#include "bench/measurements.h"
#include "bench/scratch.h"
#include "compiler/compile.h"
#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/machine/driver_types.h"
#include "io-drivers/machine/plant.h"
#include "runtime/access.h"
#include "tools/engine.h"

namespace plc::bench {
namespace {

constexpr unsigned kRegisters = 125;
constexpr core::TimeNs kPollNs = 10'000'000;

/// A task that looks at all registers of every device: they are of one answer, and so all the same.
std::string project_text(unsigned devices) {
  std::string globals, body;
  for (unsigned i = 0; i < devices; ++i) {
    globals += fmt::format("  D{} : ARRAY[0..{}] OF WORD;\n", i, kRegisters - 1);
    body +=
        fmt::format("  FOR i := 1 TO {1} DO\n    IF D{0}[i] <> D{0}[0] THEN Torn := Torn + 1; END_IF;\n  END_FOR;\n", i,
                    kRegisters - 1);
  }
  return "VAR_GLOBAL\n" + globals + "  Torn : UDINT;\nEND_VAR\nPROGRAM Main\nVAR i : DINT; END_VAR\n" + body +
         "END_PROGRAM\nCONFIGURATION C\n  RESOURCE R ON PLC\n    TASK Fast(INTERVAL := T#1ms, PRIORITY := 0);\n"
         "    PROGRAM main WITH Fast : Main;\n  END_RESOURCE\nEND_CONFIGURATION\n";
}

/// `cpu`: the task's own processor, if it has one.
std::string configuration_text(const std::vector<std::uint16_t>& ports, std::optional<unsigned> cpu) {
  std::string text = "[modbus]\nlisten = \"off\"\n";
  if (cpu) text += fmt::format("[scheduler]\ncpu = {}\n", *cpu);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    text += fmt::format("[drivers.d{}]\nkind = \"modbus\"\nbus = \"127.0.0.1:{}\"\npoll = \"{}ms\"\n", i, ports[i],
                        kPollNs / 1'000'000);
  }
  if (!ports.empty()) text += "[inputs]\n";
  for (std::size_t i = 0; i < ports.size(); ++i) {
    for (unsigned k = 0; k < kRegisters; ++k) {
      text +=
          fmt::format("\"D{0}[{1}]\" = {{ driver = \"d{0}\", table = \"holding-registers\", address = {1} }}\n", i, k);
    }
  }
  return text;
}

/// Values of several runs.
class Pool {
 public:
  void add(const runtime::Histogram& histogram) {
    for (const runtime::Histogram::Bucket& bucket : histogram.buckets()) {
      counts_[bucket.upper_ns] += bucket.count;
      count_ += bucket.count;
    }
    max_ns_ = std::max(max_ns_, histogram.max_ns());
  }
  [[nodiscard]] double percentile_us(double share) const {
    std::uint64_t seen = 0;
    for (const auto& [upper_ns, count] : counts_) {
      seen += count;
      if (static_cast<double>(seen) >= share * static_cast<double>(count_)) return static_cast<double>(upper_ns) / 1e3;
    }
    return 0;
  }
  [[nodiscard]] std::string text() const {
    return fmt::format("{:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f}", percentile_us(0.5), percentile_us(0.99),
                       percentile_us(0.999), static_cast<double>(max_ns_) / 1e3);
  }

 private:
  std::map<std::int64_t, std::uint64_t> counts_;
  std::uint64_t count_ = 0;
  std::int64_t max_ns_ = 0;
};

struct Side {
  const char* name;
  Pool latency, scan, response;
  std::uint64_t scans = 0, overruns = 0;
};

/// Takes the last processor away from all that this process starts from now on, for the task. Nothing: there is only
/// one.
std::optional<unsigned> set_one_apart(std::span<const int> all) {
  if (all.size() < 2) return std::nullopt;
  cpu_set_t others;
  CPU_ZERO(&others);
  for (const int one : all) {
    if (one != all.back()) CPU_SET(static_cast<unsigned>(one), &others);
  }
  if (::sched_setaffinity(0, sizeof others, &others) != 0) return std::nullopt;
  return static_cast<unsigned>(all.back());
}

struct Outcome {
  double reads_per_s = 0;  ///< of each device, the slowest
  bool correct = true;
  std::vector<std::string> refused;
};

/// Runs the project for `seconds` with the devices of the configuration and adds its times to `side`.
Outcome run(const std::string& project, const std::string& configuration, std::span<const int> cpus, double seconds,
            Side& side) {
  compiler::Compilation compilation;
  compiler::compile({project, {}, compiler::Goal::kRun}, compilation);
  io::MachineOptions options;
  options.project = project;
  auto read = io::load_configuration(configuration, io::driver_types(), compilation.diagnostics);
  if (!compilation.ok() || !read) {
    compilation.diagnostics.render(std::cerr);
    throw std::runtime_error("the plant does not compile");
  }
  options.configuration = std::move(*read);
  auto resource = runtime::Resource::load(std::move(*compilation.image));
  if (!resource) throw std::runtime_error(resource.error().message);
  runtime::RealtimeOptions realtime;
  if (const auto tasks = io::plan_tasks(options.configuration, (*resource)->image(), cpus,
                                        runtime::FaultPolicy::kSafeState, compilation.diagnostics)) {
    realtime.plan = *tasks;
  }
  auto machine = io::Machine::configure(std::move(options), **resource, compilation.diagnostics);
  if (!machine) {
    compilation.diagnostics.render(std::cerr);
    throw std::runtime_error("the plant is refused");
  }
  if (const auto problem = tools::prepare_engine(**resource, tools::Engine::kAuto, "plc-bench")) {
    throw std::runtime_error(problem->message);
  }
  io::Plant plant(**resource, std::move(machine), std::move(realtime));
  std::vector<io::Sentence> said;
  if (const auto problem = plant.prepare([] {}, said)) throw std::runtime_error(problem->message);
  if (const auto problem = plant.start()) throw std::runtime_error(problem->message);

  Outcome outcome;
  auto& statistics = const_cast<runtime::TaskStatistics&>(plant.scheduler().statistics(0));
  // Not the first second, in which connections are made.
  constexpr core::TimeNs kSettleNs = 1'000'000'000;
  const auto duration_ns = static_cast<core::TimeNs>(seconds * 1e9);
  std::vector<std::uint64_t> before;
  const auto exchanges = [&] {
    std::vector<std::uint64_t> all;
    for (const auto& driver : plant.machine().drivers()) all.push_back(driver->status().exchanges);
    return all;
  };
  core::TimeNs begin_ns = 0;
  plant.run(
      kSettleNs + duration_ns,
      [&](core::TimeNs now_ns) {
        if (begin_ns != 0 || now_ns - plant.begin_ns() < kSettleNs) return;
        begin_ns = now_ns;
        before = exchanges();
        statistics.clear();
      },
      [&](const io::Sentence& sentence) {
        std::cout << "  " << sentence.text << '\n';
        outcome.correct = false;
      });
  const double took_s = static_cast<double>(core::MonotonicClock().now_ns() - begin_ns) / 1e9;
  const std::vector<std::uint64_t> after = exchanges();
  plant.stop();
  side.latency.add(statistics.latency);
  side.scan.add(statistics.scan_time);
  side.response.add(statistics.response);
  side.scans += statistics.scans;
  side.overruns += statistics.overruns;
  outcome.reads_per_s = after.empty() ? 0 : 1e9;
  for (std::size_t i = 0; i < after.size(); ++i) {
    outcome.reads_per_s = std::min(outcome.reads_per_s, static_cast<double>(after[i] - before[i]) / took_s);
  }
  const runtime::Access access(**resource);
  if (access.read(*access.find("Torn")) != "0") {
    std::cout << "  registers of one answer were seen apart\n";
    outcome.correct = false;
  }
  return outcome;
}

}  // namespace

Verdict measure_devices(const DevicesPlan& plan) {
  Verdict verdict;
  const std::vector<int> cpus = io::available_cpus();
  const std::optional<unsigned> cpu = plan.share ? std::nullopt : set_one_apart(cpus);
  const DeviceServers servers(plan.devices);
  const Scratch scratch;
  const std::string project = scratch.file("plant.st");
  std::ofstream(project) << project_text(plan.devices);
  std::ofstream(scratch.file("none.toml")) << configuration_text({}, cpu);
  std::ofstream(scratch.file("all.toml")) << configuration_text(servers.ports(), cpu);
  std::cout << fmt::format(
      "Devices: {} Modbus devices of {} registers at {} Hz in one process, beside a task of 1 ms that reads them; {} "
      "times {:.0f} s of each, in turns; {}; us\n",
      plan.devices, kRegisters, 1'000'000'000 / kPollNs, plan.rounds, plan.seconds,
      cpu ? fmt::format("the task has processor {} for itself", *cpu) : "all share the processors");
  Side without{"without", {}, {}, {}}, with{"with", {}, {}, {}};
  double slowest = 1e9;
  for (unsigned round = 0; round < plan.rounds; ++round) {
    verdict.correct = run(project, scratch.file("none.toml"), cpus, plan.seconds, without).correct && verdict.correct;
    const Outcome outcome = run(project, scratch.file("all.toml"), cpus, plan.seconds, with);
    verdict.correct = outcome.correct && verdict.correct;
    slowest = std::min(slowest, outcome.reads_per_s);
  }
  std::cout << fmt::format("  {:<18} {:<8} {:>9} {:>9} {:>9} {:>9}\n", "", "", "p50", "p99", "p99.9", "max");
  const auto print = [&](const char* what, Pool Side::*pool) {
    for (const Side* side : {&without, &with}) {
      std::cout << fmt::format("  {:<18} {:<8} {}\n", side == &without ? what : "", side->name, (side->*pool).text());
    }
  };
  print("release latency", &Side::latency);
  print("scan", &Side::scan);
  print("release to end", &Side::response);
  const double ratio = with.response.percentile_us(0.999) / without.response.percentile_us(0.999);
  std::cout << fmt::format("  p99.9 from release to end, with / without: {:.2f}  {}\n", ratio,
                           limit_text(ratio, limit::kBesideDevices, verdict));
  std::cout << fmt::format(
      "  scans: {} without, {} with; overruns: {}, {}; the slowest device was read {:.1f} times a second\n",
      without.scans, with.scans, without.overruns, with.overruns, slowest);
  // A machine that stands still for a while leaves out reads.
  if (slowest < 0.9 * 1e9 / static_cast<double>(kPollNs)) {
    std::cout << "  a device was read too seldom\n";
    verdict.correct = false;
  }
  return verdict;
}

}  // namespace plc::bench
