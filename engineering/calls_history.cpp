// Values of the past: calls of the subject "history".
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "historian/historian.h"
#include "runtime/access.h"
#include "shadow/player.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr double kFarS = 9e9;  // so that nanoseconds fit

constexpr Field kTagsAnswer[] = {
    texts("tags", "Paths of the variables that are kept"),
    number("interval_ms", "Between two samples; 0: nothing is kept"),
    integer("days", "How long they are kept"),
    number("begin", "The oldest that is kept, seconds since 1970, UTC; 0: nothing yet"),
};

void tags(Context& context, const Caller&, const Json&, Answer& answer) {
  Json& body = answer.body();
  Json& all = body["tags"] = Json::array();
  historian::Historian* const historian = context.historian;
  if (historian != nullptr) {
    for (const historian::Tag& tag : historian->tags()) all.push_back(tag.path);
  }
  body["interval_ms"] = historian == nullptr ? 0 : static_cast<double>(historian->settings().interval_ns) / 1e6;
  body["days"] = historian == nullptr ? 0 : historian->settings().days;
  body["begin"] = historian == nullptr ? 0 : static_cast<double>(historian->begin_ns()) / 1e9;
}

constexpr Field kPointFields[] = {
    number("time", "Seconds since 1970, UTC: of the sample, or the begin of a stretch"),
    number("least", "Of the samples in it; BOOL as 0 and 1, durations in seconds"),
    number("mean", "Mean of the samples"),
    number("greatest", "Greatest of the samples"),
};
constexpr Record kPoint = {"HistoryPoint", "A sample, or what was sampled in a stretch of time.", kPointFields};

constexpr Field kQueryRequest[] = {
    text("tag", "Path of a variable that is kept, as `history.tags` has it", 1, 1000),
    number("from", "Seconds since 1970, UTC"),
    number("to", "Until when"),
    optional(integer("points", "So many at most; default 1000", 1, historian::HistoryReader::kMostPoints)),
};
constexpr Field kQueryAnswer[] = {
    records("points", kPoint, "Rising times; stretches in which nothing was sampled are left out"),
    number("step", "Seconds that a point covers; 0: each is a sample"),
};

void query(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto tag = request["tag"].get<std::string>();
  const auto time = [&](const char* name) {
    return static_cast<core::TimeNs>(std::clamp(request[name].get<double>(), 0.0, kFarS) * 1e9);
  };
  std::optional<historian::Course> course;
  if (context.historian != nullptr)
    course = context.historian->read(tag, time("from"), time("to"), request.value("points", std::size_t{1000}));
  if (!course) {
    return answer.refuse(
        {core::Code::P7101, "\"" + tag + "\" is not kept", "history.tags lists what is; historian.toml says it"},
        "tag");
  }
  Json& rows = answer.body()["points"] = Json::array();
  for (const historian::Point& point : course->points) {
    Json row;
    row["time"] = static_cast<double>(point.us) / 1e6;
    const auto number = [](double value) {
      return std::isfinite(value) ? Json(value) : Json(value > 0 ? 1e308 : -1e308);
    };
    row["least"] = number(point.summary.least);
    row["mean"] = number(point.summary.mean());
    row["greatest"] = number(point.summary.greatest);
    rows.push_back(std::move(row));
  }
  answer.body()["step"] = static_cast<double>(course->step_ns) / 1e9;
}

constexpr std::int64_t kMostPaths = 16;
constexpr std::int64_t kMostScans = 5000;

constexpr Field kScanFields[] = {
    number("time", "Seconds since 1970, UTC, as the scan was told"),
    integer("scan", "Of the task, counted from 0 since recording began"),
    value("values", "After it, in the order of the request; BOOL as 0 and 1, durations in seconds"),
};
constexpr Record kScan = {"HistoryScan", "A recorded scan.", kScanFields};

constexpr Field kScansRequest[] = {
    texts("tags", "Paths of BOOLs and numbers of any place", kMostPaths),
    number("from", "Seconds since 1970, UTC"),
    number("to", "Until when"),
};
constexpr Field kScansAnswer[] = {
    records("scans", kScan, "Of the task with the shortest interval; at most 5000, from `from` on"),
    boolean("whole", "All scans of that time are there: it is still in memory, and not too long"),
};

