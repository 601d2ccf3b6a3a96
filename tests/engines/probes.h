// What probe maps show, against programs of the same IR that store every value (instrument.h).
//
// In: a project that compiles. Out: what differs first, in words. Does not belong here: making projects.
#pragma once

#include <cstdint>
#include <string>

namespace plc::test {

/// A fault in the maps, which has to be found.
enum class PlantedFault { kNone, kOrder, kLate };

struct ProbeTally {
  std::uint64_t programs = 0, scans = 0;
  std::uint64_t points = 0;        ///< of all maps
  std::uint64_t values = 0;        ///< compared
  std::uint64_t not_run = 0;       ///< points that a scan did not come by
  std::uint64_t not_computed = 0;  ///< values that the code does not compute
};

/// Runs the project at `path` with inputs of the seed, recorded, executed again with probes, and beside it the program
/// that stores what its probes show.
std::string compare_probes(const std::string& path, std::uint64_t seed, std::uint64_t scans, PlantedFault planted,
                           ProbeTally& tally);

}  // namespace plc::test
