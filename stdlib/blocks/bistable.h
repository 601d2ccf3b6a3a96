// Blocks: bistables and edge detection (IEC 61131-3:2013, tables 43 and 44), and the semaphore of earlier editions.
#pragma once

#include <cstddef>

#include "stdlib/row.h"

namespace plc::stdlib::fb {

/// Set dominant.
struct Sr {
  struct Ports {
    std::uint8_t s1 = 0, r = 0, q1 = 0;
  };
  static constexpr std::string_view name = "SR";
  static constexpr std::string_view clause = "IEC 61131-3:2013, table 43";
  static constexpr std::string_view summary = "Bistable, set dominant: Q1 := S1 OR (NOT R AND Q1).";
  static constexpr Field fields[] = {
      {"S1", Direction::kInput, TypeId::kBool, offsetof(Ports, s1), "sets Q1, whatever R", "SET1"},
      {"R", Direction::kInput, TypeId::kBool, offsetof(Ports, r), "resets Q1", "RESET"},
      {"Q1", Direction::kOutput, TypeId::kBool, offsetof(Ports, q1), "state"}};
  static constexpr BlockExample examples[] = {{"S1 wins", R"(
at     S1 R | Q1
T#0ms  0  0 | 0
T#10ms 1  0 | 1
T#20ms 0  0 | 1
T#30ms 1  1 | 1
T#40ms 0  1 | 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.q1 = p.s1 | (p.q1 & static_cast<std::uint8_t>(p.r ^ 1u));
  }
};

/// Reset dominant.
struct Rs {
  struct Ports {
    std::uint8_t s = 0, r1 = 0, q1 = 0;
  };
  static constexpr std::string_view name = "RS";
  static constexpr std::string_view clause = "IEC 61131-3:2013, table 43";
  static constexpr std::string_view summary = "Bistable, reset dominant: Q1 := NOT R1 AND (S OR Q1).";
  static constexpr Field fields[] = {
      {"S", Direction::kInput, TypeId::kBool, offsetof(Ports, s), "sets Q1 unless R1", "SET"},
      {"R1", Direction::kInput, TypeId::kBool, offsetof(Ports, r1), "resets Q1, whatever S", "RESET1"},
      {"Q1", Direction::kOutput, TypeId::kBool, offsetof(Ports, q1), "state"}};
  static constexpr BlockExample examples[] = {{"R1 wins", R"(
at     S R1 | Q1
T#0ms  0 0  | 0
T#10ms 1 0  | 1
T#20ms 0 0  | 1
T#30ms 1 1  | 0
T#40ms 1 0  | 1
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.q1 = (p.s | p.q1) & static_cast<std::uint8_t>(p.r1 ^ 1u);
  }
};

/// M starts FALSE in both, as the standard writes them: docs/guides/first-scan.md.
struct RTrig {
  struct Ports {
    std::uint8_t clk = 0, q = 0, m = 0;
  };
  static constexpr std::string_view name = "R_TRIG";
  static constexpr std::string_view clause = "IEC 61131-3:2013, table 44";
  static constexpr std::string_view summary =
      "Q is TRUE for one execution when CLK has become TRUE, also when it is TRUE at the first one.";
  static constexpr Field fields[] = {
      {"CLK", Direction::kInput, TypeId::kBool, offsetof(Ports, clk), "signal"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "rising edge"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "CLK at the last execution"}};
  static constexpr BlockExample examples[] = {{"One scan for each edge", R"(
at     CLK | Q
T#0ms  0   | 0
T#10ms 1   | 1
T#20ms 1   | 0
T#30ms 0   | 0
T#40ms 1   | 1
)"},
                                              {"TRUE in the first scan is an edge", R"(
at     CLK | Q
T#0ms  1   | 1
T#10ms 1   | 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.q = p.clk & static_cast<std::uint8_t>(p.m ^ 1u);
    p.m = p.clk;
  }
};
struct FTrig {
  struct Ports {
    std::uint8_t clk = 0, q = 0, m = 0;
  };
  static constexpr std::string_view name = "F_TRIG";
  static constexpr std::string_view clause = "IEC 61131-3:2013, table 44";
  static constexpr std::string_view summary =
      "Q is TRUE for one execution when CLK has become FALSE, also when it is FALSE at the first one.";
  static constexpr Field fields[] = {
      {"CLK", Direction::kInput, TypeId::kBool, offsetof(Ports, clk), "signal"},
      {"Q", Direction::kOutput, TypeId::kBool, offsetof(Ports, q), "falling edge"},
      {"M", Direction::kState, TypeId::kBool, offsetof(Ports, m), "NOT CLK at the last execution"}};
  static constexpr BlockExample examples[] = {{"One scan for each edge", R"(
at     CLK | Q
T#0ms  1   | 0
T#10ms 0   | 1
T#20ms 0   | 0
T#30ms 1   | 0
T#40ms 0   | 1
)"},
                                              {"FALSE in the first scan is an edge", R"(
at     CLK | Q
T#0ms  0   | 1
T#10ms 0   | 0
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    const auto low = static_cast<std::uint8_t>(p.clk ^ 1u);
    p.q = low & static_cast<std::uint8_t>(p.m ^ 1u);
    p.m = low;
  }
};

/// Within one task only: other tasks see a global instance as a snapshot, so that two of them could claim it at once.
struct Sema {
  struct Ports {
    std::uint8_t claim = 0, release = 0, busy = 0, x = 0;
  };
  static constexpr std::string_view name = "SEMA";
  static constexpr std::string_view clause = "not in the third edition; IEC 61131-3:1993, table 34";
  static constexpr std::string_view summary =
      "Semaphore: BUSY says whether it was claimed before this execution; CLAIM claims it, RELEASE alone gives it "
      "back. "
      "Who claims and gets BUSY = FALSE has it. It guards what the programs of one task share, not what several do.";
  static constexpr Field fields[] = {
      {"CLAIM", Direction::kInput, TypeId::kBool, offsetof(Ports, claim), "claims it"},
      {"RELEASE", Direction::kInput, TypeId::kBool, offsetof(Ports, release), "gives it back, without CLAIM"},
      {"BUSY", Direction::kOutput, TypeId::kBool, offsetof(Ports, busy), "was claimed already"},
      {"X", Direction::kState, TypeId::kBool, offsetof(Ports, x), "is claimed"}};
  static constexpr BlockExample examples[] = {{"The second claim finds it taken", R"(
at     CLAIM RELEASE | BUSY
T#0ms  1     0       | 0
T#10ms 1     0       | 1
T#20ms 0     0       | 1
T#30ms 0     1       | 0
T#40ms 1     1       | 0
T#50ms 0     0       | 1
)"}};
  static void step(Ports& p, const StepContext&) noexcept {
    p.busy = p.x;
    if (p.claim != 0) {
      p.x = 1;
    } else if (p.release != 0) {
      p.busy = 0;
      p.x = 0;
    }
  }
};

using BistableRows = Rows<Sr, Rs, RTrig, FTrig, Sema>;

}  // namespace plc::stdlib::fb