/// The task with the shortest interval.
std::uint32_t fastest(const bytecode::Image& image) {
  std::uint32_t best = 0;
  for (std::uint32_t task = 1; task < image.tasks.size(); ++task) {
    const core::TimeNs period = image.tasks[task].period_ns;
    if (period != 0 && (image.tasks[best].period_ns == 0 || period < image.tasks[best].period_ns)) best = task;
  }
  return best;
}

void scans(Context& context, const Caller&, const Json& request, Answer& answer) {
  Json rows = Json::array();
  answer.body() = {{"scans", rows}, {"whole", false}};
  if (context.shadow == nullptr) return;
  const auto file = shadow::RecordFile::read(context.shadow->recording(), "memory");
  if (!file) return answer.refuse(file.error());
  core::Diagnostics diagnostics;
  auto made = shadow::Player::make(*file, diagnostics);
  if (!made) return answer.refuse(made.error());
  shadow::Player& player = **made;
  const runtime::Access access(player.resource());
  std::vector<alarms::Watched> wanted;
  for (const Json& path : request["tags"]) {
    auto watched = alarms::watch(player.resource(), path.get<std::string>(), true);
    if (!watched) return answer.refuse(watched.error(), "tags");
    wanted.push_back(*watched);
  }
  // Programs have another clock than people, and after a start with retained values another one than the machine.
  const core::TimeNs ahead_ns = context.calendar.utc_ns() - context.scheduler.program_ns(context.clock.now_ns());
  const auto time = [&](const char* name) {
    return static_cast<core::TimeNs>(std::clamp(request[name].get<double>(), 0.0, kFarS) * 1e9) - ahead_ns;
  };
  const core::TimeNs from_ns = time("from"), to_ns = time("to");
  const std::uint32_t task = fastest(player.resource().image());
  const auto begin_ns = player.begin_ns();
  bool whole = begin_ns && *begin_ns <= from_ns;
  player.seek(from_ns - 1);
  std::string cell;
  // WHY: another program, or the end, waits for this thread.
  const auto is_given_up = [&context] { return context.program != nullptr && context.program->ending; };
  while (player.next_ns().value_or(to_ns + 1) <= to_ns) {
    if (is_given_up()) {
      whole = false;
      break;
    }
    const auto played = player.step();
    if (played->task != task) continue;
    if (rows.size() == kMostScans) {
      whole = false;
      break;
    }
    player.show_globals();
    Json row;
    row["time"] = static_cast<double>(player.replicas().replica(task).head().utc_ns) / 1e9;
    row["scan"] = played->scan;
    Json& values = row["values"] = Json::array();
    for (const alarms::Watched& one : wanted) {
      cell.clear();
      access.read_to(one.place, cell);
      const double number = std::strtod(cell.c_str(), nullptr);
      const bool duration = core::in_category(one.type, core::kAnyDuration);
      values.push_back(std::isfinite(number) ? Json(duration ? number / 1e9 : number) : Json(nullptr));
    }
    rows.push_back(std::move(row));
  }
  answer.body() = {{"scans", std::move(rows)}, {"whole", whole}};
}

constexpr Call kCalls[] = {
    {.name = "history.tags",
     .path = "/api/history/tags",
     .doc = "Which variables are kept, how often and how long.",
     .response = kTagsAnswer,
     .example = "{}",
     .run = tags,
     .thread = Thread::kFiles},
    {.name = "history.query",
     .path = "/api/history",
     .doc = "The course of a variable in the past, in as many points as asked for, however long the time is.",
     .request = kQueryRequest,
     .response = kQueryAnswer,
     .example = R"({"tag": "Level", "from": 0, "to": 9000000000, "points": 10})",
     .run = query,
     .thread = Thread::kFiles},
    {.name = "history.scans",
     .method = Method::kPost,
     .path = "/api/history/scans",
     .doc = "Values after every single scan of some seconds, as far as recorded scans are still in memory: they are "
            "executed again for it.",
     .request = kScansRequest,
     .response = kScansAnswer,
     .example = R"({"tags": ["Level", "Running"], "from": 0, "to": 9000000000})",
     .run = scans,
     .thread = Thread::kPast},
};

}  // namespace

std::span<const Call> history_calls() { return kCalls; }

}  // namespace plc::engineering
