#include "core/clock.h"

#include <ctime>

namespace plc::core {
namespace {
constexpr std::int64_t kNsPerSecond = 1'000'000'000;
}

TimeNs MonotonicClock::now_ns() const noexcept {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<TimeNs>(t.tv_sec) * kNsPerSecond + t.tv_nsec;
}

void MonotonicClock::sleep_until_ns(TimeNs deadline_ns) noexcept {
  timespec t{};
  t.tv_sec = static_cast<time_t>(deadline_ns / kNsPerSecond);
  t.tv_nsec = static_cast<long>(deadline_ns % kNsPerSecond);
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}

}  // namespace plc::core
