// Drawings of POUs and their power flow: calls of the subject "diagrams".
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/text.h"
#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/diagram_search.h"
#include "engineering/diagram_services.h"
#include "engineering/drawn_place.h"
#include "engineering/subjects.h"
#include "pictures/picture.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr std::int64_t kMostInstances = 10'000;
constexpr std::int64_t kMostFound = 500;
constexpr std::int64_t kMostSide = 8192;
/// Pieces of a part of a drawing.
constexpr std::size_t kMostPieces = 5000;

void refuse_without(Answer& answer) {
  answer.refuse({Code::P7740, "the image that runs has no drawings",
                 "start plc-run with the project, or compile with plc compile --drawings"});
}
void refuse_unknown(Answer& answer, const std::string& pou) {
  answer.refuse({Code::P7101, fmt::format("there is no POU \"{}\" with a drawing", pou), {}}, "pou");
}

std::shared_ptr<const Diagrams::Opened> opened(Context& context, const Json& request, Answer& answer) {
  if (!context.drawn->diagrams.book()) return refuse_without(answer), nullptr;
  const auto name = request["pou"].get<std::string>();
  auto found = context.drawn->diagrams.open(name);
  if (!found) refuse_unknown(answer, name);
  return found;
}

constexpr Field kPouFields[] = {
    text("pou", "Its name; of actions and transitions \"Main.Start\""),
    choice("owner", "program|function block|function|action|transition", "What it is"),
    choice("language", "LD|FBD|ST|IL|SFC", "In which it is written"),
    integer("instances", "How many instances tasks execute; 10000: so many or more"),
    boolean("live", "Its power flow can be shown"),
};
constexpr Record kPou = {"DrawnPou", "A POU with a drawing or a text.", kPouFields};
constexpr Field kListAnswer[] = {records("pous", kPou, "In the order of the project; none: the image has no drawings")};

void list(Context& context, const Caller&, const Json&, Answer& answer) {
  constexpr std::string_view kOwners[] = {"program", "function block", "function", "action", "transition"};
  constexpr std::string_view kLanguages[] = {"LD", "FBD", "ST", "IL", "SFC"};
  Diagrams& diagrams = context.drawn->diagrams;
  Json& all = answer.body()["pous"] = Json::array();
  const auto book = diagrams.book();
  for (std::size_t i = 0; book && i < book->pous.size(); ++i) {
    const DrawnPou& pou = book->pous[i];
    const std::size_t count = diagrams.instances(pou, kMostInstances).size();
    all.push_back({{"pou", pou.name},
                   {"owner", kOwners[static_cast<std::size_t>(pou.bodies[0]->owner)]},
                   {"language", kLanguages[static_cast<std::size_t>(pou.bodies[0]->language)]},
                   {"instances", count},
                   {"live", context.drawn->live.on() && count != 0 && !diagrams.points(pou).empty()}});
  }
}

constexpr Field kInstanceFields[] = {
    text("path", "Its path; of a function the name"),
    text("task", "Name of the task that executes it"),
};
constexpr Record kInstance = {"DrawnInstance", "An instance of a POU.", kInstanceFields};
constexpr Field kInstancesRequest[] = {
    text("pou", "Whose instances", 1, 500),
    optional(text("pattern", "A part of the path", 0, 500)),
    optional(integer("most", "So many at most; default 1000", 1, kMostInstances)),
};
constexpr Field kInstancesAnswer[] = {
    records("instances", kInstance, "Task by task"),
    integer("total", "How many match"),
};

void instances(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto book = context.drawn->diagrams.book();
  if (!book) return refuse_without(answer);
  const auto name = request["pou"].get<std::string>();
  const DrawnPou* const pou = book->find(name);
  if (pou == nullptr) return refuse_unknown(answer, name);
  const std::string pattern = core::folded(request.value("pattern", std::string()));
  const auto most = request.value("most", std::size_t{1000});
  Json& all = answer.body()["instances"] = Json::array();
  std::size_t total = 0;
  for (const DrawnInstance& one : context.drawn->diagrams.instances(*pou, kMostInstances)) {
    if (core::folded(one.at.path).find(pattern) == std::string::npos) continue;
    if (total++ >= most) continue;
    all.push_back({{"path", one.at.path}, {"task", context.drawn->diagrams.resource().image().tasks[one.task].name}});
  }
  answer.body()["total"] = total;
}

