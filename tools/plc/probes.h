// Probes: small programs in which one kind of cost stands out, and mixed ones to check the sum.
//
// In: nothing. Out: texts in ST, from which plc calibrate finds what instructions cost. A probe may use kinds whose
// probes come before it, and no later ones. Does not belong here: measuring (measure.h).
#pragma once

#include <string>
#include <vector>

#include "runtime/sched/cost_table.h"

namespace plc::tools {

struct Probe {
  runtime::CostKind kind = runtime::CostKind::kCount;
  std::string text;      ///< a whole project; its first task is measured
  bool partner = false;  ///< the second task runs before each scan: it writes what the first one imports
};

/// In the order of costs.def; the kinds that no instruction has (what the system takes) have none.
std::vector<Probe> probes();

struct Sample {
  std::string name;
  std::string text;
};
/// Programs like people's: logic, arithmetic, loops, texts, blocks of blocks. Their estimates are held against their
/// times.
std::vector<Sample> samples();

}  // namespace plc::tools
