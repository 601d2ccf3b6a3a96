// Historian: samples chosen variables at an interval and keeps them, on a thread of its own. The scan never waits for
// it, nor it for a scan.
//
// In: settings, a source of values. Out: a file, courses. A disk that is full or slow costs samples, which is said.
// Threads: read() any but the tasks'; the rest one owner. Does not belong here: files (history_file.h), calls.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "alarms/watch.h"
#include "core/clock.h"
#include "core/diagnostics.h"
#include "historian/history_file.h"
#include "historian/history_reader.h"
#include "historian/settings.h"
#include "runtime/sched/ordinary_thread.h"

namespace plc::historian {

/// Where values come from: the thread of the historian alone calls it.
struct Source {
  std::function<void()> take;  ///< the newest ones
  std::function<void(const runtime::Place& place, std::uint32_t bytes, std::byte* to)> read;
};

/// What is kept.
struct Chosen {
  std::vector<Tag> tags;
  std::vector<alarms::Watched> watched;  ///< of each tag
};
/// The variables that the settings name. What of them cannot be kept is reported. `recorded`: variables of tasks have
/// values.
Chosen chosen_by(const Settings& settings, runtime::Resource& resource, bool recorded, core::Diagnostics& diagnostics);

class Historian {
 public:
  /// `folder`: that exists. What of the tags cannot be kept is reported. `recorded`: variables of tasks have values.
  Historian(const Settings& settings, const std::string& folder, runtime::Resource& resource, bool recorded,
            Source source, const core::Calendar& calendar, core::Diagnostics& diagnostics);
  ~Historian() { stop(); }
  Historian(const Historian&) = delete;
  Historian& operator=(const Historian&) = delete;

  [[nodiscard]] const Settings& settings() const { return settings_; }
  [[nodiscard]] const std::vector<Tag>& tags() const { return file_->tags(); }
  [[nodiscard]] core::TimeNs begin_ns() { return reader_->begin_ns(); }
  std::optional<Course> read(std::string_view path, core::TimeNs from_ns, core::TimeNs to_ns, std::size_t points) {
    return reader_->read(path, from_ns, to_ns, points);
  }
  void start();
  /// What there is, is in the file then.
  void stop();
  /// What has gone wrong since the last call, or goes on again; empty: nothing.
  std::string take_said();

 private:
  void run();

  const Settings settings_;
  Source source_;
  const core::Calendar& calendar_;
  std::vector<alarms::Watched> watched_;
  std::unique_ptr<HistoryFile> file_;
  std::unique_ptr<HistoryReader> reader_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ends_ = false, runs_ = false;
  std::string said_;
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::historian
