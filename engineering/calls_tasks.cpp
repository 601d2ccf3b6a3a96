// What tasks do and need: calls of the subject "tasks".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/health.h"
#include "engineering/subjects.h"
#include "engineering/task_times.h"
#include "runtime/program.h"
#include "stdlib/library.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kTimesFields[] = {
    integer("count", "Scans"),
    integer("min_ns", "Shortest"),
    number("mean_ns", "Mean"),
    integer("p50_ns", "Half of all are not longer"),
    integer("p99_ns", "99 % are not longer"),
    integer("p99_9_ns", "99.9 % are not longer"),
    integer("max_ns", "Longest"),
};
constexpr Record kTimes = {"Times", "Times of all scans since the start, in nanoseconds.", kTimesFields};

constexpr Field kTaskFields[] = {
    text("name", "Name of the task"),
    text("state", "starts, runs, faulted (it goes on) or stopped (by a fault)"),
    integer("period_ns", "Interval; 0: as often as possible, or when triggered"),
    text("trigger", "Variable whose rising edge releases it; empty: none"),
    integer("priority", "0 is the most urgent"),
    text("engine", "native or interpreter"),
    integer("scans", "Scans since the start"),
    integer("overruns", "Scans that ended after the next release"),
    integer("missed", "Releases that passed without a scan"),
    integer("faults", "Faults since the start"),
    record("latency", kTimes, "From the release to the wake-up"),
    record("scan", kTimes, "From the wake-up to the end of the scan"),
    record("response", kTimes, "From the release to the end of the scan"),
};
constexpr Record kTask = {"Task", "A task, and what it needed.", kTaskFields};

constexpr Field kTasksAnswer[] = {records("tasks", kTask, "In the order of the project")};

void tasks(Context& context, const Caller&, const Json&, Answer& answer) {
  const bytecode::Image& image = context.variables.image();
  Json& all = answer.body()["tasks"] = Json::array();
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    const bytecode::ImageTask& declared = image.tasks[i];
    const runtime::TaskStatistics& statistics = context.scheduler.statistics(i);
    Json task;
    task["name"] = declared.name;
    task["state"] = task_state(i, context.scheduler);
    task["period_ns"] = declared.single.empty() ? declared.period_ns : 0;
    task["trigger"] = declared.single;
    task["priority"] = context.scheduler.plan(i).priority;
    task["engine"] = context.variables.resource().program(i).is_compiled() ? "native" : "interpreter";
    task["scans"] = statistics.scans.load(std::memory_order_acquire);
    task["overruns"] = statistics.overruns.load(std::memory_order_relaxed);
    task["missed"] = statistics.missed.load(std::memory_order_relaxed);
    task["faults"] = statistics.faults.load(std::memory_order_relaxed);
    for (const Quantity& quantity : quantities()) task[quantity.name] = times_json(statistics.*quantity.histogram);
    all.push_back(std::move(task));
  }
}

constexpr Field kBarFields[] = {
    integer("up_to_ns", "Scans that were not longer, and longer than the bar before"),
    integer("count", "How many"),
};
constexpr Record kBar = {"Bar", "A part of a histogram.", kBarFields};
constexpr Field kHistogramsFields[] = {
    text("name", "Name of the task"),
    records("latency", kBar, "From the release to the wake-up; rising times, parts without scans are left out"),
    records("scan", kBar, "From the wake-up to the end of the scan"),
    records("response", kBar, "From the release to the end of the scan"),
};
constexpr Record kHistograms = {"TaskHistograms", "How often a task needed how long, since the start.",
                                kHistogramsFields};
constexpr Field kHistogramsAnswer[] = {records("tasks", kHistograms, "In the order of the project")};

/// Four parts to each power of two.
Json bars_json(const runtime::Histogram& histogram) {
  constexpr int kParts = 4;
  Json bars = Json::array();
  const auto part_of = [](std::int64_t ns) {
    return static_cast<int>(std::ceil(std::log2(static_cast<double>(std::max<std::int64_t>(ns, 1))) * kParts));
  };
  int before = -1;
  for (const runtime::Histogram::Bucket& bucket : histogram.buckets()) {
    const int part = part_of(bucket.upper_ns);
    if (part != before) {
      bars.push_back({{"up_to_ns", std::llround(std::exp2(static_cast<double>(part) / kParts))}, {"count", 0}});
      before = part;
    }
    bars.back()["count"] = bars.back()["count"].get<std::uint64_t>() + bucket.count;
  }
  return bars;
}

void histograms(Context& context, const Caller&, const Json&, Answer& answer) {
  Json& all = answer.body()["tasks"] = Json::array();
  const bytecode::Image& image = context.variables.image();
  for (std::uint32_t i = 0; i < image.tasks.size(); ++i) {
    const runtime::TaskStatistics& statistics = context.scheduler.statistics(i);
    Json task;
    task["name"] = image.tasks[i].name;
    for (const Quantity& quantity : quantities()) task[quantity.name] = bars_json(statistics.*quantity.histogram);
    all.push_back(std::move(task));
  }
}

constexpr Field kEventFields[] = {
    text("task", "Whose instruction it is"),
    text("event", "What happened"),
    text("pou", "POU of the instruction"),
    text("file", "Of the project, as the compiler was told; empty: not known"),
    integer("line", "In the file; 0: not known"),
    integer("column", "In the line"),
    text("element", "What was drawn there, \"block 14\"; empty in a text"),
    integer("count", "How often since the start"),
};
constexpr Record kEvent = {
    "Event", "An instruction that could not do what it says: a division by zero, an index outside.", kEventFields};
constexpr Field kEventsAnswer[] = {
    records("events", kEvent, "In no particular order"),
    integer("others", "Events of instructions that are not told apart any more"),
};

void events(Context& context, const Caller&, const Json&, Answer& answer) {
  runtime::Resource& resource = context.variables.resource();
  const bytecode::Image& image = resource.image();
  Json& all = answer.body()["events"] = Json::array();
  std::uint64_t others = 0;
  for (std::size_t task = 0; task < resource.task_count(); ++task) {
    const runtime::Program& program = resource.program(task);
    others += program.other_events();
    for (const runtime::EventCount& event : program.events()) {
      const core::SourceRef at = runtime::source_of(image, event.pou, event.word);
      Json row;
      row["task"] = program.task().name;
      row["event"] = stdlib::event_name(event.last);
      row["pou"] = image.pous[event.pou].name;
      row["file"] = at.line != 0 && at.file < image.files.size() ? image.files[at.file] : std::string();
      row["line"] = at.line;
      row["column"] = at.column;
      row["element"] = at.local_id < 0 ? std::string() : fmt::format("{} {}", core::element_word(at.kind), at.local_id);
      row["count"] = event.count;
      all.push_back(std::move(row));
    }
  }
  answer.body()["others"] = others;
}

constexpr Call kCalls[] = {
    {.name = "tasks",
     .path = "/api/tasks",
     .doc = "The tasks, and what they needed: as `plc-run --stats=json`, without the histograms, which "
            "`tasks.histograms` has.",
     .response = kTasksAnswer,
     .example = "{}",
     .run = tasks},
    {.name = "tasks.histograms",
     .path = "/api/tasks/histograms",
     .doc = "How often each task needed how long.",
     .response = kHistogramsAnswer,
     .example = "{}",
     .run = histograms},
    {.name = "events",
     .path = "/api/events",
     .doc = "Events of instructions, counted since the start.",
     .response = kEventsAnswer,
     .example = "{}",
     .run = events},
};

}  // namespace

std::span<const Call> task_calls() { return kCalls; }

}  // namespace plc::engineering
