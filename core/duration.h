// Durations as people type them, on command lines and in plc.toml. Literals of the languages are
// runtime/value_text.h's.
#pragma once

#include <optional>
#include <string_view>

#include "core/clock.h"

namespace plc::core {

/// "20s", "500ms", "1.5min", "2h", "T#1m30s"; a plain number is seconds. Nothing when it is not a duration.
std::optional<TimeNs> parse_duration_ns(std::string_view text);

}  // namespace plc::core
