// The kinds of drivers that PICARD comes with, one line each; and those of the libraries that a plc.toml names.
//
// In: the rows of their folders. Out: the list, for what reads plc.toml. Does not belong here: anything of one kind.
#pragma once

#include <optional>
#include <string>

#include "core/diagnostics.h"
#include "io-drivers/config/configuration.h"

namespace plc::io {

/// In the order in which `plc config init` and the reference page have them. Any thread.
DriverTypes driver_types();

/// Whether a problem of a start is one of a device or of the guardian, so that another start may succeed without a
/// change of the configuration: DriverType::device_problems of all kinds. Any thread.
bool is_about_devices(core::Code code);

/// Reads a plc.toml by the rows of these kinds and of those of its [driver_kinds], which stay loaded as long as the
/// process: before other threads are started. Nothing after an error, which is in `diagnostics`.
std::optional<Configuration> load_configuration(const std::string& path, core::Diagnostics& diagnostics);

}  // namespace plc::io
