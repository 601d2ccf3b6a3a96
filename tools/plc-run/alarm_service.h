// The alarms of plc-run: from alarms.toml and the instances of ALARM to alarms that are evaluated and kept.
//
// In: a file, a resource, the shadow. Out: alarms for the engineering server, sentences for the log. Threads: the main
// one's. Does not belong here: what alarms do (alarms/).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "alarms/alarm_store.h"
#include "alarms/alarms.h"
#include "engineering/engineering.h"
#include "shadow/shadow.h"

namespace plc::tools {

class AlarmService {
 public:
  /// Before any thread reads globals. `file`: alarms.toml, which need not be there. `recorded`: scans are to be.
  AlarmService(const std::string& file, runtime::Resource& resource, bool recorded);
  /// Before the tasks start. `folder`: where they are kept, or empty. `shadow`: null when nothing is recorded, also
  /// when it was to be; it must live until stop().
  void open(const std::string& folder, shadow::Shadow* shadow, std::vector<engineering::Said>& said);

  /// Null when there are none.
  [[nodiscard]] alarms::Alarms* alarms() { return alarms_.get(); }
  [[nodiscard]] alarms::AlarmStore* store() { return store_.get(); }
  /// About every 100 ms. `settled`: the program stays. Until then nothing is kept: events and states of a program on
  /// trial that fails are gone with it, and the one before finds its own.
  void service(core::TimeNs now_ns, core::TimeNs utc_ns, bool settled, std::vector<engineering::Said>& said);
  /// After the shadow has ended, or while it goes on.
  void stop(bool settled);

 private:
  void keep();

  std::string wrong_;  ///< with the file; said by open()
  std::unique_ptr<alarms::Alarms> alarms_;
  std::unique_ptr<alarms::AlarmStore> store_;
};

}  // namespace plc::tools
