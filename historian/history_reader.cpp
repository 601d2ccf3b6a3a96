#include "historian/history_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "alarms/watch.h"
#include "core/text.h"

namespace plc::historian {
namespace {

constexpr std::int64_t kUs = 1000;
constexpr std::int64_t kSecondUs = kSecond / kUs;

}  // namespace

/// Takes what comes, mostly in the order of time, into stretches of one width.
class HistoryReader::Collector {
 public:
  Collector(std::int64_t tag, core::TypeId of_type, std::int64_t from_us, std::int64_t to_us, std::size_t points)
      : number(tag),
        type(of_type),
        width(alarms::bytes_of(of_type)),
        from_us_(from_us),
        to_us_(to_us),
        step_us_((to_us - from_us + static_cast<std::int64_t>(points)) / static_cast<std::int64_t>(points)),
        most_(points) {}

  void add(std::int64_t us, const Summary& one) {
    exact_ = false;
    put(us, one);
  }
  void add(std::int64_t us, double value) {
    if (us < from_us_ || us > to_us_) return;
    Summary one;
    one.add(value);
    if (one.empty()) return;
    if (exact_ && samples_.size() < most_)
      samples_.push_back({us, one});
    else
      exact_ = false;
    put(us, one);
  }
  Course take() {
    const auto is_before = [](const Point& one, const Point& other) { return one.us < other.us; };
    if (exact_) {
      std::stable_sort(samples_.begin(), samples_.end(), is_before);
      return {std::move(samples_), 0};
    }
    return {std::move(points_), step_us_ * kUs};
  }
  [[nodiscard]] std::int64_t step_us() const { return step_us_; }

  const std::int64_t number;
  const core::TypeId type;
  const std::uint32_t width;

 private:
  void put(std::int64_t us, const Summary& one) {
    if (us < from_us_ - step_us_ || us > to_us_ || one.empty()) return;
    const std::int64_t at = from_us_ + std::max<std::int64_t>(0, us - from_us_) / step_us_ * step_us_;
    if (points_.empty() || points_.back().us < at) points_.push_back({at, {}});
    if (points_.back().us == at) return points_.back().summary.add(one);
    // The clock was set back: what comes now lies before what came then.
    auto place = std::lower_bound(points_.begin(), points_.end(), at,
                                  [](const Point& point, std::int64_t time) { return point.us < time; });
    if (place->us != at) place = points_.insert(place, {at, {}});
    place->summary.add(one);
  }

