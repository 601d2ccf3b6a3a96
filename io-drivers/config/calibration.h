// Calibration files: what instructions, functions and blocks cost on a machine, as `plc calibrate` writes it down.
//
// In: TOML text. Out: a complete CostTable, or P7607 with the place. The table of a typical machine has the same form
// (typical.toml) and is built in. Does not belong here: measuring, adding up.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/diagnostics.h"
#include "runtime/sched/cost_table.h"

namespace plc::io {

/// Added to estimates: costs of another machine may be half of what they are here, and those of this machine were
/// measured on programs that are not the user's.
inline constexpr double kTypicalMargin = 1.0;
inline constexpr double kCalibratedMargin = 0.3;

/// Every cost, function and block of this version must be there, and nothing else.
std::optional<runtime::CostTable> read_calibration(std::string_view text, std::string_view file,
                                                   core::Diagnostics& diagnostics);
/// `at`: where the file is named, for one that cannot be read at all (P7001).
std::optional<runtime::CostTable> load_calibration(const std::string& path, const core::SourceRef& at,
                                                   core::Diagnostics& diagnostics);
std::string calibration_text(const runtime::CostTable& costs);

/// Measured on a typical machine: a virtual one on a server of 2020.
const runtime::CostTable& typical_costs();
/// The text it is read from.
std::string_view typical_calibration();

}  // namespace plc::io
