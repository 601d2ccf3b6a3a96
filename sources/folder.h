// Source folders: a folder, a .plcproj, or a single source file of TwinCAT or CODESYS, as one Project.
//
// In: a path. Out: the Project of all files that belong to it; P1204, P1205, P1209 and those of the readers. Does not
// belong here: what the files hold (object_file.h, export_file.h, frontend-st).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::sources {

/// Files that a project may have: SourceRef counts them in 16 bits, and libraries want some, too.
inline constexpr std::size_t kMaxFiles = 20'000;

/// True for what read() reads: a folder, or a file named as .plcproj, .TcPOU, .TcGVL, .TcDUT, .TcIO, .TcTTO or .exp.
bool is_source_path(const std::string& path);

/// Reads a project. A folder with one .plcproj in it, at any depth, is that project: the files it lists, and no others.
/// A folder without one is all .TcPOU, .TcGVL, .TcDUT, .TcIO, .TcTTO, .st, .iecst and .exp files below it, in the order
/// of their paths; names that begin with a dot, and links that lead out of the folder, are left out. Null when nothing
/// was read, which was reported. `defines` as those of st::read().
std::unique_ptr<plcopen::Project> read(const std::string& path, core::Diagnostics& diagnostics,
                                       const std::vector<std::string>& defines = {});

}  // namespace plc::sources
