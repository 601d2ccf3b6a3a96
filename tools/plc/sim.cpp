// plc sim: runs a project in virtual time.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/config/plan_tasks.h"
#include "io-drivers/stimulus.h"
#include "io-drivers/trace.h"
#include "log/format.h"
#include "runtime/sched/simulation.h"
#include "runtime/sched/statistics.h"
#include "shadow/arithmetic.h"
#include "shadow/record_writer.h"
#include "shadow/recording.h"
#include "tools/command_line.h"
#include "tools/date.h"
#include "tools/engine.h"
#include "tools/open.h"
#include "tools/plc/commands.h"
#include "tools/statistics.h"
#include "tools/taskblock_libraries.h"
#include "tools/version.h"
#include "tools/watched_paths.h"

namespace plc::tools {
namespace {

/// What --stats prints.
enum class Stats : std::uint8_t {
  kNone,
  kText,
  kJson,  ///< one JSON document, and nothing else, on stdout
};

struct Sim {
  std::string file, stimulus, trace, configuration, record;
  std::vector<std::string> watch;
  std::uint64_t cycles = 0;
  std::optional<runtime::ValueStyle> values;
  Stats stats = Stats::kNone;
  Engine engine = Engine::kAuto;
  runtime::ProgramOptions program;
  core::CompileOptions options;
  std::vector<std::string> libraries;
  DateOptions date;
};
constexpr std::uint64_t kDefaultCycles = 1000;

/// Scan times on the machine's clock, beside the virtual one.
class ScanTimes final : public runtime::CycleListener {
 public:
  explicit ScanTimes(std::size_t tasks) {
    for (std::size_t i = 0; i < tasks; ++i) times_.push_back(std::make_unique<runtime::Histogram>());
  }
  void before_scan(const runtime::ReleaseContext&) noexcept override { begin_ = clock_.now_ns(); }
  void after_scan(const runtime::ReleaseContext& context) noexcept override {
    times_[context.task]->record(clock_.now_ns() - begin_);
  }
  void safe_state() noexcept override {}

  void print(const runtime::Resource& resource, std::ostream& out) const {
    std::vector<std::vector<std::string>> rows = {{"task", "engine", "scans", "min ns", "median ns", "p99 ns"}};
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const runtime::Histogram& h = *times_[i];
      const runtime::Program& program = resource.program(i);
      rows.push_back({program.task().name, engine_name(program), std::to_string(h.count()),
                      std::to_string(h.count() ? h.min_ns() : 0), std::to_string(h.percentile_ns(0.5)),
                      std::to_string(h.percentile_ns(0.99))});
    }
    print_table(rows, out);
  }
  /// {"tasks": [{"name": .., "engine": .., "scans": .., "min_ns": .., "median_ns": .., "p99_ns": ..}]}, and what
  /// skipped_counts() says
  void print_json(const runtime::Resource& resource, std::ostream& out) const {
    nlohmann::ordered_json document;
    document["tasks"] = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const runtime::Histogram& h = *times_[i];
      const runtime::Program& program = resource.program(i);
      document["tasks"].push_back({{"name", program.task().name},
                                   {"engine", engine_name(program)},
                                   {"scans", h.count()},
                                   {"min_ns", h.count() ? h.min_ns() : 0},
                                   {"median_ns", h.percentile_ns(0.5)},
                                   {"p99_ns", h.percentile_ns(0.99)}});
    }
    // WHY replace: a name that is no UTF-8 must not spoil the document.
    out << document.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
  }

 private:
  core::MonotonicClock clock_;
  core::TimeNs begin_ = 0;
  std::vector<std::unique_ptr<runtime::Histogram>> times_;
};

/// What taskblocks tell the operator, with the virtual time.
void print_messages(runtime::Resource& resource, core::TimeNs now_ns) {
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    runtime::Program& program = resource.program(task);
    for (const runtime::TaskblockMessage& message : program.messages()) {
      std::cerr << fmt::format("{}: {}: {}: {} (task {}, scan {})\n", duration_text(static_cast<double>(now_ns)),
                               log::word_of(message.severity), message.taskblock, log::printable(message.text),
                               program.task().name, message.scan);
    }
  }
}

