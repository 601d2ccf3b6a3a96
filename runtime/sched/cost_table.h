// CostTable: how long the parts of a scan take on one machine.
//
// In: measurements of `plc calibrate`, read from a file (io-drivers/config/calibration.h). Out: numbers for the
// estimator. The kinds of cost are the rows of costs.def; which opcode is of which kind is said here, once.
// Does not belong here: adding up (estimate.h), files, measuring (tools/plc/calibrate.cpp).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "bytecode/opcode.h"

namespace plc::runtime {

enum class CostKind : std::uint8_t {
#define PLC_COST(Name, key, unit, meaning) k##Name,
#include "runtime/sched/costs.def"
  kCount
};
inline constexpr std::size_t kCostKinds = static_cast<std::size_t>(CostKind::kCount);

struct CostInfo {
  std::string_view key;   ///< in calibration files
  std::string_view unit;  ///< what is counted: "instruction", "byte"
  std::string_view meaning;
};
const CostInfo& info(CostKind kind);

/// The kind of an instruction itself; what it copies, calls or runs counts besides. kCount for BOOL_RUN, which is
/// nothing but its records.
CostKind cost_kind(bytecode::Opcode opcode);

/// Nanoseconds. Code that was not executed for some milliseconds has to come from memory and its jumps are not
/// foreseen: what a scan does for the first time takes several times as long as what a loop repeats.
struct Cost {
  double first = 0;  ///< the first time in a scan
  double again = 0;  ///< in the later rounds of a loop

  Cost& operator+=(const Cost& other) {
    first += other.first;
    again += other.again;
    return *this;
  }
  friend Cost operator+(Cost a, const Cost& b) { return a += b; }
  friend Cost operator*(const Cost& a, double times) { return {a.first * times, a.again * times}; }
  friend bool operator==(const Cost&, const Cost&) = default;
};
/// The longer one of two ways, by each count.
Cost longer(const Cost& a, const Cost& b);

struct CostTable {
  std::string machine;  ///< where it was measured
  std::array<Cost, kCostKinds> kinds{};
  /// One call each, the longest that was found, in ns, once its code is at hand.
  std::map<std::string, double, std::less<>> functions;  ///< by stdlib::key_of: "SIN:REAL"
  std::map<std::string, double, std::less<>> blocks;     ///< by name: "TON"

  [[nodiscard]] const Cost& operator[](CostKind kind) const { return kinds[static_cast<std::size_t>(kind)]; }
  Cost& operator[](CostKind kind) { return kinds[static_cast<std::size_t>(kind)]; }
};

}  // namespace plc::runtime
