// What an alarm is, as a table or an instance of the block ALARM declares it.
//
// In: nothing. Out: plain data. Does not belong here: reading files (io-drivers/config/read_alarms.h), states.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "core/source_ref.h"

namespace plc::alarms {

/// How soon somebody has to act.
enum class Priority : std::uint8_t { kLow, kMedium, kHigh, kCritical };
inline constexpr std::array<std::string_view, 4> kPriorityTexts = {"low", "medium", "high", "critical"};

/// When the condition holds.
enum class Comparison : std::uint8_t {
  kTrue,     ///< a BOOL is TRUE, a number is not 0
  kFalse,    ///< a BOOL is FALSE, a number is 0
  kAbove,    ///< value > limit; then until value <= limit - hysteresis
  kBelow,    ///< value < limit; then until value >= limit + hysteresis
  kEqual,    ///< value = limit
  kUnequal,  ///< value <> limit
};

struct Definition {
  std::string name;      ///< what calls and people name it by; of a block the path of its instance
  std::string variable;  ///< path of a BOOL, a number, a duration or an enumeration; empty of a block
  Comparison comparison = Comparison::kTrue;
  double limit = 0;
  double hysteresis = 0;         ///< at least 0
  core::TimeNs on_delay_ns = 0;  ///< the condition has to hold so long
  core::TimeNs off_delay_ns = 0;
  bool latch = false;  ///< stays until it was acknowledged, even when the condition is gone
  Priority priority = Priority::kMedium;
  std::string category;     ///< what it is about: "process"
  std::string text;         ///< what has happened
  std::string help;         ///< what to do
  std::string group;        ///< of which the first one is the cause; empty: none
  std::string suppress;     ///< path of a BOOL: while it is TRUE, the alarm has no meaning; or empty
  core::SourceRef at = {};  ///< in the table
};

}  // namespace plc::alarms
