// The commands of plc, one file each. add_<name>() declares the command's flags and what to call when it is chosen.
//
// In: the application, the place for the exit code. Out: the exit code once CLI11 has run the chosen command.
#pragma once

#include <CLI/CLI.hpp>

namespace plc::tools {

#define PLC_COMMAND(name, example, purpose) void add_##name(CLI::App& app, int& exit_code);
#include "tools/plc/commands.def"

}  // namespace plc::tools