constexpr Field kSheetRequest[] = {
    text("pou", "Whose drawing", 1, 500),
    optional(boolean("breaks", "Where pages may end, too")),
};
constexpr Field kSheetAnswer[] = {
    integer("width", "Pixels"),
    integer("height", "Pixels"),
    integer("points", "How many places have values"),
    optional(numbers("breaks", "Heights at which nothing is cut")),
};

void sheet(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto found = opened(context, request, answer);
  if (!found) return;
  answer.body()["width"] = found->sheet->width();
  answer.body()["height"] = found->sheet->height();
  answer.body()["points"] = context.drawn->diagrams.points(*found->pou).size();
  if (request.value("breaks", false)) answer.body()["breaks"] = found->sheet->breaks();
}

constexpr Field kTileRequest[] = {
    text("pou", "Whose drawing", 1, 500),
    integer("x", "Left border, pixels", 0, bytecode::kMaxDrawn),
    integer("y", "Upper border", 0, INT32_MAX - kMostSide),
    integer("width", "How wide the part is", 1, kMostSide),
    integer("height", "How high the part is", 1, kMostSide),
};
constexpr Field kTileAnswer[] = {
    text("svg",
         "What touches the rectangle, as pieces of SVG. data-k is the number of a point, data-e an element, "
         "data-name what it is called, data-type of which type a block is"),
    integer("left_out", "Pieces that are not in it: there are more than 5000"),
};

void tile(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto found = opened(context, request, answer);
  if (!found) return;
  pictures::Sheet::Part part =
      found->sheet->draw(request["x"].get<std::int32_t>(), request["y"].get<std::int32_t>(),
                         request["width"].get<std::int32_t>(), request["height"].get<std::int32_t>(), kMostPieces);
  answer.body()["svg"] = std::move(part.svg);
  answer.body()["left_out"] = part.left_out;
}

