// Who is logged in where, for plc remote: kept for this user of the machine alone.
//
// In: $XDG_CONFIG_HOME/picard/logins.json, else ~/.config/picard/logins.json, mode 0600. Does not belong here: the
// server.
#pragma once

#include <string>

namespace plc::tools {

struct Login {
  std::string token;        ///< secret of the session, or empty
  std::string fingerprint;  ///< of a certificate that is taken, or empty
  std::string user;
};

/// Of this server; empty when nothing is known.
Login load_login(const std::string& url);
/// Empty; or why it cannot be kept.
std::string store_login(const std::string& url, const Login& login);
/// A line that is not shown while it is typed; from stdin when that is no terminal.
std::string read_secret(const std::string& prompt);

}  // namespace plc::tools
