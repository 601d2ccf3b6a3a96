// plc replay: executes the scans of a recording again.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/guess.h"
#include "core/text.h"
#include "io-drivers/config/bind.h"
#include "io-drivers/trace.h"
#include "log/format.h"
#include "log/record.h"
#include "shadow/arithmetic.h"
#include "shadow/player.h"
#include "taskblocks/registry.h"
#include "testing/case_run.h"
#include "tools/command_line.h"
#include "tools/engine.h"
#include "tools/plc/commands.h"
#include "tools/plc/replay_case.h"
#include "tools/plc/replay_flow.h"
#include "tools/plc/test_report.h"
#include "tools/statistics.h"
#include "tools/watched_paths.h"

namespace plc::tools {
namespace {

struct ReplayCommand {
  std::string file, trace, from, until, at, test, project, task, flow, svg;
  std::optional<std::uint64_t> scan;
  std::vector<std::string> watch, libraries;
  std::optional<runtime::ValueStyle> values;
  Engine engine = Engine::kAuto;
};

/// Where to begin and to stop, in time of the tasks since the first recorded scan.
struct Span {
  core::TimeNs from_ns = 0;
  std::optional<core::TimeNs> until_ns, at_ns;
  bool until_fault = false, until_event = false;
};

struct TaskSums {
  std::uint64_t scans = 0, gaps = 0, events = 0, faults = 0, first = 0, last = 0;
};

std::optional<Span> span_of(const ReplayCommand& replay) {
  Span span;
  const auto duration = [](const char* flag, const std::string& text) {
    const auto parsed = parse_duration_ns(text);
    if (!parsed) {
      complain("plc replay", fmt::format("{} \"{}\" is not a duration", flag, text),
               "write 500ms, 20s, 1.5min or 1h; --until also takes fault and event");
    }
    return parsed;
  };
  if (!replay.from.empty()) {
    const auto from = duration("--from", replay.from);
    if (!from) return {};
    span.from_ns = *from;
  }
  if (!replay.at.empty()) {
    span.at_ns = duration("--at", replay.at);
    if (!span.at_ns) return {};
  }
  span.until_fault = replay.until == "fault";
  span.until_event = replay.until == "event";
  if (!replay.until.empty() && !span.until_fault && !span.until_event) {
    span.until_ns = duration("--until", replay.until);
    if (!span.until_ns) return {};
  }
  return span;
}

void print_sums(const shadow::RecordFile& file, const runtime::Resource& resource, const std::vector<TaskSums>& sums,
                std::ostream& out) {
  std::vector<std::vector<std::string>> rows = {
      {"task", "scans", "first", "last", "gaps", "faults", "events", "bytes a scan"}};
  for (std::uint32_t t = 0; t < sums.size(); ++t) {
    std::uint64_t bytes = 0, scans = 0;
    for (const shadow::BlockInfo& block : file.blocks()) {
      if (block.task == t) bytes += block.stored_bytes, scans += block.scans;
    }
    const TaskSums& s = sums[t];
    rows.push_back({resource.program(t).task().name, std::to_string(s.scans), std::to_string(s.first),
                    std::to_string(s.last), std::to_string(s.gaps), std::to_string(s.faults), std::to_string(s.events),
                    scans == 0 ? "-" : fmt::format("{:.1f}", static_cast<double>(bytes) / static_cast<double>(scans))});
  }
  print_table(rows, out);
}

/// The task that --task names; the one with the shortest interval without. Nothing, after a message, for no task.
std::optional<std::uint32_t> task_of(const ReplayCommand& replay, const bytecode::Image& image) {
  if (replay.task.empty()) return io::fastest_task(image);
  core::Guess guess(replay.task);
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    if (core::iequals(image.tasks[task].name, replay.task)) return task;
    guess.offer(image.tasks[task].name);
  }
  complain("plc replay", fmt::format("the recording has no task \"{}\"", replay.task), guess.help());
  return {};
}

runtime::ValueStyle style_of(const ReplayCommand& replay) {
  return replay.values.value_or(runtime::ValueStyle::kNames);
}

/// ", 2026-03-12 08:00:00.000 UTC"; empty when the programs had no date.
std::string utc_text(core::TimeNs utc_ns) {
  if (utc_ns == 0) return {};
  const core::TimeNs ms = utc_ns / 1'000'000;
  return fmt::format(", {:%F %T}.{:03} UTC", fmt::gmtime(ms / 1000), ms % 1000);
}

/// What LOG_MSG told in a scan.
void print_messages(runtime::Program& program, const shadow::PlayedScan& played, core::TimeNs begin_ns) {
  for (const runtime::TaskblockMessage& message : program.messages()) {
    std::cerr << fmt::format("{}: {}: {}: {} (task {}, scan {})\n",
                             duration_text(static_cast<double>(played.now_ns - begin_ns)),
                             log::word_of(message.severity), message.taskblock, log::printable(message.text),
                             program.task().name, played.scan);
  }
}

/// --flow: as text, or with --svg as a picture.
bool show_flow(const ReplayCommand& replay, const ReplayFlow& flow, shadow::Player& player, std::ostream& out) {
  return replay.svg.empty() ? flow.show(player, style_of(replay), out)
                            : flow.draw(player, style_of(replay), replay.svg, out);
}

/// --at, --scan: the variables at one time, one below the other.
int show_instant(const ReplayCommand& replay, const Span& span, shadow::Player& player,
                 const std::optional<ReplayFlow>& flow) {
  runtime::Resource& resource = player.resource();
  const auto task = flow ? std::optional(flow->task()) : task_of(replay, resource.image());
  if (!task) return kExitUsage;
  if (replay.scan) {
    if (!player.seek(*task, *replay.scan)) {
      complain("plc replay", fmt::format("the recording has no scan {} of task {}", *replay.scan,
                                         resource.program(*task).task().name));
      return kExitUsage;
    }
  } else {
    player.seek(*player.begin_ns() + *span.at_ns);
  }
  if (flow) return show_flow(replay, *flow, player, std::cout) ? kExitOk : kExitErrors;
  player.show_globals();
  const runtime::RecordHead& head = player.replicas().replica(*task).head();
  std::cout << fmt::format("after scan {} of task {}, {} after the first recorded one{}\n\n", head.scan,
                           resource.program(*task).task().name,
                           duration_text(static_cast<double>(head.now_ns - *player.begin_ns())), utc_text(head.utc_ns));
  const runtime::Access access(resource);
  std::vector<std::vector<std::string>> rows = {{"variable", "value"}};
  for (const std::string& path : watched_paths(replay.watch, resource)) {
    const auto place = access.find_leaf(path);
    if (place) rows.push_back({path, access.read(*place, style_of(replay))});
  }
  print_table(rows, std::cout);
  return kExitOk;
}

/// --test: writes the case, runs it, and says whether it gives what was recorded.
int make_test(const ReplayCommand& replay, const Span& span, shadow::Player& player) {
  player.count_releases();
  const core::TimeNs begin_ns = player.next_ns().value_or(0);
  ReplayCase request;
  request.folder = replay.test;
  request.project = replay.project;
  request.libraries = replay.libraries;
  request.options = player.resource().image().options;
  request.watch = replay.watch;
  request.from_ns = begin_ns + span.from_ns;
  if (span.until_ns) request.until_ns = begin_ns + *span.until_ns;
  request.until_fault = span.until_fault;
  const auto written = write_case(player, request);
  if (!written) return complain(written.error()), exit_code_of(written.error());
  std::cout << fmt::format("{}: {} from {} on, {}, {}\n", replay.test, counted(written->instants, "cycle"),
                           duration_text(static_cast<double>(written->begin_ns - begin_ns)),
                           counted(written->variables, "variable"), counted(written->inputs, "input"));
  if (!written->aligned)
    std::cerr << "plc replay: at no time near --from all tasks are released at once: their phases are lost\n";
  const auto results = tests::run_case({replay.test, replay.test, {}, &taskblocks::Registry::built_in()});
  if (!results) return complain(results.error()), exit_code_of(results.error());
  for (const tests::TestResult& result : *results) {
    if (result.failures.empty()) continue;
    std::cerr << fmt::format(
        "plc replay: {} does not give what was recorded: {}\n  help: {}\n", replay.project,
        failure_text(result.failures.front()),
        "if the project has changed since, this is what has changed; taskblocks, values of queues, offsets of tasks, "
        "scans that were left out and what tasks gave each other in the middle of a scan are not in a case");
    return kExitErrors;
  }
  std::cout << fmt::format("it gives what was recorded; plc test {}\n", shell_word(replay.test));
  return kExitOk;
}

int run(const ReplayCommand& replay) {
  const auto span = span_of(replay);
  if (!span) return kExitUsage;
  const auto file = shadow::RecordFile::open(replay.file);
  if (!file) return complain(file.error()), exit_code_of(file.error());
  core::Diagnostics diagnostics;
  auto made = shadow::Player::make(*file, diagnostics);
  diagnostics.render_with_lines(std::cerr);
  if (!made) return complain(made.error()), kExitErrors;
  shadow::Player& player = **made;
  runtime::Resource& resource = player.resource();
  if (const auto problem = prepare_engine(resource, replay.engine, "plc replay"))
    return complain(*problem), kExitErrors;
  const bool same_arithmetic = file->head().arithmetic == shadow::arithmetic_fingerprint();
  if (!same_arithmetic) {
    std::cerr << fmt::format(
        "plc replay: recorded on {} with another library of functions: results of LN, SIN, EXPT and their kin may "
        "differ "
        "in their last bit\n",
        file->head().processor);
  }
  if (!player.has_zone()) {
    std::cerr << fmt::format("plc replay: this machine has no time zone {}: local time is UTC\n", file->head().zone);
  }
  if (file->damaged_bytes() != 0)
    std::cerr << fmt::format("plc replay: {} bytes of {} are cut or damaged\n", file->damaged_bytes(), replay.file);

  if (!player.begin_ns())
    return complain(core::Problem{core::Code::P7630, replay.file + ": has no scan", {}}), kExitErrors;
  std::optional<ReplayFlow> flow;
  if (!replay.flow.empty()) {
    flow = ReplayFlow::find(resource, replay.flow);
    if (!flow) return kExitErrors;
  }
  if (span->at_ns || replay.scan) return show_instant(replay, *span, player, flow);
  if (!replay.test.empty()) return make_test(replay, *span, player);
  std::unique_ptr<io::TraceWriter> trace;
  const bool trace_on_stdout = replay.trace == "-" || (replay.trace.empty() && !replay.watch.empty());
  if (const auto code = open_trace("plc replay", replay.trace, replay.watch, replay.values, resource, trace))
    return *code;

  std::vector<TaskSums> sums(resource.task_count());
  std::uint64_t instants = 0, different = 0;
  bool stopped = false;
  const std::optional<core::TimeNs> begin_ns = player.begin_ns();
  // What comes before is not executed but for the scans since the last table.
  if (span->from_ns != 0) player.seek(*begin_ns + span->from_ns - 1);
  // Nor is what these told.
  for (std::size_t task = 0; task < resource.task_count(); ++task) static_cast<void>(resource.program(task).messages());
  while (const auto now_ns = player.next_ns()) {
    if (stopped || (span->until_ns && *now_ns - *begin_ns > *span->until_ns)) break;
    // All scans of one instant, then its row.
    while (player.next_ns() == now_ns && !stopped) {
      const auto played = player.step();
      const shadow::Replica::Outcome& outcome = played->outcome;
      TaskSums& sum = sums[played->task];
      if (sum.scans++ == 0) sum.first = played->scan;
      sum.last = played->scan;
      sum.gaps += played->after_gap ? 1 : 0;
      sum.events += outcome.events;
      print_messages(resource.program(played->task), *played, *begin_ns);
      if (outcome.fault) {
        ++sum.faults;
        print_fault(resource, {played->task, played->scan, played->now_ns, outcome.fault}, std::cerr);
      }
      if (!outcome.equal && different++ == 0) {
        core::Problem problem{core::Code::P7632,
                              fmt::format("scan {} of task \"{}\": {} is not as it was", played->scan,
                                          resource.program(played->task).task().name, outcome.differs),
                              {}};
        if (same_arithmetic) problem.help = "this is a fault of PICARD: please report it with the recording";
        complain(problem);
      }
      stopped = (span->until_fault && outcome.fault) || (span->until_event && outcome.events != 0);
    }
    if (trace) {
      player.show_globals();
      trace->record({instants, *now_ns - *begin_ns, {}});
    }
    ++instants;
  }
  if (trace) {
    if (const auto problem = trace->close()) return complain(*problem), kExitUsage;
  }
  std::ostream& out = trace_on_stdout ? std::cerr : std::cout;
  if (flow) {
    if (!show_flow(replay, *flow, player, out)) return kExitErrors;
    out << "\n";
  }
  out << fmt::format(
      "{}: {}, {}; {}\n\n", replay.file, resource.image().project, file->head().product,
      different == 0 ? "every scan gives what it gave" : fmt::format("{} scans give something else", different));
  print_sums(*file, resource, sums, out);
  if (span->until_fault && !stopped) out << "no scan ended with a fault\n";
  if (span->until_event && !stopped) out << "no scan raised an event\n";
  if (player.damaged_blocks() != 0) out << fmt::format("{} blocks could not be read\n", player.damaged_blocks());
  const bool whole = file->damaged_bytes() == 0 && player.damaged_blocks() == 0;
  return different == 0 && whole ? kExitOk : kExitErrors;
}

}  // namespace

