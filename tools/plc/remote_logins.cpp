#include "tools/plc/remote_logins.h"

#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <iostream>
#include <nlohmann/json.hpp>

#include "engineering/state_files.h"

namespace plc::tools {
namespace {

using nlohmann::ordered_json;

std::string folder() {
  const char* const configured = std::getenv("XDG_CONFIG_HOME");
  if (configured != nullptr && *configured != '\0') return std::string(configured) + "/picard";
  const char* const home = std::getenv("HOME");
  return home != nullptr && *home != '\0' ? std::string(home) + "/.config/picard" : std::string();
}

ordered_json load() {
  std::string why;
  const std::string at = folder();
  const auto text = at.empty() ? std::nullopt : engineering::read_whole_file(at + "/logins.json", why);
  ordered_json document = text ? ordered_json::parse(*text, nullptr, false) : ordered_json::object();
  return document.is_object() ? document : ordered_json::object();
}

}  // namespace

Login load_login(const std::string& url) {
  const ordered_json document = load();
  const auto found = document.find(url);
  if (found == document.end() || !found->is_object()) return {};
  const auto part = [&](const char* name) {
    const auto value = found->find(name);
    return value != found->end() && value->is_string() ? value->get<std::string>() : std::string();
  };
  return {part("token"), part("fingerprint"), part("user")};
}

std::string store_login(const std::string& url, const Login& login) {
  const std::string at = folder();
  if (at.empty()) return "there is no HOME to keep the login in";
  ordered_json document = load();
  document[url] = {{"token", login.token}, {"fingerprint", login.fingerprint}, {"user", login.user}};
  std::string why = engineering::make_private_folder(at);
  if (why.empty()) why = engineering::write_private_file(at + "/logins.json", document.dump(1) + "\n");
  return why;
}

std::string read_secret(const std::string& prompt) {
  std::string line;
  if (::isatty(STDIN_FILENO) != 1) {
    std::getline(std::cin, line);
    return line;
  }
  std::cerr << prompt << std::flush;
  termios before{};
  ::tcgetattr(STDIN_FILENO, &before);
  termios silent = before;
  silent.c_lflag &= ~static_cast<tcflag_t>(ECHO);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &silent);
  std::getline(std::cin, line);
  ::tcsetattr(STDIN_FILENO, TCSAFLUSH, &before);
  std::cerr << '\n';
  return line;
}

}  // namespace plc::tools
