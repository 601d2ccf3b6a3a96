#include "alarms/alarm_state.h"

#include <utility>

namespace plc::alarms {

State AlarmState::state() const {
  if (out_of_service_) return State::kOutOfService;
  if (suppressed_) return State::kSuppressed;
  if (shelved_until_) return State::kShelved;
  if (raised_) return unacked_ ? State::kUnackedActive : State::kAckedActive;
  return unacked_ ? State::kUnackedReturned : State::kNormal;
}

Happened AlarmState::condition(bool is, bool latch) {
  active_ = is;
  if (is_hidden()) return Happened::kNothing;
  if (is) {
    // A latched one that comes again is to be seen again.
    const bool again = raised_ && unacked_;
    raised_ = unacked_ = true;
    return again ? Happened::kNothing : Happened::kRaised;
  }
  if (!raised_ || (latch && unacked_)) return Happened::kNothing;
  raised_ = false;
  return Happened::kReturned;
}

Happened AlarmState::acknowledge() {
  if (!is_unacked()) return Happened::kNothing;
  unacked_ = false;
  const bool latched = raised_ && !active_;
  if (latched) raised_ = false;
  return latched ? Happened::kReturned : Happened::kAcknowledged;
}

Happened AlarmState::take_shown() {
  if (!std::exchange(fresh_, false)) return Happened::kNothing;
  raised_ = unacked_ = true;
  return Happened::kRaised;
}

std::int64_t AlarmState::packed() const {
  return (active_ ? kPackedActive : 0) | (raised_ ? 2 : 0) | (unacked_ ? 4 : 0) | (out_of_service_ ? 8 : 0);
}

void AlarmState::unpack(std::int64_t packed, std::optional<core::TimeNs> shelved_until_ns) {
  active_ = (packed & kPackedActive) != 0;
  raised_ = (packed & 2) != 0;
  unacked_ = (packed & 4) != 0;
  out_of_service_ = (packed & 8) != 0;
  shelved_until_ = shelved_until_ns;
}

}  // namespace plc::alarms
