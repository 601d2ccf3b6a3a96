// Which taskblocks allocate memory in their cycle, said once of each.
//
// In: counts of tasks that run. Out: lines of the log. Threads: the main one's. Does not belong here: counting.
#pragma once

#include <set>
#include <string>
#include <utility>

#include "runtime/resource.h"
#include "tools/plc-run/run_log.h"

namespace plc::tools {

/// Says of each taskblock once that it allocates memory in its cycle. The tasks may run.
class AllocationWarnings {
 public:
  explicit AllocationWarnings(const runtime::Resource& resource) : resource_(resource) {}
  void say_new(RunLog& log) {
    for (std::size_t task = 0; task < resource_.task_count(); ++task) {
      const runtime::Program& program = resource_.program(task);
      for (const auto& found : program.allocations()) {
        if (!told_.emplace(task, found.taskblock).second) continue;
        log.say(core::Severity::kWarning, "taskblock " + std::string(found.taskblock) +
                                              " allocates memory in its cycle (task " + program.task().name + ")");
      }
    }
  }

 private:
  const runtime::Resource& resource_;
  std::set<std::pair<std::size_t, std::string>> told_;
};

}  // namespace plc::tools
