// Alarms: calls of the subject "alarms".
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "alarms/alarm_store.h"
#include "alarms/alarms.h"
#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "log/format.h"
#include "runtime/sched/realtime.h"

namespace plc::engineering {
namespace {

using namespace field;
using alarms::State;
using core::Code;

constexpr std::int64_t kMostNames = 1000;
constexpr std::int64_t kLongestShelfS = std::int64_t{7} * 24 * 3600;

constexpr Field kAlarmFields[] = {
    text("name", "By which calls name it"),
    choice("state", "normal|unacked active|acked active|unacked returned|shelved|suppressed|out of service",
           "As ISA-18.2 has them"),
    boolean("active", "The condition holds, whatever the state is"),
    choice("priority", "low|medium|high|critical", "How soon somebody has to act"),
    text("class", "What it is about; or empty"),
    text("text", "What has happened"),
    text("help", "What to do; or empty"),
    optional(number("value", "Latest value of its variable; durations in seconds")),
    text("variable", "That it watches; empty: an instance of the block ALARM"),
    optional(text("since", "UTC, when it was raised")),
    optional(text("task", "In whose scan it was raised; without: between scans")),
    optional(integer("scan", "Scan of that task, counted from 0 since recording began")),
    text("group", "Alarms that follow from one cause; or empty"),
    optional(integer("order", "In its group: 1 was raised first; alarms of one scan have one number")),
    optional(text("user", "Who acknowledged it, shelved it or took it out of service")),
    optional(text("comment", "What was said with it")),
    optional(text("until", "UTC, when its shelf ends")),
};
constexpr Record kAlarm = {"Alarm", "An alarm and its state.", kAlarmFields};

Json alarm_json(const alarms::View& view) {
  const alarms::Definition& definition = view.definition;
  Json row;
  row["name"] = definition.name;
  row["state"] = alarms::kStateTexts[static_cast<std::size_t>(view.state)];
  row["active"] = view.active;
  row["priority"] = alarms::kPriorityTexts[static_cast<std::size_t>(definition.priority)];
  row["class"] = definition.category;
  row["text"] = definition.text.empty() ? definition.name : definition.text;
  row["help"] = definition.help;
  if (std::isfinite(view.value)) row["value"] = view.value;
  row["variable"] = definition.variable;
  if (view.raised.utc_ns != 0) row["since"] = log::time_text(view.raised.utc_ns);
  if (view.raised.task) {
    row["task"] = view.task;
    row["scan"] = view.raised.scan;
  }
  row["group"] = definition.group;
  if (view.order != 0) row["order"] = view.order;
  if (!view.user.empty()) row["user"] = view.user;
  if (!view.comment.empty()) row["comment"] = view.comment;
  if (view.until_ns) row["until"] = log::time_text(*view.until_ns);
  return row;
}

constexpr Field kListRequest[] = {
    optional(boolean("all", "Those in their normal state, too")),
    optional(integer("most", "So many at most; default 1000", 0, 10'000)),
};
constexpr Field kListAnswer[] = {
    records("alarms", kAlarm, "Those that need somebody first: unacknowledged ones, by priority, the newest first"),
    integer("all", "How many alarms there are, in any state"),
    integer("active", "Shown as active"),
    integer("unacked", "Not acknowledged"),
    integer("hidden", "Shelved, suppressed or out of service"),
    optional(record("newest", kAlarm, "That was raised last and is not acknowledged")),
};

void list(Context& context, const Caller&, const Json& request, Answer& answer) {
  Json& body = answer.body();
  Json& rows = body["alarms"] = Json::array();
  std::int64_t active = 0, unacked = 0, hidden = 0;
  const alarms::View* newest = nullptr;
  const auto most = request.value("most", std::size_t{1000});
  const auto views =
      context.alarms == nullptr ? std::vector<alarms::View>() : context.alarms->list(request.value("all", false));
  for (const alarms::View& view : views) {
    const bool waits = view.state == State::kUnackedActive || view.state == State::kUnackedReturned;
    active += view.state == State::kUnackedActive || view.state == State::kAckedActive ? 1 : 0;
    unacked += waits ? 1 : 0;
    hidden += view.state >= State::kShelved ? 1 : 0;
    if (waits && (newest == nullptr || view.raised.utc_ns > newest->raised.utc_ns)) newest = &view;
    if (rows.size() < most) rows.push_back(alarm_json(view));
  }
  body["all"] = context.alarms == nullptr ? 0 : context.alarms->count();
  body["active"] = active;
  body["unacked"] = unacked;
  body["hidden"] = hidden;
  if (newest != nullptr) body["newest"] = alarm_json(*newest);
}

alarms::Alarms::Deed deed_of(const Context& context, const Caller& caller, const Json& request, const char* comment) {
  return {caller.user, request.value(comment, ""), context.calendar.utc_ns(),
          context.scheduler.program_ns(context.clock.now_ns())};
}

/// Whether there is an alarm of this name; else the answer says so.
bool knows(Context& context, const std::string& name, Answer& answer, std::string field = "name") {
  if (context.alarms != nullptr && context.alarms->has(name)) return true;
  answer.refuse({Code::P7101, "there is no alarm \"" + name + "\"", "alarms.list all=true lists them"},
                std::move(field));
  return false;
}

constexpr Field kAckRequest[] = {
    optional(texts("names", "Which ones; without: all that are not acknowledged", kMostNames)),
    optional(text("comment", "What for", 0, 500)),
};
constexpr Field kAckAnswer[] = {integer("acknowledged", "How many")};

void acknowledge(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  std::vector<std::string> names;
  for (const Json& name : request.value("names", Json::array())) {
    names.push_back(name.get<std::string>());
    if (!knows(context, names.back(), answer, fmt::format("names[{}]", names.size() - 1))) return;
  }
  const bool none = request.contains("names") && names.empty();
  const std::size_t count = context.alarms == nullptr || none
                                ? 0
                                : context.alarms->acknowledge(names, deed_of(context, caller, request, "comment"));
  if (count != 0) context.audit.add(caller.user, caller.address, "alarms.ack", request);
  answer.body()["acknowledged"] = count;
}

constexpr Field kShelveRequest[] = {
    text("name", "Which one", 1, 1000),
    integer("seconds", "It comes back by itself after this time", 1, kLongestShelfS),
    text("reason", "Why, for those who miss it", 1, 500),
};
constexpr Field kShelveAnswer[] = {text("until", "UTC")};

void shelve(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["name"].get<std::string>();
  if (!knows(context, name, answer)) return;
  const alarms::Alarms::Deed deed = deed_of(context, caller, request, "reason");
  const core::TimeNs until_ns = deed.utc_ns + request["seconds"].get<core::TimeNs>() * 1'000'000'000;
  context.alarms->shelve(name, until_ns, deed);
  context.audit.add(caller.user, caller.address, "alarms.shelve", request);
  answer.body()["until"] = log::time_text(until_ns);
}

constexpr Field kUnshelveRequest[] = {text("name", "Which one", 1, 1000)};

void unshelve(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["name"].get<std::string>();
  if (!knows(context, name, answer)) return;
  context.alarms->unshelve(name, deed_of(context, caller, request, "reason"));
  context.audit.add(caller.user, caller.address, "alarms.unshelve", request);
  answer.body() = Json::object();
}

constexpr Field kServiceRequest[] = {
    text("name", "Which one", 1, 1000),
    boolean("out", "Out of service: it is not shown until it is put into service again"),
    text("reason", "Why", 1, 500),
};

void service(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["name"].get<std::string>();
  if (!knows(context, name, answer)) return;
  context.alarms->take_out_of_service(name, request["out"].get<bool>(), deed_of(context, caller, request, "reason"));
  context.audit.add(caller.user, caller.address, "alarms.service", request);
  answer.body() = Json::object();
}

constexpr Field kEventFields[] = {
    integer("number", "Counted from 1 on, over restarts"),
    text("time", "UTC; of the scan, where there is one"),
    choice("what", "raised|returned|acknowledged|shelved|unshelved|suppressed|unsuppressed|out of service|in service",
           "What happened"),
    text("alarm", "Its name"),
    choice("priority", "low|medium|high|critical", "How soon somebody has to act"),
    text("class", "What it is about; or empty"),
    text("text", "What had happened"),
    optional(number("value", "Of its variable then")),
    optional(text("task", "In whose scan; without: between scans")),
    optional(integer("scan", "Scan of that task, counted from 0 since recording began")),
    optional(text("user", "Who did it")),
    optional(text("comment", "What was said with it")),
};
constexpr Record kEvent = {"AlarmEvent", "What happened to an alarm.", kEventFields};

constexpr Field kHistoryRequest[] = {
    optional(integer("before", "Events before the one of this number; without: the newest", 1, INT64_MAX)),
    optional(text("name", "Of this alarm alone", 1, 1000)),
    optional(number("from", "Seconds since 1970, UTC")),
    optional(number("to", "Until when")),
    optional(integer("most", "So many at most; default 100", 1, 1000)),
};
constexpr Field kHistoryAnswer[] = {records("events", kEvent, "The newest first")};

void history(Context& context, const Caller&, const Json& request, Answer& answer) {
  alarms::HistoryRequest wanted;
  wanted.before = request.value("before", std::int64_t{0});
  wanted.alarm = request.value("name", "");
  const auto time = [&](const char* name) {
    return static_cast<core::TimeNs>(std::clamp(request.value(name, 0.0), 0.0, 9e9) * 1e9);
  };
  wanted.from_ns = time("from");
  wanted.to_ns = time("to");
  wanted.most = request.value("most", std::size_t{100});
  Json& rows = answer.body()["events"] = Json::array();
  if (context.alarm_store == nullptr) return;
  for (const alarms::Event& event : context.alarm_store->read(wanted)) {
    Json row;
    row["number"] = event.number;
    row["time"] = log::time_text(event.utc_ns);
    row["what"] = alarms::kHappenedTexts[static_cast<std::size_t>(event.what)];
    row["alarm"] = event.alarm;
    row["priority"] = alarms::kPriorityTexts[static_cast<std::size_t>(event.priority)];
    row["class"] = event.category;
    row["text"] = event.text.empty() ? event.alarm : event.text;
    if (event.value && std::isfinite(*event.value)) row["value"] = *event.value;
    if (event.scan) {
      row["task"] = event.task;
      row["scan"] = *event.scan;
    }
    if (!event.user.empty()) row["user"] = event.user;
    if (!event.comment.empty()) row["comment"] = event.comment;
    rows.push_back(std::move(row));
  }
}

constexpr Call kCalls[] = {
    {.name = "alarms.list",
     .path = "/api/alarms",
     .doc = "Alarms of the plant and their states.",
     .request = kListRequest,
     .response = kListAnswer,
     .example = R"({"all": true, "most": 100})",
     .run = list},
    {.name = "alarms.ack",
     .method = Method::kPost,
     .path = "/api/alarms/ack",
     .right = Right::kOperator,
     .doc = "Acknowledges alarms: somebody has seen them. Recorded in the audit.",
     .request = kAckRequest,
     .response = kAckAnswer,
     .example = R"({"comment": "valve was cleaned"})",
     .run = acknowledge},
    {.name = "alarms.shelve",
     .method = Method::kPost,
     .path = "/api/alarms/shelve",
     .right = Right::kOperator,
     .doc =
         "Takes an alarm out of sight for a time. When that ends and the condition holds, it is raised again. Recorded "
         "in the audit.",
     .request = kShelveRequest,
     .response = kShelveAnswer,
     .example = R"({"name": "LevelHigh", "seconds": 600, "reason": "sensor is being cleaned"})",
     .run = shelve},
    {.name = "alarms.unshelve",
     .method = Method::kPost,
     .path = "/api/alarms/unshelve",
     .right = Right::kOperator,
     .doc = "Ends a shelf. Recorded in the audit.",
     .request = kUnshelveRequest,
     .example = R"({"name": "LevelHigh"})",
     .run = unshelve},
    {.name = "alarms.service",
     .method = Method::kPost,
     .path = "/api/alarms/service",
     .right = Right::kEngineer,
     .doc = "Takes an alarm out of service, or puts it into service again. Recorded in the audit.",
     .request = kServiceRequest,
     .example = R"({"name": "LevelHigh", "out": false, "reason": "sensor is good again"})",
     .run = service},
    {.name = "alarms.history",
     .path = "/api/alarms/history",
     .doc = "What happened to alarms, over restarts.",
     .request = kHistoryRequest,
     .response = kHistoryAnswer,
     .example = R"({"most": 10})",
     .run = history,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> alarm_calls() { return kCalls; }

}  // namespace plc::engineering
