#include "bench/engineering_server.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

namespace plc::bench {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return std::string{std::istreambuf_iterator<char>(in), {}};
}

/// What follows `before` in the text, up to a blank or the end of the line; empty when it is not there.
std::string word_after(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + before.size(), end = text.find_first_of(" \n", begin);
  return end == std::string::npos ? std::string() : text.substr(begin, end - begin);
}

}  // namespace

EngineeringServer::EngineeringServer(const std::string& project) {
  const std::string out = scratch_.file("out");
  std::vector<std::string> words = {PLC_RUN_TOOL,    project,       "--modbus", "off",
                                    "--engineering", "127.0.0.1:0", "--state",  scratch_.file("state")};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  const int refused = ::posix_spawn(&process_, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) throw std::runtime_error("plc-run cannot be run");
  std::string code;
  for (int turn = 0; turn < 2000 && code.empty(); ++turn) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const std::string said = text_of(out);
    const std::string port = word_after(said, "engineering: http://127.0.0.1:");
    if (!port.empty()) port_ = static_cast<std::uint16_t>(std::stoi(port));
    code = word_after(said, "code of the first one ");
  }
  if (code.empty()) throw std::runtime_error("plc-run does not come up:\n" + text_of(out));
  const nlohmann::json user = {{"code", code}, {"user", kUser}, {"password", kPassword}, {"token", true}};
  token_ = nlohmann::json::parse(ask("POST", "/api/first-user", user.dump()))["token"].get<std::string>();
}

EngineeringServer::~EngineeringServer() {
  if (process_ <= 0) return;
  ::kill(process_, SIGTERM);
  ::waitpid(process_, nullptr, 0);
}

std::string EngineeringServer::request(const std::string& method, const std::string& target,
                                       const std::string& body) const {
  std::string text = fmt::format("{} {} HTTP/1.1\r\nHost: 127.0.0.1\r\n", method, target);
  if (!token_.empty()) text += "Authorization: Bearer " + token_ + "\r\n";
  if (method == "POST") text += fmt::format("Content-Type: application/json\r\nContent-Length: {}\r\n", body.size());
  return text + "\r\n" + body;
}

std::string EngineeringServer::upgrade(const std::string& target) const {
  return fmt::format(
      "GET {} HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer {}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n",
      target, token_);
}

std::string EngineeringServer::ask(const std::string& method, const std::string& target,
                                   const std::string& body) const {
  test::HttpClient client = connect();
  const test::HttpAnswer answer = client.ask(request(method, target, body));
  if (answer.status != 200)
    throw std::runtime_error(fmt::format("{} {} is answered {}: {}", method, target, answer.status, answer.body));
  return answer.body;
}

double EngineeringServer::server_seconds() const {
  double ticks = 0;
  for (const auto& thread : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", process_))) {
    std::string name = text_of((thread.path() / "comm").string());
    if (name != "plc-eng\n") continue;
    const std::string stat = text_of((thread.path() / "stat").string());
    // The 14th and 15th field, behind the name in brackets.
    std::size_t at = stat.rfind(')') + 1;
    for (int field = 2; field < 13; ++field) at = stat.find(' ', at + 1);
    std::size_t used = 0;
    ticks += std::stod(stat.substr(at), &used);
    ticks += std::stod(stat.substr(at + used));
  }
  return ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

EngineeringServer::TaskTimes EngineeringServer::task_times() const {
  const auto task = nlohmann::json::parse(ask("GET", "/api/tasks"))["tasks"][0];
  return {task["latency"]["p99_9_ns"].get<double>() / 1000, task["scan"]["p99_9_ns"].get<double>() / 1000};
}

}  // namespace plc::bench
