// Diagrams of the past: calls of the subject "diagrams" that execute recorded scans again.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/diagram_services.h"
#include "engineering/drawn_place.h"
#include "engineering/flow_points.h"
#include "engineering/subjects.h"
#include "shadow/cause.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr std::int64_t kMostPoints = 20'000;
/// For the way back to a cause.
constexpr std::chrono::milliseconds kCauseLimit{15'000};

void refuse_without_recording(Answer& answer) { answer.refuse({Code::P7720, "nothing is recorded", kRecordingIsOff}); }

constexpr Field kTaskFields[] = {
    text("task", "Its name"),
    integer("first", "Its first scan that is here"),
    integer("last", "Its last one"),
};
constexpr Record kPastTask = {"PastTask", "The scans of a task in a recording.", kTaskFields};
constexpr Field kPastAnswer[] = {
    integer("recording", "Its number, for other calls"),
    records("tasks", kPastTask, "Tasks that have scans in it"),
};

Json past_tasks(const Context& context, const shadow::Past& past) {
  Json tasks = Json::array();
  const auto& all = context.drawn->diagrams.resource().image().tasks;
  for (std::uint32_t task = 0; task < all.size(); ++task) {
    if (const auto scans = past.scans(task))
      tasks.push_back({{"task", all[task].name}, {"first", scans->first}, {"last", scans->last}});
  }
  return tasks;
}

void open_past(Context& context, const Caller&, const Json&, Answer& answer) {
  if (context.shadow == nullptr) return refuse_without_recording(answer);
  const auto view = context.drawn->past.open(*context.shadow, context.clock.now_ns());
  if (!view) return answer.refuse(view.error());
  answer.body()["recording"] = (*view)->number;
  answer.body()["tasks"] = past_tasks(context, *(*view)->past);
}

/// Which instance of which drawing in which recording a request is about.
struct Asked {
  std::shared_ptr<const Diagrams::Book> book;
  const DrawnPou* pou = nullptr;
  DrawnInstance instance;
  PastViews::View* view = nullptr;
};

bool find_asked(Context& context, const Json& request, Answer& answer, Asked& asked) {
  Diagrams& diagrams = context.drawn->diagrams;
  asked.book = diagrams.book();
  if (!asked.book) {
    answer.refuse({Code::P7740, "the image that runs has no drawings",
                   "start plc-run with the project, or compile with plc compile --drawings"});
    return false;
  }
  const auto name = request["pou"].get<std::string>();
  asked.pou = asked.book->find(name);
  const auto instance = asked.pou == nullptr ? std::nullopt
                                             : diagrams.instance(*asked.pou, request.value("instance", std::string()),
                                                                 request.value("task", std::string()));
  if (!instance) {
    answer.refuse({Code::P7101, fmt::format("no task executes such an instance of \"{}\"", name), {}}, "instance");
    return false;
  }
  asked.instance = *instance;
  if (request.contains("recording")) {
    asked.view = context.drawn->past.find(request["recording"].get<std::uint64_t>(), context.clock.now_ns());
    if (asked.view == nullptr)
      answer.refuse(404, Code::P7741, "this recording is not kept any more", "recording", "stop the time again");
    return asked.view != nullptr;
  }
  if (context.shadow == nullptr) return refuse_without_recording(answer), false;
  const auto opened = context.drawn->past.open(*context.shadow, context.clock.now_ns());
  if (!opened) return answer.refuse(opened.error()), false;
  asked.view = *opened;
  return true;
}

/// The scan that is asked for: by its number, else by the time, else the last one.
std::optional<std::uint64_t> scan_of(const Json& request, const Asked& asked) {
  const shadow::Past& past = *asked.view->past;
  if (request.contains("scan")) return past.nearest(asked.instance.task, request["scan"].get<std::uint64_t>());
  const auto all = past.scans(asked.instance.task);
  if (request.contains("now_ns")) return past.scan_at(asked.instance.task, request["now_ns"].get<core::TimeNs>());
  return all ? std::optional(all->last) : std::nullopt;
}

void refuse_scan(Answer& answer) {
  answer.refuse(404, Code::P7741, "the recording has no such scan of this task", "scan");
}

constexpr Field kFlowRequest[] = {
    integer("recording", "Number of the recording", 1, INT64_MAX),
    text("pou", "Whose drawing", 1, 500),
    optional(text("instance", "Path of the instance; default: the first one", 0, 1000)),
    optional(text("task", "Name of the task; default: the first one that executes it", 0, 200)),
    numbers("points", "Numbers of what is in view", kMostPoints),
    optional(
        integer("scan", "Of the task; one that is not there: the last one before it. Default: the last", 0, INT64_MAX)),
    optional(integer("now_ns", "Instead: the last scan at this time of the plant or before", 0, INT64_MAX)),
};
constexpr Field kFlowAnswer[] = {
    text("task", "Name of the task"),
    integer("scan", "What is shown"),
    integer("first", "First scan of the task that is here"),
    integer("last", "Last one"),
    integer("now_ns", "Time of the plant when it began"),
    integer("utc_ms", "Date and time when it began, since 1970"),
    records("points", kFlowPoint, "In the order of the request; without those that have nothing"),
};

void flow(Context& context, const Caller&, const Json& request, Answer& answer) {
  Asked asked;
  if (!find_asked(context, request, answer, asked)) return;
  const auto points = context.drawn->diagrams.points(*asked.pou);
  shadow::Past& past = *asked.view->past;
  const auto scan = scan_of(request, asked);
  if (!scan) return refuse_scan(answer);
  const std::uint32_t task = asked.instance.task;
  Json& body = answer.body();
  const bool seen = past.look(task, *scan, {&asked.instance.at.view, 1}, [&](const runtime::RecordHead& head) {
    body["task"] = context.drawn->diagrams.resource().image().tasks[task].name;
    body["scan"] = head.scan;
    body["first"] = past.scans(task)->first;
    body["last"] = past.scans(task)->last;
    body["now_ns"] = head.now_ns;
    body["utc_ms"] = head.utc_ns / 1'000'000;
    Json& all = body["points"] = Json::array();
    const shadow::ProbeView view(past.resource().program(task), asked.instance.at.view);
    for (const Json& number : request["points"]) {
      const auto row = number.get<std::uint64_t>();
      if (row >= points.size() || !view.any()) continue;
      const auto shown = view.at(points[row].key);
      if (!shown) continue;
      const FlowPoint point = flow_point(*shown, view.text(points[row].key, runtime::ValueStyle::kNames));
      all.push_back(flow_json(static_cast<std::uint32_t>(row), point));
    }
  });
  if (!seen) refuse_scan(answer);
}

constexpr Field kWhyRequest[] = {
    text("pou", "Where the variable stands", 1, 500),
    text("name", "Its name there: a BOOL", 1, 500),
    optional(text("instance", "Path of the instance; default: the first one", 0, 1000)),
    optional(text("task", "Name of the task; default: the first one that executes it", 0, 200)),
    optional(integer("recording", "Number of the recording; default: a new one", 1, INT64_MAX)),
    optional(integer("scan", "After which the variable has the value; default: the last", 0, INT64_MAX)),
};
constexpr Field kLinkFields[] = {
    choice("kind", "asked|wrote|contact|block|rail|not run|outside|as begun|seen|too far",
           "asked: the variable; wrote: what gave it the value; contact: what changed the power there, which is asked "
           "for next. Ends: block: its output; rail: nothing is between; not run: what writes it is not executed; "
           "outside: an input, an HMI, a force, another task; seen: it keeps itself; too far: it takes too long. as "
           "begun: the value is as old as the recording"),
    text("variable", "Its name there"),
    boolean("value", "Of the variable, or of the power"),
    text("task", "Whose scan"),
    integer("scan", "In which it got the value"),
    optional(integer("now_ns", "Time of the plant when that scan began")),
    optional(integer("utc_ms", "Date and time, since 1970")),
    optional(text("instance", "Path of the instance")),
    optional(record("place", kDrawnPlace, "The contact, coil, statement or block")),
};
constexpr Record kLink = {"CauseLink", "One step on the way back to a cause.", kLinkFields};
constexpr Field kWhyAnswer[] = {
    integer("recording", "In which the scans are"),
    records("links", kLink, "From what was asked for to its cause"),
};

Json link_json(const Context& context, const Asked& asked, const shadow::CauseLink& link) {
  constexpr std::string_view kKinds[] = {"asked",   "wrote",   "contact",  "block", "rail",
                                         "not run", "outside", "as begun", "seen",  "too far"};
  Json row = {{"kind", kKinds[static_cast<std::size_t>(link.kind)]},
              {"variable", link.variable},
              {"value", link.value},
              {"task", context.drawn->diagrams.resource().image().tasks[link.task].name},
              {"scan", link.scan}};
  if (link.utc_ns != 0) {
    row["now_ns"] = link.now_ns;
    row["utc_ms"] = link.utc_ns / 1'000'000;
  }
  if (!link.placed) return row;
  const DrawnPou* const pou = asked.book->find(link.body->name);
  if (pou == nullptr) return row;
  std::size_t body = 0;
  while (body + 1 < pou->bodies.size() && pou->bodies[body] != link.body) ++body;
  row["instance"] = link.instance.path;
  const bool drawn = !link.body->elements.empty();
  row["place"] = place_json(*pou, body, drawn ? link.element : kNoElement, link.line, link.variable);
  return row;
}

void why(Context& context, const Caller&, const Json& request, Answer& answer) {
  Asked asked;
  if (!find_asked(context, request, answer, asked)) return;
  const auto scan = scan_of(request, asked);
  if (!scan) return refuse_scan(answer);
  const auto links = shadow::cause_of(*asked.view->past, asked.book->drawings, asked.instance.task, *scan,
                                      asked.instance.at, request["name"].get<std::string>(), kCauseLimit,
                                      context.program == nullptr ? nullptr : &context.program->ending);
  if (links.empty()) {
    return answer.refuse(
        {Code::P7742, "this is no BOOL that has a name here", "ask for the variable of a contact or coil"}, "name");
  }
  answer.body()["recording"] = asked.view->number;
  Json& all = answer.body()["links"] = Json::array();
  for (const shadow::CauseLink& link : links) all.push_back(link_json(context, asked, link));
}

constexpr Call kCalls[] = {
    {.name = "diagrams.past",
     .method = Method::kPost,
     .path = "/api/diagrams/past",
     .doc = "Stops the time: keeps the scans that are in memory, to look into them, while somebody does. Three at once "
            "are kept; the one that was unused for longest gives way.",
     .response = kPastAnswer,
     .example = "{}",
     .run = open_past,
     .thread = Thread::kPast},
    {.name = "diagrams.flow",
     .method = Method::kPost,
     .path = "/api/diagrams/flow",
     .doc = "The power flow of a part of a drawing in any scan of such a recording.",
     .request = kFlowRequest,
     .response = kFlowAnswer,
     .example = R"({"recording": 1, "pou": "Station", "points": [0, 1, 2]})",
     .run = flow,
     .thread = Thread::kPast},
    {.name = "diagrams.why",
     .method = Method::kPost,
     .path = "/api/diagrams/why",
     .doc = "Why a BOOL has its value: back to the contact, the rung and the scan that changed it, and on from there, "
            "across POUs.",
     .request = kWhyRequest,
     .response = kWhyAnswer,
     .example = R"({"pou": "Station", "name": "Running"})",
     .run = why,
     .thread = Thread::kPast},
};

}  // namespace

std::span<const Call> past_calls() { return kCalls; }

}  // namespace plc::engineering
