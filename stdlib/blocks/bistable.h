// Blocks: bistables and edge detection (IEC 61131-3:2013, tables 43 and 44).
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
  static void step(Ports& p, const StepContext&) noexcept {
    const auto low = static_cast<std::uint8_t>(p.clk ^ 1u);
    p.q = low & static_cast<std::uint8_t>(p.m ^ 1u);
    p.m = low;
  }
};

using BistableRows = Rows<Sr, Rs, RTrig, FTrig>;

}  // namespace plc::stdlib::fb
