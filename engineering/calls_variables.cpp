// Variables: calls of the subject "values".
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "engineering/value_json.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr std::int64_t kMostPaths = 5000;
constexpr std::uint64_t kMostLeaves = 100'000;
constexpr std::int64_t kMostNodes = 5000;
/// Values in one record of the audit.
constexpr std::size_t kMostAudited = 50;

constexpr Field kNodeFields[] = {
    text("name", "Name below its parent; elements of arrays: \"[3]\""),
    text("path", "Path by which other calls find it"),
    choice("kind", "value|structure|array|list|reference", "What it is; a list holds globals"),
    optional(text("type", "Type, as it is declared")),
    optional(text("address", "Address of a located global, \"%IX0.0\"")),
    optional(boolean("readable", "Its value can be had")),
    optional(boolean("writable", "Clients may write it")),
};
constexpr Record kNode = {"Node", "A name in the tree of variables.", kNodeFields};

constexpr Field kBrowseRequest[] = {
    optional(text("path", "Whose parts; empty: program instances, lists of globals, globals", 0, 1000)),
    optional(integer("from", "The first one, counted from 0", 0, INT32_MAX)),
    optional(integer("most", "So many at most; default 1000", 1, kMostNodes)),
};
constexpr Field kBrowseAnswer[] = {
    records("nodes", kNode, "In the order of the declarations"),
    integer("total", "How many there are"),
};

Json node_json(const Variables& variables, const Node& node) {
  Json row;
  row["name"] = node.name;
  row["path"] = node.path;
  row["kind"] = node.kind;
  if (!node.place) return row;
  row["type"] = type_name(variables.image(), node.place->type);
  row["readable"] = variables.is_readable(*node.place);
  row["writable"] = variables.is_writable(*node.place);
  return row;
}

void browse(Context& context, const Caller&, const Json& request, Answer& answer) {
  const Variables& variables = context.variables;
  std::size_t total = 0;
  const auto nodes = variables.children(request.value("path", ""), request.value("from", std::size_t{0}),
                                        request.value("most", std::size_t{1000}), total);
  if (!nodes) return answer.refuse(nodes.error(), "path");
  Json& all = answer.body()["nodes"] = Json::array();
  for (const Node& node : *nodes) {
    Json row = node_json(variables, node);
    if (node.place) {
      if (const std::string_view address = variables.address(*node.place); !address.empty()) row["address"] = address;
    }
    all.push_back(std::move(row));
  }
  answer.body()["total"] = total;
}

constexpr Field kSearchRequest[] = {
    text("pattern", "Paths that match it; * stands for any characters, ? for one", 1, 1000),
    optional(integer("most", "So many at most; default 100", 1, kMostNodes)),
};
constexpr Field kSearchAnswer[] = {
    records("nodes", kNode, "Single values, instances before globals"),
    boolean("more", "There are more than these"),
};

void search(Context& context, const Caller&, const Json& request, Answer& answer) {
  const std::size_t most = request.value("most", std::size_t{100});
  const auto found =
      runtime::Access(context.variables.resource()).list_places(request["pattern"].get<std::string>(), most + 1);
  Json& all = answer.body()["nodes"] = Json::array();
  for (std::size_t i = 0; i < std::min(most, found.size()); ++i) {
    const std::string& path = found[i].path;
    all.push_back(node_json(context.variables, {path.substr(path.rfind('.') + 1), path, "value", found[i].place}));
  }
  answer.body()["more"] = found.size() > most;
}

constexpr Field kProblemFields[] = {
    text("code", "Code of the problem, with a page of its own"),
    text("text", "What is wrong"),
    optional(text("help", "What to do")),
};
constexpr Record kProblem = {"Problem", "Why one of several things was not done.", kProblemFields};

constexpr Field kValueFields[] = {
    text("path", "As it was asked for"),
    optional(value("value", "The value")),
    optional(text("type", "Type, as it is declared")),
    optional(record("problem", kProblem, "Why there is no value")),
};
constexpr Record kValue = {"Value", "A value, or why there is none.", kValueFields};

constexpr Field kReadRequest[] = {
    texts("paths", "Variables, or parts of them; a structure or array is read as a whole", kMostPaths)};
constexpr Field kReadAnswer[] = {
    records("values", kValue, "One for each path, in their order; values of one task are of one scan"),
};

void read(Context& context, const Caller&, const Json& request, Answer& answer) {
  Variables& variables = context.variables;
  variables.values().take();
  Json& all = answer.body()["values"] = Json::array();
  std::uint64_t leaves = 0;
  for (const Json& path : request["paths"]) {
    Json row;
    row["path"] = path;
    const auto place = variables.find(path.get<std::string>());
    if (!place) {
      Json& problem = row["problem"];
      problem["code"] = core::info(place.error().code).name;
      problem["text"] = place.error().message;
      if (!place.error().help.empty()) problem["help"] = place.error().help;
      all.push_back(std::move(row));
      continue;
    }
    leaves += leaf_count(variables.image(), place->type);
    if (leaves > kMostLeaves) {
      return answer.refuse(413, Code::P7717, fmt::format("these are more than {} single values", kMostLeaves), "paths");
    }
    row["value"] = variables.read(*place);
    row["type"] = type_name(variables.image(), place->type);
    all.push_back(std::move(row));
  }
}

