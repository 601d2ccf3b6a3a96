// plc remote: asks a running PLC, by the calls of its engineering server.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "engineering/client.h"
#include "tools/command_line.h"
#include "tools/plc/commands.h"
#include "tools/plc/remote_fields.h"
#include "tools/plc/remote_logins.h"
#include "tools/plc/remote_program.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

using engineering::Call;
using engineering::Client;
using engineering::Form;
using engineering::Json;
using engineering::Reply;

constexpr auto kAway = std::chrono::seconds(20);

struct Remote {
  std::string url, what, token, fingerprint, output;
  std::vector<std::string> arguments;
  bool json = false, follow = false;
};

const Call& row(std::string_view name) {
  for (const Call& call : engineering::calls()) {
    if (call.name == name) return call;
  }
  throw std::logic_error("no such row");
}

/// One run of the command: a server, and what is said of it.
class Session {
 public:
  Session(const Remote& remote, engineering::ServerUrl url)
      : remote_(remote), url_(url.text()), known_(load_login(url_)), client_(std::move(url), secret(), fingerprint()) {}

  int run() {
    const std::string& what = remote_.what;
    for (const std::string_view alone : {"", "logout", "status", "tasks", "log", "alarms", "calls", "stop"}) {
      if (what == alone && !remote_.arguments.empty()) return wrong_arguments(what);
    }
    if (what == "login") return login();
    if (what == "first-user") return first_user();
    if (what == "logout") return logout();
    if (what.empty() || what == "status") return status();
    if (what == "tasks") return tasks();
    if (what == "values") return values();
    if (what == "write") return write();
    if (what == "log") return log();
    if (what == "alarms") return alarms();
    if (what == "calls") return list_calls();
    const AskServer asking = [this](std::string_view call, const Json& fields, bool quiet) {
      return ask(row(call), fields, quiet);
    };
    if (what == "upload") return remote_upload(asking, remote_.url, remote_.arguments);
    if (what == "start") return remote_start(asking, remote_.url, remote_.arguments);
    if (what == "stop") return remote_stop(asking);
    for (const Call& call : engineering::calls()) {
      if (call.name == what && call.form != Form::kStream) return by_row(call);
      if (call.name == what) return no_stream(call);
    }
    complain("plc remote", fmt::format("there is no call \"{}\"", what), "plc remote URL calls lists all");
    return kExitUsage;
  }

 private:
  [[nodiscard]] std::string secret() const { return remote_.token.empty() ? known_.token : remote_.token; }
  [[nodiscard]] std::string fingerprint() const {
    return remote_.fingerprint.empty() ? known_.fingerprint : remote_.fingerprint;
  }

  /// What the server answers to a call; nothing, and said, when it refuses.
  std::optional<Json> ask(const Call& call, const Json& fields, bool quiet = false) {
    const auto reply = client_.send(call, fields);
    if (quiet && (!reply || reply->status != 200)) return std::nullopt;
    if (!reply) return complain_of(reply.error()), std::nullopt;
    return document_of(*reply);
  }

  /// Of a certificate that never was another one than --fingerprint says, the client knows no better.
  void complain_of(core::Problem problem) const {
    if (problem.code == core::Code::P7731 && !remote_.fingerprint.empty())
      problem.message = "the certificate of " + url_ + " is not the one of --fingerprint";
    complain(problem);
  }
  std::optional<Json> ask(std::string_view call, const Json& fields = Json::object()) { return ask(row(call), fields); }

  /// For who follows: a server that is away for the start of another program is asked until it is there again.
  std::optional<Json> again(std::string_view call, const Json& fields, bool has_answered) {
    if (has_answered) {
      const auto until = std::chrono::steady_clock::now() + kAway;
      while (std::chrono::steady_clock::now() < until) {
        if (auto answer = ask(row(call), fields, true)) return answer;
        std::this_thread::sleep_for(std::chrono::milliseconds(200));
      }
    }
    return ask(call, fields);
  }

