// The global table and the task bodies: who imports and exports what, in which order.
//
// Globals are ordered so that what a task exports is one range: first those written by no task, then by each task
// alone, then by each set of tasks; within these by the tasks that read them, so that imports are few ranges too. Under
// --coherence=priority-ceiling those with the same ceiling lie together (paper, 3.2.3).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bytecode/codegen/body.h"
#include "ir/reach.h"

namespace plc::bytecode {

/// What every task uses, and the order of the global table.
struct GlobalPlan {
  std::vector<ir::GlobalUse> use;      ///< by task
  std::vector<std::uint32_t> order;    ///< ir global of each field
  std::vector<std::uint32_t> writers;  ///< by field: number of tasks that write it
  /// By field: priority of the most urgent task that uses it, where one task alone writes it. Nothing: it takes no
  /// critical section to copy it.
  std::vector<std::optional<std::int32_t>> ceilings;
};

GlobalPlan plan_globals(const ir::Module& module, core::Coherence coherence);
/// Makes the global table; sets Shared::global_offset.
void lay_out_globals(Shared& shared, const GlobalPlan& plan);
/// Makes Image::queues; sets Shared::queue_of. False when one takes more than a table may.
bool lay_out_queues(Shared& shared);
/// Makes the task bodies and Image::tasks. All POUs have their place in Shared::image_pou.
void generate_tasks(Shared& shared, const GlobalPlan& plan);

}  // namespace plc::bytecode