int run(Command command, Sim& sim) {
  if (const auto code = parse_date_options("plc sim", sim.date)) return *code;
  const bool trace_on_stdout = sim.trace == "-" || (sim.trace.empty() && !sim.watch.empty());
  if (trace_on_stdout && sim.stats == Stats::kJson) {
    complain("plc sim", "--stats=json and the trace both want stdout", "give the trace a file: --trace out.csv");
    return kExitUsage;
  }
  taskblocks::Registry registry;
  io::Configuration configuration;
  core::Diagnostics diagnostics;
  if (sim.options.show_all) diagnostics.show_all();
  std::vector<std::string> libraries = sim.libraries;
  const auto unusable = load_taskblocks(sim.configuration, registry, libraries, configuration, diagnostics);
  if (unusable) return diagnostics.render_with_lines(std::cerr), *unusable;
  Compilation compilation;
  Request request{sim.file, sim.options, Goal::kRun, libraries, {}, &registry};
  request.drawings = !sim.record.empty();
  if (const auto code = open_or_explain(command, request, compilation)) return *code;
  runtime::ProgramOptions program = sim.program;
  program.taskblocks = &registry;
  program.zone = &sim.date.time_zone;
  auto loaded = runtime::Resource::load(std::move(*compilation.image), program);
  if (!loaded) return complain(loaded.error()), kExitErrors;
  runtime::Resource& resource = **loaded;
  // Times and processors of the configuration are for the plant; that it is one for this project counts here, too.
  const bool fits =
      io::plan_tasks(configuration, resource.image(), io::every_cpu(), runtime::FaultPolicy::kSafeState, diagnostics)
          .has_value();
  diagnostics.render_with_lines(std::cerr);
  if (!fits) return kExitErrors;
  if (const auto problem = prepare_engine(resource, sim.engine, "plc sim")) return complain(*problem), kExitErrors;
  runtime::Simulation simulation(resource, {.date_ns = sim.date.date_ns});

  std::unique_ptr<io::Stimulus> stimulus;
  if (!sim.stimulus.empty()) {
    auto driver = io::Stimulus::load(sim.stimulus, resource);
    if (!driver) return complain(driver.error()), exit_code_of(driver.error());
    stimulus = std::make_unique<io::Stimulus>(std::move(*driver));
    stimulus->attach(simulation);
  }
  std::unique_ptr<io::TraceWriter> trace;
  if (const auto code = open_trace("plc sim", sim.trace, sim.watch, sim.values, resource, trace)) return *code;
  if (trace) trace->attach(simulation);
  std::unique_ptr<shadow::RecordWriter> recorded;
  std::optional<core::Problem> unwritten;  // the first block that was not
  std::unique_ptr<shadow::Recording> recording;
  if (!sim.record.empty()) {
    auto writer = shadow::RecordWriter::open(
        sim.record,
        shadow::file_head({kVersionText, shadow::processor_kind(), shadow::arithmetic_fingerprint(),
                           program.loop_budget, sim.date.time_zone.name(), bytecode::save(resource.image())}));
    if (!writer) return complain(writer.error()), kExitUsage;
    recorded = std::move(*writer);
    auto started = shadow::Recording::start(
        resource, [&recorded, &unwritten](const shadow::BlockInfo&, const std::vector<std::byte>& block) {
          if (!recorded->write(block) && !unwritten) unwritten = recorded->problem();
        });
    if (!started) return complain(started.error()), kExitErrors;
    recording = std::move(*started);
    simulation.after_instant([&recording](const runtime::Instant&) { recording->drain(); });
  }
  ScanTimes times(resource.task_count());
  if (sim.stats != Stats::kNone) simulation.add_listener(times);
  const auto& blocks = resource.image().blocks;
  const bool talks = std::any_of(blocks.begin(), blocks.end(),
                                 [](const auto& block) { return stdlib::block_named(block.name) == nullptr; });
  if (talks)
    simulation.after_instant(
        [&resource](const runtime::Instant& instant) { print_messages(resource, instant.now_ns); });

  const bool until_stimulus_ends = sim.cycles == 0 && stimulus != nullptr;
  const std::uint64_t ran = until_stimulus_ends ? simulation.run_until(stimulus->end_ns() + 1)
                                                : simulation.run_cycles(sim.cycles == 0 ? kDefaultCycles : sim.cycles);
  if (trace) {
    if (const auto problem = trace->close()) return complain(*problem), kExitUsage;
  }
  if (recording) {
    recording->finish();
    if (unwritten) return complain(*unwritten), kExitUsage;
  }
  for (const runtime::TaskFault& fault : simulation.faults()) print_fault(resource, fault, std::cerr);
  print_events(resource, std::cerr);
  const bool lost = stimulus != nullptr && stimulus->lost().values != 0;
  if (lost) {
    core::Problem problem = *stimulus->lost().first;
    problem.message =
        fmt::format("{}: {} values are lost, the first {}", sim.stimulus, stimulus->lost().values, problem.message);
    complain(problem);
  }
  // WHY not stdout when the trace goes there: it stays one clean CSV.
  std::ostream& out = trace_on_stdout || sim.stats == Stats::kJson ? std::cerr : std::cout;
  out << fmt::format(
      "{} cycles, {} of virtual time, {} events, {} faults; {}\n", ran,
      duration_text(static_cast<double>(simulation.now_ns())),
      [&] {
        std::uint64_t events = 0;
        for (std::size_t i = 0; i < resource.task_count(); ++i) events += resource.program(i).event_total();
        return events;
      }(),
      simulation.fault_count(), describe(resource.image().options));
  if (sim.stats == Stats::kJson) times.print_json(resource, std::cout);
  if (sim.stats == Stats::kText) {
    times.print(resource, out);
    print_link_report(resource, out);
    print_memory(out);
  }
  return simulation.fault_count() == 0 && !lost ? kExitOk : kExitErrors;
}

}  // namespace

