// Who is calling: calls of the subject "session".
#include <nlohmann/json.hpp>

#include "core/text.h"
#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"

namespace plc::engineering {

std::string FirstCode::text() const {
  const std::lock_guard lock(mutex_);
  return code_;
}

void FirstCode::renew() {
  const std::lock_guard lock(mutex_);
  code_ = random_code();
  shown_ = true;
  wrong_ = 0;
}

bool FirstCode::matches(std::string_view text) {
  const std::lock_guard lock(mutex_);
  if (!code_.empty() && same_secret(plain_code(text), plain_code(code_))) return true;
  if (!code_.empty() && ++wrong_ >= kMostWrong) {
    code_ = random_code();
    shown_ = true;
    wrong_ = 0;
  }
  return false;
}

std::string FirstCode::take_shown() {
  const std::lock_guard lock(mutex_);
  if (!shown_) return {};
  shown_ = false;
  return code_;
}

namespace {

using namespace field;
using core::Code;

constexpr std::int64_t kMostPassword = 256;

constexpr Field kWhoFields[] = {
    text("user", "Name"),
    choice("role", "viewer|operator|engineer|admin", "What the user may do"),
};

constexpr Field kLoginRequest[] = {
    text("user", "Name", 1, 64),
    text("password", "Password", 1, kMostPassword),
    optional(
        boolean("token", "The secret is in the answer, for the header Authorization: Bearer; else it is a cookie")),
};
constexpr Field kLoginAnswer[] = {
    kWhoFields[0],
    kWhoFields[1],
    optional(text("token", "For the header Authorization: Bearer")),
};

void too_soon(Answer& answer, core::TimeNs wait_ns) {
  answer.refuse(Refusal{429, Code::P7713, "too many attempts: wait before the next one", {}, {}, wait_ns});
}

/// Checks a password, with the delays. False, and refused, when it is wrong or may not be tried now.
bool password_is_right(Context& context, const std::string& name, const std::string& address,
                       const std::string& password, Answer& answer, std::optional<User>& user) {
  if (const core::TimeNs wait = context.delay.attempt(name, address, context.clock.now_ns())) {
    too_soon(answer, wait);
    return false;
  }
  user = context.users.find(name);
  // WHY: whether there is such a user must not show in the time that the answer takes.
  static const std::string none = hash_password("nobody has this password", context.cost);
  const PasswordCheck check = check_password(user ? user->password : none, password);
  if (check == PasswordCheck::kNoMemory) {
    context.delay.withdrawn(name, address);
    answer.refuse(503, Code::P7717, "there is no memory to check a password");
    return false;
  }
  if (check == PasswordCheck::kRight && user) {
    context.delay.succeeded(name, address);
    return true;
  }
  context.audit.add(name, address, "login.refused", Json::object());
  answer.refuse(401, Code::P7712, "wrong user or password");
  return false;
}

/// Refused when the user is not any more who the password was checked of.
void begin_session(Context& context, const User& user, const Caller& caller, bool token, Answer& answer) {
  std::string secret = context.sessions.begin(user.name, user.role, caller.address, context.clock.now_ns());
  // WHY after it began: who removes or changes a user ends the sessions that there are by then.
  const auto now = context.users.find(user.name);
  if (!now || now->role != user.role || now->password != user.password) {
    context.sessions.end(secret);
    context.audit.add(user.name, caller.address, "login.refused", Json::object());
    return answer.refuse(401, Code::P7712, "wrong user or password");
  }
  context.audit.add(user.name, caller.address, "login", Json::object());
  answer.body()["user"] = user.name;
  answer.body()["role"] = right_text(user.role);
  if (token) {
    answer.body()["token"] = secret;
  } else {
    answer.set_cookie(std::move(secret));
  }
}

void login(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  std::optional<User> user;
  if (!password_is_right(context, request["user"].get<std::string>(), caller.address,
                         request["password"].get<std::string>(), answer, user))
    return;
  begin_session(context, *user, caller, request.value("token", false), answer);
}

constexpr Field kFirstUserRequest[] = {
    text("code", "That plc-run has printed", 1, 64),
    text("user", "Name of the first user, who is admin", 1, 64),
    text("password", "At least 10 characters", 1, kMostPassword),
    optional(boolean("token", "As in login")),
};

void first_user(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  if (!context.users.empty()) return answer.refuse(409, Code::P7718, "there are users already: one of them is admin");
  if (const core::TimeNs wait = context.delay.attempt("", caller.address, context.clock.now_ns()))
    return too_soon(answer, wait);
  if (!context.first_code.matches(request["code"].get<std::string>())) {
    context.audit.add("", caller.address, "first-user.refused", Json::object());
    return answer.refuse(401, Code::P7719, "this is not the code that plc-run has printed", "code",
                         "it stands on the console, or in the journal: journalctl -u picard@NAME");
  }
  context.delay.succeeded("", caller.address);
  User user{request["user"].get<std::string>(), Right::kAdmin, {}};
  const auto password = request["password"].get<std::string>();
  if (const std::string why = wrong_name(user.name); !why.empty()) return answer.refuse(400, Code::P7714, why, "user");
  if (const std::string why = wrong_password(password, user.name); !why.empty()) {
    return answer.refuse(400, Code::P7714, why, "password");
  }
  user.password = hash_password(password, context.cost);
  if (user.password.empty()) return answer.refuse(503, Code::P7717, "there is no memory to keep a password");
  if (const auto problem = context.users.add_first(user)) return answer.refuse(*problem);
  context.audit.add(user.name, caller.address, "first-user", Json::object());
  begin_session(context, user, caller, request.value("token", false), answer);
}

void logout(Context& context, const Caller& caller, const Json&, Answer& answer) {
  if (caller.session != 0) {
    context.sessions.end(caller.secret);
    context.audit.add(caller.user, caller.address, "logout", Json::object());
  }
  answer.set_cookie({});
}

constexpr Field kSessionAnswer[] = {
    kWhoFields[0],
    kWhoFields[1],
    integer("session", "Number of the session; 0: a token"),
    text("image", "SHA-256 of the image that runs: another one has other variables, drawings and pages"),
};

void session(Context& context, const Caller& caller, const Json&, Answer& answer) {
  answer.body() = {{"user", caller.user},
                   {"role", right_text(caller.role)},
                   {"session", caller.session},
                   {"image", context.identity.image_hash}};
}

constexpr Field kPasswordRequest[] = {
    text("old", "Present password", 1, kMostPassword),
    text("new", "New password: at least 10 characters", 1, kMostPassword),
};

void password(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  std::optional<User> user;
  if (!password_is_right(context, caller.user, caller.address, request["old"].get<std::string>(), answer, user)) return;
  const auto wanted = request["new"].get<std::string>();
  if (const std::string why = wrong_password(wanted, caller.user); !why.empty())
    return answer.refuse(400, Code::P7714, why, "new");
  const std::string hash = hash_password(wanted, context.cost);
  if (hash.empty()) return answer.refuse(503, Code::P7717, "there is no memory to keep a password");
  if (const auto problem = context.users.change(caller.user, std::nullopt, hash)) return answer.refuse(*problem);
  // Whoever knew the old one is out.
  context.sessions.end_all_of(caller.user);
  context.audit.add(caller.user, caller.address, "password", Json::object());
  answer.set_cookie({});
}

constexpr Call kCalls[] = {
    {.name = "first_user",
     .method = Method::kPost,
     .path = "/api/first-user",
     .right = Right::kAnybody,
     .doc = "Makes the first user, with the code that plc-run prints while there is none, and logs in.",
     .request = kFirstUserRequest,
     .response = kLoginAnswer,
     .example = R"({"code": "ABCD-EFGH-JKMN", "user": "anna", "password": "correct horse battery", "token": true})",
     .run = first_user,
     .thread = Thread::kSecrets},
    {.name = "login",
     .method = Method::kPost,
     .path = "/api/login",
     .right = Right::kAnybody,
     .doc = "Begins a session: it ends after 30 minutes without a call, after 12 hours, and with the server. Wrong "
            "passwords make the next attempt wait.",
     .request = kLoginRequest,
     .response = kLoginAnswer,
     .example = R"({"user": "anna", "password": "correct horse battery", "token": true})",
     .run = login,
     .thread = Thread::kSecrets},
    {.name = "logout",
     .method = Method::kPost,
     .path = "/api/logout",
     .doc = "Ends the session.",
     .example = "{}",
     .run = logout},
    {.name = "session",
     .path = "/api/session",
     .doc = "Who is calling.",
     .response = kSessionAnswer,
     .example = "{}",
     .run = session},
    {.name = "password",
     .method = Method::kPost,
     .path = "/api/password",
     .doc = "Gives the caller a new password. All sessions of the user end.",
     .request = kPasswordRequest,
     .example = R"({"old": "correct horse battery", "new": "another horse battery"})",
     .run = password,
     .thread = Thread::kSecrets},
};

}  // namespace

std::span<const Call> login_calls() { return kCalls; }

}  // namespace plc::engineering
