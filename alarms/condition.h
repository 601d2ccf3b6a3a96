// Condition: whether what an alarm watches is the case, with hysteresis and delays.
//
// In: values with the time of their scan. Out: when it begins and ends. Threads: one at a time. Does not belong here:
// who acknowledges (alarm_state.h), where values come from.
#pragma once

#include <cmath>
#include <optional>

#include "alarms/definition.h"

namespace plc::alarms {

class Condition {
 public:
  /// Whether the comparison holds for `value`, when it held before or not. What is no number changes nothing.
  static bool holds(const Definition& alarm, double value, bool before) {
    if (std::isnan(value)) return before;
    switch (alarm.comparison) {
      case Comparison::kTrue:
        return value != 0;
      case Comparison::kFalse:
        return value == 0;
      case Comparison::kAbove:
        return before ? value > alarm.limit - alarm.hysteresis : value > alarm.limit;
      case Comparison::kBelow:
        return before ? value < alarm.limit + alarm.hysteresis : value < alarm.limit;
      case Comparison::kEqual:
        return value == alarm.limit;
      case Comparison::kUnequal:
        return value != alarm.limit;
    }
    return before;
  }

  /// The value after the scan of `now_ns`. True when is() has changed.
  bool update(const Definition& alarm, double value, core::TimeNs now_ns) {
    value_ = value;
    const bool holds_now = holds(alarm, value, holds_);
    if (holds_now != holds_) since_ns_ = now_ns;
    holds_ = holds_now;
    return pass(alarm, now_ns);
  }
  /// Time goes on while the value stays. True when is() has changed.
  bool pass(const Definition& alarm, core::TimeNs now_ns) {
    if (holds_ == is_ || now_ns - since_ns_ < (holds_ ? alarm.on_delay_ns : alarm.off_delay_ns)) return false;
    is_ = holds_;
    return true;
  }
  /// A delay runs.
  [[nodiscard]] bool waits() const { return holds_ != is_; }
  /// It is the case, after the delays.
  [[nodiscard]] bool is() const { return is_; }
  [[nodiscard]] double value() const { return value_; }
  /// As it was when the program ended.
  void restore(bool is) { is_ = holds_ = is; }

 private:
  bool holds_ = false, is_ = false;
  core::TimeNs since_ns_ = 0;
  double value_ = 0;
};

}  // namespace plc::alarms
