#include "engineering/users.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/text.h"
#include "engineering/secrets.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

using core::Code;
using core::Problem;

constexpr int kVersion = 1;

Problem damaged(const std::string& path) {
  return {Code::P7701, path + " is not a file of users",
          "put back a copy, or remove it: then the first user is made anew, with a code that plc-run prints"};
}

Problem no_such_user(std::string_view name) {
  return {Code::P7718, "there is no user \"" + std::string(name) + "\"", {}};
}

template <class List>
auto find_named(List& list, std::string_view name) {
  return std::find_if(list.begin(), list.end(), [name](const auto& row) { return core::iequals(row.name, name); });
}

}  // namespace

std::string wrong_name(std::string_view name) {
  if (name.empty() || name.size() > 64) return "a name has 1 to 64 characters";
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("._-@").find(c) != std::string_view::npos;
  };
  return std::all_of(name.begin(), name.end(), allowed) ? "" : "a name consists of letters, digits and . _ - @";
}

std::string wrong_password(std::string_view password, std::string_view user) {
  constexpr std::size_t kLeast = 10;
  if (password.size() < kLeast) return "a password has at least 10 characters";
  if (password.size() > 256) return "a password has at most 256 characters";
  const bool one = std::all_of(password.begin(), password.end(), [&](char c) { return c == password.front(); });
  return one || core::iequals(password, user) ? "a password that others guess at once" : "";
}

core::Result<std::unique_ptr<Users>> Users::open(const std::string& folder) {
  std::unique_ptr<Users> users(new Users(folder.empty() ? "" : folder + "/users.json"));
  if (folder.empty()) return users;
  std::string why;
  const auto text = read_whole_file(users->path_, why);
  if (!why.empty()) return Problem{Code::P7701, why, "plc-run must be able to read it"};
  if (!text) return users;
  const Json document = Json::parse(*text, nullptr, false);
  if (!document.is_object() || document.value("version", Json()) != kVersion) return damaged(users->path_);
  const auto read = [](const Json& row, const char* key) {
    const auto it = row.is_object() ? row.find(key) : row.end();
    return it != row.end() && it->is_string() ? it->get<std::string>() : std::string();
  };
  const auto number = [](const Json& row, const char* key) {
    const auto it = row.find(key);
    return it != row.end() && it->is_number_integer() ? it->get<core::TimeNs>() : 0;
  };
  for (const Json& row : document.value("users", Json::array())) {
    User user{read(row, "name"), role_named(read(row, "role")), read(row, "password")};
    if (!wrong_name(user.name).empty() || user.role == Right::kAnybody || user.password.empty()) {
      return damaged(users->path_);
    }
    users->state_.users.push_back(std::move(user));
  }
  for (const Json& row : document.value("tokens", Json::array())) {
    Token token{read(row, "name"), read(row, "user"), role_named(read(row, "role")), read(row, "hash"), 0, 0};
    if (token.hash.empty() || token.role == Right::kAnybody) return damaged(users->path_);
    token.made_ns = number(row, "made");
    token.expires_ns = number(row, "expires");
    users->state_.tokens.push_back(std::move(token));
  }
  if (users->state_.users.empty() || !has_admin(users->state_.users)) return damaged(users->path_);
  return users;
}

bool Users::has_admin(const std::vector<User>& users) {
  return std::any_of(users.begin(), users.end(), [](const User& user) { return user.role == Right::kAdmin; });
}

/// The caller holds the mutex.
std::optional<Problem> Users::store(State next) {
  if (!path_.empty()) {
    Json document;
    document["version"] = kVersion;
    Json& users = document["users"] = Json::array();
    for (const User& user : next.users) {
      users.push_back({{"name", user.name}, {"role", right_text(user.role)}, {"password", user.password}});
    }
    Json& tokens = document["tokens"] = Json::array();
    for (const Token& token : next.tokens) {
      tokens.push_back({{"name", token.name},
                        {"user", token.user},
                        {"role", right_text(token.role)},
                        {"hash", token.hash},
                        {"made", token.made_ns},
                        {"expires", token.expires_ns}});
    }
    const std::string why = write_private_file(path_, document.dump(1) + "\n");
    if (!why.empty()) return Problem{Code::P7701, why, "nothing was changed"};
  }
  state_ = std::move(next);
  return std::nullopt;
}

