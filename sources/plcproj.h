// PlcProject: what a .plcproj of TwinCAT 3 says: which source files belong to the project, and how its libraries are
// called.
//
// In: a file. Out: entries with places; P1001 to P1006, P1207. Does not belong here: looking for the files (folder.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/reader.h"

namespace plc::sources {

struct PlcProject {
  struct Entry {
    std::string path;  ///< as written but for %20 and its like: backslashes, from the folder of the .plcproj
    core::SourceRef at;
    bool excluded = false;  ///< ExcludeFromBuild
  };
  std::uint16_t file = 0;  ///< index into Diagnostics' files
  std::string name;
  std::vector<Entry> entries;           ///< in file order
  std::vector<std::string> namespaces;  ///< of libraries: "Tc2_Standard"
};

/// Nothing when the file cannot be read or is no such project, which was reported.
std::optional<PlcProject> read_plcproj(const std::string& path, core::Diagnostics& diagnostics,
                                       const plcopen::ReadLimits& limits = {});
/// The same from memory; `name` appears in messages.
std::optional<PlcProject> read_plcproj_memory(std::string_view bytes, const std::string& name,
                                              core::Diagnostics& diagnostics, const plcopen::ReadLimits& limits = {});

}  // namespace plc::sources