  std::optional<Json> document_of(const Reply& reply) const {
    Json document = Json::parse(reply.body, nullptr, false);
    if (reply.status == 200 && !document.is_discarded()) return document;
    const auto part = [&](const char* name) {
      const auto found = document.is_object() ? document.find(name) : document.end();
      return found != document.end() && found->is_string() ? found->get<std::string>() : std::string();
    };
    const std::string field = part("field");
    const std::string help = part("code") == "P7710" ? login_help(part("help")) : part("help");
    std::cerr << fmt::format(
        "error {}: {}{}\n", part("code").empty() ? "P7730" : part("code"), field.empty() ? "" : field + ": ",
        part("text").empty() ? fmt::format("the server answers with status {}", reply.status) : part("text"));
    if (!help.empty()) std::cerr << "  help: " << help << '\n';
    return std::nullopt;
  }

  /// What somebody does who is not logged in. `said`: by the server, for those who make calls themselves.
  [[nodiscard]] std::string login_help(const std::string& said) const {
    if (said.find("first-user") != std::string::npos) {
      return fmt::format(
          "there is no user yet: plc remote {} first-user CODE USER, with the code that plc-run has printed",
          remote_.url);
    }
    if (!remote_.token.empty()) return "the token of --token or PICARD_TOKEN does not count here, or has ended";
    return fmt::format("plc remote {} login USER", remote_.url);
  }

  static int print(const Json& document) {
    std::cout << document.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
    return kExitOk;
  }

  int keep(const Json& answer) {
    Login login{answer.value("token", ""), fingerprint(), answer.value("user", "")};
    if (const std::string why = store_login(url_, login); !why.empty()) {
      complain("plc remote", why, "the session is known to this run alone");
      return kExitErrors;
    }
    std::cout << fmt::format("logged in to {} as {}, {}\n", url_, login.user, answer.value("role", ""));
    return kExitOk;
  }

  int login() {
    if (remote_.arguments.size() != 1) return wrong_arguments("login USER");
    const Json fields = {{"user", remote_.arguments[0]}, {"password", read_secret("Password: ")}, {"token", true}};
    const auto answer = ask("login", fields);
    return answer ? keep(*answer) : kExitErrors;
  }

  int first_user() {
    if (remote_.arguments.size() != 2) return wrong_arguments("first-user CODE USER");
    const Json fields = {{"code", remote_.arguments[0]},
                         {"user", remote_.arguments[1]},
                         {"password", read_secret("Password for the new user, at least 10 characters: ")},
                         {"token", true}};
    const auto answer = ask("first_user", fields);
    return answer ? keep(*answer) : kExitErrors;
  }

  int logout() {
    const auto answer = ask("logout");
    const std::string why = store_login(url_, {{}, known_.fingerprint, {}});
    if (!why.empty()) complain("plc remote", why);
    return answer && why.empty() ? kExitOk : kExitErrors;
  }

  int wrong_arguments(std::string_view form) const {
    complain("plc remote", "wrong arguments", fmt::format("plc remote {} {}", remote_.url, form));
    return kExitUsage;
  }

  static int no_stream(const Call& call) {
    const std::string_view subject = call.name.substr(0, call.name.find('.'));
    const bool follows = subject == "values" || subject == "log";
    complain(
        "plc remote", fmt::format("{} is a stream, which is not followed by its name", call.name),
        follows ? fmt::format("{} --follow", subject) : "browsers and clients take it: docs/guides/engineering.md");
    return kExitUsage;
  }

  int status() {
    const auto target = ask("target");
    if (!target) return kExitErrors;
    if (remote_.json) return print(*target);
    std::vector<std::vector<std::string>> rows;
    for (const auto& [name, value] : target->items()) {
      if (name == "uptime_ms") {
        rows.push_back({"uptime", duration_text(value.get<double>() * 1e6)});
      } else if (!value.is_array()) {
        rows.push_back({name, value.is_string() ? value.get<std::string>() : value.dump()});
      } else {
        for (const Json& one : value) rows.push_back({name, one.get<std::string>()});
      }
    }
    print_table(rows, std::cout);
    return kExitOk;
  }

