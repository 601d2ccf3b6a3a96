#include "historian/history_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "alarms/watch.h"
#include "core/text.h"

namespace plc::historian {
namespace {

constexpr std::int64_t kUs = 1000;  // in ns
constexpr std::int64_t kSecondUs = kSecond / kUs;
constexpr std::int64_t kMinuteUs = 60 * kSecondUs;
constexpr std::int64_t kDayUs = 1440 * kMinuteUs;
/// What is too old is looked for so often.
constexpr std::int64_t kRetainUs = 10 * kMinuteUs;
/// Stretches that summaries are built of again, where the clock was ahead of what comes now: those of a day.
constexpr int kMostAgain = 24 * 60;

/// Rows of a noisy tag have 2 kB: of those of 4 kB half would be empty.
constexpr unsigned kPageBytes = 16'384;

constexpr std::string_view kSchema = R"(
CREATE TABLE IF NOT EXISTS tag (number INTEGER PRIMARY KEY, path TEXT NOT NULL, type INTEGER NOT NULL, UNIQUE (path, type));
CREATE TABLE IF NOT EXISTS stretch (begin INTEGER PRIMARY KEY, times BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS level0 (row INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS level1 (row INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS level2 (row INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS level3 (row INTEGER PRIMARY KEY, data BLOB NOT NULL);
CREATE TABLE IF NOT EXISTS done (level INTEGER PRIMARY KEY, window INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS tail (number INTEGER PRIMARY KEY, times BLOB NOT NULL, data BLOB NOT NULL);
)";

std::span<const std::byte> bytes_of(const std::vector<std::int64_t>& values) {
  return {reinterpret_cast<const std::byte*>(values.data()), values.size() * sizeof(std::int64_t)};
}

/// What a row of the table tail has before its samples, for each tag.
struct TailTag {
  std::int64_t number = 0;
  std::int64_t width = 0;
};

}  // namespace

HistoryFile::HistoryFile(std::string path, std::vector<Tag> tags, std::uint32_t days, std::uint64_t most_bytes)
    : path_(std::move(path)), days_(days), most_bytes_(most_bytes), tags_(std::move(tags)) {
  for (const Tag& tag : tags_) widths_.push_back(alarms::bytes_of(tag.type));
  open_.columns.resize(tags_.size());
  note(open());
}

bool HistoryFile::open() {
  std::string said;
  if (!database_.open(path_, kSchema, said, kPageBytes)) return false;
  if (!said.empty()) said_ = "historian: " + said;
  if (database_.transact([this] { return number_tags() && recover(); })) return true;
  database_.close();
  return false;
}

bool HistoryFile::number_tags() {
  // In any letter case, as programs name it: the course goes on when somebody writes it in another one.
  const auto key = [](std::string_view path, std::int64_t type) { return fmt::format("{} {}", type, path); };
  std::unordered_map<std::string, std::int64_t> exact, folded;
  {
    storage::Statement rows(database_, "SELECT number, path, type FROM tag ORDER BY number");
    while (rows.next()) {
      const std::string path = rows.text(1);
      exact[key(path, rows.integer(2))] = folded[key(core::folded(path), rows.integer(2))] = rows.integer(0);
    }
  }
  storage::Statement insert(database_, "INSERT INTO tag (path, type) VALUES (?1, ?2)");
  for (Tag& tag : tags_) {
    const auto type = static_cast<std::int64_t>(tag.type);
    std::int64_t number = 0;
    if (const auto same = exact.find(key(tag.path, type)); same != exact.end()) {
      number = same->second;
    } else if (const auto alike = folded.find(key(core::folded(tag.path), type)); alike != folded.end()) {
      number = alike->second;
    } else {
      if (!insert.bind(1, tag.path).bind(2, type).run()) return false;
      number = database_.number("SELECT last_insert_rowid()");
    }
    const std::lock_guard lock(mutex_);
    tag.number = number;
  }
  return true;
}

void HistoryFile::add(core::TimeNs utc_ns, const std::function<void(std::size_t, std::byte*)>& read) {
  const std::int64_t us = utc_ns / kUs;
  const bool other_minute = !open_.times.empty() && (us / kMinuteUs != open_.times.back() / kMinuteUs);
  const bool backwards = !open_.times.empty() && us <= open_.times.back();
  if (other_minute || backwards) close_stretch();
  {
    const std::lock_guard lock(mutex_);
    open_.times.push_back(us);
    for (std::size_t i = 0; i < tags_.size(); ++i) {
      std::vector<std::byte>& column = open_.columns[i];
      column.resize(column.size() + widths_[i]);
      read(i, column.data() + column.size() - widths_[i]);
    }
  }
  if (us - tail_us_ < kTailNs / kUs && us >= tail_us_) return;
  tail_us_ = us;
  note(waiting_.empty() ? write_tail() : write_waiting());
}

void HistoryFile::close_stretch() {
  {
    const std::lock_guard lock(mutex_);
    if (open_.times.empty()) return;
    waiting_.push_back(std::exchange(open_, {}));
    open_.columns.resize(tags_.size());
    in_tail_ = 0;
    if (waiting_.size() > kMostWaiting) {
      waiting_.pop_front();
      ++lost_;
    }
  }
  note(write_waiting());
}

bool HistoryFile::write_waiting() {
  if (!database_.is_open() && !open()) return false;
  const bool good = database_.transact([this] {
    for (const Stretch& stretch : waiting_) {
      if (!write_stretch(stretch)) return false;
    }
    if (!database_.run("DELETE FROM tail")) return false;
    if (waiting_.empty()) return true;
    std::int64_t first_us = INT64_MAX;
    for (const Stretch& stretch : waiting_) first_us = std::min(first_us, stretch.times.front());
    return summarize(first_us, waiting_.back().times.back() / kMinuteUs * kMinuteUs);
  });
  if (!good) return false;
  const std::int64_t now_us = waiting_.empty() ? 0 : waiting_.back().times.back();
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
  }
  return now_us == 0 || retain(now_us);
}

bool HistoryFile::write_stretch(const Stretch& stretch) {
  const std::int64_t begin = stretch.times.front() / kSecondUs;
  storage::Statement times(database_, "INSERT OR REPLACE INTO stretch VALUES (?1, ?2)");
  if (!times.bind(1, begin).bind_bytes(2, columns_.pack(bytes_of(stretch.times), 8)).run()) return false;
  storage::Statement row(database_, "INSERT OR REPLACE INTO level0 VALUES (?1, ?2)");
  for (std::size_t i = 0; i < tags_.size(); ++i) {
    if (!row.bind(1, row_number(begin, tags_[i].number))
             .bind_bytes(2, columns_.pack(stretch.columns[i], widths_[i]))
             .run())
      return false;
  }
  return true;
}

bool HistoryFile::write_tail() {
  if (!database_.is_open() && !open()) return false;
  const std::size_t count = open_.times.size();
  if (in_tail_ == count) return true;
  std::vector<std::byte> data;
  const auto append = [&data](const void* from, std::size_t bytes) {
    const auto* const begin = static_cast<const std::byte*>(from);
    data.insert(data.end(), begin, begin + bytes);
  };
  for (std::size_t i = 0; i < tags_.size(); ++i) {
    const TailTag tag{tags_[i].number, widths_[i]};
    append(&tag, sizeof tag);
    append(open_.columns[i].data() + in_tail_ * widths_[i], (count - in_tail_) * widths_[i]);
  }
  const std::vector<std::int64_t> times(open_.times.begin() + static_cast<std::ptrdiff_t>(in_tail_), open_.times.end());
  storage::Statement row(database_, "INSERT INTO tail (times, data) VALUES (?1, ?2)");
  row.bind_bytes(1, columns_.pack(bytes_of(times), 8));
  if (!row.bind_bytes(2, columns_.pack(data, 1)).run()) return false;
  in_tail_ = count;
  return true;
}

/// What a program that was killed had in its tail becomes stretches.
bool HistoryFile::recover() {
  struct Found {
    std::vector<TailTag> tags;
    Stretch stretch;
  };
  std::vector<Found> all;
  storage::Statement rows(database_, "SELECT times, data FROM tail ORDER BY number");
  while (rows.next()) {
    const auto times = columns_.unpack(rows.bytes(0), 8);
    std::vector<std::int64_t> at(times.size() / 8);
    if (at.empty()) continue;
    std::memcpy(at.data(), times.data(), times.size());
    const auto data = columns_.unpack(rows.bytes(1), 1);
    Found found;
    found.stretch.times = at;
    std::size_t place = 0;
    while (place + sizeof(TailTag) <= data.size()) {
      TailTag tag;
      std::memcpy(&tag, &data[place], sizeof tag);
      place += sizeof tag;
      const std::size_t bytes = static_cast<std::size_t>(tag.width) * at.size();
      if (tag.width < 1 || tag.width > 8 || place + bytes > data.size()) break;
      found.tags.push_back(tag);
      found.stretch.columns.emplace_back(data.begin() + static_cast<std::ptrdiff_t>(place),
                                         data.begin() + static_cast<std::ptrdiff_t>(place + bytes));
      place += bytes;
    }
    const bool goes_on = !all.empty() && all.back().tags.size() == found.tags.size() &&
                         all.back().stretch.times.back() / kMinuteUs == at.front() / kMinuteUs;
    if (!goes_on) {
      all.push_back(std::move(found));
      continue;
    }
    Stretch& before = all.back().stretch;
    before.times.insert(before.times.end(), at.begin(), at.end());
    for (std::size_t i = 0; i < before.columns.size(); ++i) {
      const std::vector<std::byte>& more = found.stretch.columns[i];
      before.columns[i].insert(before.columns[i].end(), more.begin(), more.end());
    }
  }
  std::int64_t first_us = INT64_MAX;
  for (const Found& found : all) {
    first_us = std::min(first_us, found.stretch.times.front());
    const std::int64_t begin = found.stretch.times.front() / kSecondUs;
    storage::Statement times(database_, "INSERT OR REPLACE INTO stretch VALUES (?1, ?2)");
    if (!times.bind(1, begin).bind_bytes(2, columns_.pack(bytes_of(found.stretch.times), 8)).run()) return false;
    storage::Statement row(database_, "INSERT OR REPLACE INTO level0 VALUES (?1, ?2)");
    for (std::size_t i = 0; i < found.tags.size(); ++i) {
      const auto width = static_cast<std::uint32_t>(found.tags[i].width);
      row.bind(1, row_number(begin, found.tags[i].number))
          .bind_bytes(2, columns_.pack(found.stretch.columns[i], width));
      if (!row.run()) return false;
    }
  }
  if (!database_.run("DELETE FROM tail")) return false;
  return all.empty() || summarize(first_us, all.back().stretch.times.back() / kMinuteUs * kMinuteUs);
}

bool HistoryFile::is_soon_built_again(std::int64_t from_us) {
  const std::int64_t done_us = database_.number("SELECT window FROM done WHERE level = 1") * (window_ns(1) / kUs);
  if (from_us >= done_us) return true;
  storage::Statement count(database_,
                           "SELECT count(*) FROM (SELECT 1 FROM stretch WHERE begin >= ?1 AND begin < ?2 LIMIT ?3)");
  count.bind(1, from_us / kSecondUs).bind(2, done_us / kSecondUs).bind(3, std::int64_t{kMostAgain + 1});
  return count.next() && count.integer(0) <= kMostAgain;
}

bool HistoryFile::summarize(std::int64_t from_us, std::int64_t until_us) {
  // WHY not always: a clock that begins in 1970 at each start of the machine would have all of them built again.
  const bool again = is_soon_built_again(from_us);
  for (int level = 1; level < kLevels; ++level) {
    const std::int64_t window_us = window_ns(level) / kUs;
    const std::int64_t end = until_us / window_us;
    // The first window with anything in it, from the one on that comes next.
    storage::Statement done(database_, "SELECT window FROM done WHERE level = ?1");
    std::int64_t next = done.bind(1, std::int64_t{level}).next() ? done.integer(0) : 0;
    done.reset();
    const std::int64_t was = next;
    // The clock was ahead: what comes now was taken for done.
    if (again) next = std::min(next, from_us / window_us);
    while (next < end) {
      storage::Statement first(database_, level == 1
                                              ? std::string("SELECT min(begin) FROM stretch WHERE begin >= ?1")
                                              : fmt::format("SELECT min(row) FROM level{} WHERE row >= ?1", level - 1));
      const std::int64_t child_us = window_ns(level - 1) / kUs;
      first.bind(1, level == 1 ? next * window_us / kSecondUs : row_number(next * window_us / child_us, 0));
      if (!first.next() || first.is_null(0)) break;
      const std::int64_t begin_us = level == 1 ? first.integer(0) * kSecondUs : (first.integer(0) >> 20) * child_us;
      first.reset();
      next = std::max(next, begin_us / window_us);
      if (next >= end) break;
      if (!build(level, next)) return false;
      ++next;
    }
    if (std::max(next, end) == was) continue;
    storage::Statement keep(database_, "INSERT OR REPLACE INTO done VALUES (?1, ?2)");
    if (!keep.bind(1, std::int64_t{level}).bind(2, std::max(next, end)).run()) return false;
  }
  return true;
}

bool HistoryFile::build(int level, std::int64_t window) {
  const std::int64_t begin_us = window * (window_ns(level) / kUs), end_us = begin_us + window_ns(level) / kUs;
  const std::int64_t entry_us = kEntryNs[static_cast<std::size_t>(level)] / kUs;
  std::vector<std::array<Summary, kEntries>> all(tags_.size());
  const auto entry = [&](std::int64_t us) { return static_cast<std::size_t>((us - begin_us) / entry_us); };
  const auto read = [&](storage::Statement& row, std::int64_t time, std::size_t tag) {
    const bool there = row.bind(1, row_number(time, tags_[tag].number)).next();
    const auto data = there ? columns_.unpack(row.bytes(0), level == 1 ? widths_[tag] : sizeof(Summary))
                            : std::span<const std::byte>();
    row.reset();
    return data;
  };
  storage::Statement row(database_, fmt::format("SELECT data FROM level{} WHERE row = ?1", level - 1));
  if (level == 1) {
    storage::Statement stretches(database_, "SELECT begin, times FROM stretch WHERE begin >= ?1 AND begin < ?2");
    stretches.bind(1, begin_us / kSecondUs).bind(2, end_us / kSecondUs);
    while (stretches.next()) {
      const auto packed = columns_.unpack(stretches.bytes(1), 8);
      std::vector<std::int64_t> times(packed.size() / 8);
      std::memcpy(times.data(), packed.data(), packed.size());
      for (std::size_t tag = 0; tag < tags_.size(); ++tag) {
        const auto data = read(row, stretches.integer(0), tag);
        for (std::size_t i = 0; i < times.size() && (i + 1) * widths_[tag] <= data.size(); ++i) {
          if (times[i] < begin_us || times[i] >= end_us) continue;
          all[tag][entry(times[i])].add(alarms::number_at(&data[i * widths_[tag]], tags_[tag].type));
        }
      }
    }
  } else {
    const std::int64_t child_us = window_ns(level - 1) / kUs;
    const std::int64_t child_entry_us = kEntryNs[static_cast<std::size_t>(level - 1)] / kUs;
    for (std::int64_t child = begin_us / child_us; child < end_us / child_us; ++child) {
      for (std::size_t tag = 0; tag < tags_.size(); ++tag) {
        const auto data = read(row, child, tag);
        for (std::size_t i = 0; (i + 1) * sizeof(Summary) <= data.size(); ++i) {
          Summary one;
          std::memcpy(&one, &data[i * sizeof one], sizeof one);
          const std::int64_t us = child * child_us + static_cast<std::int64_t>(i) * child_entry_us;
          if (!one.empty()) all[tag][entry(us)].add(one);
        }
      }
    }
  }
  storage::Statement insert(database_, fmt::format("INSERT OR REPLACE INTO level{} VALUES (?1, ?2)", level));
  for (std::size_t tag = 0; tag < tags_.size(); ++tag) {
    const std::span<const Summary> entries(all[tag]);
    if (std::all_of(entries.begin(), entries.end(), [](const Summary& one) { return one.empty(); })) continue;
    insert.bind(1, row_number(window, tags_[tag].number))
        .bind_bytes(2, columns_.pack(std::as_bytes(entries), sizeof(Summary)));
    if (!insert.run()) return false;
  }
  return true;
}

std::int64_t HistoryFile::oldest_us() {
  const std::int64_t stretch = database_.number("SELECT min(begin) FROM stretch");
  std::int64_t oldest = stretch == 0 ? INT64_MAX : stretch * kSecondUs;
  for (int level = 1; level < kLevels; ++level) {
    const std::int64_t row = database_.number(fmt::format("SELECT min(row) FROM level{}", level));
    if (row != 0) oldest = std::min(oldest, ((row >> 20) + 1) * (window_ns(level) / kUs));
  }
  return oldest == INT64_MAX ? 0 : oldest;
}

bool HistoryFile::retain(std::int64_t now_us) {
  if (now_us - retained_us_ < kRetainUs && now_us >= retained_us_) return true;
  retained_us_ = now_us;
  const auto drop_before = [this](std::int64_t us, int levels) {
    storage::Statement stretch(database_, "DELETE FROM stretch WHERE begin < ?1");
    if (!stretch.bind(1, us / kSecondUs).run()) return false;
    for (int level = 0; level < levels; ++level) {
      storage::Statement rows(database_, fmt::format("DELETE FROM level{} WHERE row < ?1", level));
      const std::int64_t time = level == 0 ? us / kSecondUs : us / (window_ns(level) / kUs);
      if (!rows.bind(1, row_number(time, 0)).run()) return false;
    }
    return true;
  };
  // WHY a day at most: a clock that is ahead for a moment must not take everything.
  const std::int64_t limit_us = std::min(now_us - days_ * kDayUs, oldest_us() + kDayUs);
  if (!database_.transact([&] { return drop_before(limit_us, kLevels); })) return false;
  // WHY an hour after the other: what is too much by size goes as it came.
  while (database_.used_bytes() > most_bytes_) {
    const std::int64_t oldest = database_.number("SELECT min(begin) FROM stretch") * kSecondUs;
    const std::int64_t oldest_summary = (database_.number("SELECT min(row) FROM level1") >> 20) * (window_ns(1) / kUs);
    const bool samples = oldest != 0 && oldest < now_us - 60 * kMinuteUs;
    if (!samples && (oldest_summary == 0 || oldest_summary > now_us - 60 * kMinuteUs)) break;
    // Samples first, as long as there is more than a day of them: summaries take little.
    const bool both = !samples || now_us - oldest < kDayUs;
    const std::int64_t until =
        both ? std::min(samples ? oldest : now_us, oldest_summary == 0 ? now_us : oldest_summary) : oldest;
    if (!database_.transact([&] { return drop_before(until + 60 * kMinuteUs, both ? 2 : 1); })) return false;
  }
  return true;
}

void HistoryFile::flush() { close_stretch(); }

void HistoryFile::newest(std::string_view path, std::vector<std::pair<std::int64_t, double>>& to) const {
  const std::lock_guard lock(mutex_);
  const auto tag =
      std::find_if(tags_.begin(), tags_.end(), [&](const Tag& one) { return core::iequals(one.path, path); });
  if (tag == tags_.end()) return;
  const auto i = static_cast<std::size_t>(tag - tags_.begin());
  const auto append = [&](const Stretch& stretch) {
    for (std::size_t k = 0; k < stretch.times.size() && (k + 1) * widths_[i] <= stretch.columns[i].size(); ++k)
      to.emplace_back(stretch.times[k], alarms::number_at(&stretch.columns[i][k * widths_[i]], tag->type));
  };
  for (const Stretch& stretch : waiting_) append(stretch);
  append(open_);
}

void HistoryFile::note(bool good) {
  if (good == !in_trouble_) return;
  in_trouble_ = !good;
  said_ =
      good ? fmt::format("historian: {} is written again; {} minutes are missing", path_, lost_)
           : fmt::format("historian: {} cannot be written: {}; it goes on when there is room", path_, database_.why());
}

}  // namespace plc::historian
