// Shared objects from outside: the components that plc.toml names (paper, 3.1), and how any such library is loaded.
//
// In: the path of one shared object. Out: its blocks in a Registry, or P7801. The library stays loaded as long as the
// process: its code and descriptions are used everywhere. What a library may be and who may write it is checked before
// any of its code runs, and its code runs in a process of its own first. Call it before other threads are started.
// Does not belong here: plc.toml, what a description must look like (registry.h).
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>

#include "core/result.h"
#include "taskblocks/registry.h"

namespace plc::taskblocks {

/// Time a library has to be loaded and to describe its blocks. Both take milliseconds when all is well.
inline constexpr std::chrono::milliseconds kTrialTime{5000};

/// A library of any kind: what is exported from it, and what is done with it. `take` gets the address of the function
/// `entry`; it is called twice, at first in a process of its own, where what it keeps is lost.
struct LibraryUse {
  const char* entry = nullptr;
  std::function<std::optional<core::Problem>(void* entry, const std::string& path)> take;
  std::string missing_help;  ///< how to get the function into it
};
/// Loads the shared object at `path`. P7801, with the texts that load_shared_library() has, and what `take` says.
std::optional<core::Problem> load_library(const std::string& path, const LibraryUse& use,
                                          std::chrono::milliseconds trial_time = kTrialTime);

/// Adds the blocks of the shared object at `path` to `registry`. P7801 when it is not there, when somebody else than
/// root and this user could have written it, when its code crashes, ends the process or takes longer than `trial_time`,
/// and for all that Registry::add() refuses.
std::optional<core::Problem> load_shared_library(const std::string& path, Registry& registry,
                                                 std::chrono::milliseconds trial_time = kTrialTime);

}  // namespace plc::taskblocks
