#include "alarms/alarm_store.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace plc::alarms {
namespace {

constexpr std::chrono::milliseconds kAgain{1000};
/// The oldest events go when so many more are there than are kept.
constexpr std::int64_t kCutAt = 10'000;

constexpr std::string_view kSchema = R"(
CREATE TABLE IF NOT EXISTS event (
  number INTEGER PRIMARY KEY, utc INTEGER NOT NULL, alarm TEXT NOT NULL, what INTEGER NOT NULL, priority INTEGER NOT NULL,
  category TEXT, text TEXT, user TEXT, comment TEXT, task TEXT, scan INTEGER, value REAL);
CREATE INDEX IF NOT EXISTS event_of_alarm ON event (alarm COLLATE NOCASE, number);
CREATE TABLE IF NOT EXISTS state (
  alarm TEXT PRIMARY KEY, packed INTEGER NOT NULL, shelved_until INTEGER, raised INTEGER NOT NULL);
)";

}  // namespace

AlarmStore::AlarmStore(const std::string& folder, std::vector<std::string>& said)
    : path_(folder.empty() ? ":memory:" : folder + "/alarms.db") {
  std::string sentence;
  open(sentence);
  if (!sentence.empty()) said.push_back(std::move(sentence));
}

void AlarmStore::open(std::string& said) {
  if (!database_.open(path_, kSchema, said) && !in_trouble_) {
    in_trouble_ = true;
    said = "alarms: the history cannot be kept in " + path_ + ": " + database_.why() + "; it waits in memory";
  }
}

std::int64_t AlarmStore::last_number() {
  const std::lock_guard lock(database_mutex_);
  return database_.is_open() ? database_.number("SELECT max(number) FROM event") : 0;
}

std::vector<Kept> AlarmStore::states() {
  const std::lock_guard lock(database_mutex_);
  std::vector<Kept> all;
  if (!database_.is_open()) return all;
  storage::Statement rows(database_, "SELECT alarm, packed, shelved_until, raised FROM state");
  // What somebody has said counts until it is raised again.
  storage::Statement said(database_,
                          "SELECT what, user, comment FROM event WHERE alarm = ?1 COLLATE NOCASE AND "
                          "(what = ?2 OR user <> '') ORDER BY number DESC LIMIT 1");
  while (rows.next()) {
    Kept kept{rows.text(0), rows.integer(1), std::nullopt, rows.integer(3)};
    if (!rows.is_null(2)) kept.shelved_until_ns = rows.integer(2);
    if (said.bind(1, kept.alarm).bind(2, static_cast<std::int64_t>(Happened::kRaised)).next() &&
        said.integer(0) != static_cast<std::int64_t>(Happened::kRaised)) {
      kept.user = said.text(1);
      kept.comment = said.text(2);
    }
    said.reset();
    all.push_back(std::move(kept));
  }
  return all;
}

void AlarmStore::start() {
  runs_ = true;
  thread_.start("plc-alarms", [this] { run(); });
}

