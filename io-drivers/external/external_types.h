// Kinds of drivers that come from shared objects outside of PICARD, as rows (config/driver_type.h).
//
// In: the libraries that [driver_kinds] of a plc.toml names. Out: rows like those of the kinds that PICARD comes with.
// A library is loaded as those of taskblocks are: its files are checked, its code is tried in a process of its own, and
// it stays loaded as long as the process. Before other threads are started. Does not belong here: what such a driver
// does (external_driver.h).
#pragma once

#include <optional>
#include <string>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"
#include "io-drivers/config/driver_type.h"
#include "picard/driver_abi.h"

namespace plc::io {

/// DriverType::device_problems of each such kind.
inline constexpr core::Code kExternalDeviceProblems[] = {core::Code::P7421};

/// `known` and the kinds of all libraries; what is wrong with one (P7420) goes to `findings`. The list lives as long as
/// the process.
DriverTypes load_external_types(const Configuration& configuration, DriverTypes known, Findings& findings);

/// Why a description cannot be a kind beside these: "it has no name"; empty when it can.
std::string complaint(const picard_driver_kind& kind, DriverTypes known);
/// Its row. `kind` lives as long as the process, and so does the row.
const DriverType* make_external_type(const picard_driver_kind& kind);

}  // namespace plc::io
