// A record as text, as a line of JSON, and as a datagram of systemd's journal.
//
// Every result is one record for whoever reads it: control characters in a text are written as '?', bytes that are no
// UTF-8 too, so that no text of a component can look like a message of another. Does not belong here: writing.
#pragma once

#include <string>
#include <string_view>

#include "log/record.h"

namespace plc::log {

/// "2026-01-31T12:00:00.000Z", to the millisecond.
std::string time_text(core::TimeNs utc_ns);
/// "TIME warning: text\n", and its details; without "TIME " when `with_time` is false.
std::string text_line(const Record& record, bool with_time = true);
/// {"time": .., "severity": .., "message": ..} and of the rest what is there; ends with a line feed.
std::string json_line(const Record& record);
/// MESSAGE, PRIORITY (3, 4 or 6), SYSLOG_IDENTIFIER, and PICARD_SOURCE, PICARD_CODE, PICARD_TASK, PICARD_SCAN,
/// PICARD_BLOCK and PICARD_DETAILS of what is there (systemd.io/JOURNAL_NATIVE_PROTOCOL).
std::string journal_datagram(const Record& record);
/// The text without control characters and broken UTF-8.
std::string printable(std::string_view text);

}  // namespace plc::log
