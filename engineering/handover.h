// What a server hands to the one that follows it when another program starts: who is logged in, the log, its port.
//
// In, out: one text. Times are of the same clock before and after: it is the same machine since the same boot. Does not
// belong here: how the text gets there (tools/plc-run/relaunch.h).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engineering/log_book.h"
#include "engineering/sessions.h"

namespace plc::engineering {

std::string handover_text(const Sessions& sessions, std::uint16_t port);
std::string handover_text(const LogBook& log);
/// A text that cannot be read changes nothing.
void take_over(std::string_view text, Sessions& sessions, std::uint16_t& port);
void take_over(std::string_view text, LogBook& log);

}  // namespace plc::engineering
