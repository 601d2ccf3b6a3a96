// EngineeringRig: a small plant with all that calls of the engineering server need, without sockets.
//
// Time is virtual. Users: one of each role, "viewer" to "admin", with the password of the same name and "-password".
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "engineering/diagram_services.h"
#include "engineering/dispatch.h"
#include "engineering/streams.h"
#include "tests/support/image_builder.h"
#include "tests/support/run_tool.h"

namespace plc::test {

using engineering::HttpRequest;
using engineering::HttpResponse;
using engineering::Json;
using engineering::Right;

class SetCalendar final : public core::Calendar {
 public:
  [[nodiscard]] core::TimeNs utc_ns() const noexcept override { return now_ns; }
  core::TimeNs now_ns = 1'800'000'000'000'000'000;
};

inline bytecode::VerifiedImage engineering_image() {
  ImageBuilder b;
  const auto outside = [](std::string list = {}, std::string address = {}) {
    return ImageBuilder::GlobalOptions{false, true, std::move(list), std::move(address)};
  };
  const std::uint32_t dint = b.type(TypeId::kDint);
  std::uint32_t colour = b.limited(TypeId::kInt, 0, 2, "Colour");
  b.image.types[colour].members = {"Red", "Green", "Blue"};
  b.image.types[colour].member_values = {0, 1, 2};
  const std::uint32_t point = b.structure("Point", {{"X", dint}, {"Y", dint}});
  b.global("Start", b.boolean(), {}, outside({}, "%IX0.0"));
  b.global("Level", b.type(TypeId::kReal), {}, outside("GVL"));
  b.global("Deep", b.type(TypeId::kLreal), {}, outside("GVL"));
  b.global("Large", b.type(TypeId::kUlint), {}, outside());
  b.global("Long", b.type(TypeId::kLint), {}, outside());
  b.global("Small", b.type(TypeId::kSint), {}, outside());
  b.global("Text", b.string(10), {}, outside());
  b.global("Wide", b.string(10, TypeId::kWstring), {}, outside());
  b.global("Wait", b.type(TypeId::kTime), {}, outside());
  b.global("Day", b.type(TypeId::kDate), {}, outside());
  b.global("Lamp", colour, {}, outside());
  b.global("Percent", b.limited(TypeId::kInt, 0, 100), {}, outside());
  b.global("Points", b.array(point, 3, 1), {}, outside());
  b.global("Fixed", b.type(TypeId::kInt), bytes_of<std::int16_t>(77), {true, false, {}, {}});
  const Word total = b.global("Total", dint, {}, {false, false, {}, {}, 0});
  PouBuilder main = b.pou("Main", PouKind::kProgram);
  const Word count = main.variable("Count", dint);
  main.op(Opcode::kAdd32, {count, count, b.constant<std::int32_t>(TypeId::kDint, 1)});
  main.op(Opcode::kAdd32, {total, total, b.constant<std::int32_t>(TypeId::kDint, 1)});
  b.task("Fast", 10'000'000, {main.finish()});
  core::Diagnostics diagnostics;
  auto image = bytecode::verify(b.build(), diagnostics);
  if (!image) {
    for (const auto& found : diagnostics.all()) ADD_FAILURE() << found.message;
  }
  return std::move(*image);
}

class EngineeringRig {
 public:
  explicit EngineeringRig(bool secure = false, bool with_users = true, const std::string& folder = {},
                          const std::string& project = {})
      : EngineeringRig(engineering_image(), secure, with_users, folder, project) {}
  explicit EngineeringRig(bytecode::VerifiedImage image, bool secure = false, bool with_users = true,
                          const std::string& folder = {}, const std::string& project = {})
      : resource(std::move(*runtime::Resource::load(std::move(image)))),
        values(resource->globals()),
        variables(*resource, values),
        drawn(*resource),
        forces(*resource),
        hmi(project, variables),
        presses(variables, [this](std::uint32_t) { return std::optional(scans); }),
        scheduler(*resource),
        users(std::move(*engineering::Users::open(folder))),
        audit(folder, calendar, audit_said),
        dispatcher_(std::make_unique<engineering::Dispatcher>(context, hosts, secure)) {
    context.drawn = &drawn;
    control.store = store.get();
    control.check = [this](const std::string&) { return check_says; };
    context.program = &control;
    if (!with_users) return;
    for (const char* role : {"viewer", "operator", "engineer", "admin"}) {
      engineering::User user{role, engineering::role_named(role),
                             engineering::hash_password(std::string(role) + "-password", context.cost)};
      EXPECT_FALSE(users->add(user));
    }
  }

