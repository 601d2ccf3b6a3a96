// plc explain --schedule: do the tasks of a project meet their deadlines, and by how much?
//
// In: a project or image, plc.toml. Out: a table per processor, or JSON. Does not belong here: the computation
// (runtime/sched/schedule.h).
#pragma once

#include <string>
#include <vector>

#include "core/options.h"
#include "taskblocks/registry.h"
#include "tools/cli.h"

namespace plc::tools {

struct ExplainSchedule {
  std::string file;
  std::string configuration;  ///< plc.toml, or empty
  bool json = false;
  core::CompileOptions options;
  std::vector<std::string> libraries;
  const taskblocks::Registry* taskblocks = nullptr;  ///< that the project may use
};

int explain_schedule(Command command, const ExplainSchedule& explain);

}  // namespace plc::tools