void add_replay(Command program) {
  static ReplayCommand replay;
  static std::uint64_t scan_number = 0;
  const Command command = program.sub(
      "replay",
      "Executes the scans of a recording again: the same values, faults and events, on any machine.\n"
      "\n"
      "Examples:\n"
      "  plc replay plant.rec                                    does every scan give what it gave?\n"
      "  plc replay plant.rec --until fault --watch 'Main.*'     values of each scan up to the first fault\n"
      "  plc replay plant.rec --from 10s --until 12s --trace out.csv   all variables of two seconds\n"
      "  plc replay plant.rec --at 11s --watch 'Main.*'          values at one time\n"
      "  plc replay plant.rec --at 11s --flow Main               power flow of the scan at that time\n"
      "  plc replay plant.rec --at 11s --flow Main --svg main.svg    the same as a picture\n"
      "  plc replay fault.rec --until fault --from 3s --test cases/jam --project plant.xml   a test, for plc test\n"
      "\n"
      "plc sim --record FILE and plc-run make recordings. Taskblocks do not run: what they gave is in the recording, "
      "so "
      "their\n"
      "libraries are not needed. Times count from the first recorded scan.");
  command.option("FILE", replay.file, "a recording").required();
  command
      .option(
          "--watch=PATTERN", replay.watch,
          "variables to trace, * and ? match; may be repeated. Without --trace the trace goes to stdout; with it, all "
          "are traced by default")
      .repeated();
  const Flag trace =
      command.option("--trace=out.csv", replay.trace, "write the values of every instant as CSV; - is stdout");
  command.choice("--values=STYLE", replay.values,
                 {{"names", runtime::ValueStyle::kNames}, {"numbers", runtime::ValueStyle::kNumbers}},
                 "how enumerations, durations and dates are written, as for plc sim");
  const Flag from =
      command.option("--from=TIME", replay.from, "begin at this time: 500ms, 20s, 1h; what is before is not executed");
  const Flag until = command.option("--until=TIME", replay.until,
                                    "stop after this time; fault or event: after the first scan with one");
  const Flag at = command.option("--at=TIME", replay.at, "print the variables as they were at this time");
  const Flag scan =
      command.option("--scan=N", scan_number, "print the variables as they were after this scan of --task");
  command.option("--task=NAME", replay.task, "task that --scan counts of; default: the one with the shortest interval");
  const Flag test = command.option(
      "--test=DIR", replay.test,
      "write what --from and --until leave as a test case, which plc test runs: the project, the values it began with, "
      "what came from outside, and a table of the variables of --watch (default: addresses at %Q, or all)");
  const Flag project = command.option("--project=FILE", replay.project, "of --test: the project, a file or a folder");
  project.needs(test);
  test.needs(project);
  command.option("--lib=FILE", replay.libraries, "of --test: a library that the project needs; may be repeated")
      .repeated();
  const Flag flow = command.option(
      "--flow=POU[:INSTANCE]", replay.flow,
      "print what this POU had at its pins, contacts, coils and statements in the last scan of --until, or in "
      "that of --at or --scan: Main, or Valve:Main.valves[2]");
  flow.excludes({test});
  command.option("--svg=OUT", replay.svg, "of --flow: draw the POU with its flow into this file instead; - is stdout")
      .needs(flow);
  at.excludes({from, until, trace, test, scan});
  scan.excludes({from, until, trace, test});
  test.excludes({trace});
  add_engine_option(command, replay.engine);
  command.on_run([scan] {
    if (scan.given()) replay.scan = scan_number;
    return run(replay);
  });
}

}  // namespace plc::tools
