// plc replay: executes the scans of a recording again.
#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io-drivers/trace.h"
#include "shadow/arithmetic.h"
#include "shadow/player.h"
#include "tools/command_line.h"
#include "tools/engine.h"
#include "tools/plc/commands.h"
#include "tools/statistics.h"
#include "tools/watched_paths.h"

namespace plc::tools {
namespace {

struct ReplayCommand {
  std::string file, trace, from, until;
  std::vector<std::string> watch;
  std::optional<runtime::ValueStyle> values;
  Engine engine = Engine::kAuto;
};

/// Where to begin and to stop, in time of the tasks since the first recorded scan.
struct Span {
  core::TimeNs from_ns = 0;
  std::optional<core::TimeNs> until_ns;
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

  std::unique_ptr<io::TraceWriter> trace;
  const bool trace_on_stdout = replay.trace == "-" || (replay.trace.empty() && !replay.watch.empty());
  if (const auto code = open_trace("plc replay", replay.trace, replay.watch, replay.values, resource, trace))
    return *code;

  std::vector<TaskSums> sums(resource.task_count());
  std::uint64_t instants = 0, different = 0;
  bool stopped = false;
  const std::optional<core::TimeNs> begin_ns = player.next_ns();
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
    if (trace && *now_ns - *begin_ns >= span->from_ns) {
      player.show_globals();
      trace->record({instants, *now_ns, {}});
    }
    ++instants;
  }
  if (trace) {
    if (const auto problem = trace->close()) return complain(*problem), kExitUsage;
  }
  std::ostream& out = trace_on_stdout ? std::cerr : std::cout;
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
  const Command command = program.sub(
      "replay",
      "Executes the scans of a recording again: the same values, faults and events, on any machine.\n"
      "\n"
      "Examples:\n"
      "  plc replay plant.rec                                    does every scan give what it gave?\n"
      "  plc replay plant.rec --until fault --watch 'Main.*'     values of each scan up to the first fault\n"
      "  plc replay plant.rec --from 10s --until 12s --trace out.csv   all variables of two seconds\n"
      "\n"
      "plc sim --record FILE makes recordings. Taskblocks do not run: what they gave is in the recording, so their\n"
      "libraries are not needed. Times count from the first recorded scan.");
  command.option("FILE", replay.file, "a recording").required();
  command
      .option(
          "--watch=PATTERN", replay.watch,
          "variables to trace, * and ? match; may be repeated. Without --trace the trace goes to stdout; with it, all "
          "are traced by default")
      .repeated();
  command.option("--trace=out.csv", replay.trace, "write the values of every instant as CSV; - is stdout");
  command.choice("--values=STYLE", replay.values,
                 {{"names", runtime::ValueStyle::kNames}, {"numbers", runtime::ValueStyle::kNumbers}},
                 "how enumerations, durations and dates are written, as for plc sim");
  command.option("--from=TIME", replay.from, "trace from this time on: 500ms, 20s, 1h");
  command.option("--until=TIME", replay.until, "stop after this time; fault or event: after the first scan with one");
  add_engine_option(command, replay.engine);
  command.on_run([] { return run(replay); });
}

}  // namespace plc::tools
