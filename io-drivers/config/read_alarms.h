// alarms.toml: the table of alarms of a plant (docs/guides/alarms.md).
//
// In: text. Out: definitions, not yet looked up in a project. Does not belong here: evaluating them (alarms/).
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "alarms/definition.h"
#include "core/diagnostics.h"
#include "io-drivers/config/keys.h"

namespace plc::io {

/// The keys of [[alarm]].
std::span<const KeyInfo> alarm_keys();
/// What is wrong is reported with its place (P7301 to P7311), and the alarm left out.
std::vector<alarms::Definition> read_alarms(std::string_view text, std::string_view file,
                                            core::Diagnostics& diagnostics);

}  // namespace plc::io
