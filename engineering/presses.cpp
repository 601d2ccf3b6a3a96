#include "engineering/presses.h"

#include <nlohmann/json.hpp>

#include "engineering/value_json.h"
#include "runtime/link/link.h"

namespace plc::engineering {

using core::Code;
using core::Problem;

std::vector<std::uint32_t> Presses::readers(std::uint32_t offset) const {
  const bytecode::Image& image = variables_.image();
  const std::uint32_t field = variables_.resource().globals().field_of(offset);
  std::vector<std::uint32_t> tasks;
  for (std::uint32_t task = 0; task < image.tasks.size(); ++task) {
    // Tasks that wait for an event may never scan.
    if (!image.tasks[task].single.empty()) continue;
    for (const runtime::FieldRange& range : runtime::exchanged_ranges(image, image.tasks[task].body)) {
      if (field < range.first || field >= range.first + range.count) continue;
      tasks.push_back(task);
      break;
    }
  }
  return tasks;
}

bool Presses::was_seen(const Button& button, core::TimeNs now_ns) const {
  if (now_ns - button.since_ns < kShortestNs) return false;
  for (const auto& [task, scans] : button.wanted) {
    const std::optional<std::uint64_t> ended = scans_(task);
    if (ended && *ended < scans) return false;
  }
  return true;
}

bool Presses::let_go(const Button& button, core::TimeNs now_ns) {
  return button.holders.empty() && was_seen(button, now_ns) && !variables_.write(button.off);
}

Presses::Pressed Presses::press(const std::string& path, const Holder& holder, bool renews, core::TimeNs now_ns) {
  std::vector<Variables::Write> on, off;
  std::string field;
  if (auto problem = variables_.prepare(path, true, on, field)) return {false, false, std::move(problem)};
  if (auto problem = variables_.prepare(path, false, off, field)) return {false, false, std::move(problem)};
  if (on.size() != 1 || type_name(variables_.image(), on[0].type) != "BOOL") {
    return {false, false, Problem{Code::P7102, "\"" + path + "\" is no BOOL", {}}};
  }
  const std::lock_guard lock(mutex_);
  const auto found = buttons_.find(on[0].offset);
  const bool fresh = found == buttons_.end() || !found->second.holders.contains(holder);
  if (fresh && renews) return {};
  if (found == buttons_.end() && buttons_.size() >= kMost) {
    return {false, false, Problem{Code::P7717, "too many buttons are held", {}}};
  }
  if (!fresh) return found->second.holders[holder] = now_ns + kLeaseNs, Pressed{false, true, {}};
  if (auto problem = variables_.write(on)) return {false, false, std::move(problem)};
  // WHY after the write, and two more: the scan that goes on now may have begun before it.
  std::vector<std::pair<std::uint32_t, std::uint64_t>> wanted;
  for (const std::uint32_t task : readers(on[0].offset)) wanted.emplace_back(task, scans_(task).value_or(0) + 2);
  Button& button = buttons_[on[0].offset];
  button.path = path;
  button.off = std::move(off);
  button.since_ns = now_ns;
  button.wanted = std::move(wanted);
  button.holders[holder] = now_ns + kLeaseNs;
  return {true, true, std::nullopt};
}

bool Presses::release(const std::string& path, const Holder& holder, core::TimeNs now_ns) {
  const auto place = runtime::Access(variables_.resource()).find(path);
  if (!place || place->task != runtime::Place::kGlobal) return false;
  const std::lock_guard lock(mutex_);
  const auto found = buttons_.find(place->offset);
  if (found == buttons_.end() || found->second.holders.erase(holder) == 0) return false;
  if (let_go(found->second, now_ns)) buttons_.erase(found);
  return true;
}

std::vector<Presses::Ended> Presses::service(core::TimeNs now_ns) {
  std::vector<Ended> ended;
  const std::lock_guard lock(mutex_);
  for (auto at = buttons_.begin(); at != buttons_.end();) {
    Button& button = at->second;
    std::erase_if(button.holders, [&](const auto& holder) {
      if (now_ns < holder.second) return false;
      ended.push_back({button.path, holder.first});
      return true;
    });
    at = let_go(button, now_ns) ? buttons_.erase(at) : std::next(at);
  }
  return ended;
}

void Presses::stop() {
  const std::lock_guard lock(mutex_);
  for (const auto& [offset, button] : buttons_) (void)variables_.write(button.off);
  buttons_.clear();
}

}  // namespace plc::engineering
