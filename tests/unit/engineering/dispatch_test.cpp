// Which request becomes which call, and which becomes none: rights, hosts, origins, cookies, fields.
#include "engineering/dispatch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>
#include <new>
#include <string>
#include <utility>

#include "engineering/validate.h"
#include "engineering/worker.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::Call;
using engineering::calls;
using engineering::Form;
using engineering::Method;

const char* method_of(const Call& call) { return call.method == Method::kGet ? "GET" : "POST"; }

/// A request for the call, with the fields of its example.
HttpRequest request_for(EngineeringRig& rig, const Call& call) {
  HttpRequest request = rig.request(method_of(call), std::string(call.path));
  request.upgrade = call.form == Form::kStream;
  const Json example = Json::parse(call.example.empty() ? "{}" : call.example);
  const engineering::Field* const file = engineering::file_field(call);
  if (call.method == Method::kPost && file == nullptr) {
    request.body = example.dump();
  } else {
    std::string query;
    if (file != nullptr) {
      request.content_type = "application/octet-stream";
      request.body = "bytes of a file";
    }
    for (const auto& [name, value] : example.items()) {
      if (file != nullptr && name == file->name) continue;
      query += (query.empty() ? "?" : "&") + name + "=" + (value.is_string() ? value.get<std::string>() : value.dump());
    }
    request.target += query;
  }
  return request;
}

