// Export files of CODESYS 2.3 and TwinCAT 2 (.EXP): declarations and bodies as text, several objects a file, between
// settings of the tool. What is text is read as such; bodies that are drawn are named with their POU.
//
// In: a file in Windows-1252. Out: Project with places; P1001, P1006, P1210, and those of frontend-st. Does not belong
// here: declarations and statements (frontend-st).
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::sources {

/// Reads a file. `defines` as those of st::read(). Null when it cannot be read, which was reported.
std::unique_ptr<plcopen::Project> read_export_file(const std::string& path, core::Diagnostics& diagnostics,
                                                   const std::vector<std::string>& defines = {});
/// The same from memory; `name` appears in messages.
std::unique_ptr<plcopen::Project> read_export_memory(std::string_view bytes, const std::string& name,
                                                     core::Diagnostics& diagnostics,
                                                     const std::vector<std::string>& defines = {});

}  // namespace plc::sources
