#include "historian/historian.h"

#include <chrono>
#include <set>
#include <utility>

#include "core/text.h"

namespace plc::historian {
namespace {

using std::chrono::nanoseconds;
using std::chrono::steady_clock;

}  // namespace

Chosen chosen_by(const Settings& settings, runtime::Resource& resource, bool recorded, core::Diagnostics& diagnostics) {
  const runtime::Access access(resource);
  std::set<std::string> known;
  Chosen chosen;
  for (std::size_t i = 0; i < settings.tags.size(); ++i) {
    const std::string& pattern = settings.tags[i];
    const core::SourceRef at = i < settings.tags_at.size() ? settings.tags_at[i] : core::SourceRef();
    const bool one = pattern.find_first_of("*?") == std::string::npos;
    std::size_t found = 0;
    const auto add = [&](const std::string& path) {
      auto watched = alarms::watch(resource, path, recorded);
      if (!watched) {
        // A pattern means what can be kept of what it matches.
        if (one) diagnostics.report(watched.error().code, at, {}, watched.error().message, watched.error().help);
        return;
      }
      ++found;
      if (chosen.tags.size() >= kMostTags || !known.insert(core::folded(path)).second) return;
      chosen.tags.push_back({path, watched->type, 0});
      chosen.watched.push_back(*watched);
    };
    if (one) {
      add(pattern);
      continue;
    }
    for (const std::string& path : access.list(pattern, kMostTags)) add(path);
    if (found == 0)
      diagnostics.report(core::Code::P7101, at, {}, "no variable that can be kept matches \"" + pattern + "\"");
  }
  return chosen;
}

Historian::Historian(const Settings& settings, const std::string& folder, runtime::Resource& resource, bool recorded,
                     Source source, const core::Calendar& calendar, core::Diagnostics& diagnostics)
    : settings_(settings), source_(std::move(source)), calendar_(calendar) {
  Chosen chosen = chosen_by(settings, resource, recorded, diagnostics);
  watched_ = std::move(chosen.watched);
  file_ =
      std::make_unique<HistoryFile>(folder + "/history.db", std::move(chosen.tags), settings.days, settings.most_bytes);
  reader_ = std::make_unique<HistoryReader>(*file_);
}

void Historian::start() {
  runs_ = true;
  thread_.start("plc-historian", [this] { run(); });
}

void Historian::stop() {
  if (!std::exchange(runs_, false)) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Historian::run() {
  auto next = steady_clock::now();
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      if (std::string said = file_->take_said(); !said.empty()) said_ = std::move(said);
      if (wake_.wait_until(lock, next, [this] { return ends_; })) break;
    }
    source_.take();
    file_->add(calendar_.utc_ns(), [this](std::size_t i, std::byte* to) {
      source_.read(watched_[i].place, alarms::bytes_of(watched_[i].type), to);
    });
    // What was missed while the disk was slow is not made up for.
    const auto now = steady_clock::now();
    next += nanoseconds(settings_.interval_ns);
    if (next < now) next = now + nanoseconds(settings_.interval_ns);
  }
  file_->flush();
  const std::lock_guard lock(mutex_);
  if (std::string said = file_->take_said(); !said.empty()) said_ = std::move(said);
}

std::string Historian::take_said() {
  const std::lock_guard lock(mutex_);
  return std::exchange(said_, {});
}

}  // namespace plc::historian
