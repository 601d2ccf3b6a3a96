// What plc-run does about RETAIN and PERSISTENT: where values go, what comes back at the start, what is said of it.
//
// In: command line, configuration, a loaded resource. Out: a keeper (retain/keeper.h), or none, and sentences. Does not
// belong here: storing (retain/).
#pragma once

#include <iosfwd>
#include <memory>
#include <optional>
#include <string>

#include "io-drivers/config/configuration.h"
#include "retain/keeper.h"

namespace plc::tools {

/// The folder of retained values: --state, else that of plc.toml, else the StateDirectory of a systemd service; empty
/// for none. `simulate`: --state alone, so that a dry run leaves the values of the plant alone.
std::string state_folder(const std::string& given, const io::Configuration& configuration, bool simulate);

struct Retained {
  std::unique_ptr<retain::Keeper> keeper;         ///< null when nothing is kept
  std::optional<core::TimeNs> program_time_ns{};  ///< for RealtimeOptions
};

/// Brings stored values into the resource, before anything of it runs. What cannot be had or does not fit is said on
/// `errors`, and the rest goes on.
Retained restore_retained(runtime::Resource& resource, const std::string& folder, core::TimeNs interval_ns,
                          retain::Start start, std::ostream& talk, std::ostream& errors);

}  // namespace plc::tools
