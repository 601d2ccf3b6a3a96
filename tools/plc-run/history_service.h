// The historian of plc-run: from historian.toml to a thread that keeps values, and what it says to the log.
//
// In: a file, a resource, the shadow. Out: a historian for the engineering server, or none. Threads: the main one's.
// Does not belong here: keeping (historian/).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engineering/engineering.h"
#include "engineering/shadow_values.h"
#include "historian/historian.h"

namespace plc::tools {

class HistoryService {
 public:
  /// Before any thread reads globals. `file`: historian.toml, which need not be there.
  HistoryService(std::string file, runtime::Resource& resource);
  /// Before the tasks start. `state`: folder, or empty. `shadow`: null when nothing is recorded; it must live until
  /// stop().
  void open(const std::string& state, runtime::Resource& resource, shadow::Shadow* shadow,
            const core::Calendar& calendar, std::vector<engineering::Said>& said);

  /// Null when nothing is kept.
  [[nodiscard]] historian::Historian* historian() { return historian_.get(); }
  void service(std::vector<engineering::Said>& said);
  void stop();

 private:
  std::string file_;
  std::unique_ptr<engineering::ShadowValues> values_;  ///< null without the file
  std::unique_ptr<historian::Historian> historian_;
};

}  // namespace plc::tools
