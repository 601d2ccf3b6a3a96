// plc replay --test: a piece of a recording as a case, which plc test runs (tests/cases/README.md).
//
// In: a player, a stretch of time, the project. Out: a folder with the project, the state that the piece begins with,
// what came from outside as a stimulus, and a table of what variables were. Does not belong here: running the case.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "core/options.h"
#include "core/result.h"
#include "shadow/player.h"

namespace plc::tools {

struct ReplayCase {
  std::string folder;                  ///< of the case; made when it is not there
  std::string project;                 ///< file or folder that is copied into it
  std::vector<std::string> libraries;  ///< files that are compiled with it
  core::CompileOptions options;
  std::vector<std::string> watch;          ///< variables of the table; empty: addresses at %Q, or all if there are none
  core::TimeNs from_ns = 0;                ///< instant of release, as Player::count_releases() has it
  std::optional<core::TimeNs> until_ns{};  ///< nothing: to the end
  bool until_fault = false;                ///< the scan with the first fault is the last one
};

struct WrittenCase {
  std::uint64_t instants = 0;
  std::size_t variables = 0;    ///< columns of the table
  std::size_t inputs = 0;       ///< columns of the stimulus
  core::TimeNs begin_ns = 0;    ///< where it begins: an instant at which all cyclic tasks are released
  bool aligned = true;          ///< false: there is no such instant, phases of tasks are lost
  std::uint64_t different = 0;  ///< scans that gave something else than recorded
};

/// P7202, P7203 for files that cannot be written or read, P7101 for paths.
core::Result<WrittenCase> write_case(shadow::Player& player, const ReplayCase& request);

}  // namespace plc::tools
