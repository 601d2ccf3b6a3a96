// Who may do what, and who did: calls of the subject "users".
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/text.h"
#include "engineering/answer.h"
#include "engineering/context.h"
#include "engineering/subjects.h"
#include "log/format.h"

namespace plc::engineering {
namespace {

using namespace field;
using core::Code;

constexpr std::string_view kRoles = "viewer|operator|engineer|admin";
constexpr core::TimeNs kDayNs = 86'400'000'000'000;

constexpr Field kUserFields[] = {text("user", "Name"), choice("role", kRoles, "What the user may do")};
constexpr Record kUser = {"User", "Somebody who may log in.", kUserFields};
constexpr Field kUsersAnswer[] = {records("users", kUser, "All of them")};

void users(Context& context, const Caller&, const Json&, Answer& answer) {
  Json& all = answer.body()["users"] = Json::array();
  for (const User& user : context.users.all()) all.push_back({{"user", user.name}, {"role", right_text(user.role)}});
}

constexpr Field kAddRequest[] = {
    text("user", "Letters, digits and . _ - @", 1, 64),
    text("password", "At least 10 characters", 1, 256),
    choice("role", kRoles, "What the user may do"),
};

void add(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  User user{request["user"].get<std::string>(), role_named(request["role"].get<std::string>()), {}};
  const auto password = request["password"].get<std::string>();
  if (const std::string why = wrong_name(user.name); !why.empty()) return answer.refuse(400, Code::P7714, why, "user");
  if (const std::string why = wrong_password(password, user.name); !why.empty()) {
    return answer.refuse(400, Code::P7714, why, "password");
  }
  user.password = hash_password(password, context.cost);
  if (user.password.empty()) return answer.refuse(503, Code::P7717, "there is no memory to keep a password");
  if (const auto problem = context.users.add(user)) return answer.refuse(*problem, "user");
  context.audit.add(caller.user, caller.address, "users.add", {{"user", user.name}, {"role", right_text(user.role)}});
}

constexpr Field kChangeRequest[] = {
    text("user", "Who", 1, 64),
    optional(choice("role", kRoles, "What the user may do from now on")),
    optional(text("password", "A new one, at least 10 characters", 1, 256)),
};

void change(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["user"].get<std::string>();
  std::optional<Right> role;
  if (request.contains("role")) role = role_named(request["role"].get<std::string>());
  std::string hash;
  if (request.contains("password")) {
    const auto password = request["password"].get<std::string>();
    if (const std::string why = wrong_password(password, name); !why.empty())
      return answer.refuse(400, Code::P7714, why, "password");
    hash = hash_password(password, context.cost);
    if (hash.empty()) return answer.refuse(503, Code::P7717, "there is no memory to keep a password");
  }
  if (const auto problem = context.users.change(name, role, hash)) return answer.refuse(*problem, "user");
  context.sessions.end_all_of(name);
  Json details = {{"user", name}, {"password", !hash.empty()}};
  if (role) details["role"] = right_text(*role);
  context.audit.add(caller.user, caller.address, "users.change", details);
}

constexpr Field kNameRequest[] = {text("user", "Who", 1, 64)};

void remove(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["user"].get<std::string>();
  if (const auto problem = context.users.remove(name)) return answer.refuse(*problem, "user");
  context.sessions.end_all_of(name);
  context.audit.add(caller.user, caller.address, "users.remove", {{"user", name}});
}

constexpr Field kTokenFields[] = {
    text("name", "What it is for"),
    text("user", "Whose it is"),
    choice("role", kRoles, "What it may do"),
    text("made", "When, UTC"),
    optional(text("expires", "When it ends, UTC; without: never")),
};
constexpr Record kToken = {"Token", "A secret by which a script may call.", kTokenFields};
constexpr Field kTokensAnswer[] = {records("tokens", kToken, "Those of the caller; an admin sees all")};

void tokens(Context& context, const Caller& caller, const Json&, Answer& answer) {
  Json& all = answer.body()["tokens"] = Json::array();
  for (const Token& token : context.users.tokens()) {
    if (caller.role != Right::kAdmin && !core::iequals(token.user, caller.user)) continue;
    Json row = {{"name", token.name},
                {"user", token.user},
                {"role", right_text(token.role)},
                {"made", log::time_text(token.made_ns)}};
    if (token.expires_ns != 0) row["expires"] = log::time_text(token.expires_ns);
    all.push_back(std::move(row));
  }
}

constexpr Field kTokenRequest[] = {
    text("name", "What it is for: letters, digits and . _ - @", 1, 64),
    optional(choice("role", kRoles, "At most that of the caller; default: that of the caller")),
    optional(integer("days", "How long it counts; default 365; 0: for ever", 0, 36'500)),
};
constexpr Field kTokenAnswer[] = {text("token", "For the header Authorization: Bearer. It is told once")};

void add_token(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  if (caller.session == 0) return answer.refuse(403, Code::P7711, "a token makes no tokens: log in");
  Token token;
  token.name = request["name"].get<std::string>();
  if (const std::string why = wrong_name(token.name); !why.empty()) return answer.refuse(400, Code::P7714, why, "name");
  token.user = caller.user;
  token.role = request.contains("role") ? role_named(request["role"].get<std::string>()) : caller.role;
  if (token.role > caller.role)
    return answer.refuse(403, Code::P7711, "a token may not do more than who makes it", "role");
  const std::string secret = random_secret();
  token.hash = hash_of_secret(secret);
  token.made_ns = context.calendar.utc_ns();
  const auto days = request.value("days", std::int64_t{365});
  token.expires_ns = days == 0 ? 0 : token.made_ns + days * kDayNs;
  if (const auto problem = context.users.add(token)) return answer.refuse(*problem, "name");
  context.audit.add(caller.user, caller.address, "tokens.add",
                    {{"name", token.name}, {"role", right_text(token.role)}, {"days", days}});
  answer.body()["token"] = secret;
}

constexpr Field kRevokeRequest[] = {
    text("name", "Which one", 1, 64),
    optional(text("user", "Whose; default: the caller's. Those of others are for admin", 1, 64)),
};

void revoke(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto name = request["name"].get<std::string>();
  const std::string user = request.value("user", caller.user);
  if (!core::iequals(user, caller.user) && caller.role != Right::kAdmin) {
    return answer.refuse(403, Code::P7711, "tokens of others are for admin", "user");
  }
  const auto exceeds = [&](const Token& token) {
    return core::iequals(token.user, user) && core::iequals(token.name, name) && token.role > caller.role;
  };
  const auto all = context.users.tokens();
  if (caller.session == 0 && std::any_of(all.begin(), all.end(), exceeds))
    return answer.refuse(403, Code::P7711, "a token ends none that may do more than it", "name");
  if (const auto problem = context.users.remove_token(user, name)) return answer.refuse(*problem, "name");
  context.audit.add(caller.user, caller.address, "tokens.revoke", {{"name", name}, {"user", user}});
}

constexpr Field kSessionFields[] = {
    integer("session", "Number"),  text("user", "Who is logged in"),     choice("role", kRoles, "What the user may do"),
    text("address", "From where"), integer("age_ms", "Since the login"), integer("idle_ms", "Since the latest call"),
};
constexpr Record kSession = {"Session", "Somebody who is logged in.", kSessionFields};
constexpr Field kSessionsAnswer[] = {records("sessions", kSession, "All of them")};

void sessions(Context& context, const Caller&, const Json&, Answer& answer) {
  Json& all = answer.body()["sessions"] = Json::array();
  const core::TimeNs now_ns = context.clock.now_ns();
  for (const Session& session : context.sessions.all(now_ns)) {
    all.push_back({{"session", session.number},
                   {"user", session.user},
                   {"role", right_text(session.role)},
                   {"address", session.address},
                   {"age_ms", (now_ns - session.begin_ns) / 1'000'000},
                   {"idle_ms", (now_ns - session.last_ns) / 1'000'000}});
  }
}

constexpr Field kEndRequest[] = {integer("session", "Number", 1, INT64_MAX)};

void end_session(Context& context, const Caller& caller, const Json& request, Answer& answer) {
  const auto number = request["session"].get<std::uint64_t>();
  if (!context.sessions.end_number(number))
    return answer.refuse(404, Code::P7718, "there is no such session", "session");
  context.audit.add(caller.user, caller.address, "sessions.end", {{"session", number}});
}

constexpr Field kAuditRecordFields[] = {
    integer("n", "Number of the record"),
    text("time", "UTC"),
    text("user", "Who; empty: nobody was logged in"),
    text("address", "From where"),
    text("what", "Name of the call, or what happened: login.refused, program.start.failed, audit.broken"),
    optional(value("details", "What was asked for, and why it failed")),
    optional(integer("lost", "Records that were lost before")),
    text("after", "Hash of the record before"),
};
constexpr Record kAuditRecord = {"AuditRecord", "Who did what.", kAuditRecordFields};
constexpr Field kAuditRequest[] = {optional(integer("most", "So many at most; default 100", 1, 1000))};
constexpr Field kAuditAnswer[] = {
    records("records", kAuditRecord, "The latest, oldest first"),
    integer("lost", "Records that could not be kept since the start"),
};

void audit(Context& context, const Caller&, const Json& request, Answer& answer) {
  Json& all = answer.body()["records"] = Json::array();
  for (const std::string& record : context.audit.recent(request.value("most", std::size_t{100}))) {
    all.push_back(Json::parse(record, nullptr, false));
  }
  answer.body()["lost"] = context.audit.lost();
}

constexpr Call kCalls[] = {
    {.name = "users",
     .path = "/api/users",
     .right = Right::kAdmin,
     .doc = "Who may log in.",
     .response = kUsersAnswer,
     .example = "{}",
     .run = users},
    {.name = "users.add",
     .method = Method::kPost,
     .path = "/api/users/add",
     .right = Right::kAdmin,
     .doc = "Makes a user.",
     .request = kAddRequest,
     .example = R"({"user": "ben", "password": "battery horse staple", "role": "viewer"})",
     .run = add,
     .thread = Thread::kSecrets},
    {.name = "users.change",
     .method = Method::kPost,
     .path = "/api/users/change",
     .right = Right::kAdmin,
     .doc = "Gives a user another role or password. The user's sessions end.",
     .request = kChangeRequest,
     .example = R"({"user": "ben", "role": "operator"})",
     .run = change,
     .thread = Thread::kSecrets},
    {.name = "users.remove",
     .method = Method::kPost,
     .path = "/api/users/remove",
     .right = Right::kAdmin,
     .doc = "Removes a user, with tokens and sessions. One admin stays.",
     .request = kNameRequest,
     .example = R"({"user": "ben"})",
     .run = remove,
     .thread = Thread::kSecrets},
    {.name = "tokens",
     .path = "/api/tokens",
     .doc = "Tokens of scripts.",
     .response = kTokensAnswer,
     .example = "{}",
     .run = tokens},
    {.name = "tokens.add",
     .method = Method::kPost,
     .path = "/api/tokens/add",
     .doc = "Makes a token, by which a script may call without a login.",
     .request = kTokenRequest,
     .response = kTokenAnswer,
     .example = R"({"name": "grafana", "role": "viewer", "days": 30})",
     .run = add_token,
     .thread = Thread::kFiles},
    {.name = "tokens.revoke",
     .method = Method::kPost,
     .path = "/api/tokens/revoke",
     .doc = "Ends a token.",
     .request = kRevokeRequest,
     .example = R"({"name": "grafana"})",
     .run = revoke,
     .thread = Thread::kFiles},
    {.name = "sessions",
     .path = "/api/sessions",
     .right = Right::kAdmin,
     .doc = "Who is logged in.",
     .response = kSessionsAnswer,
     .example = "{}",
     .run = sessions},
    {.name = "sessions.end",
     .method = Method::kPost,
     .path = "/api/sessions/end",
     .right = Right::kAdmin,
     .doc = "Ends a session.",
     .request = kEndRequest,
     .example = R"({"session": 1})",
     .run = end_session},
    {.name = "audit",
     .path = "/api/audit",
     .right = Right::kAdmin,
     .doc = "Who did what: logins, writes, changes. `plc audit` checks the file.",
     .request = kAuditRequest,
     .response = kAuditAnswer,
     .example = R"({"most": 10})",
     .run = audit},
};

}  // namespace

std::span<const Call> user_calls() { return kCalls; }

}  // namespace plc::engineering
