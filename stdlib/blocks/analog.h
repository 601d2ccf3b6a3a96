// Blocks: analog values on their way from and to the process. None is in the standard; where CODESYS or OSCAT have the
// block, its pins are theirs. measured.h has the rules for time and for what is no number.
#pragma once

#include <cstddef>

#include "stdlib/blocks/measured.h"

namespace plc::stdlib::fb {

struct Scaler {
  struct Ports {
    float in = 0, in_min = 0, in_max = 0, out_min = 0, out_max = 0, out = 0;
    std::uint8_t error = 0;
  };
  static constexpr std::string_view clause = "not in the standard; pins as those of LIN_TRAFO in CODESYS";
  static constexpr std::string_view summary =
      "IN of the range IN_MIN .. IN_MAX as the value of OUT_MIN .. OUT_MAX; beyond it OUT stays at the end, with "
      "ERROR.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, TypeId::kReal, offsetof(Ports, in), "value"},
      {"IN_MIN", Direction::kInput, TypeId::kReal, offsetof(Ports, in_min), "becomes OUT_MIN; may be above IN_MAX"},
      {"IN_MAX", Direction::kInput, TypeId::kReal, offsetof(Ports, in_max), "becomes OUT_MAX"},
      {"OUT_MIN", Direction::kInput, TypeId::kReal, offsetof(Ports, out_min), "OUT at IN_MIN"},
      {"OUT_MAX", Direction::kInput, TypeId::kReal, offsetof(Ports, out_max), "OUT at IN_MAX"},
      {"OUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, out), "scaled value"},
      {"ERROR", Direction::kOutput, TypeId::kBool, offsetof(Ports, error),
       "IN is outside of the range, or there is none: IN_MIN = IN_MAX, or an input is no number; OUT keeps its value"}};
  static constexpr BlockExample examples[] = {{"4 .. 20 mA as 0 .. 100 %, and a broken wire", R"(
at     IN   IN_MIN IN_MAX OUT_MIN OUT_MAX | OUT   ERROR
T#0s   12.0 4.0    20.0   0.0     100.0   | 50.0  0
T#1s   20.0 .      .      .       .       | 100.0 0
T#2s   3.5  .      .      .       .       | 0.0   1
)"},
                                              {"A range of no width divides by nothing", R"(
at     IN   IN_MIN IN_MAX OUT_MIN OUT_MAX | OUT   ERROR
T#0s   5.0  0.0    10.0   10.0    0.0     | 5.0   0
T#1s   .    .      0.0    .       .       | 5.0   1
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.error = !all_finite(p.in, p.in_min, p.in_max, p.out_min, p.out_max) || p.in_min == p.in_max;
    if (p.error != 0) return;
    const double from = p.in_min, to = p.out_min;
    const double share = (static_cast<double>(p.in) - from) / (static_cast<double>(p.in_max) - from);
    p.error = share < 0 || share > 1;
    p.out = to_real(to + std::clamp(share, 0.0, 1.0) * (static_cast<double>(p.out_max) - to));
  }
};
struct Scale : Scaler {
  static constexpr std::string_view name = "SCALE";
};
struct LinTrafo : Scaler {
  static constexpr std::string_view name = "LIN_TRAFO";
};

inline constexpr std::string_view kLimitAlarm = "LIMITALARM", kLimitAlarmReal = "LIMITALARM_REAL";

template <TypeId T, const std::string_view& Name>
struct LimitAlarm {
  struct Ports {
    core::cpp_of<T> in = 0, high = 0, low = 0;
    std::uint8_t o = 0, u = 0, il = 0;
  };
  static constexpr std::string_view name = Name;
  static constexpr std::string_view clause = "not in the standard; as in CODESYS, which has it for INT";
  static constexpr std::string_view summary =
      "Whether IN is above HIGH, below LOW, or neither; of a NaN nothing is said.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, T, offsetof(Ports, in), "value"},
      {"HIGH", Direction::kInput, T, offsetof(Ports, high), "upper limit"},
      {"LOW", Direction::kInput, T, offsetof(Ports, low), "lower limit"},
      {"O", Direction::kOutput, TypeId::kBool, offsetof(Ports, o), "IN > HIGH"},
      {"U", Direction::kOutput, TypeId::kBool, offsetof(Ports, u), "IN < LOW"},
      {"IL", Direction::kOutput, TypeId::kBool, offsetof(Ports, il), "in the limits: LOW <= IN <= HIGH"}};
  static constexpr BlockExample examples[] = {{"The limits themselves are inside", R"(
at     IN  HIGH LOW | O U IL
T#0s   50  80   20  | 0 0 1
T#1s   80  .    .   | 0 0 1
T#2s   81  .    .   | 1 0 0
T#3s   19  .    .   | 0 1 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.o = p.in > p.high;
    p.u = p.in < p.low;
    p.il = p.low <= p.in && p.in <= p.high;
  }
};

struct Average {
  static constexpr int kMost = 32;

