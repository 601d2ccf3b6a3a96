// One message of a plant that runs, with what is known of it besides its words.
//
// Does not belong here: how it is written (format.h), whether (limiter.h), where (sink.h).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "core/clock.h"
#include "core/diagnostics.h"

namespace plc::log {

struct Record {
  core::Severity severity = core::Severity::kNote;
  std::string text;     ///< one line, without severity and time
  std::string source;   ///< who says it: "modbus", the name of a driver, "retain"; empty: plc-run itself
  std::string code;     ///< "P7510", "R1002", or empty
  std::string task;     ///< or empty
  std::string block;    ///< "LOWPASS main.filter", or empty
  std::string details;  ///< further lines, as they are printed, without a line feed at the end
  std::optional<std::uint64_t> scan{};  ///< of the task, counted from 0
  core::TimeNs utc_ns = 0;              ///< since 1970-01-01
  bool shown = false;                   ///< is on stdout or stderr already, whether or not the log can be written
};

/// "error", "warning", "note".
const char* word_of(core::Severity severity);

}  // namespace plc::log
