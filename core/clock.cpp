#include "core/clock.h"

#include <ctime>

namespace plc::core {
namespace {
constexpr std::int64_t kNsPerSecond = 1'000'000'000;

TimeNs read(clockid_t clock) noexcept {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<TimeNs>(t.tv_sec) * kNsPerSecond + t.tv_nsec;
}
}  // namespace

TimeNs MonotonicClock::now_ns() const noexcept { return read(CLOCK_MONOTONIC); }

TimeNs SystemCalendar::utc_ns() const noexcept { return read(CLOCK_REALTIME); }

void MonotonicClock::sleep_until_ns(TimeNs deadline_ns) noexcept {
  timespec t{};
  t.tv_sec = static_cast<time_t>(deadline_ns / kNsPerSecond);
  t.tv_nsec = static_cast<long>(deadline_ns % kNsPerSecond);
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr);
}

}  // namespace plc::core