  int tasks() {
    const auto answer = ask("tasks");
    if (!answer) return kExitErrors;
    if (remote_.json) return print(*answer);
    std::vector<std::vector<std::string>> rows = {
        {"task", "state", "period", "scans", "overruns", "missed", "faults", "scan mean", "max", "latency p99", "max"}};
    const auto time = [](const Json& ns) { return duration_text(ns.get<double>()); };
    for (const Json& task : (*answer)["tasks"]) {
      rows.push_back({task["name"], task["state"], time(task["period_ns"]), task["scans"].dump(),
                      task["overruns"].dump(), task["missed"].dump(), task["faults"].dump(),
                      time(task["scan"]["mean_ns"]), time(task["scan"]["max_ns"]), time(task["latency"]["p99_ns"]),
                      time(task["latency"]["max_ns"])});
    }
    print_table(rows, std::cout);
    return kExitOk;
  }

  /// Paths as they are, patterns as what they match.
  std::optional<Json> paths() {
    Json found = Json::array();
    std::vector<std::string> wanted = remote_.arguments;
    if (wanted.empty()) wanted.emplace_back("*");
    for (const std::string& one : wanted) {
      if (one.find_first_of("*?") == std::string::npos) {
        found.push_back(one);
        continue;
      }
      const auto nodes = ask("values.search", {{"pattern", one}, {"most", 1000}});
      if (!nodes) return std::nullopt;
      const std::size_t before = found.size();
      for (const Json& node : (*nodes)["nodes"]) {
        if (node.value("readable", false)) found.push_back(node["path"]);
      }
      // Without one, "*" is nobody's pattern: a program may have no variables.
      if (found.size() == before && !remote_.arguments.empty()) {
        complain("plc remote", fmt::format("no variable matches \"{}\"", one));
        return std::nullopt;
      }
    }
    return found;
  }

  int values() {
    const auto which = paths();
    if (!which) return kExitErrors;
    Json before;
    for (;;) {
      const auto answer = again("values.read", {{"paths", *which}}, !before.is_null());
      if (!answer) return kExitErrors;
      const Json& now = (*answer)["values"];
      if (remote_.json) {
        if (now != before) print(now);
      } else if (before.is_null()) {
        std::vector<std::vector<std::string>> rows;
        for (const Json& value : now) rows.push_back({value["path"], value.value("type", ""), text_of(value)});
        print_table(rows, std::cout);
      } else {
        for (std::size_t i = 0; i < now.size(); ++i) {
          if (now[i] != before[i])
            std::cout << now[i]["path"].get<std::string>() << "  " << text_of(now[i]) << std::endl;
        }
      }
      if (!remote_.follow) {
        const bool wrong = std::any_of(now.begin(), now.end(), [](const Json& one) { return one.contains("problem"); });
        return wrong ? kExitErrors : kExitOk;
      }
      before = now;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }

  static std::string text_of(const Json& value) {
    if (value.contains("problem"))
      return fmt::format("{}: {}", value["problem"].value("code", ""), value["problem"].value("text", ""));
    return shown_value(value["value"]);
  }

  int write() {
    if (remote_.arguments.empty()) return wrong_arguments("write PATH=VALUE ..");
    Json values = Json::array(), which = Json::array();
    for (const std::string& argument : remote_.arguments) {
      const std::size_t equals = argument.find('=');
      if (equals == std::string::npos || equals == 0) return wrong_arguments("write PATH=VALUE ..");
      values.push_back({{"path", argument.substr(0, equals)}, {"value", value_of(argument.substr(equals + 1))}});
      which.push_back(values.back()["path"]);
    }
    const auto before = ask(row("values.read"), {{"paths", which}}, true);
    for (std::size_t i = 0; before && i < values.size(); ++i) {
      // Of a text what was typed counts: 1.50 is no number there.
      const std::string type = (*before)["values"][i].value("type", "");
      const bool characters =
          type.starts_with("STRING") || type.starts_with("WSTRING") || type == "CHAR" || type == "WCHAR";
      const std::string& argument = remote_.arguments[i];
      if (characters && !values[i]["value"].is_string()) values[i]["value"] = argument.substr(argument.find('=') + 1);
    }
    const auto answer = ask("values.write", {{"values", values}});
    if (!answer) return kExitErrors;
    if (remote_.json) return print(*answer);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const Json had = before ? (*before)["values"][i].value("value", Json()) : Json();
      Json has = values[i]["value"];
      if (had.is_boolean() && has.is_number()) has = has != 0;
      std::cout << fmt::format("{}: {}{}\n", which[i].get<std::string>(),
                               had.is_null() ? "" : shown_value(had) + " -> ", shown_value(has));
    }
    return kExitOk;
  }

