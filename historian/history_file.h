// HistoryFile: samples of many tags in a database, with summaries of them, so that any stretch of time is read by few
// rows.
//
// A stretch is what was sampled within one minute: one row of times, and a row for each tag. Rows of summaries follow
// when their time is over, from the level below, in the same transaction. Samples of the last seconds are in a table of
// their own at once, from which the next start makes a stretch: a program that is killed loses those of some seconds.
// In: samples, in the order of time. Out: a file. Threads: one. Does not belong here: when to sample (historian.h),
// reading (history_reader.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "core/types.h"
#include "historian/column.h"
#include "historian/summary.h"
#include "storage/database.h"

namespace plc::historian {

struct Tag {
  std::string path;
  core::TypeId type = core::TypeId::kBool;
  std::int64_t number = 0;  ///< in the file, from 1 on
};

/// Samples that are in no row yet.
struct Stretch {
  std::vector<std::int64_t> times;              ///< UTC, us
  std::vector<std::vector<std::byte>> columns;  ///< by tag, in its own type
};

/// Number of a row: those of one time lie together, so that rows are appended and the oldest go at once.
constexpr std::int64_t row_number(std::int64_t time, std::int64_t tag) { return (time << 20) | tag; }
inline constexpr std::int64_t kMostTags = 1'000'000;

class HistoryFile {
 public:
  static constexpr core::TimeNs kTailNs = 5 * kSecond;
  /// Stretches that wait for a disk that refuses; of more the oldest are lost.
  static constexpr std::size_t kMostWaiting = 10;

  HistoryFile(std::string path, std::vector<Tag> tags, std::uint32_t days, std::uint64_t most_bytes);

  /// A sample of all tags: `read(i, to)` gives the bytes of the i-th one. A time before the last one begins anew.
  void add(core::TimeNs utc_ns, const std::function<void(std::size_t, std::byte*)>& read);
  /// Writes what there is.
  void flush();
  /// What has gone wrong since the last call, or goes on again; empty: nothing.
  std::string take_said() { return std::exchange(said_, {}); }

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Samples of `tag` that are in no row yet, to whoever reads: any thread.
  void newest(std::string_view path, std::vector<std::pair<std::int64_t, double>>& to) const;
  [[nodiscard]] const std::vector<Tag>& tags() const { return tags_; }
  [[nodiscard]] std::uint64_t lost_stretches() const { return lost_; }

 private:
  bool open();
  bool number_tags();
  bool recover();
  void close_stretch();
  bool write_waiting();
  bool write_stretch(const Stretch& stretch);
  bool write_tail();
  /// Builds all rows of summaries whose time is over at `until_us`; those from `from_us` on, of the earliest stretch
  /// that is new, also where the clock had been later already.
  bool summarize(std::int64_t from_us, std::int64_t until_us);
  /// Whether rows from then on may be built again: there are few.
  bool is_soon_built_again(std::int64_t from_us);
  bool build(int level, std::int64_t window);
  /// The first stretch, or the end of the first row of summaries when that is earlier; 0 without any.
  std::int64_t oldest_us();
  bool retain(std::int64_t now_us);
  void note(bool good);

  const std::string path_;
  const std::uint32_t days_;
  const std::uint64_t most_bytes_;
  std::vector<Tag> tags_;
  std::vector<std::uint32_t> widths_;
  storage::Database database_;
  Columns columns_;
  mutable std::mutex mutex_;  ///< of the samples
  Stretch open_;
  std::deque<Stretch> waiting_;
  std::size_t in_tail_ = 0;  ///< samples of open_
  std::int64_t tail_us_ = 0, retained_us_ = 0;
  std::uint64_t lost_ = 0;
  bool in_trouble_ = false;
  std::string said_;
};

}  // namespace plc::historian
