// The files of a shared object: itself, and what it asks the loader for from folders of its own (RUNPATH).
//
// In: the path of a shared object. Out: P7801 when somebody else than root and this user may have written one of the
// files, or could put one there; a handle of a private copy, so that replacing a file on disk changes nothing in this
// process. Folders of the system and LD_LIBRARY_PATH are trusted: who sets them decides what runs anyway. Does not
// belong here: what is in the library (shared_library.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace plc::taskblocks {

/// P7801 for the library at `path`.
core::Problem library_refused(const std::string& path, const std::string& why, std::string help);

/// The library and its files, those it needs before those that need them. `path` has no links in it. None of their code
/// runs.
core::Result<std::vector<std::string>> check_library_files(const std::string& path);

/// dlopen() of all of them; the handle of the last one, or null with the reason in `why`. Each is loaded from a copy in
/// memory; from its file where the system refuses that.
void* open_library(const std::vector<std::string>& files, std::string& why);

}  // namespace plc::taskblocks
