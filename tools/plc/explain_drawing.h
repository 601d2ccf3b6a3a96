// plc explain --svg: POUs of a project or an image as a picture.
//
// In: what to read or load, which POU. Out: exit code. Does not belong here: how drawings look (pictures/).
#pragma once

#include <string>

#include "tools/open.h"

namespace plc::tools {

/// Draws a POU with its actions and transitions, or one of these ("Main.Start"), or all; `svg` is a file, or "-" for
/// standard output.
int explain_drawing(Command command, const Request& request, const std::string& pou, const std::string& svg);

}  // namespace plc::tools
