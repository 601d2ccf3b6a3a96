// plc-run for tests that run side by side: without servers, since ports are those of the whole machine.
//
// In: arguments; PLC_RUN_TOOL, where it is, which the target of the test defines. Out: a command line. Does not belong
// here: starting it (run_tool.h).
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/run_tool.h"

namespace plc::test {

/// Both servers are off, but for those of which the arguments say where they listen.
inline std::vector<std::string> plc_run(std::vector<std::string> arguments) {
  for (const char* server : {"--modbus", "--engineering"}) {
    if (std::find(arguments.begin(), arguments.end(), server) == arguments.end())
      arguments.insert(arguments.end(), {server, "off"});
  }
  arguments.insert(arguments.begin(), PLC_RUN_TOOL);
  return arguments;
}

/// Runs it with these arguments, as run_tool().
inline ToolResult run_plant(std::vector<std::string> arguments, unsigned seconds = 60) {
  return run_tool(plc_run(std::move(arguments)), seconds);
}

}  // namespace plc::test
