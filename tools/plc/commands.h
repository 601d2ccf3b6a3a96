// The commands of plc, one file each. add_<name>() declares the command's flags and what to call when it is chosen.
//
// In: the program. Out: its commands.
#pragma once

#include "tools/cli.h"

namespace plc::tools {

#define PLC_COMMAND(name, example, purpose) void add_##name(Command program);
#include "tools/plc/commands.def"

}  // namespace plc::tools
