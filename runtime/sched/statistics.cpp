#include "runtime/sched/statistics.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace plc::runtime {

// Buckets: values below 64 exactly, then 64 per octave.
std::size_t Histogram::bucket_of(std::uint64_t value) noexcept {
  constexpr std::uint64_t kExact = std::uint64_t{1} << kStepBits;
  if (value < kExact) return static_cast<std::size_t>(value);
  const auto octave = static_cast<unsigned>(std::bit_width(value)) - 1 - kStepBits;
  return (std::size_t{octave} << kStepBits) + static_cast<std::size_t>(value >> octave);
}

std::uint64_t Histogram::upper_of(std::size_t bucket) noexcept {
  constexpr std::size_t kExact = std::size_t{1} << kStepBits;
  if (bucket < 2 * kExact) return bucket;
  const auto octave = static_cast<unsigned>(bucket >> kStepBits) - 1;
  const std::uint64_t step = (bucket & (kExact - 1)) + kExact;
  return ((step + 1) << octave) - 1;
}

// RT:
void Histogram::record(std::int64_t value_ns) noexcept {
  const std::int64_t value = std::max<std::int64_t>(value_ns, 0);
  // One writer: load and store instead of a locked addition.
  const auto bump = [](std::atomic<std::uint64_t>& counter, std::uint64_t by) {
    counter.store(counter.load(std::memory_order_relaxed) + by, std::memory_order_relaxed);
  };
  bump(buckets_[bucket_of(static_cast<std::uint64_t>(value))], 1);
  bump(sum_, static_cast<std::uint64_t>(value));
  if (value < min_.load(std::memory_order_relaxed)) min_.store(value, std::memory_order_relaxed);
  if (value > max_.load(std::memory_order_relaxed)) max_.store(value, std::memory_order_relaxed);
  // Release: a thread that sees the count sees the rest.
  count_.store(count_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
}

std::int64_t Histogram::min_ns() const noexcept { return count() == 0 ? 0 : min_.load(std::memory_order_relaxed); }

double Histogram::mean_ns() const noexcept {
  const std::uint64_t n = count();
  return n == 0 ? 0.0 : static_cast<double>(sum_.load(std::memory_order_relaxed)) / static_cast<double>(n);
}

std::int64_t Histogram::percentile_ns(double p) const noexcept {
  const std::uint64_t n = count();
  if (n == 0) return 0;
  const auto wanted =
      std::clamp<std::uint64_t>(static_cast<std::uint64_t>(std::ceil(p * static_cast<double>(n))), 1, n);
  std::uint64_t seen = 0;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    seen += buckets_[bucket].load(std::memory_order_relaxed);
    if (seen >= wanted) {
      return std::clamp(static_cast<std::int64_t>(upper_of(bucket)), min_ns(), max_ns());
    }
  }
  return max_ns();
}

std::vector<Histogram::Bucket> Histogram::buckets() const {
  std::vector<Bucket> found;
  for (std::size_t bucket = 0; bucket < kBuckets; ++bucket) {
    const std::uint64_t count = buckets_[bucket].load(std::memory_order_relaxed);
    if (count != 0) found.push_back({static_cast<std::int64_t>(upper_of(bucket)), count});
  }
  return found;
}

void Histogram::clear() noexcept {
  for (auto& bucket : buckets_) bucket.store(0, std::memory_order_relaxed);
  count_.store(0, std::memory_order_relaxed);
  sum_.store(0, std::memory_order_relaxed);
  min_.store(INT64_MAX, std::memory_order_relaxed);
  max_.store(0, std::memory_order_relaxed);
}

void TaskStatistics::clear() noexcept {
  latency.clear();
  scan_time.clear();
  response.clear();
  for (auto* counter : {&scans, &overruns, &missed, &faults}) counter->store(0, std::memory_order_relaxed);
}

}  // namespace plc::runtime
