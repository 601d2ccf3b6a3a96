// AlarmStore: the history of alarms and their states, kept over restarts in a database.
//
// In: events, states. Out: events by time and name; what is wrong with the disk. A disk that is full or slow costs
// nothing but patience: what could not be written waits in memory. Threads: read() any; a thread of its own writes; the
// rest one owner. Does not belong here: what an alarm is.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <vector>

#include "alarms/alarms.h"
#include "runtime/sched/ordinary_thread.h"
#include "storage/database.h"

namespace plc::alarms {

/// What is asked for.
struct HistoryRequest {
  std::int64_t before = 0;              ///< events with smaller numbers; 0: the newest
  std::string alarm = {};               ///< of this name; empty: of all
  core::TimeNs from_ns = 0, to_ns = 0;  ///< UTC; 0: without end
  std::size_t most = 100;
};

class AlarmStore {
 public:
  /// Events that are kept; the oldest go.
  static constexpr std::int64_t kMostEvents = 1'000'000;
  static constexpr std::size_t kMostWaiting = 100'000;

  /// `folder`: empty, and they are kept until the program ends. `said`: what is wrong, in words.
  AlarmStore(const std::string& folder, std::vector<std::string>& said);
  ~AlarmStore() { stop(); }
  AlarmStore(const AlarmStore&) = delete;
  AlarmStore& operator=(const AlarmStore&) = delete;

  [[nodiscard]] std::int64_t last_number();
  [[nodiscard]] std::vector<Kept> states();
  void start();
  /// Takes what has happened; the thread writes it.
  void add(std::vector<Event> events, std::vector<Kept> states);
  /// Writes what waits.
  void stop();
  /// What has gone wrong since the last call, or goes on again; empty: nothing.
  std::string take_said();
  /// Newest first.
  [[nodiscard]] std::vector<Event> read(const HistoryRequest& request);

 private:
  void open(std::string& said);
  void run();
  /// False: it was not written. `said`: what became of a file that was broken.
  bool write(const std::vector<Event>& events, const std::vector<Kept>& states, std::string& said);

  std::string path_;
  std::mutex database_mutex_;
  storage::Database database_;
  /// Of numbers in the file: where it could be opened later only, events have been counted from 1 on.
  std::int64_t shift_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Event> events_;
  std::vector<Kept> states_;
  std::string said_;
  bool in_trouble_ = false, ends_ = false, runs_ = false;
  runtime::OrdinaryThread thread_;
};

}  // namespace plc::alarms
