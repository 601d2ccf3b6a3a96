// One row of the table of `plc-bench scan`: a workload of one size, all sides compared variable by variable and timed
// in turns.
//
// In: a Workload and how much of it. Out: a row on stdout, and what plots are made of. Does not belong here: making
// programs (workload.h), making them run (side.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "bench/side.h"
#include "bench/verdict.h"
#include "bench/workload.h"

namespace plc::bench {

/// What does the same: C with a barrier after each rung, C without barriers, interpreter, native code.
inline constexpr std::size_t kSides = 4;
enum : std::size_t { kC, kPlainC, kInterpreter, kNative };

struct ScanPlan {
  std::uint32_t size = 1000;  ///< of the workload
  std::uint64_t seed = 1;
  std::uint32_t scans = 1000;   ///< checked ones, fewer where they would compare very many bytes
  std::uint32_t batches = 100;  ///< timed ones of each side, interleaved; 0 = check only
  bool c = true;                ///< false: without the C, which takes a compiler long
  bool plain_c = true;          ///< ... without that without barriers
};
struct ScanResult {
  Verdict verdict;
  std::array<double, kSides> ns{};  ///< medians, per unit of the size; 0 = not measured
  std::array<Footprint, kSides> footprints{};
};
/// Columns of what measure_scan() prints.
std::string scan_head();
/// Interpreter and native code against the same program in C compiled with -O2, with and without a barrier after each
/// rung, in one process, with inputs changing before each scan. Prints a row.
ScanResult measure_scan(const Workload& workload, const ScanPlan& plan);

}  // namespace plc::bench