class EveryCall : public testing::TestWithParam<Call> {};
INSTANTIATE_TEST_SUITE_P(Rows, EveryCall, testing::ValuesIn(calls().begin(), calls().end()), [](const auto& row) {
  std::string name(row.param.name);
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

TEST_P(EveryCall, IsForItsRightAlone) {
  const Call& call = GetParam();
  EngineeringRig rig;
  HttpRequest request = request_for(rig, call);
  auto nobody = engineering::Dispatcher(rig.context, rig.hosts, false).check(request);
  if (call.right == Right::kAnybody) {
    EXPECT_NE(nobody.call, nullptr);
    return;
  }
  EXPECT_EQ(nobody.call, nullptr) << "without login";
  EXPECT_EQ(nobody.response.status, 401);
  EXPECT_EQ(body_of(nobody.response)["code"], "P7710");
  for (const char* role : {"viewer", "operator", "engineer", "admin"}) {
    request.authorization = "Bearer " + rig.session(role);
    auto ready = engineering::Dispatcher(rig.context, rig.hosts, false).check(request);
    const bool may = engineering::role_named(role) >= call.right;
    EXPECT_EQ(ready.call != nullptr, may) << role << ": " << ready.response.body;
    if (may) continue;
    EXPECT_EQ(ready.response.status, 403) << role;
    EXPECT_EQ(body_of(ready.response)["code"], "P7711");
  }
}

TEST_P(EveryCall, TakesItsMethodAlone) {
  const Call& call = GetParam();
  EngineeringRig rig;
  for (const char* method : {"GET", "POST", "PUT", "DELETE", "HEAD", "OPTIONS", "TRACE", "PATCH", "get", ""}) {
    HttpRequest request = request_for(rig, call);
    request.authorization = "Bearer " + rig.session("admin");
    request.method = method;
    const auto ready = engineering::Dispatcher(rig.context, rig.hosts, false).check(request);
    EXPECT_EQ(ready.call != nullptr, std::string(method) == method_of(call)) << method;
    if (ready.call == nullptr) {
      EXPECT_EQ(ready.response.status, 405) << method;
    }
  }
}

TEST_P(EveryCall, RefusesAFieldThatItDoesNotHave) {
  const Call& call = GetParam();
  EngineeringRig rig;
  HttpRequest request = request_for(rig, call);
  request.authorization = "Bearer " + rig.session("admin");
  if (call.method == Method::kPost && engineering::file_field(call) == nullptr) {
    Json body = Json::parse(request.body);
    body["nonsense"] = 1;
    request.body = body.dump();
  } else {
    request.target += (request.target.find('?') == std::string::npos ? "?" : "&") + std::string("nonsense=1");
  }
  const auto ready = engineering::Dispatcher(rig.context, rig.hosts, false).check(request);
  EXPECT_EQ(ready.call, nullptr);
  EXPECT_EQ(ready.response.status, 400);
  EXPECT_EQ(body_of(ready.response)["field"], "nonsense");
}

/// Calls of a plant that has more than the rig: drawings, pages, alarms, a history. Their own tests send them
/// (diagrams_test.cpp, hmi_test.cpp, alarms_test.cpp).
bool needs_more(std::string_view name) {
  return name.starts_with("diagrams.") || name == "pages.save" || name == "pages.press" || name == "alarms.shelve" ||
         name == "history.query";
}

TEST_P(EveryCall, AnswersAsItsRowSays) {
  const Call& call = GetParam();
  if (call.form != Form::kJson || call.response.empty() || needs_more(call.name)) return;
  EngineeringRig rig(false, call.name != "first_user");
  rig.log.add({core::Severity::kWarning, "a message", "modbus", "P7510", "Fast", {}, {}, 7, 1});
  rig.audit.add("anna", "127.0.0.1", "login", Json::object());
  HttpRequest request = request_for(rig, call);
  request.authorization = "Bearer " + rig.session("admin");
  if (call.name == "login") request.body = R"({"user": "viewer", "password": "viewer-password", "token": true})";
  if (call.name == "values.write") request.body = R"({"values": [{"path": "Start", "value": true}]})";
  if (call.name == "program.store_project") {
    ASSERT_EQ(rig.post_file("/api/program/upload", "an image").status, 200);
  }
  if (call.name == "values.search") request.target = "/api/values/search?pattern=*";
  if (call.name == "first_user") {
    rig.first_code.renew();
    request.authorization.clear();
    request.body = Json{{"code", rig.first_code.text()}, {"user", "anna"}, {"password", "correct horse"}}.dump();
  }
  const HttpResponse response = rig.send(request);
  ASSERT_EQ(response.status, 200) << response.body;
  const auto wrong = engineering::wrong_fields(body_of(response), call.response);
  EXPECT_FALSE(wrong) << wrong->field << " " << wrong->text << "\n" << response.body;
}

TEST(Dispatch, KnowsExactPathsAlone) {
  EngineeringRig rig;
  for (const char* path : {"/", "", "api/tasks", "/api/tasks/", "//api/tasks", "/api//tasks", "/api/../api/tasks",
                           "/api/%74asks", "/API/tasks", "/api/tasks/../users", "/api/tasks;x", "/api/tasks%00",
                           "/etc/passwd", "http://127.0.0.1/api/tasks", "/api/tasks#x"}) {
    EXPECT_EQ(rig.get(path, "admin").status, 404) << path;
  }
  EXPECT_EQ(rig.get("/api/tasks").status, 200);
  EXPECT_EQ(rig.get("/api/tasks?").status, 200);
}

TEST(Dispatch, TakesNamesOfThisMachineAlone) {
  EngineeringRig rig;
  const auto status = [&](const std::string& host) {
    HttpRequest request = rig.request("GET", "/api/version");
    request.host = host;
    return rig.send(request).status;
  };
  for (const char* host : {"127.0.0.1:8061", "127.0.0.1", "localhost:8061", "LOCALHOST", "[::1]:8061",
                           "192.168.7.9:443", "plant.example", "Plant.Example:8061", "[fe80::1]"}) {
    EXPECT_EQ(status(host), 200) << host;
  }
  // The last are names that a site may have its name server answer with the address of a PLC.
  for (const char* host : {"", "evil.example", "plant.example.evil", "xplant.example", "127.0.0.1.evil.example", "[::1",
                           "localhost.evil", "evil:8061:1", "\x7f", "127.1"}) {
    EXPECT_EQ(status(host), 403) << host;
  }
}

TEST(Dispatch, TakesPagesOfItsOwnAlone) {
  EngineeringRig rig;
  const auto status = [&](const std::string& origin, const std::string& site = {}) {
    HttpRequest request = rig.request("GET", "/api/tasks");
    request.authorization = "Bearer " + rig.session("viewer");
    request.origin = origin;
    request.fetch_site = site;
    return rig.send(request).status;
  };
  EXPECT_EQ(status("http://127.0.0.1:8061"), 200);
  EXPECT_EQ(status("http://127.0.0.1:8061", "same-origin"), 200);
  for (const char* origin :
       {"https://127.0.0.1:8061", "http://127.0.0.1", "http://127.0.0.1:8062", "http://evil.example", "null",
        "http://127.0.0.1:8061.evil.example", "file://", "127.0.0.1:8061", "\x7f"}) {
    EXPECT_EQ(status(origin), 403) << origin;
  }
  EXPECT_EQ(status("", "cross-site"), 403);
  EXPECT_EQ(status("", "same-site"), 403);
}

TEST(Dispatch, ACookieCountsWithAnOriginWhereItChangesSomething) {
  EngineeringRig rig;
  HttpRequest request = rig.request("POST", "/api/values/write", R"({"values": [{"path": "Start", "value": true}]})");
  request.cookie = "theme=dark; picard=" + rig.session("operator");
  EXPECT_EQ(rig.send(request).status, 403);
  request.origin = "http://127.0.0.1:8061";
  EXPECT_EQ(rig.send(request).status, 200);
  HttpRequest reads = rig.request("GET", "/api/tasks");
  reads.cookie = request.cookie;
  EXPECT_EQ(rig.send(reads).status, 200) << "a page that is opened has no origin";
  HttpRequest stream = rig.request("GET", "/api/values/stream");
  stream.upgrade = true;
  stream.cookie = request.cookie;
  EXPECT_EQ(rig.send(stream).status, 403) << "a WebSocket of another site has the cookie, too";
}

TEST(Dispatch, CookiesOfAnotherNameAreNone) {
  EngineeringRig plain, secure(true);
  for (const char* name : {"__Host-picard", "Picard", "picard2", "xpicard"}) {
    HttpRequest request = plain.request("GET", "/api/tasks");
    request.cookie = std::string(name) + "=" + plain.session("admin");
    EXPECT_EQ(plain.send(request).status, 401) << name;
  }
  HttpRequest request = secure.request("GET", "/api/tasks");
  request.cookie = "picard=" + secure.session("admin");
  EXPECT_EQ(secure.send(request).status, 401) << "anything on the machine may set a cookie without the prefix";
  request.cookie = "__Host-picard=" + secure.session("admin");
  EXPECT_EQ(secure.send(request).status, 200);
}

TEST(Dispatch, SecretsThatAreNoneAreNobody) {
  EngineeringRig rig;
  const std::string good = rig.session("admin");
  for (const std::string& header : {std::string("Bearer"), std::string("Bearer "), "Basic " + good, good,
                                    "Bearer " + good + "x", "Bearer " + good.substr(1), "Bearer x" + good,
                                    std::string("Bearer ") + std::string(10'000, 'a'), std::string("\x7f")}) {
    HttpRequest request = rig.request("GET", "/api/tasks");
    request.authorization = header;
    EXPECT_EQ(rig.send(request).status, 401) << header.substr(0, 60);
  }
  HttpRequest request = rig.request("GET", "/api/tasks");
  request.authorization = "bearer " + good;
  EXPECT_EQ(rig.send(request).status, 200) << "the scheme has no letter case";
}

TEST(Dispatch, ABodyIsJsonOfTheRightKind) {
  EngineeringRig rig;
  const auto answer = [&](const std::string& body, const std::string& type = "application/json") {
    HttpRequest request = rig.request("POST", "/api/values/read", body);
    request.authorization = "Bearer " + rig.session("viewer");
    request.content_type = type;
    return rig.send(request);
  };
  EXPECT_EQ(answer(R"({"paths": []})").status, 200);
  EXPECT_EQ(answer(R"({"paths": []})", "application/json; charset=utf-8").status, 200);
  for (const char* type :
       {"", "text/plain", "application/x-www-form-urlencoded", "multipart/form-data", "application/jsonx", "\x7f"}) {
    EXPECT_EQ(answer(R"({"paths": []})", type).status, 415) << type;
  }
  const std::string deep = "{\"paths\": " + std::string(100'000, '[') + std::string(100'000, ']') + "}";
  for (const std::string& body :
       {std::string(), std::string("{"), std::string("[]"), std::string("1"), std::string("{\"paths\": []} x"), deep,
        std::string("{\"paths\": [], \"paths\": []}"), std::string("{\"paths\": [\"\xff\"]}"),
        std::string("\xef\xbb\xbf\xff"), std::string("{\"paths\": [NaN]}"), std::string("{/**/\"paths\": []}")}) {
    const HttpResponse response = answer(body);
    EXPECT_EQ(response.status, 400) << body.substr(0, 60);
    EXPECT_EQ(body_of(response)["code"], "P7714");
  }
  const auto field_of = [&](const std::string& body) { return body_of(answer(body))["field"]; };
  EXPECT_EQ(field_of("{}"), "paths");
  EXPECT_EQ(field_of(R"({"paths": "x"})"), "paths");
  EXPECT_EQ(field_of(R"({"paths": ["a", 1]})"), "paths[1]");
  EXPECT_EQ(field_of(R"({"paths": [], "more": 1})"), "more");
}

TEST(Dispatch, NamesWithoutEndHoldUpNobody) {
  EngineeringRig rig;
  std::string body = "{", query = "/api/version?";
  for (int i = 0; i < 90'000; ++i) body += "\"" + std::to_string(i) + "\":0,";
  for (int i = 0; i < 20'000; ++i) query += std::to_string(i) + "&";
  body.back() = '}';
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(rig.send(rig.request("POST", "/api/login", body)).status, 400);
  EXPECT_EQ(rig.get(query, "").status, 400);
  // Each name compared with all before it, this takes 15 s.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(3));
}

TEST(Dispatch, AQueryIsReadAsItsFields) {
  EngineeringRig rig;
  EXPECT_EQ(rig.get("/api/values?path=GVL&from=1&most=1").status, 200);
  EXPECT_EQ(rig.get("/api/values?path=Points%5B2%5D").status, 200);
  for (const char* query : {"from=x", "from=-1", "most=0", "most=1e3", "from=99999999999999999999", "path=%",
                            "path=%zz", "path=a&path=b", "from=1.5", "path=%ff"}) {
    EXPECT_EQ(rig.get("/api/values?" + std::string(query)).status, 400) << query;
  }
}

TEST(Dispatch, TooManyCallsOfOneAddressWait) {
  EngineeringRig rig;
  int refused = 0;
  for (int i = 0; i < 5000; ++i) refused += rig.get("/api/version", "").status == 429 ? 1 : 0;
  EXPECT_GT(refused, 500);
  HttpRequest other = rig.request("GET", "/api/version");
  other.address = "192.168.7.9";
  EXPECT_EQ(rig.send(other).status, 200);
  rig.clock.sleep_until_ns(rig.clock.now_ns() + 1'000'000'000);
  EXPECT_EQ(rig.get("/api/version", "").status, 200);
}

/// Runs a row of this test's own.
HttpResponse run(EngineeringRig& rig, const Call& call) {
  const engineering::Dispatcher dispatcher(rig.context, rig.hosts, false);
  engineering::ReadyCall ready;
  ready.call = &call;
  ready.request = std::make_unique<Json>(Json::object());
  return dispatcher.run(ready);
}

TEST(Dispatch, DoesNotCopyAFile) {
  static const char* given = nullptr;
  constexpr Call kCall = {
      .name = "large",
      .path = "",
      .doc = "",
      .run =
          [](engineering::Context&, const engineering::Caller&, const Json&, engineering::Answer& answer) {
            std::string bytes(1'000'000, 'x');
            given = bytes.data();
            answer.give_file(std::move(bytes), "large");
          },
      .form = Form::kFile};
  EngineeringRig rig;
  const HttpResponse response = run(rig, kCall);
  EXPECT_EQ(response.body.size(), 1'000'000u);
  EXPECT_EQ(response.body.data(), given);
}

TEST(Dispatch, ACallWithoutMemoryIsAnAnswer) {
  constexpr Call kCall = {.name = "greedy",
                          .path = "",
                          .doc = "",
                          .run = [](engineering::Context&, const engineering::Caller&, const Json&,
                                    engineering::Answer&) { throw std::bad_alloc(); }};
  EngineeringRig rig;
  const HttpResponse response = run(rig, kCall);
  EXPECT_EQ(response.status, 500);
  EXPECT_EQ(body_of(response)["code"], "P9001");
}

TEST(Worker, WorkThatThrowsEndsNothing) {
  engineering::Worker worker(8);
  worker.start("test");
  std::promise<void> done;
  EXPECT_TRUE(worker.post([] { throw std::bad_alloc(); }));
  EXPECT_TRUE(worker.post([&done] { done.set_value(); }));
  EXPECT_EQ(done.get_future().wait_for(std::chrono::seconds(10)), std::future_status::ready);
  worker.stop();
}

TEST(Worker, WhatWaitsIsLetGoOfByItsOwner) {
  engineering::Worker worker(8);
  const auto held = std::make_shared<int>(0);
  EXPECT_TRUE(worker.post([held] {}));
  worker.stop();
  EXPECT_EQ(held.use_count(), 2);
  worker.drop();
  EXPECT_EQ(held.use_count(), 1);
}

TEST(Dispatch, RecordedScansAreExecutedAgainOnTheThreadForThem) {
  for (const char* path : {"/api/trace", "/api/history/scans"})
    EXPECT_EQ(engineering::find_call(path)->thread, engineering::Thread::kPast) << path;
}

TEST(Dispatch, TellsTheVersionAloneBeforeLogin) {
  EngineeringRig rig;
  rig.identity.plant = "secret-brewery";
  for (const Call& call : calls()) {
    const HttpResponse response = rig.send(request_for(rig, call));
    EXPECT_EQ(response.body.find("secret-brewery"), std::string::npos) << call.name;
    if (call.method == Method::kGet && call.right == Right::kAnybody && response.status == 200) {
      EXPECT_TRUE(call.name == "version" || call.name == "openapi") << call.name << " tells something before login";
    }
  }
  EXPECT_EQ(body_of(rig.get("/api/version", "")), (Json{{"product", "PICARD test"}, {"api", 1}}));
}

}  // namespace
}  // namespace plc::test
