// The kinds of drivers that PICARD comes with: one line each.
//
// In: the rows of their folders. Out: the list, for what reads plc.toml. Does not belong here: anything of one kind.
#pragma once

#include "io-drivers/config/keys.h"

namespace plc::io {

/// In the order in which `plc config init` and the reference page have them. Any thread.
DriverTypes driver_types();

}  // namespace plc::io
