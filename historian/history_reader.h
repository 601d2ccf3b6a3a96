// HistoryReader: the course of a tag over any time, in as many points as one wants, from few rows.
//
// In: the file of a historian that runs. Out: points. Threads: one at a time. Does not belong here: writing.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/types.h"
#include "historian/column.h"
#include "historian/history_file.h"
#include "historian/summary.h"
#include "storage/database.h"

namespace plc::historian {

/// A stretch of time in which something was sampled.
struct Point {
  std::int64_t us = 0;  ///< UTC, its begin
  Summary summary;
};

struct Course {
  std::vector<Point> points;  ///< rising times; stretches without samples are not there
  core::TimeNs step_ns = 0;   ///< time that one covers; 0: each point is a sample
};

class HistoryReader {
 public:
  static constexpr std::size_t kMostPoints = 5000;

  explicit HistoryReader(const HistoryFile& file) : file_(file) {}

  /// At most `points` points from `from_ns` to `to_ns`, UTC; fewer than that many samples come as they are. Nothing for
  /// a tag that the file does not know.
  std::optional<Course> read(std::string_view path, core::TimeNs from_ns, core::TimeNs to_ns, std::size_t points);
  /// The first sample or summary that is kept, of all tags, UTC; 0 without one.
  core::TimeNs begin_ns();

 private:
  class Collector;
  void collect(int level, std::int64_t from_us, std::int64_t to_us, Collector& to);
  void collect_samples(std::int64_t from_us, std::int64_t to_us, Collector& to);
  /// Rows of a level are there up to this time.
  std::int64_t done_us(int level);
  bool open();

  const HistoryFile& file_;
  std::mutex mutex_;
  storage::Database database_;
  Columns columns_;
};

}  // namespace plc::historian