  struct Ports {
    float in = 0;
    std::uint8_t e = 1, rst = 0, count = 0, next = 0;
    std::int16_t n = 16;
    float avg = 0;
    /// Not shown as state fields: 32 lines for every instance in a live view help nobody.
    float samples[kMost] = {};
  };
  static constexpr std::string_view name = "AVERAGE";
  static constexpr std::string_view clause = "not in the standard; pins as those of FT_AVG in OSCAT";
  static constexpr std::string_view summary = "Moving average: the mean of the last N samples, one in each execution.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, TypeId::kReal, offsetof(Ports, in), "value; NaN and infinities are no samples"},
      {"E", Direction::kInput, TypeId::kBool, offsetof(Ports, e), "takes samples, TRUE at first; FALSE holds AVG"},
      {"N", Direction::kInput, TypeId::kInt, offsetof(Ports, n),
       "samples that count, 1 .. 32, 16 at first; the nearest of these"},
      {"RST", Direction::kInput, TypeId::kBool, offsetof(Ports, rst), "forgets all samples, and AVG is IN; dominant"},
      {"AVG", Direction::kOutput, TypeId::kReal, offsetof(Ports, avg), "mean of the samples there are, up to N"},
      {"COUNT", Direction::kState, TypeId::kUsint, offsetof(Ports, count), "samples there are"},
      {"NEXT", Direction::kState, TypeId::kUsint, offsetof(Ports, next), "place of the next sample"}};
  static constexpr BlockExample examples[] = {{"Of the last three; a new N takes effect at once", R"(
at      IN   E N RST | AVG
T#0ms   3.0  1 3 0   | 3.0
T#10ms  5.0  . . .   | 4.0
T#20ms  10.0 . . .   | 6.0
T#30ms  0.0  . . .   | 5.0
T#40ms  99.0 0 . .   | 5.0
T#50ms  2.0  1 2 .   | 1.0
T#60ms  8.0  . . 1   | 8.0
T#70ms  4.0  . . 0   | 4.0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    if (p.rst != 0) {
      p.count = 0;
      p.next = 0;
      if (all_finite(p.in)) p.avg = p.in;
      return;
    }
    if (p.e == 0 || !all_finite(p.in)) return;
    // The memory of an instance can be written from outside, so the place is held within the samples.
    p.samples[p.next % kMost] = p.in;
    p.next = static_cast<std::uint8_t>((p.next + 1) % kMost);
    p.count = static_cast<std::uint8_t>(std::min(p.count + 1, kMost));
    // Summed up anew in each execution: a running sum would keep its rounding errors for ever.
    const int counted = std::clamp<int>(p.n, 1, p.count);
    double sum = 0;
    for (int i = 1; i <= counted; ++i) sum += static_cast<double>(p.samples[(p.next - i + kMost) % kMost]);
    p.avg = to_real(sum / counted);
  }
};

struct Lag1 {
  struct Ports {
    float in = 0;
    std::int64_t t = 0;
    float k = 1, out = 0;
    double y = 0;
    Stopwatch watch;
  };
  static constexpr std::string_view name = "LAG1";
  static constexpr std::string_view clause = "not in the standard; pins as those of FT_PT1 in OSCAT";
  static constexpr std::string_view summary =
      "First-order lag, a low-pass filter: OUT approaches K * IN with the time constant T, 63 % of the way in each T. "
      "It "
      "begins settled.";
  static constexpr Field fields[] = {
      {"IN", Direction::kInput, TypeId::kReal, offsetof(Ports, in), "value"},
      {"T", Direction::kInput, TypeId::kTime, offsetof(Ports, t), "time constant; 0 or less: OUT is K * IN"},
      {"K", Direction::kInput, TypeId::kReal, offsetof(Ports, k), "gain, 1.0 at first"},
      {"OUT", Direction::kOutput, TypeId::kReal, offsetof(Ports, out), "filtered value"},
      {"Y", Direction::kState, TypeId::kLreal, offsetof(Ports, y), "OUT, with all its digits"},
      {"LAST", Direction::kState, TypeId::kLtime, offsetof(Ports, watch.last), "clock at the last execution"},
      {"STARTED", Direction::kState, TypeId::kBool, offsetof(Ports, watch.started), "LAST is valid"}};
  static constexpr BlockExample examples[] = {{"A step from 0 to 10: 10 * (1 - exp(-t / T))", R"(
at      IN   T    K   | OUT
T#0s    0.0  T#1s 1.0 | 0.0
T#1s    10.0 .    .   | 6.3212056
T#2s    .    .    .   | 8.6466472
T#3s    .    .    .   | 9.5021293
T#4s    .    T#0s .   | 10.0
)"}};
  static void step(Ports& p, const StepContext& context) noexcept {
    if (!all_finite(p.in, p.k)) return;
    const bool first = p.watch.started == 0;
    const double elapsed = p.watch.lap(context.now_ns);
    const double target = static_cast<double>(p.k) * static_cast<double>(p.in);
    // The exact solution for an input that does not change: the cycle time makes no difference.
    p.y = first || p.t <= 0 ? target : canonical(p.y - (target - p.y) * std::expm1(-elapsed / to_seconds(p.t)));
    p.out = to_real(p.y);
  }
};

using AnalogRows = Rows<Scale, LinTrafo, LimitAlarm<TypeId::kInt, kLimitAlarm>,
                        LimitAlarm<TypeId::kReal, kLimitAlarmReal>, Average, Lag1>;

}  // namespace plc::stdlib::fb
