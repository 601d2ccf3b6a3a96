// What the PLC is, and how it is: calls of the subject "target".
#include <fmt/format.h>
#include <sys/utsname.h>

#include <nlohmann/json.hpp>

#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/health.h"
#include "engineering/openapi.h"
#include "engineering/subjects.h"
#include "log/format.h"

namespace plc::engineering {
namespace {

using namespace field;

constexpr Field kVersionAnswer[] = {
    text("product", "Name and version of the server, \"PICARD 0.1.0\""),
    integer("api", "Version of these calls; they change compatibly as long as it is the same"),
};

void version(Context& context, const Caller&, const Json&, Answer& answer) {
  answer.body() = {{"product", context.identity.product}, {"api", kApiVersion}};
}

void openapi(Context&, const Caller&, const Json&, Answer& answer) { answer.give_ready(openapi_text()); }

constexpr Field kTargetAnswer[] = {
    text("product", "Name and version of the server"),
    text("plant", "The plant, as people call it"),
    text("machine", "Host name"),
    text("system", "Kernel and its release"),
    text("processor", "Architecture: x86_64, aarch64"),
    text("state",
         "starts, runs, faulted (a task had a fault and goes on), stopped (a task has ended by a fault, or all by "
         "program.stop) or stops"),
    integer("uptime_ms", "Since the tasks started"),
    text("time", "Date and time of the machine, UTC"),
    boolean("realtime_priority", "All tasks have real-time priorities"),
    boolean("memory_locked", "No page of the program can be swapped out"),
    texts("refused", "What the system did not grant, in sentences"),
};

void target(Context& context, const Caller&, const Json&, Answer& answer) {
  utsname system{};
  ::uname(&system);
  const runtime::RealtimeReport& report = context.scheduler.report();
  Json& body = answer.body();
  body["product"] = context.identity.product;
  body["plant"] = context.identity.plant;
  body["machine"] = context.identity.machine;
  body["system"] = fmt::format("{} {}", system.sysname, system.release);
  body["processor"] = system.machine;
  const bool halted = context.program != nullptr && context.program->state() == ProgramControl::State::kStopped;
  body["state"] = halted ? "stopped" : plant_state(context.variables.image(), context.scheduler);
  body["uptime_ms"] = (context.clock.now_ns() - context.begin_ns) / 1'000'000;
  body["time"] = log::time_text(context.calendar.utc_ns());
  body["realtime_priority"] = report.realtime_priority;
  body["memory_locked"] = report.memory_locked;
  body["refused"] = report.refused;
}

constexpr Call kCalls[] = {
    {.name = "version",
     .path = "/api/version",
     .right = Right::kAnybody,
     .doc = "Which server this is. All that it tells before login.",
     .response = kVersionAnswer,
     .example = "{}",
     .run = version},
    {.name = "openapi",
     .path = "/api/openapi.json",
     .right = Right::kAnybody,
     .doc = "These calls as an OpenAPI 3.1 document.",
     .example = "{}",
     .run = openapi},
    {.name = "target",
     .path = "/api/target",
     .doc = "What the PLC is, and how it is.",
     .response = kTargetAnswer,
     .example = "{}",
     .run = target},
};

}  // namespace

std::span<const Call> target_calls() { return kCalls; }

}  // namespace plc::engineering
