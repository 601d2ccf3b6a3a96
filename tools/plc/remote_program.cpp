#include "tools/plc/remote_program.h"

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/text.h"
#include "tools/command_line.h"

namespace plc::tools {
namespace {

using engineering::Json;

/// For a program to start: of machine code, of devices, and its first second.
constexpr auto kPatience = std::chrono::seconds(60);

std::optional<std::string> read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return std::nullopt;
  return std::string{std::istreambuf_iterator<char>(in), {}};
}

int cannot_read(const std::string& path) {
  complain("plc remote", path + " cannot be read");
  return kExitUsage;
}

std::string short_hash(const Json& hash) { return hash.get<std::string>().substr(0, 8); }

}  // namespace

int remote_upload(const AskServer& ask, const std::string& url, const std::vector<std::string>& words) {
  if (words.empty() || words.size() > 2) {
    complain("plc remote", "wrong arguments", fmt::format("plc remote {} upload IMAGE [PROJECT]", url));
    return kExitUsage;
  }
  const std::string& image = words[0];
  if (!is_image_path(image)) {
    complain("plc remote", image + " is no image",
             fmt::format("plc compile {} --drawings -o plant.pbc makes one", image));
    return kExitUsage;
  }
  const auto bytes = read(image);
  if (!bytes) return cannot_read(image);
  const auto project = words.size() == 2 ? read(words[1]) : std::nullopt;
  if (words.size() == 2 && !project) return cannot_read(words[1]);
  Json fields = {{"image", *bytes}};
  if (const auto signature = read(image + ".sig")) fields["signature"] = core::trimmed(*signature);
  const auto answer = ask("program.upload", fields, false);
  if (!answer) return kExitErrors;
  if (project) {
    const Json more = {{"project", *project}, {"name", std::filesystem::path(words[1]).filename().string()}};
    if (!ask("program.store_project", more, false)) return kExitErrors;
  }
  const std::string signer = answer->value("signer", "");
  std::cout << fmt::format("program {} was found good{}, and waits: plc remote {} start\n",
                           short_hash((*answer)["program"]["image"]), signer.empty() ? "" : ", signed by " + signer,
                           url);
  return kExitOk;
}

int remote_start(const AskServer& ask, const std::string& url, const std::vector<std::string>& words) {
  const std::string kind = words.empty() ? "warm" : words[0];
  if (words.size() > 1 || (kind != "warm" && kind != "cold")) {
    complain("plc remote", "wrong arguments", fmt::format("plc remote {} start [warm|cold]", url));
    return kExitUsage;
  }
  const auto before = ask("program", Json::object(), false);
  if (!before) return kExitErrors;
  const auto asked = ask("program.start", {{"kind", kind}}, false);
  if (!asked) return kExitErrors;
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (std::chrono::steady_clock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    const auto now = ask("program", Json::object(), true);
    if (!now) continue;
    const bool failed = now->contains("failed") && (*now)["failed"]["program"]["image"] == (*asked)["image"] &&
                        (!before->contains("failed") || (*before)["failed"] != (*now)["failed"]);
    // The one before answers when it runs.
    if (failed && (*now)["state"] != "ends") {
      std::cerr << fmt::format("error P7752: program {} does not start; {} runs again\n", short_hash((*asked)["image"]),
                               short_hash((*now)["image"]))
                << (*now)["failed"]["why"].get<std::string>() << '\n';
      return kExitErrors;
    }
    // The one that ran answers until it ends.
    if ((*now)["starts"] == (*before)["starts"]) continue;
    if ((*now)["image"] != (*asked)["image"] || (*now)["state"] != "runs") continue;
    const int stood = now->value("stood_ms", 0);
    std::cout << fmt::format("program {} runs{}\n", short_hash((*now)["image"]),
                             stood == 0 ? "" : fmt::format("; control stood for {} ms", stood));
    return kExitOk;
  }
  complain("plc remote", fmt::format("{} does not say that the program runs", url), "its log says why");
  return kExitErrors;
}

int remote_stop(const AskServer& ask) {
  const auto answer = ask("program.stop", Json::object(), false);
  if (!answer) return kExitErrors;
  std::cout << fmt::format("program {} stops; outputs go into their safe state\n", short_hash((*answer)["image"]));
  return kExitOk;
}

}  // namespace plc::tools
