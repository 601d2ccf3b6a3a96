// Workloads of `plc-bench scan`: programs made from a seed that do the same as a project and as C.
//
// In: name, size, seed. Out: texts, and the variables that all sides must agree on; equal inputs give equal bytes.
// Does not belong here: running and measuring them (scan.cpp, side.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bench/limits.h"

namespace plc::bench {

/// Which values the benchmark gives an input.
enum class Stimulus : std::uint8_t {
  kNone,  ///< no input: the program writes it, or nobody does
  kBool,  ///< 0 or 1
  kDint,  ///< any value
  kReal,  ///< -1000 .. 1000
};
inline constexpr std::size_t kStimulusCount = 4;

/// Which inputs change before each scan.
enum class Inputs : std::uint8_t {
  kOneOfEachType,  ///< a BOOL is inverted, a DINT and a REAL get a new value
  kAll,            ///< all get random values
};

/// A variable that every side has; all hold the same bytes after each scan.
struct Variable {
  std::string path;         ///< as runtime::Access takes it; of an array, its first element; of a global, task 0's copy
  std::string c;            ///< the same as an lvalue of the C source
  std::uint32_t bytes = 1;  ///< of the variable, or of the whole array
  Stimulus stimulus = Stimulus::kNone;
};

/// One program in both languages.
struct Source {
  std::string project;  ///< one task, one instance
  /// Files that make one shared object; one after another they are a valid file, too. They define plc_scan(long long
  /// now_ns). BARRIER follows each rung: a compiler barrier, so that the compiler may not carry values from rung
  /// to rung, or nothing with -DBARRIER=.
  std::vector<std::string> c;
  std::vector<Variable> variables;
  /// So many taskblocks the C calls through its arrays `plc_calls` of {fire, object}, with `plc_failure` after the
  /// object. The variables are then those of the ports that their objects are bound to.
  std::uint32_t taskblocks = 0;
  const char* extension = "xml";  ///< of the project's file: PLCopen, or "st"
};

/// Of medians of ratios; null = no limit.
struct ScanLimits {
  const Limit* interpreter = nullptr;   ///< interpreter / C
  const Limit* native = nullptr;        ///< native code / C
  const Limit* native_plain = nullptr;  ///< native code / C without barriers
  const Limit* native_interpreter = nullptr;
};

struct Workload {
  std::string name;
  const char* unit;  ///< what a size counts, and times are per; work grows with the size in proportion
  Source (*make)(std::uint32_t size, std::uint64_t seed);
  std::vector<std::uint32_t> sizes;
  std::uint32_t small_size;  ///< for checks without measuring
  bool barriers;             ///< the C has barriers: it is measured with and without them
  ScanLimits limits;
  Inputs inputs = Inputs::kOneOfEachType;
};

/// All of them, in the order of the table.
std::span<const Workload> workloads();
/// Null when there is none of that name.
const Workload* find_workload(const std::string& name);

}  // namespace plc::bench