  std::int64_t from_us_, to_us_, step_us_;
  std::size_t most_;
  bool exact_ = true;
  std::vector<Point> samples_, points_;
};

bool HistoryReader::open() { return database_.is_open() || database_.open_to_read(file_.path()); }

std::int64_t HistoryReader::done_us(int level) {
  return database_.number(fmt::format("SELECT window FROM done WHERE level = {}", level)) * (window_ns(level) / kUs);
}

core::TimeNs HistoryReader::begin_ns() {
  const std::lock_guard lock(mutex_);
  if (!open()) return 0;
  std::int64_t begin = 0;
  const auto offer = [&](std::int64_t us) {
    if (us != 0 && (begin == 0 || us < begin)) begin = us;
  };
  offer(database_.number("SELECT min(begin) FROM stretch") * kSecondUs);
  for (int level = 1; level < kLevels; ++level) {
    offer((database_.number(fmt::format("SELECT min(row) FROM level{}", level)) >> 20) * (window_ns(level) / kUs));
  }
  return begin * kUs;
}

std::optional<Course> HistoryReader::read(std::string_view path, core::TimeNs from_ns, core::TimeNs to_ns,
                                          std::size_t points) {
  const std::lock_guard lock(mutex_);
  const std::int64_t from_us = from_ns / kUs, to_us = std::max(to_ns, from_ns) / kUs;
  points = std::clamp<std::size_t>(points, 1, kMostPoints);
  std::optional<Collector> collector;
  const auto& tags = file_.tags();
  const auto now =
      std::find_if(tags.begin(), tags.end(), [&](const Tag& tag) { return core::iequals(tag.path, path); });
  if (open()) {
    const auto type = now != tags.end() ? static_cast<std::int64_t>(now->type) : std::int64_t{-1};
    const std::string_view name = now != tags.end() ? std::string_view(now->path) : path;
    for (const char* const alike : {"", " COLLATE NOCASE"}) {
      storage::Statement tag(database_, fmt::format("SELECT number, type FROM tag WHERE path = ?1{} AND "
                                                    "(type = ?2 OR ?2 < 0) ORDER BY number DESC LIMIT 1",
                                                    alike));
      if (!tag.bind(1, name).bind(2, type).next()) continue;
      if (tag.integer(1) >= 0 && tag.integer(1) < static_cast<std::int64_t>(core::TypeId::kPointer))
        collector.emplace(tag.integer(0), static_cast<core::TypeId>(tag.integer(1)), from_us, to_us, points);
      break;
    }
  }
  if (!collector && now == tags.end()) return std::nullopt;
  if (!collector) collector.emplace(0, now->type, from_us, to_us, points);
  // Taken first: what becomes a row meanwhile would be missing else. Samples that come twice count once.
  std::vector<std::pair<std::int64_t, double>> newest;
  file_.newest(path, newest);
  const std::int64_t newest_us = newest.empty() ? INT64_MAX : newest.front().first;
  int level = 0;
  while (level + 1 < kLevels && kEntryNs[static_cast<std::size_t>(level + 1)] / kUs <= collector->step_us()) ++level;
  if (database_.is_open()) collect(level, from_us, std::min(to_us, newest_us - 1), *collector);
  for (const auto& [us, value] : newest) collector->add(us, value);
  return collector->take();
}

void HistoryReader::collect(int level, std::int64_t from_us, std::int64_t to_us, Collector& to) {
  if (from_us > to_us) return;
  if (level == 0) return collect_samples(from_us, to_us, to);
  const std::int64_t done = std::min(to_us + 1, done_us(level));
  const std::int64_t window_us = window_ns(level) / kUs, entry_us = kEntryNs[static_cast<std::size_t>(level)] / kUs;
  storage::Statement row(database_, fmt::format("SELECT data FROM level{} WHERE row = ?1", level));
  // Times in which nothing ran are not looked through.
  storage::Statement next(database_,
                          fmt::format("SELECT row FROM level{} WHERE row >= ?1 ORDER BY row LIMIT 1", level));
  for (std::int64_t window = from_us / window_us; window * window_us < done; ++window) {
    const bool there = row.bind(1, row_number(window, to.number)).next();
    const auto data = there ? columns_.unpack(row.bytes(0), sizeof(Summary)) : std::span<const std::byte>();
    row.reset();
    for (std::size_t i = 0; (i + 1) * sizeof(Summary) <= data.size(); ++i) {
      Summary one;
      std::memcpy(&one, &data[i * sizeof one], sizeof one);
      const std::int64_t us = window * window_us + static_cast<std::int64_t>(i) * entry_us;
      if (us + entry_us > from_us && us < done) to.add(us, one);
    }
    if (there) continue;
    const bool more = next.bind(1, row_number(window + 1, 0)).next();
    const std::int64_t found = more ? next.integer(0) >> 20 : done / window_us + 1;
    next.reset();
    window = std::max(window, found - 1);
  }
  collect(level - 1, std::max(from_us, done), to_us, to);
}

void HistoryReader::collect_samples(std::int64_t from_us, std::int64_t to_us, Collector& to) {
  storage::Statement stretches(database_, "SELECT begin, times FROM stretch WHERE begin >= ?1 AND begin <= ?2");
  storage::Statement row(database_, "SELECT data FROM level0 WHERE row = ?1");
  stretches.bind(1, from_us / kSecondUs - 60).bind(2, to_us / kSecondUs);
  std::vector<std::int64_t> times;
  while (stretches.next()) {
    const auto packed = columns_.unpack(stretches.bytes(1), 8);
    times.resize(packed.size() / 8);
    std::memcpy(times.data(), packed.data(), packed.size());
    if (times.empty() || times.back() < from_us) continue;
    const bool there = row.bind(1, row_number(stretches.integer(0), to.number)).next();
    const auto data = there ? columns_.unpack(row.bytes(0), to.width) : std::span<const std::byte>();
    for (std::size_t i = 0; i < times.size() && (i + 1) * to.width <= data.size(); ++i) {
      if (times[i] > to_us) break;
      to.add(times[i], alarms::number_at(&data[i * to.width], to.type));
    }
    row.reset();
  }
}

}  // namespace plc::historian
