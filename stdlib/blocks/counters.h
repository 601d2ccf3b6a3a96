// Blocks: counters (IEC 61131-3:2013, table 45). All count rising edges, CTD too; CV stops at the ends of its type.
#pragma once

#include <cstddef>
#include <limits>

#include "stdlib/row.h"

namespace plc::stdlib::fb {

inline constexpr std::string_view kCounterClause = "IEC 61131-3:2013, table 45";

/// "CTU" for the INT form of the second edition, "CTU_DINT" for the typed forms.
template <const std::string_view& Base, TypeId T, bool Typed>
constexpr std::string_view counter_name() {
  static_assert(core::in_category(T, core::kAnyInt));
  if constexpr (Typed) {
    return TypedName<Base, T>::value;
  } else {
    return Base.substr(0, Base.size() - 1);
  }
}
inline constexpr std::string_view kCtu = "CTU_", kCtd = "CTD_", kCtud = "CTUD_";

/// The edge of `now` since `memory`, which then becomes `now`.
inline bool rising(std::uint8_t now, std::uint8_t& memory) noexcept {
  const bool edge = now != 0 && memory == 0;
  memory = now;
  return edge;
}

template <TypeId T, bool Typed = true>
struct Ctu {
  using V = core::cpp_of<T>;
  struct Ports {
    std::uint8_t cu = 0, r = 0, q = 0, cu_m = 0;
    V pv = 0, cv = 0;
  };
  static constexpr std::string_view name = counter_name<kCtu, T, Typed>();
  static constexpr std::string_view clause = kCounterClause;
  static constexpr std::string_view summary = "Counts rising edges of CU up; Q when CV has reached PV.";
  static constexpr Field fields[] = {
      {"CU", Direction::kInput, TypeId::kBool, offsetof(Ports, cu), "counts up at its rising edge"},
      {"R", Direction::kInput, TypeId::kBool, offsetof(Ports, r), "sets CV to 0, dominant", "RESET"},
      {"PV", Direction::kInput, T, offsetof(Ports, pv), "preset value"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "CV >= PV"},
      {"CV", Direction::kOutput, T, offsetof(Ports, cv), "counter value"},
      {"CU_M", Direction::kState, TypeId::kBool, offsetof(Ports, cu_m), "CU at the last execution"}};
  static constexpr BlockExample examples[] = {{"Counts edges, also beyond PV; R dominates and takes its edge away", R"(
at     CU R PV | Q CV
T#0ms  0  0 2  | 0 0
T#10ms 1  0 .  | 0 1
T#20ms 1  0 .  | 0 1
T#30ms 0  0 .  | 0 1
T#40ms 1  0 .  | 1 2
T#50ms 0  0 .  | 1 2
T#60ms 1  0 .  | 1 3
T#70ms 0  0 .  | 1 3
T#80ms 1  1 .  | 0 0
T#90ms 1  0 .  | 0 0
)"},
                                              {"TRUE in the first scan counts", R"(
at     CU R PV | Q CV
T#0ms  1  0 1  | 1 1
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    const bool up = rising(p.cu, p.cu_m);
    if (p.r != 0) {
      p.cv = 0;
    } else if (up && p.cv < std::numeric_limits<V>::max()) {
      ++p.cv;
    }
    p.q = p.cv >= p.pv;
  }
};

template <TypeId T, bool Typed = true>
struct Ctd {
  using V = core::cpp_of<T>;
  struct Ports {
    std::uint8_t cd = 0, ld = 0, q = 0, cd_m = 0;
    V pv = 0, cv = 0;
  };
  static constexpr std::string_view name = counter_name<kCtd, T, Typed>();
  static constexpr std::string_view clause = kCounterClause;
  static constexpr std::string_view summary = "Counts rising edges of CD down from PV; Q when CV has reached 0.";
  static constexpr Field fields[] = {
      {"CD", Direction::kInput, TypeId::kBool, offsetof(Ports, cd), "counts down at its rising edge"},
      {"LD", Direction::kInput, TypeId::kBool, offsetof(Ports, ld), "sets CV to PV, dominant", "LOAD"},
      {"PV", Direction::kInput, T, offsetof(Ports, pv), "preset value"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "CV <= 0"},
      {"CV", Direction::kOutput, T, offsetof(Ports, cv), "counter value"},
      {"CD_M", Direction::kState, TypeId::kBool, offsetof(Ports, cd_m), "CD at the last execution"}};
  static constexpr BlockExample examples[] = {{"LD loads PV and dominates; edges count down from there", R"(
at     CD LD PV | Q CV
T#0ms  0  1  2  | 0 2
T#10ms 1  1  .  | 0 2
T#20ms 1  0  .  | 0 2
T#30ms 0  0  .  | 0 2
T#40ms 1  0  .  | 0 1
T#50ms 1  0  .  | 0 1
T#60ms 0  0  .  | 0 1
T#70ms 1  0  .  | 1 0
)"},
                                              {"Not loaded it is at 0", R"(
at     CD LD PV | Q CV
T#0ms  0  0  5  | 1 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    const bool down = rising(p.cd, p.cd_m);
    if (p.ld != 0) {
      p.cv = p.pv;
    } else if (down && p.cv > std::numeric_limits<V>::min()) {
      --p.cv;
    }
    p.q = p.cv <= 0;
  }
};

template <TypeId T, bool Typed = true>
struct Ctud {
  using V = core::cpp_of<T>;
  struct Ports {
    std::uint8_t cu = 0, cd = 0, r = 0, ld = 0, qu = 0, qd = 0, cu_m = 0, cd_m = 0;
    V pv = 0, cv = 0;
  };
  static constexpr std::string_view name = counter_name<kCtud, T, Typed>();
  static constexpr std::string_view clause = kCounterClause;
  static constexpr std::string_view summary =
      "Counts rising edges of CU up and of CD down; both at once cancel. R dominates LD, LD dominates counting.";
  static constexpr Field fields[] = {
      {"CU", Direction::kInput, TypeId::kBool, offsetof(Ports, cu), "counts up at its rising edge"},
      {"CD", Direction::kInput, TypeId::kBool, offsetof(Ports, cd), "counts down at its rising edge"},
      {"R", Direction::kInput, TypeId::kBool, offsetof(Ports, r), "sets CV to 0", "RESET"},
      {"LD", Direction::kInput, TypeId::kBool, offsetof(Ports, ld), "sets CV to PV", "LOAD"},
      {"PV", Direction::kInput, T, offsetof(Ports, pv), "preset value"},
      {"QU", Direction::kOutput, TypeId::kBool, offsetof(Ports, qu), "CV >= PV"},
      {"QD", Direction::kOutput, TypeId::kBool, offsetof(Ports, qd), "CV <= 0"},
      {"CV", Direction::kOutput, T, offsetof(Ports, cv), "counter value"},
      {"CU_M", Direction::kState, TypeId::kBool, offsetof(Ports, cu_m), "CU at the last execution"},
      {"CD_M", Direction::kState, TypeId::kBool, offsetof(Ports, cd_m), "CD at the last execution"}};
  static constexpr BlockExample examples[] = {{"Up, down, and both at once", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  0  0 1  3  | 1  0  3
T#10ms 1  0  0 0  .  | 1  0  4
T#20ms 0  1  0 0  .  | 1  0  3
T#30ms 0  0  0 0  .  | 1  0  3
T#40ms 0  1  0 0  .  | 0  0  2
T#50ms 0  0  0 0  .  | 0  0  2
T#60ms 1  1  0 0  .  | 0  0  2
)"},
                                              {"R dominates LD", R"(
at     CU CD R LD PV | QU QD CV
T#0ms  0  0  1 1  3  | 0  1  0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    const bool up = rising(p.cu, p.cu_m);
    const bool down = rising(p.cd, p.cd_m);
    if (p.r != 0) {
      p.cv = 0;
    } else if (p.ld != 0) {
      p.cv = p.pv;
    } else if (up && !down && p.cv < std::numeric_limits<V>::max()) {
      ++p.cv;
    } else if (down && !up && p.cv > std::numeric_limits<V>::min()) {
      --p.cv;
    }
    p.qu = p.cv >= p.pv;
    p.qd = p.cv <= 0;
  }
};

using CounterRows =
    Rows<Ctu<TypeId::kInt, false>, Ctu<TypeId::kInt>, Ctu<TypeId::kDint>, Ctu<TypeId::kLint>, Ctu<TypeId::kUint>,
         Ctu<TypeId::kUdint>, Ctu<TypeId::kUlint>, Ctd<TypeId::kInt, false>, Ctd<TypeId::kInt>, Ctd<TypeId::kDint>,
         Ctd<TypeId::kLint>, Ctd<TypeId::kUint>, Ctd<TypeId::kUdint>, Ctd<TypeId::kUlint>, Ctud<TypeId::kInt, false>,
         Ctud<TypeId::kInt>, Ctud<TypeId::kDint>, Ctud<TypeId::kLint>, Ctud<TypeId::kUint>, Ctud<TypeId::kUdint>,
         Ctud<TypeId::kUlint>>;

}  // namespace plc::stdlib::fb
