// plc explain --flow: the data flow between the tasks of a project, as tables or drawn.
//
// In: what to compile or load. Out: exit code. Does not belong here: what flows (flow.h).
#pragma once

#include <string>

#include "tools/open.h"

namespace plc::tools {

/// Prints the tables, or writes the drawing to the file `svg` when one is named.
int explain_flow(Command command, const Request& request, const std::string& svg);

}  // namespace plc::tools
