#include "tools/plc-run/retained.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <ostream>

#include "tools/command_line.h"
#include "tools/statistics.h"

namespace plc::tools {
namespace {

constexpr std::size_t kMostNames = 8;
constexpr std::size_t kMostMisfits = 20;

/// What code alone knows of has no name for people.
std::vector<const retain::Root*> named(const retain::Layout& layout) {
  std::vector<const retain::Root*> roots;
  for (const retain::Root& root : layout.roots) {
    if (!root.internal) roots.push_back(&root);
  }
  return roots;
}

void warn_not_kept(const retain::Layout& layout, std::ostream& errors) {
  const std::vector<const retain::Root*> roots = named(layout);
  if (roots.empty()) return;
  std::string names;
  for (std::size_t r = 0; r < std::min(roots.size(), kMostNames); ++r) names += (r == 0 ? "" : ", ") + roots[r]->path;
  if (roots.size() > kMostNames) names += ", ..";
  errors << fmt::format("warning {}: {} {} not kept, no folder is given for {}: {}\n",
                        core::info(core::Code::P7610).name, counted(roots.size(), "retained variable"),
                        roots.size() == 1 ? "is" : "are", roots.size() == 1 ? "it" : "them", names)
         << "  help: --state DIR, or state = \"DIR\" under [retain] in plc.toml, keeps them over a restart\n";
}

const char* word_of(retain::Start start) {
  return start == retain::Start::kWarm ? "warm" : start == retain::Start::kCold ? "cold" : "origin";
}

}  // namespace

std::string state_folder(const std::string& given, const io::Configuration& configuration, bool simulate) {
  if (!given.empty() || simulate) return given;
  if (!configuration.retain.state.text.empty()) return configuration.beside(configuration.retain.state.text);
  const char* const service = std::getenv("STATE_DIRECTORY");
  const std::string folders = service == nullptr ? "" : service;
  return folders.substr(0, folders.find(':'));
}

Retained restore_retained(runtime::Resource& resource, const std::string& folder, core::TimeNs interval_ns,
                          retain::Start start, std::ostream& talk, std::ostream& errors) {
  if (folder.empty()) {
    warn_not_kept(retain::find_kept(resource).layout, errors);
    return {};
  }
  auto keeper = std::make_unique<retain::Keeper>(resource, retain::KeeperOptions{folder, interval_ns});
  if (keeper->empty()) return {};
  const retain::Restored restored = keeper->restore(start);
  const std::size_t count = named(keeper->layout()).size();
  if (restored.problem) {
    complain(*restored.problem);
    errors << "  retained variables have their initial values; the file becomes " << retain::kPreviousName << '\n';
  }
  for (std::size_t m = 0; m < std::min(restored.carried.misfits.size(), kMostMisfits); ++m) {
    errors << fmt::format("warning {}: {}\n", core::info(core::Code::P7612).name, restored.carried.misfits[m]);
  }
  if (restored.carried.misfits.size() > kMostMisfits) {
    errors << fmt::format("warning {}: and {} more\n", core::info(core::Code::P7612).name,
                          restored.carried.misfits.size() - kMostMisfits);
  }
  const bool values = restored.found && !restored.problem;
  talk << fmt::format("retain: {} start, {} in {}", word_of(start), counted(count, "variable"), keeper->path());
  if (values) {
    talk << fmt::format("; {} restored, stored {:%Y-%m-%d %H:%M:%S} UTC", restored.carried.kept,
                        fmt::gmtime(restored.time_of_day_ns / 1'000'000'000));
  } else {
    talk << (start == retain::Start::kOrigin || restored.problem ? "; initial values" : "; nothing stored yet");
  }
  talk << '\n';
  return {std::move(keeper), restored.program_time_ns};
}

}  // namespace plc::tools