constexpr Field kPlaceRequest[] = {
    text("pou", "Whose drawing", 1, 500),
    integer("body", "Worksheet, from 0", 0, 65'535),
    optional(integer("element", "Of a drawing", 0, UINT32_MAX)),
    optional(integer("line", "Of a text, as the file counts", 1, UINT32_MAX)),
};
constexpr Field kPlaceAnswer[] = {
    integer("x", "Left border, pixels"),
    integer("y", "Upper border"),
    integer("width", "How wide it is"),
    integer("height", "How high it is"),
};

void place(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto found = opened(context, request, answer);
  if (!found) return;
  const auto body = request["body"].get<std::size_t>();
  std::optional<pictures::Sheet::Place> at;
  if (body < found->pou->bodies.size()) {
    const bytecode::DrawnBody& drawn = *found->pou->bodies[body];
    const std::uint32_t line = request.value("line", std::uint32_t{0});
    const bool text = drawn.elements.empty();
    if (text ? line >= drawn.text_line : request.contains("element"))
      at = found->sheet->place_of(body, text ? line - drawn.text_line : request["element"].get<std::size_t>());
  }
  if (!at) return answer.refuse({Code::P7101, "there is no such element or line", {}}, "element");
  answer.body() = {{"x", at->x}, {"y", at->y}, {"width", at->width}, {"height", at->height}};
}

constexpr Field kFindRequest[] = {
    text("text", "A part of what stands there; of a variable its name", 1, 200),
    optional(text("pou", "Only there; with uses: where the name stands", 1, 500)),
    optional(text("instance", "With uses: on which instance", 0, 1000)),
    optional(boolean("uses", "All places of the variable of this name, under whatever name")),
    optional(integer("most", "So many at most; default 200", 1, kMostFound)),
};
constexpr Field kFoundFields[] = {
    record("place", kDrawnPlace, "Where"),
    boolean("writes", "The variable gets its value there"),
};
constexpr Record kFound = {"DrawnUse", "A place that was found.", kFoundFields};
constexpr Field kFindAnswer[] = {
    records("found", kFound, "In the order of the project"),
    boolean("more", "There are more"),
    optional(text("path", "With uses: path of the variable, for other calls")),
};

void find(Context& context, const Caller&, const Json& request, Answer& answer) {
  Diagrams& diagrams = context.drawn->diagrams;
  const auto book = diagrams.book();
  if (!book) return refuse_without(answer);
  DiagramSearch search(diagrams, *book);
  search.text = request["text"].get<std::string>();
  search.most = request.value("most", std::size_t{200});
  const auto pou = request.value("pou", std::string());
  const DrawnPou* const in = book->find(pou);
  if (!pou.empty() && in == nullptr) return refuse_unknown(answer, pou);
  if (request.value("uses", false)) {
    if (in == nullptr) return refuse_unknown(answer, pou);
    const auto instance = diagrams.instance(*in, request.value("instance", std::string()), {});
    search.find_uses(*in, instance ? &*instance : nullptr);
    if (!search.path.empty()) answer.body()["path"] = search.path;
  } else {
    search.find_text(in);
  }
  Json& all = answer.body()["found"] = Json::array();
  for (const DiagramSearch::Found& found : search.found)
    all.push_back({{"place", place_json(*found.pou, found.body, found.element, found.line, found.text)},
                   {"writes", found.writes}});
  answer.body()["more"] = search.more;
}

constexpr Field kSvgRequest[] = {text("pou", "Whose drawing", 1, 500)};

void svg(Context& context, const Caller&, const Json& request, Answer& answer) {
  const auto book = context.drawn->diagrams.book();
  if (!book) return refuse_without(answer);
  const auto name = request["pou"].get<std::string>();
  const DrawnPou* const pou = book->find(name);
  if (pou == nullptr) return refuse_unknown(answer, name);
  std::vector<pictures::PicturedBody> bodies;
  for (const bytecode::DrawnBody* const body : pou->bodies)
    bodies.push_back({body, pou->bodies.size() > 1 ? body->worksheet : std::string(), 0});
  answer.give_file(pictures::svg(pou->name, bodies), pou->name + ".svg");
}

constexpr Field kStreamRequest[] = {
    optional(integer("period_ms", "Time between two frames at least; default 50", 10, 60'000)),
};

constexpr Call kCalls[] = {
    {.name = "diagrams",
     .path = "/api/diagrams",
     .doc = "POUs that are drawn or written, as the image that runs carries them.",
     .response = kListAnswer,
     .example = "{}",
     .run = list,
     .thread = Thread::kFiles},
    {.name = "diagrams.instances",
     .path = "/api/diagrams/instances",
     .doc = "The instances of a POU.",
     .request = kInstancesRequest,
     .response = kInstancesAnswer,
     .example = R"({"pou": "Station"})",
     .run = instances,
     .thread = Thread::kFiles},
    {.name = "diagrams.sheet",
     .path = "/api/diagrams/sheet",
     .doc = "How large the drawing of a POU is.",
     .request = kSheetRequest,
     .response = kSheetAnswer,
     .example = R"({"pou": "Station"})",
     .run = sheet,
     .thread = Thread::kFiles},
    {.name = "diagrams.tile",
     .path = "/api/diagrams/tile",
     .doc = "A part of the drawing of a POU.",
     .request = kTileRequest,
     .response = kTileAnswer,
     .example = R"({"pou": "Station", "x": 0, "y": 0, "width": 1000, "height": 500})",
     .run = tile,
     .thread = Thread::kFiles},
    {.name = "diagrams.place",
     .path = "/api/diagrams/place",
     .doc = "Where an element or a line is in the drawing of its POU.",
     .request = kPlaceRequest,
     .response = kPlaceAnswer,
     .example = R"({"pou": "Station", "body": 0, "element": 0})",
     .run = place,
     .thread = Thread::kFiles},
    {.name = "diagrams.find",
     .path = "/api/diagrams/find",
     .doc = "Searches all drawings and texts: for a part of a text, or for the places of one variable.",
     .request = kFindRequest,
     .response = kFindAnswer,
     .example = R"({"text": "Level"})",
     .run = find,
     .thread = Thread::kFiles},
    {.name = "diagrams.svg",
     .path = "/api/diagrams/svg",
     .doc = "The whole drawing of a POU as a file.",
     .request = kSvgRequest,
     .example = R"({"pou": "Station"})",
     .run = svg,
     .form = Form::kFile,
     .thread = Thread::kFiles},
    {.name = "diagrams.stream",
     .path = "/api/diagrams/stream",
     .doc = "The power flow of a part of a drawing on one instance, as a WebSocket. The client sends {\"pou\", "
            "\"instance\", \"task\", \"points\"}, the server answers, and sends a frame for each scan that it has "
            "executed again, the newest alone.",
     .request = kStreamRequest,
     .form = Form::kStream},
};

}  // namespace

std::span<const Call> diagram_calls() { return kCalls; }

}  // namespace plc::engineering
