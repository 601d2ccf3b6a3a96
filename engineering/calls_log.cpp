// The log: calls of the subject "log".
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/log_json.h"
#include "engineering/subjects.h"
#include "log/format.h"

namespace plc::engineering {

core::Severity severity_named(const std::string& name) {
  return name == "error"     ? core::Severity::kError
         : name == "warning" ? core::Severity::kWarning
                             : core::Severity::kNote;
}

Json log_json(const LogBook::Entry& entry) {
  Json row;
  row["number"] = entry.number;
  // The same members as a line of --log=json.
  const Json record = Json::parse(log::json_line(entry.record), nullptr, false);
  if (record.is_object()) row.update(record);
  return row;
}

namespace {

using namespace field;

constexpr Field kRecordFields[] = {
    integer("number", "Counted from 1 on since the start"),
    text("time", "UTC"),
    choice("severity", "note|warning|error", "How severe"),
    text("message", "One line"),
    optional(text("source", "Who says it: the name of a driver, modbus, retain, taskblock")),
    optional(text("code", "Code of the problem")),
    optional(text("task", "Task that it is about")),
    optional(integer("scan", "Scan of the task, counted from 0")),
    optional(text("block", "Taskblock that it is about")),
    optional(text("details", "Further lines")),
};
constexpr Record kRecord = {"LogRecord", "A message of the log.", kRecordFields};

constexpr Field kLogRequest[] = {
    optional(integer("after", "Messages after the one of this number; without: the latest ones", 0, INT64_MAX)),
    optional(choice("least", "note|warning|error", "Messages at least as severe; default note")),
    optional(integer("most", "So many at most; default 100", 1, 1000)),
};
constexpr Field kLogAnswer[] = {
    records("records", kRecord, "Oldest first"),
    integer("last", "Number of the latest message"),
    integer("first", "Number of the oldest one that is kept"),
};

void log_records(Context& context, const Caller&, const Json& request, Answer& answer) {
  const core::Severity least = severity_named(request.value("least", "note"));
  const std::size_t most = request.value("most", std::size_t{100});
  const auto found = request.contains("after") ? context.log.after(request["after"].get<std::uint64_t>(), least, most)
                                               : context.log.latest(least, most);
  Json& all = answer.body()["records"] = Json::array();
  for (const LogBook::Entry& entry : found) all.push_back(log_json(entry));
  answer.body()["last"] = context.log.last_number();
  answer.body()["first"] = context.log.first_number();
}

constexpr Field kStreamRequest[] = {
    optional(integer("after", "Messages after the one of this number, too; without: new ones alone", 0, INT64_MAX)),
    optional(choice("least", "note|warning|error", "Messages at least as severe; default note")),
};

constexpr Call kCalls[] = {
    {.name = "log",
     .path = "/api/log",
     .doc = "Messages of the log: faults, devices, components, start and end.",
     .request = kLogRequest,
     .response = kLogAnswer,
     .example = R"({"most": 10})",
     .run = log_records},
    {.name = "log.stream",
     .path = "/api/log/stream",
     .doc = "Messages of the log as they come, as a WebSocket: a text frame each, a JSON object as in `log`. "
            "{\"missed\": n} stands for messages that came faster than the client reads.",
     .request = kStreamRequest,
     .form = Form::kStream},
};

}  // namespace

std::span<const Call> log_calls() { return kCalls; }

}  // namespace plc::engineering
