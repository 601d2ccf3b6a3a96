// Summary: least, greatest and mean of what lies in a stretch of time; and the levels of them that are kept, so that
// any zoom reads few of them.
//
// In: samples, finer summaries. Out: coarser ones. Does not belong here: where they lie (history_file.h).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/clock.h"

namespace plc::historian {

struct Summary {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  double sum = 0;
  double count = 0;  ///< a number so that all have one width

  void add(double value) {
    if (std::isnan(value)) return;
    least = std::min(least, value);
    greatest = std::max(greatest, value);
    sum += value;
    count += 1;
  }
  void add(const Summary& other) {
    least = std::min(least, other.least);
    greatest = std::max(greatest, other.greatest);
    sum += other.sum;
    count += other.count;
  }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] double mean() const { return sum / count; }
};

inline constexpr core::TimeNs kSecond = 1'000'000'000;
/// Samples lie in stretches that end with the minute.
inline constexpr core::TimeNs kStretchNs = 60 * kSecond;
/// Summaries of one row.
inline constexpr int kEntries = 60;
/// Time that one summary of a level covers; level 0 are the samples.
inline constexpr std::array<core::TimeNs, 4> kEntryNs = {0, 10 * kSecond, 300 * kSecond, 9000 * kSecond};
inline constexpr int kLevels = 4;
/// Time that one row of a level covers.
constexpr core::TimeNs window_ns(int level) {
  return level == 0 ? kStretchNs : kEntryNs[static_cast<std::size_t>(level)] * kEntries;
}
/// Which of them `utc_ns` lies in; times before 1970 do not come.
constexpr std::int64_t window_of(int level, core::TimeNs utc_ns) { return utc_ns / window_ns(level); }

}  // namespace plc::historian