void AlarmStore::stop() {
  if (!std::exchange(runs_, false)) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void AlarmStore::add(std::vector<Event> events, std::vector<Kept> states) {
  if (events.empty() && states.empty()) return;
  {
    const std::lock_guard lock(mutex_);
    std::move(events.begin(), events.end(), std::back_inserter(events_));
    if (events_.size() > kMostWaiting)
      events_.erase(events_.begin(), events_.end() - static_cast<std::ptrdiff_t>(kMostWaiting));
    for (Kept& state : states) {
      std::erase_if(states_, [&](const Kept& one) { return one.alarm == state.alarm; });
      states_.push_back(std::move(state));
    }
  }
  wake_.notify_one();
}

void AlarmStore::run() {
  std::string broken;  // what became of the file, until it is written again
  for (;;) {
    std::vector<Event> events;
    std::vector<Kept> states;
    bool ends = false;
    {
      std::unique_lock lock(mutex_);
      const auto has_work = [this] { return ends_ || !events_.empty() || !states_.empty(); };
      if (in_trouble_) {
        wake_.wait_for(lock, kAgain, [this] { return ends_; });
      } else {
        wake_.wait(lock, has_work);
      }
      ends = ends_;
      events = events_;
      states = states_;
    }
    const bool written = write(events, states, broken);
    const std::lock_guard lock(mutex_);
    if (written) {
      // WHY by number: others came meanwhile.
      const std::int64_t last = events.empty() ? 0 : events.back().number;
      std::erase_if(events_, [last](const Event& event) { return event.number <= last; });
      std::erase_if(states_, [&](const Kept& one) {
        return std::any_of(states.begin(), states.end(), [&](const Kept& done) {
          return done.alarm == one.alarm && done.packed == one.packed &&
                 done.shelved_until_ns == one.shelved_until_ns && done.raised_utc_ns == one.raised_utc_ns;
        });
      });
      if (std::exchange(in_trouble_, false)) said_ = "alarms: the history is written again";
      if (!broken.empty()) said_ = "alarms: " + std::exchange(broken, {});
    } else if (!std::exchange(in_trouble_, true)) {
      const std::lock_guard database(database_mutex_);
      said_ = "alarms: the history cannot be written: " + database_.why() + "; it waits in memory";
    }
    if (ends && (!written || (events_.empty() && states_.empty()))) return;
  }
}

bool AlarmStore::write(const std::vector<Event>& events, const std::vector<Kept>& states, std::string& said) {
  const std::lock_guard lock(database_mutex_);
  if (!database_.is_open()) {
    if (!database_.open(path_, kSchema, said)) return false;
    shift_ = database_.number("SELECT max(number) FROM event");
  }
  return database_.transact([&] {
    storage::Statement event(database_,
                             "INSERT OR REPLACE INTO event VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)");
    for (const Event& one : events) {
      event.bind(1, one.number + shift_)
          .bind(2, one.utc_ns)
          .bind(3, one.alarm)
          .bind(4, static_cast<std::int64_t>(one.what))
          .bind(5, static_cast<std::int64_t>(one.priority))
          .bind(6, one.category)
          .bind(7, one.text)
          .bind(8, one.user)
          .bind(9, one.comment)
          .bind(10, one.task);
      one.scan ? event.bind(11, static_cast<std::int64_t>(*one.scan)) : event.bind_null(11);
      one.value ? event.bind(12, *one.value) : event.bind_null(12);
      if (!event.run()) return false;
    }
    storage::Statement state(database_, "INSERT OR REPLACE INTO state VALUES (?1, ?2, ?3, ?4)");
    for (const Kept& one : states) {
      state.bind(1, one.alarm).bind(2, one.packed).bind(4, one.raised_utc_ns);
      one.shelved_until_ns ? state.bind(3, *one.shelved_until_ns) : state.bind_null(3);
      if (!state.run()) return false;
    }
    const std::int64_t last = events.empty() ? 0 : events.back().number + shift_;
    if (events.empty() || last % kCutAt > static_cast<std::int64_t>(events.size())) return true;
    storage::Statement cut(database_, "DELETE FROM event WHERE number <= ?1");
    return cut.bind(1, last - kMostEvents).run();
  });
}

std::string AlarmStore::take_said() {
  const std::lock_guard lock(mutex_);
  return std::exchange(said_, {});
}

std::vector<Event> AlarmStore::read(const HistoryRequest& request) {
  const std::lock_guard lock(database_mutex_);
  std::vector<Event> all;
  if (!database_.is_open()) return all;
  storage::Statement rows(database_,
                          std::string("SELECT number, utc, alarm, what, priority, category, text, user, "
                                      "comment, task, scan, value FROM event WHERE number < ?1 AND utc >= ?2 "
                                      "AND utc <= ?3") +
                              (request.alarm.empty() ? "" : " AND alarm = ?4 COLLATE NOCASE") +
                              " ORDER BY number DESC LIMIT ?5");
  rows.bind(1, request.before == 0 ? INT64_MAX : request.before)
      .bind(2, request.from_ns)
      .bind(3, request.to_ns == 0 ? INT64_MAX : request.to_ns)
      .bind(5, static_cast<std::int64_t>(request.most));
  if (!request.alarm.empty()) rows.bind(4, request.alarm);
  while (rows.next()) {
    Event event;
    event.number = rows.integer(0);
    event.utc_ns = rows.integer(1);
    event.alarm = rows.text(2);
    event.what = static_cast<Happened>(std::clamp<std::int64_t>(rows.integer(3), 0, kHappenedTexts.size() - 1));
    event.priority = static_cast<Priority>(std::clamp<std::int64_t>(rows.integer(4), 0, kPriorityTexts.size() - 1));
    event.category = rows.text(5);
    event.text = rows.text(6);
    event.user = rows.text(7);
    event.comment = rows.text(8);
    event.task = rows.text(9);
    if (!rows.is_null(10)) event.scan = static_cast<std::uint64_t>(rows.integer(10));
    if (!rows.is_null(11)) event.value = rows.real(11);
    all.push_back(std::move(event));
  }
  return all;
}

}  // namespace plc::alarms
