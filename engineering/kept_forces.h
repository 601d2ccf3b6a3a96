// Forces that are to hold over a warm start, in a file of the state folder.
//
// In: a list of forces. Out: `forces.json`, with those that are to be kept; the same list at the next start. Threads:
// any; blocks on the disk. Does not belong here: forcing (runtime/force_list.h).
#pragma once

#include <string>
#include <vector>

#include "core/clock.h"
#include "runtime/force_list.h"

namespace plc::engineering {

/// Replaces the file. Empty, or why not; nothing to do without a folder.
std::string store_kept_forces(const std::string& folder, const std::vector<runtime::Force>& forces);

/// Forces again what the file has, but for what is over by now; others for the rest of their time, by the monotonic
/// clock, of which `now_ns` is. Before the tasks run. A sentence for each force that cannot hold any more, and for a
/// file that cannot be read.
std::vector<std::string> force_again(const std::string& folder, core::TimeNs utc_ns, core::TimeNs now_ns,
                                     runtime::ForceList& forces);

}  // namespace plc::engineering
