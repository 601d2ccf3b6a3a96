// A folder as one file: a tar archive (POSIX.1-1988, ustar) in memory.
//
// Threads: any; blocks on the disk. Does not belong here: which folder.
#pragma once

#include <string>
#include <vector>

#include "core/result.h"

namespace plc::engineering {

/// The plain files below `folder`, by paths from there; hidden ones, links and the files and folders `without` are left
/// out. P7717 when they are more than `most_bytes`, or one has a path that tar cannot hold.
core::Result<std::string> tar_of(const std::string& folder, std::size_t most_bytes,
                                 const std::vector<std::string>& without = {});

}  // namespace plc::engineering
