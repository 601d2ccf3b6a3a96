// Forced variables: calls of the subject "forces".
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "engineering/value_json.h"
#include "runtime/force_list.h"

namespace plc::engineering {
namespace {

using namespace field;

std::string utc_text(core::TimeNs utc_ns) {
  const core::TimeNs ms = utc_ns / 1'000'000;
  return fmt::format("{:%FT%T}.{:03}Z", fmt::gmtime(ms / 1000), ms % 1000);
}

constexpr Field kForceFields[] = {
    text("path", "The variable, as it was forced"),
    text("value", "The value as people write it: TRUE, Filling, T#1s500ms"),
    text("owner", "Who forces it"),
    text("reason", "Why"),
    text("since", "UTC"),
    optional(text("until", "UTC; without: until it is released")),
    boolean("warm", "It holds after a warm start, too"),
    boolean("yields",
            "The program may write the variable in the middle of a scan: from there to the end of the scan its own "
            "value counts"),
};
constexpr Record kForce = {"Force", "A variable that is forced.", kForceFields};

Json force_json(const runtime::Force& force) {
  Json row;
  row["path"] = force.path;
  row["value"] = force.value;
  row["owner"] = force.owner;
  row["reason"] = force.reason;
  row["since"] = utc_text(force.since_ns);
  if (force.until_ns) row["until"] = utc_text(*force.until_ns);
  row["warm"] = force.kept;
  row["yields"] = force.yields;
  return row;
}

constexpr Field kListAnswer[] = {records("forces", kForce, "In the order in which they were forced")};

void list(Context& context, const Caller&, const Json&, Answer& answer) {
  Json& all = answer.body()["forces"] = Json::array();
  for (const runtime::Force& force : context.forces.list()) all.push_back(force_json(force));
}

/// What holds over a warm start is on the disk with the answer; of a program on trial, once it stays. Empty, or why
/// not.
std::string keep(const Context& context) {
  return context.kept_forces == nullptr ? std::string() : context.kept_forces->store();
}

constexpr Field kSetRequest[] = {
    text("path", "A variable of any elementary type: a global, an input, an output, or one of a program or block", 1,
         1000),
    value("value", "The value"),
    text("reason", "Why, for those who find it forced", 1, 500),
    optional(integer("seconds", "It ends by itself after this time", 1, 2'592'000)),
    optional(
        boolean("warm", "It holds after a warm start, too, of this or another program; default: it ends with plc-run")),
};
constexpr Field kSetAnswer[] = {record("force", kForce, "What holds from the next scan of each task on")};

void set(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  if (context.no_force != nullptr && context.no_force->holds()) {
    return answer.refuse(409, core::Code::P7756, context.no_force->path() + " is TRUE: nothing is forced now");
  }
  runtime::Force force;
  force.path = request["path"].get<std::string>();
  const Json& value = request["value"];
  force.value = value.is_string() ? value.get<std::string>() : value.dump();
  force.owner = caller.user;
  force.reason = request["reason"].get<std::string>();
  force.since_ns = context.calendar.utc_ns();
  if (request.contains("seconds")) {
    const core::TimeNs rest_ns = request["seconds"].get<core::TimeNs>() * 1'000'000'000;
    force.until_ns = force.since_ns + rest_ns;
    force.until_mono_ns = context.clock.now_ns() + rest_ns;
  }
  force.kept = request.value("warm", false);
  if (force.kept && context.kept_forces == nullptr) {
    return answer.refuse(409, core::Code::P7701, "there is no folder in which a force could be kept", "warm",
                         "start plc-run with --state DIR, or force without warm");
  }
  const auto made = context.forces.set(std::move(force));
  if (!made) {
    const core::Code code = made.error().code;
    return answer.refuse(made.error(), code == core::Code::P7101 || code == core::Code::P7102 ? "path" : "value");
  }
  Json row = force_json(*made);
  context.audit.add(caller.user, caller.address, "forces.set", row);
  // A force that was kept may have been replaced by one that is not.
  if (const std::string why = keep(context); !why.empty()) {
    return answer.refuse(409, core::Code::P7701, "it is forced, and what is kept over a start is as before: " + why,
                         "warm");
  }
  answer.body()["force"] = std::move(row);
}

constexpr Field kReleaseRequest[] = {
    optional(text("path", "The variable; without: all that are forced", 1, 1000)),
};
constexpr Field kReleaseAnswer[] = {integer("released", "How many")};

void release(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  std::size_t released = 0;
  if (request.contains("path")) {
    released = context.forces.release(request["path"].get<std::string>(), caller.user) ? 1 : 0;
  } else {
    released = context.forces.release_all({}, caller.user);
  }
  if (released != 0) context.audit.add(caller.user, caller.address, "forces.release", request);
  if (const std::string why = keep(context); !why.empty()) {
    return answer.refuse(409, core::Code::P7701, "it is released, and what is kept over a start is as before: " + why);
  }
  answer.body()["released"] = released;
}

constexpr Call kCalls[] = {
    {.name = "forces.list",
     .path = "/api/forces",
     .doc = "Variables that are forced.",
     .response = kListAnswer,
     .example = R"({})",
     .run = list},
    {.name = "forces.set",
     .method = Method::kPost,
     .path = "/api/forces/set",
     .right = Right::kEngineer,
     .doc = "Forces a variable: it has the value whenever a scan begins and ends, and so has everything that others "
            "see of "
            "it, until it is released. Recorded in the audit.",
     .request = kSetRequest,
     .response = kSetAnswer,
     .example = R"({"path": "%IX0.0", "value": true, "reason": "switch is being changed", "seconds": 60})",
     .run = set,
     .thread = Thread::kFiles},
    {.name = "forces.release",
     .method = Method::kPost,
     .path = "/api/forces/release",
     .right = Right::kEngineer,
     .doc = "The variable is the program's again: it keeps the forced value until somebody writes it. Recorded in the "
            "audit.",
     .request = kReleaseRequest,
     .response = kReleaseAnswer,
     .example = R"({"path": "%IX0.0"})",
     .run = release,
     .thread = Thread::kFiles},
};

}  // namespace

std::span<const Call> force_calls() { return kCalls; }

}  // namespace plc::engineering