  int log() {
    Json fields = {{"most", 1000}};
    for (;;) {
      const auto answer = again("log", fields, fields.contains("after"));
      if (!answer) return kExitErrors;
      for (const Json& record : (*answer)["records"]) {
        if (remote_.json) {
          std::cout << record.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
          continue;
        }
        const std::string severity = record.value("severity", "note");
        std::cout << record.value("time", "") << ' ' << (severity == "note" ? "" : severity + ": ")
                  << record.value("message", "") << '\n';
        if (record.contains("details")) std::cout << record["details"].get<std::string>() << '\n';
      }
      std::cout.flush();
      if (!remote_.follow) return kExitOk;
      if (!(*answer)["records"].empty())
        fields["after"] = (*answer)["records"].back()["number"];
      else if (!fields.contains("after"))
        fields["after"] = (*answer)["last"];
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }

  int alarms() {
    const auto answer = ask("alarms.list", {{"most", 10'000}});
    if (!answer) return kExitErrors;
    if (remote_.json) return print(*answer);
    std::vector<std::vector<std::string>> rows = {
        {"alarm", "state", "priority", "since", "scan", "order", "by", "text"}};
    for (const Json& alarm : (*answer)["alarms"]) {
      const bool in_scan = alarm.contains("scan");
      rows.push_back({alarm.value("name", ""), alarm.value("state", ""), alarm.value("priority", ""),
                      alarm.value("since", ""), in_scan ? alarm.value("task", "") + " " + alarm["scan"].dump() : "",
                      alarm.contains("order") ? alarm["order"].dump() : "", alarm.value("user", ""),
                      alarm.value("text", "")});
    }
    print_table(rows, std::cout);
    std::cout << fmt::format("{}, {} active, {} not acknowledged, {} out of sight\n",
                             counted((*answer)["all"].get<std::size_t>(), "alarm"), (*answer)["active"].dump(),
                             (*answer)["unacked"].dump(), (*answer)["hidden"].dump());
    return kExitOk;
  }

  static int list_calls() {
    std::vector<std::vector<std::string>> rows = {{"call", "right", "what it does"}};
    for (const Call& call : engineering::calls()) {
      if (call.form == Form::kStream) continue;
      rows.push_back({std::string(call.name), std::string(engineering::right_text(call.right)),
                      std::string(call.doc.substr(0, call.doc.find(". ")))});
    }
    print_table(rows, std::cout);
    return kExitOk;
  }

  int by_row(const Call& call) {
    Json fields;
    if (const std::string why = read_fields(call, remote_.arguments, fields); !why.empty()) {
      complain("plc remote", why, fields_text(call));
      return kExitUsage;
    }
    for (const engineering::Field& field : call.request) {
      const std::string name(field.name);
      const bool secret = name == "password" || name == "old" || name == "new";
      if (secret && field.required && !fields.contains(name)) fields[name] = read_secret(std::string(field.doc) + ": ");
    }
    const auto reply = client_.send(call, fields);
    if (!reply) return complain_of(reply.error()), kExitErrors;
    if (call.form == Form::kFile && reply->status == 200) return store(*reply);
    const auto document = document_of(*reply);
    return document ? print(*document) : kExitErrors;
  }

  int store(const Reply& reply) const {
    if (remote_.output.empty()) {
      complain("plc remote", "where to is not said", fmt::format("-o {}, or -o - for stdout", reply.file_name));
      return kExitUsage;
    }
    if (remote_.output == "-") {
      std::cout.write(reply.body.data(), static_cast<std::streamsize>(reply.body.size()));
      return kExitOk;
    }
    std::string why;
    if (write_file(remote_.output, reply.body, why)) return kExitOk;
    complain("plc remote", fmt::format("cannot write {}: {}", remote_.output, why));
    return kExitUsage;
  }

  const Remote& remote_;
  std::string url_;
  Login known_;
  Client client_;
};

/// "AB:CD:..", 32 bytes.
bool is_fingerprint(std::string_view text) {
  constexpr std::size_t kCharacters = 32 * 3 - 1;
  if (text.size() != kCharacters) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool good = i % 3 == 2 ? text[i] == ':' : std::isxdigit(static_cast<unsigned char>(text[i])) != 0;
    if (!good) return false;
  }
  return true;
}

int run(const Remote& remote) {
  if (!remote.fingerprint.empty() && !is_fingerprint(remote.fingerprint)) {
    complain("plc remote", "--fingerprint \"" + remote.fingerprint + "\" is no fingerprint",
             "it has 32 bytes in hexadecimal with colons between them, AB:CD:.., as plc-run has printed it");
    return kExitUsage;
  }
  auto url = engineering::parse_url(remote.url);
  if (!url) {
    complain("plc remote", "\"" + remote.url + "\" is not an address of a server",
             "write http://127.0.0.1:8061 or https://HOST:8061");
    return kExitUsage;
  }
  return Session(remote, std::move(*url)).run();
}

}  // namespace

void add_remote(Command program) {
  static Remote remote;
  const Command command = program.sub(
      "remote",
      "Asks a running plc-run: state, values, log, users. What may be done depends on who is logged in.\n"
      "\n"
      "Examples:\n"
      "  plc remote http://127.0.0.1:8061 first-user ABCD-EFGH-JKMN anna   the code is what plc-run has printed\n"
      "  plc remote https://plant:8061 login anna                         asks for the password; a script puts it on "
      "stdin\n"
      "  plc remote https://plant:8061                                    state\n"
      "  plc remote https://plant:8061 tasks                              what tasks do and need\n"
      "  plc remote https://plant:8061 values 'Main.*' --follow           values, then what changes\n"
      "  plc remote https://plant:8061 write Setpoint=21.5 Start=true     as an HMI does\n"
      "  plc remote https://plant:8061 log --follow                       messages\n"
      "  plc remote https://plant:8061 upload plant.pbc plant.xml         another program, and its project to keep\n"
      "  plc remote https://plant:8061 start cold                         starts it; warm is the default\n"
      "  plc remote https://plant:8061 stop                               outputs go into their safe state\n"
      "  plc remote https://plant:8061 alarms                             what is wrong, and since which scan\n"
      "  plc remote https://plant:8061 alarms.ack comment=\"valve cleaned\"  somebody has seen all of them\n"
      "  plc remote https://plant:8061 users.add user=ben role=viewer     any call, by its name and fields\n"
      "  plc remote https://plant:8061 program.project -o plant.xml       the project that runs\n"
      "  plc remote https://plant:8061 calls                              all of them");
  command.option("URL", remote.url, "http://ADDR:PORT or https://ADDR:PORT; the port is 8061 if it is not said")
      .required();
  command.option("WHAT", remote.what,
                 "login, first-user, logout, status, tasks, values, write, log, alarms, upload, start, stop, calls; or "
                 "the name of a call; default: status");
  command.option("ARGUMENT", remote.arguments, "patterns, PATH=VALUE, files or FIELD=VALUE");
  command.flag("--json", remote.json, "what the server answers, as it is");
  command.flag("--follow", remote.follow, "values and log: goes on with what is new, until Ctrl-C");
  command.option("--token=SECRET", remote.token,
                 "of a session or a script, in place of the login that is kept; or PICARD_TOKEN");
  command.option("--fingerprint=AB:CD:..", remote.fingerprint,
                 "takes the certificate with this SHA-256, which plc-run has printed; login keeps it");
  command.option("-o,--output=FILE", remote.output, "where a file goes that is asked for");
  command.on_run([] {
    const char* const token = std::getenv("PICARD_TOKEN");
    if (remote.token.empty() && token != nullptr) remote.token = token;
    return run(remote);
  });
}

}  // namespace plc::tools
