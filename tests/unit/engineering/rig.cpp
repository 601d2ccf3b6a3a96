#include "tests/unit/engineering/rig.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/counting_image.h"

namespace plc::test {

bytecode::VerifiedImage engineering_image() {
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
  return counting_image(b, 1);
}

EngineeringRig::EngineeringRig(bool secure, bool with_users, const std::string& folder, const std::string& project)
    : EngineeringRig(engineering_image(), secure, with_users, folder, project) {}

EngineeringRig::EngineeringRig(bytecode::VerifiedImage image, bool secure, bool with_users, const std::string& folder,
                               const std::string& project)
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

EngineeringRig::~EngineeringRig() = default;

HttpRequest EngineeringRig::request(const std::string& method, const std::string& target,
                                    const std::string& body) const {
  HttpRequest request;
  request.method = method;
  request.target = target;
  request.host = "127.0.0.1:8061";
  request.address = "127.0.0.1";
  request.body = body;
  if (method == "POST") request.content_type = "application/json";
  return request;
}

HttpResponse EngineeringRig::post_file(const std::string& target, const std::string& bytes, const std::string& role) {
  HttpRequest asked = request("POST", target, bytes);
  asked.content_type = "application/octet-stream";
  asked.authorization = "Bearer " + session(role);
  return send(asked);
}

HttpResponse EngineeringRig::send(const HttpRequest& request) {
  auto ready = dispatcher_->check(request);
  return ready.call == nullptr ? ready.response : dispatcher_->run(ready);
}

const std::string& EngineeringRig::session(const std::string& role) {
  std::string& secret = sessions_[role];
  if (secret.empty()) {
    secret = sessions.begin(role, engineering::role_named(role), "127.0.0.1", clock.now_ns());
  }
  return secret;
}

HttpResponse EngineeringRig::get(const std::string& target, const std::string& role) {
  HttpRequest asked = request("GET", target);
  if (!role.empty()) asked.authorization = "Bearer " + session(role);
  return send(asked);
}

HttpResponse EngineeringRig::post(const std::string& target, const Json& body, const std::string& role) {
  HttpRequest asked = request("POST", target, body.dump());
  if (!role.empty()) asked.authorization = "Bearer " + session(role);
  return send(asked);
}

void EngineeringRig::scan() {
  clock.sleep_until_ns(clock.now_ns() + 10'000'000);
  ASSERT_FALSE(resource->program(0).execute({clock.now_ns(), 0, calendar.now_ns}));
  ++scans;
}

Json body_of(const HttpResponse& response) { return Json::parse(response.body, nullptr, false); }

}  // namespace plc::test
