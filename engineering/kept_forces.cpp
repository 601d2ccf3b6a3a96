#include "engineering/kept_forces.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <nlohmann/json.hpp>

#include "engineering/call.h"
#include "engineering/state_files.h"

namespace plc::engineering {
namespace {

std::string path_in(const std::string& folder) { return folder + "/forces.json"; }

Json json_of(const runtime::Force& force) {
  Json json = {{"path", force.path},
               {"value", force.value},
               {"owner", force.owner},
               {"reason", force.reason},
               {"since_ns", force.since_ns}};
  if (force.until_ns) json["until_ns"] = *force.until_ns;
  return json;
}

/// Throws what nlohmann throws.
runtime::Force force_of(const Json& json) {
  runtime::Force force;
  force.path = json.at("path").get<std::string>();
  force.value = json.at("value").get<std::string>();
  force.owner = json.at("owner").get<std::string>();
  force.reason = json.at("reason").get<std::string>();
  force.since_ns = json.at("since_ns").get<core::TimeNs>();
  if (json.contains("until_ns")) force.until_ns = json.at("until_ns").get<core::TimeNs>();
  force.kept = true;
  return force;
}

/// What the file has; none without one. `wrong`: why that is not known.
std::vector<runtime::Force> read_kept_forces(const std::string& folder, std::string& wrong) {
  std::vector<runtime::Force> all;
  const auto text = folder.empty() ? std::nullopt : read_whole_file(path_in(folder), wrong);
  if (!text) return all;
  const Json json = Json::parse(*text, nullptr, false);
  try {
    if (!json.is_array()) throw std::invalid_argument("no list");
    for (const Json& one : json) all.push_back(force_of(one));
  } catch (const std::exception&) {
    wrong = path_in(folder) + " is damaged";
    all.clear();
  }
  return all;
}

}  // namespace

std::string store_kept_forces(const std::string& folder, const std::vector<runtime::Force>& forces) {
  if (folder.empty()) return {};
  Json all = Json::array();
  for (const runtime::Force& force : forces) {
    if (force.kept) all.push_back(json_of(force));
  }
  std::string why;
  // Most plants never have one.
  if (all.empty() && !read_whole_file(path_in(folder), why) && why.empty()) return {};
  return write_private_file(path_in(folder), all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::vector<std::string> force_again(const std::string& folder, core::TimeNs utc_ns, core::TimeNs now_ns,
                                     runtime::ForceList& forces) {
  std::vector<std::string> said;
  std::string wrong;
  for (runtime::Force& force : read_kept_forces(folder, wrong)) {
    if (force.until_ns) {
      if (*force.until_ns <= utc_ns) continue;
      // WHY not more than it had at first: UTC may have been set back.
      force.until_mono_ns = now_ns + *force.until_ns - std::max(utc_ns, force.since_ns);
    }
    const std::string path = force.path;
    const auto made = forces.set(std::move(force));
    if (!made) said.push_back(fmt::format("{} is not forced any more: {}", path, made.error().message));
  }
  if (!wrong.empty()) said.push_back("forces of before the start do not hold: " + wrong);
  return said;
}

std::vector<std::string> ended_by_start(const std::string& folder) {
  std::vector<std::string> said;
  std::string ignored;  // they end in any case
  for (const runtime::Force& force : read_kept_forces(folder, ignored))
    said.push_back(force.path + " is not forced any more: it was a cold start");
  return said;
}

std::string KeptForces::store() {
  changed_ = true;  // before it is asked whether the program is on trial: release() loses nothing
  if (held_) return {};
  const std::lock_guard lock(storing_);
  changed_ = false;  // before the list is read: what changes from here on is due
  std::string why = store_kept_forces(folder_, forces_.list());
  if (!why.empty()) changed_ = true;
  return why;
}

}  // namespace plc::engineering
