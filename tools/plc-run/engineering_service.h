// The engineering server of plc-run: from command line and configuration to a server, and what it says to the log.
//
// In: [engineering] of plc.toml, --engineering, the folder of the state. Out: a server (engineering/), or none.
// Threads: the main one's. Does not belong here: what the server does.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engineering/engineering.h"
#include "engineering/handover.h"
#include "engineering/shadow_values.h"
#include "engineering/veto.h"
#include "io-drivers/config/configuration.h"
#include "io-drivers/machine/plant.h"
#include "tools/plc-run/alarm_service.h"
#include "tools/plc-run/history_service.h"
#include "tools/plc-run/program_start.h"
#include "tools/plc-run/run_log.h"

namespace plc::tools {

/// What is asked for.
struct EngineeringRequest {
  engineering::Options options;
  bool on = false;
  std::string project;               ///< file or folder that is run
  std::string tables;                ///< folder of alarms.toml and historian.toml
  std::string state;                 ///< folder, or empty
  std::vector<std::string> keys;     ///< files and folders of public keys
  std::string no_force, no_program;  ///< BOOL globals, see engineering::Veto; or empty
  bool recorded = false;             ///< what scans take in is to be recorded
};
/// `listen`: of --engineering, in place of what the configuration says; an empty address is "off". `state`: the folder
/// of the state, or empty.
EngineeringRequest engineering_request(const io::Configuration& configuration,
                                       const std::optional<io::ListenText>& listen, const std::string& project,
                                       const std::string& state);

class EngineeringService {
 public:
  /// Before Plant::prepare(), whose drivers read globals on threads of their own: what reads globals is made here. All
  /// of these must outlive it.
  EngineeringService(EngineeringRequest request, runtime::Resource& resource, RunLog& log, ProgramStart& program);
  ~EngineeringService();
  EngineeringService(const EngineeringService&) = delete;
  EngineeringService& operator=(const EngineeringService&) = delete;

  /// After Plant::prepare(), before the tasks start. `shadow`: null when nothing is recorded; it must live until
  /// stop(). `warm`: the kind of start.
  void prepare(io::Plant& plant, shadow::Shadow* shadow, bool warm);
  /// When the tasks run, which wait for nothing of it.
  void start();
  /// About every 20 ms.
  void service(core::TimeNs now_ns);
  void stop();
  /// For the process that follows; after stop(). Empty without a server.
  [[nodiscard]] std::string handover() const { return server_ ? server_->handover() : std::string(); }
  [[nodiscard]] std::string log_handover() const { return server_ ? engineering::handover_text(book_) : std::string(); }
  /// What is forced; null without a server.
  [[nodiscard]] const runtime::ForceList* forces() const { return forces_ ? &*forces_ : nullptr; }

 private:
  void read_keys();
  void note_devices(core::TimeNs now_ns);
  void tell(const std::vector<engineering::Said>& all, const std::string& source = "engineering");

  EngineeringRequest request_;
  runtime::Resource& resource_;
  RunLog& log_;
  ProgramStart& program_;
  core::MonotonicClock clock_;
  core::SystemCalendar calendar_;
  engineering::LogBook book_;
  std::optional<engineering::ShadowValues> values_;
  std::optional<runtime::ForceList> forces_;
  std::optional<engineering::Veto> no_force_, no_program_;
  std::optional<AlarmService> alarms_;
  std::optional<HistoryService> history_;
  std::unique_ptr<engineering::Engineering> server_;
  io::Plant* plant_ = nullptr;
  core::TimeNs next_ns_ = 0, next_devices_ns_ = 0;
};

}  // namespace plc::tools