bool Users::empty() const {
  const std::lock_guard lock(mutex_);
  return state_.users.empty();
}

std::vector<User> Users::all() const {
  const std::lock_guard lock(mutex_);
  return state_.users;
}

std::optional<User> Users::find(std::string_view name) const {
  const std::lock_guard lock(mutex_);
  const auto user = find_named(state_.users, name);
  if (user == state_.users.end()) return std::nullopt;
  return *user;
}

std::optional<Problem> Users::add(User user) {
  const std::lock_guard lock(mutex_);
  if (find_named(state_.users, user.name) != state_.users.end()) {
    return Problem{Code::P7718, "there is a user \"" + user.name + "\" already", {}};
  }
  if (state_.users.size() >= kMostUsers) return Problem{Code::P7718, "there are too many users", {}};
  State next = state_;
  next.users.push_back(std::move(user));
  return store(std::move(next));
}

std::optional<Problem> Users::add_first(User user) {
  const std::lock_guard lock(mutex_);
  if (!state_.users.empty()) return Problem{Code::P7718, "there are users already: one of them is admin", {}};
  State next;
  next.users.push_back(std::move(user));
  return store(std::move(next));
}

std::optional<Problem> Users::change(std::string_view name, std::optional<Right> role, const std::string& password) {
  const std::lock_guard lock(mutex_);
  State next = state_;
  const auto user = find_named(next.users, name);
  if (user == next.users.end()) return no_such_user(name);
  if (role) user->role = *role;
  if (!password.empty()) user->password = password;
  if (!has_admin(next.users)) return Problem{Code::P7718, "no admin would be left", "make another user admin first"};
  return store(std::move(next));
}

std::optional<Problem> Users::remove(std::string_view name) {
  const std::lock_guard lock(mutex_);
  State next = state_;
  const auto user = find_named(next.users, name);
  if (user == next.users.end()) return no_such_user(name);
  next.users.erase(user);
  std::erase_if(next.tokens, [name](const Token& token) { return core::iequals(token.user, name); });
  if (!has_admin(next.users)) return Problem{Code::P7718, "no admin would be left", "make another user admin first"};
  return store(std::move(next));
}

std::vector<Token> Users::tokens() const {
  const std::lock_guard lock(mutex_);
  return state_.tokens;
}

std::optional<Problem> Users::add(Token token) {
  const std::lock_guard lock(mutex_);
  // The user may have been removed since the call came: a token that stays would be that of a later user of the name.
  if (find_named(state_.users, token.user) == state_.users.end())
    return Problem{Code::P7718, "there is no user \"" + token.user + "\"", {}};
  const auto same = [&token](const Token& other) {
    return core::iequals(other.user, token.user) && core::iequals(other.name, token.name);
  };
  if (std::any_of(state_.tokens.begin(), state_.tokens.end(), same)) {
    return Problem{Code::P7718, "there is a token \"" + token.name + "\" already", "revoke it, or take another name"};
  }
  if (state_.tokens.size() >= kMostTokens) return Problem{Code::P7718, "there are too many tokens", {}};
  State next = state_;
  next.tokens.push_back(std::move(token));
  return store(std::move(next));
}

std::optional<Problem> Users::remove_token(std::string_view user, std::string_view name) {
  const std::lock_guard lock(mutex_);
  State next = state_;
  const std::size_t removed = std::erase_if(next.tokens, [&](const Token& token) {
    return core::iequals(token.user, user) && core::iequals(token.name, name);
  });
  if (removed == 0) {
    return Problem{Code::P7718, std::string(user) + " has no token \"" + std::string(name) + "\"", {}};
  }
  return store(std::move(next));
}

std::optional<Token> Users::token_of(std::string_view secret, core::TimeNs utc_ns) const {
  const std::string hash = hash_of_secret(secret);
  const std::lock_guard lock(mutex_);
  for (const Token& token : state_.tokens) {
    if (!same_secret(token.hash, hash)) continue;
    const auto user = find_named(state_.users, token.user);
    if (user == state_.users.end() || (token.expires_ns != 0 && utc_ns >= token.expires_ns)) return std::nullopt;
    Token today = token;
    today.role = std::min(token.role, user->role);
    return today;
  }
  return std::nullopt;
}

}  // namespace plc::engineering
