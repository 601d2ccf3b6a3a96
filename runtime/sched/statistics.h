// Statistics of a task: its times in preallocated log-scale histograms, counters of what went wrong.
//
// In: one record() per scan and time from the task's thread. Out: minimum, maximum, mean, percentiles and the histogram
// itself for any thread at any time (atomics, no lock: a reader never holds up the task). Resolution: 64 steps per
// octave, so that a percentile is at most 1.6 % above the exact one and never below; minimum and maximum are exact.
// Does not belong here: printing, clocks.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace plc::runtime {

class Histogram {
 public:
  /// Values of one step.
  struct Bucket {
    std::int64_t upper_ns = 0;  ///< the greatest value of the step
    std::uint64_t count = 0;
  };

  /// One value in ns; negative ones count as 0. RT: one writer.
  void record(std::int64_t value_ns) noexcept;
  /// A reader that has seen a count sees what those records left in everything else.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_acquire); }
  [[nodiscard]] std::int64_t min_ns() const noexcept;
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_.load(std::memory_order_relaxed); }
  [[nodiscard]] double mean_ns() const noexcept;
  /// The value that a share `p` (0..1) of all values does not exceed; 0 without values.
  [[nodiscard]] std::int64_t percentile_ns(double p) const noexcept;
  /// The steps that have values, ascending. Allocates.
  [[nodiscard]] std::vector<Bucket> buckets() const;
  void clear() noexcept;

 private:
  static constexpr unsigned kStepBits = 6;
  static constexpr std::size_t kBuckets = (64 - kStepBits) << kStepBits;
  static std::size_t bucket_of(std::uint64_t value) noexcept;
  static std::uint64_t upper_of(std::size_t bucket) noexcept;
  std::array<std::atomic<std::uint64_t>, kBuckets> buckets_{};
  std::atomic<std::uint64_t> count_{0};
  std::atomic<std::uint64_t> sum_{0};
  std::atomic<std::int64_t> min_{INT64_MAX};
  std::atomic<std::int64_t> max_{0};
};

struct TaskStatistics {
  Histogram latency;    ///< release latency: from the release instant to the task's wake-up
  Histogram scan_time;  ///< from the wake-up to the end of the scan, with all that interrupts it
  Histogram response;   ///< from the release instant to the end of the scan: the sum of both
  std::atomic<std::uint64_t> scans{0};
  std::atomic<std::uint64_t> overruns{0};  ///< scans that ended after the next release instant
  std::atomic<std::uint64_t> missed{0};    ///< release instants that passed without a scan
  std::atomic<std::uint64_t> faults{0};
  void clear() noexcept;
};

}  // namespace plc::runtime