constexpr Field kWriteFields[] = {
    text("path", "A global, or a part of one", 1, 1000),
    value("value", "The value; of a structure the fields to be written, of an array all elements"),
};
constexpr Record kWrite = {"Write", "A value to be written.", kWriteFields};
constexpr Field kWriteRequest[] = {
    records("values", kWrite, "All are written, or none", kMostPaths),
    optional(text("reason", "Why, for those who read the audit", 1, 500)),
    optional(boolean("offered", "Only what pages.toml offers, within its limits; for operators that is always so")),
    optional(integer("until_ms",
                     "UTC in milliseconds, by the clock of the machine: what comes later writes nothing. It does not "
                     "protect when that clock is set back meanwhile")),
};
constexpr Field kWriteAnswer[] = {integer("written", "How many single values; 0: it came after until_ms")};

void write(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  Variables& variables = context.variables;
  std::vector<Variables::Write> writes;
  const Json& values = request["values"];
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string at = fmt::format("values[{}]", i);
    std::string field = ".value";
    const auto path = values[i]["path"].get<std::string>();
    if (const auto problem = variables.prepare(path, values[i]["value"], writes, field)) {
      const bool of_path = problem->code == Code::P7101 && field == ".value";
      return answer.refuse(*problem, at + (of_path ? ".path" : field));
    }
    if (writes.size() > kMostLeaves) {
      return answer.refuse(413, Code::P7717, fmt::format("these are more than {} single values", kMostLeaves),
                           "values");
    }
  }
  if (caller.role < Right::kEngineer || request.value("offered", false)) {
    if (const auto problem = context.hmi.refusal(writes)) return answer.refuse(*problem, "values");
  }
  if (context.is_late(request)) {
    answer.body()["written"] = 0;
    return;
  }
  // What was there before, as far as anybody knows.
  variables.values().take();
  Json details = Json::array();
  for (std::size_t i = 0; i < std::min(values.size(), kMostAudited); ++i) {
    const auto path = values[i]["path"].get<std::string>();
    Json row = {{"path", path}, {"value", values[i]["value"]}};
    if (const auto place = variables.find(path)) row["before"] = variables.read(*place);
    details.push_back(std::move(row));
  }
  if (const auto problem = variables.write(writes)) return answer.refuse(*problem);
  Json record = {{"values", std::move(details)}};
  if (values.size() > kMostAudited) record["more"] = values.size() - kMostAudited;
  if (request.contains("reason")) record["reason"] = request["reason"];
  context.audit.add(caller.user, caller.address, "values.write", record);
  answer.body()["written"] = writes.size();
}

constexpr Field kStreamRequest[] = {
    optional(integer("period_ms", "Time between two frames at least; default 100", 10, 60'000)),
};

constexpr Call kCalls[] = {
    {.name = "values.browse",
     .path = "/api/values",
     .doc = "The names below a path.",
     .request = kBrowseRequest,
     .response = kBrowseAnswer,
     .example = R"({"path": ""})",
     .run = browse},
    {.name = "values.search",
     .path = "/api/values/search",
     .doc = "Variables by a part of their path.",
     .request = kSearchRequest,
     .response = kSearchAnswer,
     .example = R"({"pattern": "*Level*"})",
     .run = search},
    {.name = "values.read",
     .method = Method::kPost,
     .path = "/api/values/read",
     .doc = "Values: globals as the tasks have published them last, variables of programs and blocks as their newest "
            "scans "
            "have left them.",
     .request = kReadRequest,
     .response = kReadAnswer,
     .example = R"({"paths": ["%IX0.0"]})",
     .run = read},
    {.name = "values.write",
     .method = Method::kPost,
     .path = "/api/values/write",
     .right = Right::kOperator,
     .doc = "Writes globals, as an HMI does: a task that writes the variable itself takes the value at its next start. "
            "Where the project has a pages.toml, operators may write what its pages offer, and engineers everything. "
            "Recorded in the audit.",
     .request = kWriteRequest,
     .response = kWriteAnswer,
     .example = R"({"values": [{"path": "%IX0.0", "value": true}]})",
     .run = write},
    {.name = "values.stream",
     .path = "/api/values/stream",
     .doc = "Values as they change, as a WebSocket. The client sends {\"subscribe\": [paths]}, the server answers with "
            "the "
            "layout of its frames, and sends binary frames from then on.",
     .request = kStreamRequest,
     .form = Form::kStream},
};

}  // namespace

std::span<const Call> variable_calls() { return kCalls; }

}  // namespace plc::engineering
