// Libraries: files of data types, POUs and globals that join a project (--lib).
//
// In: a Project and another one read from a library file. Out: one Project. What the project declares itself hides what
// the library has of the same name. Does not belong here: reading files, compiling.
#pragma once

#include "core/diagnostics.h"
#include "plcopen/project.h"

namespace plc::compiler {

/// Moves what `library` declares into `project`; its tasks and program instances are left out. A name that the project
/// or an earlier library has already is reported (P5110) with both places.
void add_library(plcopen::Project& project, plcopen::Project&& library, core::Diagnostics& diagnostics);

}  // namespace plc::compiler