void add_sim(Command program) {
  static Sim sim;
  const Command command = program.sub(
      "sim",
      "Runs a project in virtual time: deterministic, as fast as the machine goes.\n"
      "\n"
      "Examples:\n"
      "  plc sim plant.xml --cycles 500 --watch 'Main.*'         values of every cycle as CSV on stdout\n"
      "  plc sim plant.xml --stimulus in.csv --trace out.csv     inputs by a script, all variables into a file\n"
      "  plc sim plant.xml --pou Mixer --cycles 100 --watch '*'  one POU alone in a 20 ms task\n"
      "  plc sim plant.pbc --cycles 100000 --stats               scan times\n"
      "  plc sim plant.xml --stimulus in.csv --record plant.rec  every scan, for plc replay\n"
      "\n"
      "Stimulus: 'time_ms,path,path' and rows of values in ascending time; a row is applied at the first release\n"
      "at or after its time, an empty cell keeps the value. Trace: 'cycle,time_ms,path,..', a row per release\n"
      "instant. Paths are INSTANCE.VAR, INSTANCE.FB.Q or GLOBAL, in any letter case.");
  command.option("FILE", sim.file, "PLCopen XML or ST file, source folder, or image").required();
  command
      .option("--cycles=N", sim.cycles,
              fmt::format("release instants to run; default: until the stimulus ends, else {}", kDefaultCycles))
      .check(wrong_count);
  command.option("--stimulus=in.csv", sim.stimulus, "inputs, as CSV");
  command.option("--trace=out.csv", sim.trace, "write the values of every cycle as CSV; - is stdout");
  command.option("--record=FILE", sim.record, "write what each scan takes in, for plc replay");
  command
      .option("--watch=PATTERN", sim.watch,
              "variables to trace, * and ? match; may be repeated (--watch a --watch b). Without --trace the "
              "trace goes to stdout; with it, all are traced by default")
      .repeated();
  command.choice("--values=STYLE", sim.values,
                 {{"names", runtime::ValueStyle::kNames}, {"numbers", runtime::ValueStyle::kNumbers}},
                 "how enumerations, durations and dates are written: names (Filling, T#1s500ms), which is the default "
                 "of --watch, or numbers (1, 1500000000 ns), which is that of --trace");
  add_date_options(command, sim.date);
  add_loop_budget(command, sim.program);
  add_engine_option(command, sim.engine);
  command.choice(
      "--stats{text}=[=json]", sim.stats, {{"text", Stats::kText}, {"json", Stats::kJson}},
      "per task: engine, scans, scan time min, median and p99 in ns; memory. --stats=json prints the tasks as "
      "one JSON document on stdout, and all else on stderr");
  add_library_option(command, sim.libraries);
  command.option("--config=plc.toml", sim.configuration,
                 "configuration whose [project] and [taskblocks] libraries the project uses");
  add_compile_options(command, sim.options);
  command.on_run([command] { return run(command, sim); });
}

}  // namespace plc::tools
