// Estimate: how long one scan of a task takes at most, from its instructions and what each of them costs.
//
// In: a verified image, a CostTable. Out: for each task the longest path through its bodies, the loops that are in it,
// and its critical sections. A body goes forward but for LOOP_JUMPs and nothing calls itself, so there is a longest
// path, found in time linear in the code. What runs is what the linker makes of it: boolean runs are counted by the
// forms of their records. It is an estimate, not a bound: costs are measured, and caches and pipelines are in them as
// they were then; its user adds a margin. How often a loop goes round is known where a FOR counts from constant to
// constant; else kAssumedRounds stands for it, and the loop is named.
// Configuration time: allocates. Does not belong here: whether the tasks fit (analysis.h), margins.
#pragma once

#include <cstdint>
#include <vector>

#include "bytecode/image.h"
#include "core/source_ref.h"
#include "runtime/sched/cost_table.h"

namespace plc::runtime {

/// Rounds of a loop whose number of rounds the code does not say.
inline constexpr std::uint32_t kAssumedRounds = 10;

/// A loop of which only the running program knows how often it goes round.
struct AssumedLoop {
  std::uint32_t pou = 0;  ///< of the image
  core::SourceRef at;
};

/// One instruction of a task's body: what it exchanges, whom it holds off meanwhile, and its time. Programs count as
/// what calls them.
struct BodyStep {
  enum class What : std::uint8_t { kOther, kCopy, kRaise, kReschedule, kLock, kUnlock } what = What::kOther;
  std::uint32_t first = 0;  ///< kCopy, kRaise: field of the global table
  std::uint32_t count = 0;
  double ns = 0;
};

struct TaskEstimate {
  Cost scan;  ///< a whole scan, without its release; `first` is the longest one on its own
  std::vector<AssumedLoop> assumed;
  std::vector<BodyStep> body;
  std::uint64_t table_bytes = 0;  ///< of the variables that the task works on
};

/// `loop_budget`: no loop goes round more often in a scan, whatever it counts to. Functions and blocks that the table
/// does not have cost what its slowest one does.
TaskEstimate estimate_task(const bytecode::Image& image, std::uint32_t task, const CostTable& costs,
                           std::uint32_t loop_budget = bytecode::kDefaultLoopBudget);

}  // namespace plc::runtime
