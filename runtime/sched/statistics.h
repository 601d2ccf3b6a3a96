// Statistics of a task: scan time and release jitter in preallocated log-scale histograms, counters of what went wrong.
//
// In: one record() per scan from the task's thread. Out: min, max, mean and percentiles for any thread (relaxed
// atomics). Resolution: 16 steps per octave, so that a percentile is right to about 3 %; minimum and maximum are exact.
// Does not belong here: printing, clocks.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace plc::runtime {

class Histogram {
 public:
  /// One value in ns; negative ones count as 0. RT: one writer.
  void record(std::int64_t value_ns) noexcept;
  [[nodiscard]] std::uint64_t count() const noexcept { return count_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::int64_t min_ns() const noexcept;
  [[nodiscard]] std::int64_t max_ns() const noexcept { return max_.load(std::memory_order_relaxed); }
  [[nodiscard]] double mean_ns() const noexcept;
  /// The value that a share `p` (0..1) of all values does not exceed; 0 without values.
  [[nodiscard]] std::int64_t percentile_ns(double p) const noexcept;
  void clear() noexcept;

 private:
  static constexpr unsigned kStepBits = 4;
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
  Histogram scan_time;  ///< from the task's wake-up to the end of its scan
  Histogram jitter;     ///< from the release instant to the wake-up
  std::atomic<std::uint64_t> scans{0};
  std::atomic<std::uint64_t> overruns{0};  ///< scans that ended after the next release instant
  std::atomic<std::uint64_t> missed{0};    ///< release instants that passed without a scan
  std::atomic<std::uint64_t> faults{0};
  void clear() noexcept;
};

}  // namespace plc::runtime