  /// A request from this machine, as a script makes it.
  [[nodiscard]] HttpRequest request(const std::string& method, const std::string& target,
                                    const std::string& body = {}) const {
    HttpRequest request;
    request.method = method;
    request.target = target;
    request.host = "127.0.0.1:8061";
    request.address = "127.0.0.1";
    request.body = body;
    if (method == "POST") request.content_type = "application/json";
    return request;
  }
  /// One that brings a file.
  HttpResponse post_file(const std::string& target, const std::string& bytes, const std::string& role = "engineer") {
    HttpRequest asked = request("POST", target, bytes);
    asked.content_type = "application/octet-stream";
    asked.authorization = "Bearer " + session(role);
    return send(asked);
  }
  HttpResponse send(const HttpRequest& request) {
    auto ready = dispatcher_->check(request);
    return ready.call == nullptr ? ready.response : dispatcher_->run(ready);
  }
  /// The secret of a session of this role.
  const std::string& session(const std::string& role) {
    std::string& secret = sessions_[role];
    if (secret.empty()) {
      secret = sessions.begin(role, engineering::role_named(role), "127.0.0.1", clock.now_ns());
    }
    return secret;
  }
  HttpResponse get(const std::string& target, const std::string& role = "viewer") {
    HttpRequest asked = request("GET", target);
    if (!role.empty()) asked.authorization = "Bearer " + session(role);
    return send(asked);
  }
  HttpResponse post(const std::string& target, const Json& body, const std::string& role = "operator") {
    HttpRequest asked = request("POST", target, body.dump());
    if (!role.empty()) asked.authorization = "Bearer " + session(role);
    return send(asked);
  }
  /// One scan of the task.
  void scan() {
    clock.sleep_until_ns(clock.now_ns() + 10'000'000);
    ASSERT_FALSE(resource->program(0).execute({clock.now_ns(), 0, calendar.now_ns}));
    ++scans;
  }
  void forget_sessions() { sessions_.clear(); }

  core::VirtualClock clock;
  SetCalendar calendar;
  engineering::Identity identity{"PICARD test", "plant", {}, "all by default", "here", "0"};
  std::unique_ptr<runtime::Resource> resource;
  engineering::GlobalValues values;
  engineering::Variables variables;
  engineering::DiagramServices drawn;
  runtime::ForceList forces;
  std::uint64_t scans = 0;
  engineering::HmiPages hmi;
  engineering::Presses presses;
  runtime::RealtimeScheduler scheduler;
  engineering::LogBook log;
  std::unique_ptr<engineering::Users> users;
  engineering::Sessions sessions;
  engineering::LoginDelay delay;
  engineering::FirstCode first_code;
  std::string check_says;  ///< of an image that is uploaded: what is wrong with it
  std::string audit_said;
  engineering::Audit audit;
  /// The cheapest that libsodium allows: tests are about who may, not about how long it takes.
  engineering::Context context{identity, variables, scheduler, log, *users,  sessions, delay, first_code, audit,
                               clock,    calendar,  forces,    hmi, presses, nullptr,  0,     {1, 8192},  nullptr};
  engineering::HostRules hosts{{"plant.example"}};
  ScratchFolder programs;
  std::unique_ptr<engineering::ProgramStore> store =
      std::move(*engineering::ProgramStore::open(programs.file("program")));
  engineering::ProgramControl control;

 private:
  std::unique_ptr<engineering::Dispatcher> dispatcher_;
  std::map<std::string, std::string> sessions_;
};

inline Json body_of(const HttpResponse& response) { return Json::parse(response.body, nullptr, false); }

}  // namespace plc::test
