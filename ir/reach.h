// What a task reaches: POUs called or run, and globals read and written by each of them.
//
// In: a Module. Out: read by ir::check (several writers) and by code generation (import and export lists).
// Conservative: a global whose handle is passed as VAR_IN_OUT counts as read and written.
#pragma once

#include <cstdint>
#include <vector>

#include "ir/ir.h"

namespace plc::ir {

/// The place that `place` is part of: a global, a variable, or what a reference points at.
const Place& root_of(const Body& body, PlaceId place);

/// POUs that executing `pou` may call or run directly; each once, in order of appearance.
std::vector<std::uint32_t> callees(const Module& module, std::uint32_t pou);

/// POUs reached from the programs of `task`, callees before callers. Ends on recursive modules too.
std::vector<std::uint32_t> reached_pous(const Module& module, const Task& task);

struct GlobalUse {
  std::vector<bool> read;     ///< by global index
  std::vector<bool> written;  ///< by global index
};
/// The globals used by everything that `task` reaches, by name or through a reference: a REF_TO may refer to any global of
/// its type of which REF() is taken, in whatever task, if references to that type stand in globals at all.
GlobalUse global_use(const Module& module, const Task& task);

}  // namespace plc::ir
