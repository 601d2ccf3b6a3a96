// Who gets in, and how long others wait: passwords, sessions, tokens, the first user.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <chrono>
#include <fstream>
#include <functional>
#include <iterator>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "engineering/login_delay.h"
#include "engineering/state_files.h"
#include "tests/support/run_tool.h"
#include "tests/unit/engineering/rig.h"

namespace plc::test {
namespace {

using engineering::LoginDelay;
using engineering::Sessions;

constexpr core::TimeNs kSecondNs = 1'000'000'000;

Json login(const std::string& user, const std::string& password) {
  return {{"user", user}, {"password", password}, {"token", true}};
}

TEST(Login, GivesASessionOfTheRole) {
  EngineeringRig rig;
  const HttpResponse response = rig.post("/api/login", login("operator", "operator-password"), "");
  ASSERT_EQ(response.status, 200) << response.body;
  EXPECT_EQ(response.set_cookie, "");
  HttpRequest request = rig.request("GET", "/api/session");
  request.authorization = "Bearer " + body_of(response)["token"].get<std::string>();
  Json answer = body_of(rig.send(request));
  EXPECT_EQ(answer["image"], body_of(rig.get("/api/program"))["image"]);
  answer.erase("image");
  EXPECT_EQ(answer, (Json{{"user", "operator"}, {"role", "operator"}, {"session", 1}}));
}

TEST(Login, GivesBrowsersACookieThatPagesCannotRead) {
  for (const bool secure : {false, true}) {
    EngineeringRig rig(secure);
    HttpRequest request = rig.request("POST", "/api/login", R"({"user": "viewer", "password": "viewer-password"})");
    request.origin = secure ? "https://127.0.0.1:8061" : "http://127.0.0.1:8061";
    const HttpResponse response = rig.send(request);
    ASSERT_EQ(response.status, 200) << response.body;
    EXPECT_FALSE(body_of(response).contains("token"));
    const std::string& cookie = response.set_cookie;
    EXPECT_EQ(cookie.find(secure ? "__Host-picard=" : "picard="), 0u) << cookie;
    for (const char* part : {"; Path=/", "; HttpOnly", "; SameSite=Strict"})
      EXPECT_NE(cookie.find(part), std::string::npos) << part;
    EXPECT_EQ(cookie.find("; Secure") != std::string::npos, secure);
    EXPECT_EQ(cookie.find("Domain"), std::string::npos);
  }
}

TEST(Login, TellsNothingOfWhatWasWrong) {
  EngineeringRig rig;
  const HttpResponse user = rig.post("/api/login", login("nobody", "viewer-password"), "");
  const HttpResponse password = rig.post("/api/login", login("viewer", "wrong-password"), "");
  EXPECT_EQ(user.status, 401);
  EXPECT_EQ(user.body, password.body);
  EXPECT_EQ(body_of(user)["code"], "P7712");
}

TEST(Login, WrongPasswordsMakeTheNextAttemptWait) {
  EngineeringRig rig;
  const auto attempt = [&](const std::string& password, const std::string& address = "10.0.0.1") {
    HttpRequest request = rig.request("POST", "/api/login", login("admin", password).dump());
    request.address = address;
    return rig.send(request);
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(attempt("wrong-password").status, 401) << i;
  const HttpResponse waits = attempt("admin-password");
  EXPECT_EQ(waits.status, 429) << "not even the right one";
  EXPECT_EQ(waits.retry_after_s, 1);
  EXPECT_EQ(attempt("admin-password", "10.0.0.2").status, 200) << "from another address";
  rig.clock.sleep_until_ns(rig.clock.now_ns() + kSecondNs);
  EXPECT_EQ(attempt("wrong-password").status, 401);
  EXPECT_EQ(attempt("admin-password").retry_after_s, 2) << "it doubles";
  rig.clock.sleep_until_ns(rig.clock.now_ns() + 2 * kSecondNs);
  EXPECT_EQ(attempt("admin-password").status, 200);
  EXPECT_EQ(attempt("wrong-password").status, 401) << "it begins anew";
}

/// A clock that is asked while a login goes on.
class MeddlingClock final : public core::Clock {
 public:
  explicit MeddlingClock(std::function<void()> meddle) : meddle_(std::move(meddle)) {}
  /// The second time: the password has been checked, and the session has not begun.
  [[nodiscard]] core::TimeNs now_ns() const noexcept override {
    if (++asked_ == 2) meddle_();
    return 0;
  }
  void sleep_until_ns(core::TimeNs) noexcept override {}

 private:
  std::function<void()> meddle_;
  mutable int asked_ = 0;
};

TEST(Login, WhoIsRemovedOrChangedMeanwhileGetsNoSession) {
  for (const bool removed : {true, false}) {
    EngineeringRig rig;
    const MeddlingClock clock([&] {
      if (removed) {
        EXPECT_FALSE(rig.users->remove("operator"));
      } else {
        EXPECT_FALSE(rig.users->change("operator", Right::kViewer, {}));
      }
      rig.sessions.end_all_of("operator");
    });
    engineering::Context context{rig.identity, rig.variables,  rig.scheduler, rig.log, *rig.users,   rig.sessions,
                                 rig.delay,    rig.first_code, rig.audit,     clock,   rig.calendar, rig.forces,
                                 rig.hmi,      rig.presses,    nullptr,       0,       {1, 8192},    nullptr};
    engineering::Answer answer;
    engineering::find_call("/api/login")->run(context, {}, login("operator", "operator-password"), answer);
    EXPECT_TRUE(answer.refused());
    EXPECT_EQ(answer.refusal().status, 401);
    EXPECT_TRUE(rig.sessions.all(0).empty());
    EXPECT_FALSE(answer.body().contains("token"));
  }
}

TEST(Login, AndChangesOfUsersComeOneAfterAnother) {
  for (const char* path : {"/api/login", "/api/password", "/api/users/change", "/api/users/remove"})
    EXPECT_EQ(engineering::find_call(path)->thread, engineering::Thread::kSecrets) << path;
}

TEST(LoginDelay, GrowsToMinutesForOneUserFromOneAddress) {
  LoginDelay delay;
  core::TimeNs now = 0, longest = 0;
  for (int i = 0; i < 40; ++i) {
    const core::TimeNs wait = delay.attempt("anna", "10.0.0.1", now);
    longest = std::max(longest, wait);
    now += wait;
    if (wait != 0) {
      EXPECT_EQ(delay.attempt("anna", "10.0.0.1", now), 0);
    }
  }
  EXPECT_EQ(longest, LoginDelay::kLongestNs);
}

TEST(LoginDelay, NobodyLocksAnotherOut) {
  LoginDelay delay;
  core::TimeNs now = 0;
  // A thousand addresses guess a thousand passwords of anna a second, for a minute.
  int looked_at = 0;
  for (int i = 0; i < 60'000; ++i, now += 1'000'000) {
    looked_at += delay.attempt("anna", "10.1.0." + std::to_string(i % 1000), now) == 0 ? 1 : 0;
  }
  EXPECT_LT(looked_at, 100) << "about one a second is looked at";
  EXPECT_LE(delay.attempt("anna", "10.0.0.1", now), LoginDelay::kLongestOthersNs);
  EXPECT_EQ(delay.attempt("ben", "10.0.0.1", now), 0) << "others do not notice";
}

TEST(LoginDelay, WhoCameInBeforeDoesNotWaitForOthers) {
  LoginDelay delay;
  ASSERT_EQ(delay.attempt("anna", "10.0.0.1", 0), 0);
  delay.succeeded("anna", "10.0.0.1");
  core::TimeNs now = 0;
  for (int i = 0; i < 10'000; ++i, now += 1'000'000) delay.attempt("anna", "10.1.0." + std::to_string(i % 250), now);
  EXPECT_NE(delay.attempt("anna", "10.0.0.2", now), 0);
  EXPECT_EQ(delay.attempt("anna", "10.0.0.1", now), 0);
}

TEST(LoginDelay, ManyAtOnceAreNoWayRound) {
  LoginDelay delay;
  int looked_at = 0;
  for (int i = 0; i < 1000; ++i) looked_at += delay.attempt("anna", "10.0.0.1", 5) == 0 ? 1 : 0;
  EXPECT_EQ(looked_at, 3);
}

TEST(LoginDelay, NamesWithoutEndTakeNoMemoryWithoutEnd) {
  LoginDelay delay;
  int looked_at = 0;
  for (int i = 0; i < 200'000; ++i) {
    looked_at += delay.attempt("user" + std::to_string(i), "10.0.0.1", core::TimeNs{i} * 1000) == 0 ? 1 : 0;
  }
  EXPECT_LT(looked_at, 30) << "the address waits";
}

TEST(Sessions, EndWhenUnusedAndInAnyCase) {
  Sessions sessions;
  const std::string secret = sessions.begin("anna", Right::kViewer, "10.0.0.1", 0);
  EXPECT_TRUE(sessions.use(secret, Sessions::kIdleNs - 1));
  EXPECT_TRUE(sessions.use(secret, 2 * Sessions::kIdleNs - 2)) << "a call keeps it";
  EXPECT_FALSE(sessions.use(secret, 3 * Sessions::kIdleNs - 2));
  EXPECT_FALSE(sessions.use(secret, 0)) << "it does not come back";
  const std::string busy = sessions.begin("anna", Right::kViewer, "10.0.0.1", 0);
  core::TimeNs now = 0;
  while (sessions.use(busy, now)) now += Sessions::kIdleNs / 2;
  EXPECT_EQ(now, Sessions::kLongestNs);
}

TEST(Sessions, AreForgottenWhenTheyAreTooMany) {
  Sessions sessions;
  const std::string other = sessions.begin("ben", Right::kViewer, "10.0.0.2", 0);
  std::vector<std::string> secrets;
  for (int i = 0; i < 100; ++i) secrets.push_back(sessions.begin("anna", Right::kViewer, "10.0.0.1", i));
  EXPECT_EQ(sessions.all(100).size(), Sessions::kMostOfUser + 1);
  EXPECT_FALSE(sessions.use(secrets.front(), 100));
  EXPECT_TRUE(sessions.use(secrets.back(), 100));
  EXPECT_TRUE(sessions.use(other, 100));
}

TEST(Sessions, ThatBeginOrEndAreTold) {
  EngineeringRig rig;
  std::size_t told = 0, there = 0;
  rig.sessions.on_change([&] {
    ++told;
    there = rig.sessions.kept().size();
  });
  rig.session("viewer");
  const std::string secret = rig.session("engineer");
  rig.session("admin");
  EXPECT_EQ(std::pair(told, there), std::pair(std::size_t{3}, std::size_t{3}));
  EXPECT_TRUE(rig.sessions.use(secret, rig.clock.now_ns()));
  EXPECT_EQ(told, 3u) << "a call is no news";
  EXPECT_EQ(rig.post("/api/logout", Json::object(), "engineer").status, 200);
  EXPECT_EQ(std::pair(told, there), std::pair(std::size_t{4}, std::size_t{2})) << "before the answer";
  EXPECT_EQ(rig.post("/api/users/remove", {{"user", "viewer"}}, "admin").status, 200);
  EXPECT_EQ(std::pair(told, there), std::pair(std::size_t{5}, std::size_t{1}));
  rig.sessions.end(secret);
  EXPECT_EQ(told, 5u) << "it has ended already";
}

TEST(Sessions, AreToldOfOneAfterAnother) {
  Sessions sessions;
  std::atomic<int> told{0};
  std::size_t handed_over = 0;  // as the process that follows finds it
  std::mutex writes;
  sessions.on_change([&] {
    const bool first = told++ == 0;
    const std::size_t there = sessions.kept().size();
    // Who reads first takes its time to write.
    if (first) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const std::lock_guard lock(writes);
    handed_over = there;
  });
  std::thread logs_in([&] { sessions.begin("anna", Right::kViewer, "10.0.0.1", 0); });
  while (told == 0) std::this_thread::yield();
  sessions.end_all_of("anna");
  logs_in.join();
  EXPECT_EQ(told, 2);
  EXPECT_EQ(handed_over, 0u) << "who has logged out would be there again";
}

TEST(Session, ASecretIsNoneAfterLogout) {
  EngineeringRig rig;
  HttpRequest request = rig.request("POST", "/api/logout", "{}");
  request.cookie = "picard=" + rig.session("viewer");
  request.origin = "http://127.0.0.1:8061";
  const HttpResponse response = rig.send(request);
  EXPECT_EQ(response.status, 200);
  EXPECT_NE(response.set_cookie.find("Max-Age=0"), std::string::npos);
  EXPECT_EQ(rig.send(request).status, 401) << "replayed";
  EXPECT_EQ(rig.get("/api/tasks").status, 401);
}

TEST(Session, ANewPasswordOrRoleEndsAllOfTheUser) {
  EngineeringRig rig;
  ASSERT_EQ(rig.get("/api/tasks", "viewer").status, 200);
  EXPECT_EQ(rig.post("/api/users/change", {{"user", "VIEWER"}, {"role", "operator"}}, "admin").status, 200);
  EXPECT_EQ(rig.get("/api/tasks", "viewer").status, 401);
  ASSERT_EQ(rig.get("/api/tasks", "engineer").status, 200);
  EXPECT_EQ(rig.post("/api/password", {{"old", "wrong-password"}, {"new", "a better password"}}, "engineer").status,
            401);
  EXPECT_EQ(rig.post("/api/password", {{"old", "engineer-password"}, {"new", "short"}}, "engineer").status, 400);
  EXPECT_EQ(rig.post("/api/password", {{"old", "engineer-password"}, {"new", "a better password"}}, "engineer").status,
            200);
  EXPECT_EQ(rig.get("/api/tasks", "engineer").status, 401);
  EXPECT_EQ(rig.post("/api/login", login("engineer", "engineer-password"), "").status, 401);
  EXPECT_EQ(rig.post("/api/login", login("engineer", "a better password"), "").status, 200);
}

TEST(FirstUser, NeedsTheCodeAndIsOne) {
  EngineeringRig rig(false, false);
  rig.first_code.renew();
  const std::string code = rig.first_code.take_shown();
  EXPECT_EQ(rig.first_code.take_shown(), "");
  const auto make = [&](const std::string& with, const std::string& user = "anna",
                        const std::string& password = "correct horse") {
    rig.clock.sleep_until_ns(rig.clock.now_ns() + 400 * kSecondNs);
    return rig.post("/api/first-user", {{"code", with}, {"user", user}, {"password", password}}, "");
  };
  EXPECT_EQ(make("AAAA-BBBB-CCCC").status, 401);
  EXPECT_EQ(make(" ").status, 401);
  EXPECT_EQ(make(code, "an na").status, 400);
  EXPECT_EQ(make(code, "anna", "short").status, 400);
  EXPECT_EQ(make(code, "anna", "aaaaaaaaaaaa").status, 400);
  std::string typed = code;
  for (char& c : typed) c = c == '-' ? ' ' : static_cast<char>(std::tolower(c));
  EXPECT_EQ(make(typed).status, 200) << "as people type it";
  EXPECT_EQ(make(code, "eve").status, 409) << "once";
  EXPECT_EQ(rig.users->find("anna")->role, Right::kAdmin);
}

TEST(FirstUser, TheCodeChangesWhenItIsGuessedAt) {
  EngineeringRig rig(false, false);
  rig.first_code.renew();
  const std::string code = rig.first_code.take_shown();
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(rig.first_code.matches("AAAA-BBBB-CCCC"));
  EXPECT_FALSE(rig.first_code.matches(code));
  EXPECT_TRUE(rig.first_code.matches(rig.first_code.take_shown()));
}

TEST(FirstUser, NothingElseMakesOne) {
  EngineeringRig rig(false, false);
  EXPECT_EQ(rig.post("/api/login", login("admin", ""), "").status, 400);
  EXPECT_EQ(rig.post("/api/login", login("admin", "admin"), "").status, 401);
  EXPECT_EQ(rig.post("/api/users/add", {{"user", "eve"}, {"password", "correct horse"}, {"role", "admin"}}, "").status,
            401);
  EXPECT_EQ(rig.post("/api/first-user", {{"code", "x"}, {"user", "eve"}, {"password", "correct horse"}}, "").status,
            401)
      << "an empty code is none";
}

TEST(Tokens, DoWhatTheyMayUntilTheyEnd) {
  EngineeringRig rig;
  EXPECT_EQ(rig.post("/api/tokens/add", {{"name", "x"}, {"role", "admin"}}, "operator").status, 403);
  const HttpResponse made =
      rig.post("/api/tokens/add", {{"name", "grafana"}, {"role", "viewer"}, {"days", 1}}, "operator");
  ASSERT_EQ(made.status, 200) << made.body;
  std::string said;
  const auto call = [&](const std::string& method, const std::string& target, const std::string& body = {}) {
    HttpRequest request = rig.request(method, target, body);
    request.authorization = "Bearer " + body_of(made)["token"].get<std::string>();
    const HttpResponse response = rig.send(request);
    said = response.body;
    return response.status;
  };
  EXPECT_EQ(call("GET", "/api/tasks"), 200);
  EXPECT_EQ(call("POST", "/api/values/write", R"({"values": []})"), 403);
  EXPECT_NE(said.find("this call is for operator, and this token is viewer"), std::string::npos) << said;
  EXPECT_EQ(call("POST", "/api/tokens/add", R"({"name": "more"})"), 403) << "a token makes no tokens";
  ASSERT_EQ(rig.post("/api/tokens/add", {{"name", "more"}}, "operator").status, 200);
  EXPECT_EQ(call("POST", "/api/tokens/revoke", R"({"name": "MORE"})"), 403) << "nor ends one that may do more";
  EXPECT_EQ(rig.post("/api/tokens/revoke", {{"name", "more"}}, "operator").status, 200);
  HttpRequest cookie = rig.request("GET", "/api/tasks");
  cookie.cookie = "picard=" + body_of(made)["token"].get<std::string>();
  EXPECT_EQ(rig.send(cookie).status, 401) << "a token is no cookie";
  rig.calendar.now_ns += 86'400 * kSecondNs;
  EXPECT_EQ(call("GET", "/api/tasks"), 401);
  rig.calendar.now_ns -= 86'400 * kSecondNs;
  EXPECT_EQ(rig.post("/api/tokens/revoke", {{"name", "grafana"}, {"user", "operator"}}, "viewer").status, 403);
  EXPECT_EQ(rig.post("/api/tokens/revoke", {{"name", "grafana"}}, "operator").status, 200);
  EXPECT_EQ(call("GET", "/api/tasks"), 401);
}

TEST(Tokens, FallWithTheirUser) {
  EngineeringRig rig;
  const auto token_of = [&](const char* role) {
    return body_of(rig.post("/api/tokens/add", {{"name", "t"}}, role))["token"].get<std::string>();
  };
  const std::string engineer = token_of("engineer");
  ASSERT_FALSE(rig.users->change("engineer", Right::kViewer, {}));
  EXPECT_EQ(rig.users->token_of(engineer, rig.calendar.utc_ns())->role, Right::kViewer);
  ASSERT_FALSE(rig.users->remove("engineer"));
  EXPECT_FALSE(rig.users->token_of(engineer, rig.calendar.utc_ns()));
  // A call that came before, and is done after.
  engineering::Token late;
  late.name = "late";
  late.user = "engineer";
  late.hash = engineering::hash_of_secret("secret");
  EXPECT_TRUE(rig.users->add(late));
  EXPECT_TRUE(rig.users->tokens().empty());
}

TEST(Users, AreKeptForThisUserAlone) {
  const ScratchFolder scratch;
  const std::string folder = scratch.file("engineering");
  ASSERT_EQ(engineering::make_private_folder(folder), "");
  {
    EngineeringRig rig(false, true, folder);
    ASSERT_EQ(rig.post("/api/tokens/add", {{"name", "grafana"}}, "viewer").status, 200);
  }
  struct stat status {};
  ASSERT_EQ(::stat((folder + "/users.json").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
  ASSERT_EQ(::stat(folder.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0700u);
  std::ifstream in(folder + "/users.json");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_EQ(text.find("viewer-password"), std::string::npos);
  EXPECT_NE(text.find("$argon2id$"), std::string::npos);
  const auto again = engineering::Users::open(folder);
  ASSERT_TRUE(again);
  EXPECT_EQ((*again)->all().size(), 4u);
  EXPECT_EQ((*again)->tokens().size(), 1u);
}

TEST(Users, ADamagedFileIsNoReasonToLetAnybodyIn) {
  const ScratchFolder scratch;
  for (const char* text : {"", "{", "[]", "{\"version\": 2}", "{\"version\": 1}", "{\"version\": 1, \"users\": []}",
                           R"({"version": 1, "users": [{"name": "a", "role": "viewer", "password": "x"}]})",
                           R"({"version": 1, "users": [{"name": "a", "role": "king", "password": "x"}]})",
                           R"({"version": 1, "users": [{"name": "a", "role": "admin", "password": ""}]})",
                           R"({"version": 1, "users": [7]})", R"({"version": "1", "users": []})"}) {
    std::ofstream(scratch.file("users.json")) << text;
    const auto users = engineering::Users::open(scratch.file(""));
    ASSERT_FALSE(users) << text;
    EXPECT_EQ(users.error().code, core::Code::P7701);
  }
}

TEST(Users, OneAdminStays) {
  EngineeringRig rig;
  EXPECT_EQ(rig.post("/api/users/remove", {{"user", "admin"}}, "admin").status, 409);
  EXPECT_EQ(rig.post("/api/users/change", {{"user", "admin"}, {"role", "viewer"}}, "admin").status, 409);
  EXPECT_EQ(rig.post("/api/users/add", {{"user", "Viewer"}, {"password", "correct horse"}, {"role", "viewer"}}, "admin")
                .status,
            409);
  EXPECT_EQ(
      rig.post("/api/users/add", {{"user", "a/b"}, {"password", "correct horse"}, {"role", "viewer"}}, "admin").status,
      400);
  EXPECT_EQ(rig.post("/api/users/remove", {{"user", "nobody"}}, "admin").status, 409);
}

}  // namespace
}  // namespace plc::test
