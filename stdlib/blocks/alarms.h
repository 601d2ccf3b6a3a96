// Blocks: alarms. The block says whether something is the case; who acknowledged it, who shelved it and the history are
// kept outside of the scan (alarms/), which finds instances by the name of the block. measured.h has the rules for what
// is no number.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "stdlib/arithmetic.h"
#include "stdlib/blocks/measured.h"

namespace plc::stdlib::fb {

/// A STRING of the usual capacity, as tables have it.
struct PortText {
  core::StringHeader header{core::kDefaultStringCapacity, 0};
  std::array<char, core::kDefaultStringCapacity> characters{};
};

struct Alarm {
  /// What holds.
  enum Holds : std::uint8_t { kIn = 1, kAbove = 2, kBelow = 4 };
  struct Ports {
    double value = 0;
    double high = std::numeric_limits<double>::max(), low = std::numeric_limits<double>::lowest(), hyst = 0;
    std::int64_t on_delay = 0, off_delay = 0, since = 0;
    std::uint8_t in = 0, latch = 0, priority = 2, active = 0, holds = 0;
    PortText text, alarm_class, first_out;
  };
  static constexpr std::string_view name = "ALARM";
  static constexpr std::string_view clause = "not in the standard; states and priorities as in ISA-18.2";
  static constexpr std::string_view summary =
      "Alarm: ACTIVE while IN is TRUE, or VALUE is above HIGH or below LOW; with hysteresis and delays. Shown, "
      "acknowledged and kept beside the program.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, TypeId::kBool, offsetof(Ports, in), "the condition"},
      {"VALUE", Direction::kInput, TypeId::kLreal, offsetof(Ports, value), "compared with HIGH and LOW, and shown"},
      {"HIGH", Direction::kInput, TypeId::kLreal, offsetof(Ports, high),
       "VALUE > HIGH is a condition, too; out of reach at first"},
      {"LOW", Direction::kInput, TypeId::kLreal, offsetof(Ports, low), "VALUE < LOW is one; out of reach at first"},
      {"HYST", Direction::kInput, TypeId::kLreal, offsetof(Ports, hyst),
       "VALUE has to come back so far behind the limit; less than 0 counts as 0"},
      {"ON_DELAY", Direction::kInput, TypeId::kTime, offsetof(Ports, on_delay), "the condition has to hold so long"},
      {"OFF_DELAY", Direction::kInput, TypeId::kTime, offsetof(Ports, off_delay), "it has to be gone so long"},
      {"LATCH", Direction::kInput, TypeId::kBool, offsetof(Ports, latch),
       "the alarm is shown until it was acknowledged, also when ACTIVE is FALSE"},
      {"PRIORITY", Direction::kInput, TypeId::kUsint, offsetof(Ports, priority),
       "1 low, 2 medium, 3 high, 4 critical; 2 at first"},
      {"TEXT", Direction::kInput, TypeId::kString, offsetof(Ports, text), "what has happened"},
      {"ALARM_CLASS", Direction::kInput, TypeId::kString, offsetof(Ports, alarm_class), "what it is about: 'process'"},
      {"FIRST_OUT", Direction::kInput, TypeId::kString, offsetof(Ports, first_out),
       "name of a group whose alarms are numbered in the order of their scans"},
      {"ACTIVE", Direction::kOutput, TypeId::kBool, offsetof(Ports, active), "it is the case, after the delays"},
      {"HOLDS", Direction::kState, TypeId::kUsint, offsetof(Ports, holds),
       "without the delays: 1 IN, 2 above HIGH, 4 below LOW, and their sums"},
      {"SINCE", Direction::kState, TypeId::kLtime, offsetof(Ports, since), "clock when HOLDS began or ended"}};
  static constexpr BlockExample examples[] = {{"A limit with hysteresis", R"(
at     IN VALUE HIGH HYST | ACTIVE
T#0s   0  90.0  90.0 5.0  | 0
T#1s   .  90.5  .    .    | 1
T#2s   .  85.5  .    .    | 1
T#3s   .  85.0  .    .    | 0
T#4s   .  89.0  .    .    | 0
)"},
                                              {"A condition with delays", R"(
at      IN ON_DELAY OFF_DELAY | ACTIVE
T#0ms   1  T#100ms  T#50ms    | 0
T#90ms  0  .        .         | 0
T#95ms  1  .        .         | 0
T#194ms .  .        .         | 0
T#195ms .  .        .         | 1
T#200ms 0  .        .         | 1
T#250ms .  .        .         | 0
)"},
                                              {"What people are told changes nothing in the program", R"(
at     LOW  VALUE LATCH PRIORITY TEXT    ALARM_CLASS FIRST_OUT | ACTIVE
T#0s   10.0 12.0  1     3        'Empty' 'process'   'line'    | 0
T#1s   .    9.0   .     .        .       .           .         | 1
T#2s   .    10.0  .     .        .       .           .         | 0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    const double back = p.hyst > 0 ? p.hyst : 0;
    // A NaN is neither above nor below.
    const bool above = p.value > p.high - ((p.holds & kAbove) != 0 ? back : 0);
    const bool below = p.value < p.low + ((p.holds & kBelow) != 0 ? back : 0);
    const std::uint8_t before = p.holds;
    p.holds = static_cast<std::uint8_t>((p.in != 0 ? kIn : 0) | (above ? kAbove : 0) | (below ? kBelow : 0));
    const std::uint8_t is = p.holds != 0 ? 1 : 0;
    if ((before != 0 ? 1 : 0) != is) p.since = context.now_ns;
    if (is != p.active && wrap_sub(context.now_ns, p.since) >= (is != 0 ? p.on_delay : p.off_delay)) p.active = is;
  }
};

using AlarmRows = Rows<Alarm>;

}  // namespace plc::stdlib::fb
