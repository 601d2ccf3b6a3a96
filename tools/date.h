// The date and time zone that programs have in virtual time: --date and --zone of the commands that simulate.
//
// In: texts of the command line. Out: UTC at virtual time 0, a time zone. Does not belong here: the clocks of a plant
// (plc-run has the machine's).
#pragma once

#include <optional>
#include <string>

#include "core/time_zone.h"
#include "tools/cli.h"

namespace plc::tools {

struct DateOptions {
  std::string date, zone = "UTC";
  // parse_date_options() fills these in.
  core::TimeNs date_ns = 0;
  core::TimeZone time_zone;
};

/// Adds --date and --zone. The options must outlive the parsing.
void add_date_options(Command command, DateOptions& options);
/// The exit code when one of them is wrong, which is said.
std::optional<int> parse_date_options(std::string_view command, DateOptions& options);

/// "2026-03-29T00:59:58.5Z", "2026-03-29 00:59:58", "2026-03-29", and as IEC 61131-3 has it, "DT#2026-03-29-00:59:58":
/// nanoseconds since 1970-01-01. Years 1970 to 2261.
std::optional<core::TimeNs> parse_date_ns(std::string_view text);

}  // namespace plc::tools
