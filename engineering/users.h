// Users: who may do what, in a file of the state folder; and the tokens that they have given to scripts.
//
// In: DIR/users.json (mode 0600), or no folder: in memory, until the program ends. Out: users and tokens by name and by
// secret. Every change is on the disk before it counts. Passwords are hashes of argon2id, tokens hashes of BLAKE2b.
// Threads: any. Does not belong here: sessions, how often somebody may try (login_delay.h).
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.h"
#include "core/result.h"
#include "engineering/call.h"

namespace plc::engineering {

struct User {
  std::string name;
  Right role = Right::kViewer;
  std::string password;  ///< hash
};

struct Token {
  std::string name;  ///< what it is for; of one user each once
  std::string user;
  Right role = Right::kViewer;  ///< at most that of the user, also when that has changed since
  std::string hash;
  core::TimeNs made_ns = 0;     ///< since 1970
  core::TimeNs expires_ns = 0;  ///< since 1970; 0 = never
};

class Users {
 public:
  static constexpr std::size_t kMostUsers = 1000;
  static constexpr std::size_t kMostTokens = 1000;

  /// P7701 when the file cannot be read or is damaged: then nobody may log in, and nobody may become the first user.
  static core::Result<std::unique_ptr<Users>> open(const std::string& folder);

  [[nodiscard]] bool empty() const;
  [[nodiscard]] std::vector<User> all() const;
  [[nodiscard]] std::optional<User> find(std::string_view name) const;
  /// P7718 when there is one of this name, or too many. P7701 when the disk refuses.
  std::optional<core::Problem> add(User user);
  /// Only when there is no other; P7718 else.
  std::optional<core::Problem> add_first(User user);
  /// A new role or password (empty: the old one). P7718 when nobody is called so, or no admin would be left.
  std::optional<core::Problem> change(std::string_view name, std::optional<Right> role, const std::string& password);
  /// With the user's tokens. P7718 as above.
  std::optional<core::Problem> remove(std::string_view name);

  [[nodiscard]] std::vector<Token> tokens() const;
  /// P7718 when there is no such user, or a token of the name, or too many. P7701 when the disk refuses.
  std::optional<core::Problem> add(Token token);
  std::optional<core::Problem> remove_token(std::string_view user, std::string_view name);
  /// The token of this secret that counts at this time of day, with the role that it has today.
  [[nodiscard]] std::optional<Token> token_of(std::string_view secret, core::TimeNs utc_ns) const;

 private:
  struct State {
    std::vector<User> users;
    std::vector<Token> tokens;
  };
  explicit Users(std::string path) : path_(std::move(path)) {}
  std::optional<core::Problem> store(State next);
  static bool has_admin(const std::vector<User>& users);

  std::string path_;  ///< empty: in memory
  mutable std::mutex mutex_;
  State state_;
};

/// What is wrong with a name for a user or token; empty when nothing is: 1 to 64 letters, digits and ._-@
std::string wrong_name(std::string_view name);
/// What is wrong with a password: 10 to 256 bytes, and not the user's name.
std::string wrong_password(std::string_view password, std::string_view user);

}  // namespace plc::engineering
