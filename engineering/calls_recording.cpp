// Recorded scans: calls of the subject "recording".
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "shadow/shadow.h"
#include "shadow/tracer.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr std::int64_t kMostTraced = 64;
constexpr std::int64_t kMostRows = 1'000'000;
/// WHY: the memory of plc-run is locked, and the kernel ends who takes more than there is: control, too.
constexpr std::size_t kMostBytes = 64'000'000;
constexpr double kFarS = 1e9;  // so that nanoseconds fit, also when they are added to a time

void refuse_without(Answer& answer) {
  answer.refuse({Code::P7720, "nothing is recorded", "[record] mode in plc.toml, or --record, is off"});
}

constexpr Field kStatusAnswer[] = {
    boolean("on", "Scans are recorded"),
    integer("scans", "Executed since the start, by all tasks"),
    integer("left_out", "Of these, in no record"),
    integer("record_bytes", "Of all records"),
    integer("stored_bytes", "Of these, compressed"),
    number("history_seconds", "How far back scans are in memory"),
    integer("history_bytes", "Memory that they take"),
    optional(text("file", "File that is written now")),
};

void status(Context& context, const Caller&, const Json&, Answer& answer) {
  const shadow::Shadow* const shadow = context.shadow;
  const shadow::RecordingCounts counts = shadow == nullptr ? shadow::RecordingCounts{} : shadow->counts();
  Json& body = answer.body();
  body["on"] = shadow != nullptr;
  body["scans"] = counts.scans;
  body["left_out"] = counts.lost;
  body["record_bytes"] = counts.record_bytes;
  body["stored_bytes"] = counts.stored_bytes;
  body["history_seconds"] = shadow == nullptr ? 0.0 : static_cast<double>(shadow->history_ns()) / 1e9;
  body["history_bytes"] = shadow == nullptr ? 0 : shadow->history_bytes();
  if (shadow != nullptr && !shadow->file().empty()) body["file"] = shadow->file();
}

void download(Context& context, const Caller&, const Json&, Answer& answer) {
  if (context.shadow == nullptr) return refuse_without(answer);
  const std::vector<std::byte> bytes = context.shadow->recording();
  answer.give_file({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "plant.rec");
}

constexpr Field kTraceRequest[] = {
    texts("paths", "Variables of any place, chosen afterwards", kMostTraced),
    optional(text("task", "Task whose scans are rows; default: the one with the shortest interval", 1, 200)),
    optional(number("seconds", "The last so many seconds; default 10")),
    optional(text("trigger", "Variable: only the time around its change", 1, 1000)),
    optional(choice("edge", "rising|falling|change", "Of the trigger; default rising")),
    optional(number("level", "That a number has to cross; default 0.5, for BOOL")),
    optional(number("before", "Seconds before the trigger; default 1")),
    optional(number("after", "Seconds after it; default 1")),
};

core::TimeNs nanoseconds(const Json& request, const char* name, double otherwise) {
  return static_cast<core::TimeNs>(std::clamp(request.value(name, otherwise), 0.0, kFarS) * 1e9);
}

void trace(Context& context, const Caller&, const Json& request, Answer& answer) {
  if (context.shadow == nullptr) return refuse_without(answer);
  const auto file = shadow::RecordFile::read(context.shadow->recording(), "memory");
  if (!file) return answer.refuse(file.error());
  core::Diagnostics diagnostics;
  auto player = shadow::Player::make(*file, diagnostics);
  if (!player) return answer.refuse(player.error());
  shadow::TraceRequest wanted;
  for (const Json& path : request["paths"]) wanted.paths.push_back(path.get<std::string>());
  const bytecode::Image& image = (*player)->resource().image();
  bool found = !request.contains("task");
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    if (request.contains("task")
            ? image.tasks[task].name == request["task"].get<std::string>()
            : image.tasks[task].period_ns != 0 && (image.tasks[wanted.task].period_ns == 0 ||
                                                   image.tasks[task].period_ns < image.tasks[wanted.task].period_ns)) {
      wanted.task = task;
      found = true;
    }
  }
  if (!found) return answer.refuse({Code::P7101, "there is no such task", {}}, "task");
  wanted.until_ns = (*player)->end_ns().value_or(0);
  wanted.from_ns = wanted.until_ns - nanoseconds(request, "seconds", 10);
  wanted.most_rows = kMostRows;
  wanted.most_bytes = kMostBytes;
  if (context.program != nullptr) wanted.ending = &context.program->ending;
  if (request.contains("trigger")) {
    const std::string edge = request.value("edge", "rising");
    wanted.trigger = shadow::Trigger{request["trigger"].get<std::string>(),
                                     edge == "change"    ? shadow::Trigger::Edge::kChange
                                     : edge == "falling" ? shadow::Trigger::Edge::kFalling
                                                         : shadow::Trigger::Edge::kRising,
                                     request.value("level", 0.5)};
    wanted.before_ns = nanoseconds(request, "before", 1);
    wanted.after_ns = nanoseconds(request, "after", 1);
  }
  auto made = shadow::trace(**player, wanted);
  if (!made) return answer.refuse(made.error(), "paths");
  answer.give_file(std::move(made->csv), made->cut ? "trace-cut.csv" : "trace.csv");
}

constexpr Call kCalls[] = {
    {.name = "recording",
     .path = "/api/recording",
     .doc = "What is recorded of the scans of the plant.",
     .response = kStatusAnswer,
     .example = R"({})",
     .run = status},
    {.name = "recording.download",
     .path = "/api/recording/download",
     .right = Right::kEngineer,
     .doc = "The scans that are in memory, as a file for plc replay. It has the program.",
     .run = download,
     .form = Form::kFile,
     .thread = Thread::kFiles},
    {.name = "trace",
     .method = Method::kPost,
     .path = "/api/trace",
     .doc =
         "Values of variables in every scan of a task, as CSV, from the scans that are in memory: chosen afterwards. "
         "Columns: scan, time_ms, one for each variable; time counts from the first row, or from the trigger. "
         "At most 1,000,000 rows and 64 MB: what is later is left out, and the file is called trace-cut.csv.",
     .request = kTraceRequest,
     .example = R"({"paths": ["%QX0.0"], "seconds": 1})",
     .run = trace,
     .form = Form::kFile,
     .thread = Thread::kPast},
};

}  // namespace

std::span<const Call> recording_calls() { return kCalls; }

}  // namespace plc::engineering
